//! Philox4x32, a counter-based random number generator.
//!
//! Salmon, Moraes, Dror and Shaw, "Parallel random numbers: as easy as 1, 2, 3" (2011). A counter of four words and
//! a key of two go through seven rounds of multiplication and exclusive or; seven is the fewest with which the
//! generator passes BigCrush. The words of the counter are (set, sample, pixel, purpose), and the key is the seed.

use glam::Vec2;

use super::unit_float;

const ROUNDS: u32 = 7;
const MULTIPLIERS: [u32; 2] = [0xD251_1F53, 0xCD9E_8D57];
/// The key's increments: the golden ratio's and √3's fractions.
const WEYL: [u32; 2] = [0x9E37_79B9, 0xBB67_AE85];

/// Philox4x32 of `counter` under `key` with `rounds` rounds: a bijection of the counters for every key.
#[inline(always)]
pub fn philox4x32(rounds: u32, counter: [u32; 4], key: [u32; 2]) -> [u32; 4] {
    let wide_product = |a: u32, b: u32| {
        let product = u64::from(a) * u64::from(b);
        ((product >> 32) as u32, product as u32)
    };
    let (mut c, mut k) = (counter, key);
    for _ in 0..rounds {
        let (high0, low0) = wide_product(MULTIPLIERS[0], c[0]);
        let (high1, low1) = wide_product(MULTIPLIERS[1], c[2]);
        c = [high1 ^ c[1] ^ k[0], low1, high0 ^ c[3] ^ k[1], low0];
        k = [k[0].wrapping_add(WEYL[0]), k[1].wrapping_add(WEYL[1])];
    }
    c
}

/// The purpose of a block of random words: the last word of the counter, so that no two uses share a block.
#[derive(Clone, Copy, Debug)]
pub(super) enum Purpose {
    /// The numbers of a [`Stream`].
    Numbers = 0,
    /// The seeds of the first pair of a scrambled sequence.
    FirstPair = 1,
    /// The seeds of the second pair of a scrambled sequence.
    SecondPair = 2,
}

/// The block of four random words at an address.
#[inline(always)]
pub(super) fn block(seed: u64, pixel: u32, sample: u32, set: u32, purpose: Purpose) -> [u32; 4] {
    philox4x32(ROUNDS, [set, sample, pixel, purpose as u32], [seed as u32, (seed >> 32) as u32])
}

/// The random numbers of one sample of one pixel: sets of four, each addressed by its index.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Stream {
    seed: u64,
    pixel: u32,
    sample: u32,
}

impl Stream {
    /// The stream of sample `sample` of pixel (or texel, or record) `pixel`. Streams with different addresses are
    /// independent.
    #[inline(always)]
    pub fn new(seed: u64, pixel: u32, sample: u32) -> Self {
        Self { seed, pixel, sample }
    }

    /// The four random words of set `set`.
    #[inline(always)]
    pub fn bits4(&self, set: u32) -> [u32; 4] {
        block(self.seed, self.pixel, self.sample, set, Purpose::Numbers)
    }

    /// The four numbers of set `set`, each uniform on the multiples of 2⁻²⁴ in [0, 1).
    #[inline(always)]
    pub fn uniform4(&self, set: u32) -> [f32; 4] {
        let [x, y, z, w] = self.bits4(set);
        [unit_float(x), unit_float(y), unit_float(z), unit_float(w)]
    }

    /// The first two numbers of set `set`.
    #[inline(always)]
    pub fn uniform2(&self, set: u32) -> Vec2 {
        let [x, y, ..] = self.uniform4(set);
        Vec2::new(x, y)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::checksums::Checksum;
    use crate::sampling::ONE_MINUS_EPSILON;
    use crate::sampling::tests::statistics::chi_squared;

    const PI_WORDS: [u32; 6] = [0x243F_6A88, 0x85A3_08D3, 0x1319_8A2E, 0x0370_7344, 0xA409_3822, 0x299F_31D0];

    /// The known answers that the authors' Random123 library publishes.
    #[test]
    fn known_answers() {
        let [c0, c1, c2, c3, k0, k1] = PI_WORDS;
        let inputs = [([0; 4], [0; 2]), ([!0; 4], [!0; 2]), ([c0, c1, c2, c3], [k0, k1])];
        let seven = [
            [0x5F6F_B709, 0x0D89_3F64, 0x4F12_1F81, 0x4F73_0A48],
            [0x5207_DDC2, 0x4516_5E59, 0x4D8E_E751, 0x8C52_F662],
            [0x4DFC_CABA, 0x190A_87F0, 0xC473_62BA, 0xB6B5_242A],
        ];
        let ten = [
            [0x6627_E8D5, 0xE169_C58D, 0xBC57_AC4C, 0x9B00_DBD8],
            [0x408F_276D, 0x41C8_3B0E, 0xA20B_C7C6, 0x6D54_51FD],
            [0xD16C_FE09, 0x94FD_CCEB, 0x5001_E420, 0x2412_6EA1],
        ];
        for (i, (counter, key)) in inputs.into_iter().enumerate() {
            assert_eq!(philox4x32(7, counter, key), seven[i]);
            assert_eq!(philox4x32(10, counter, key), ten[i]);
        }
    }

    #[test]
    fn an_address_is_a_counter_and_a_key() {
        let [set, sample, pixel, _, low, high] = PI_WORDS;
        let stream = Stream::new(u64::from(high) << 32 | u64::from(low), pixel, sample);
        assert_eq!(stream.bits4(set), philox4x32(7, [set, sample, pixel, 0], [low, high]));
    }

    #[test]
    fn floats_keep_24_bits_and_never_reach_one() {
        assert_eq!(unit_float(0), 0.0);
        assert_eq!(unit_float(255), 0.0);
        assert_eq!(unit_float(256), 1.0 / 16_777_216.0);
        assert_eq!(unit_float(u32::MAX), ONE_MINUS_EPSILON);
    }

    /// Pairs of numbers adjacent along each axis of the address fill the unit square evenly.
    #[test]
    fn neighbours_are_independent() {
        let first = |pixel, sample, set| Stream::new(5, pixel, sample).uniform4(set)[0];
        let axes: [fn(u32) -> [u32; 3]; 3] = [|i| [i, 0, 0], |i| [0, i, 0], |i| [0, 0, i]];
        for axis in axes {
            let mut counts = [0.0; 256];
            for i in 0..40_000 {
                let [x, y] = [2 * i, 2 * i + 1].map(|i| {
                    let [pixel, sample, set] = axis(i);
                    first(pixel, sample, set)
                });
                counts[(x * 16.0) as usize * 16 + (y * 16.0) as usize] += 1.0;
            }
            let z = chi_squared(&counts, &[40_000.0 / 256.0; 256]);
            assert!(z.abs() < 3.5, "{z}");
        }
    }

    #[test]
    fn golden() {
        let mut sum = Checksum::new();
        for i in 0..10_000 {
            sum.add(Stream::new(u64::from(i) << 20, i, i ^ 77).uniform4(i % 13));
        }
        assert_eq!(sum.value(), 0xC777_17CB_05D8_8968, "{:#018X}", sum.value());
    }
}
