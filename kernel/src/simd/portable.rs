//! The backend for every target, by the crate `wide`: SSE2, NEON, wasm's simd128, or plain code where there is none.

use super::twice::Twice;
use super::{CompressChildren, Lanes, Mask, Simd};

/// The target's baseline.
#[derive(Clone, Copy)]
pub(crate) struct Portable;

impl Simd for Portable {
    type F4 = wide::f32x4;
    type F8 = wide::f32x8;
    type F16 = Twice<wide::f32x8>;
    type F32 = Twice<Twice<wide::f32x8>>;
    const WIDE: bool = false;

    #[inline(always)]
    fn prefetch<const BYTES: usize>(start: *const u8) {
        #[cfg(all(target_arch = "x86_64", target_feature = "sse2"))]
        super::avx2::prefetch::<BYTES>(start);
        #[cfg(not(all(target_arch = "x86_64", target_feature = "sse2")))]
        let _ = start;
    }

    #[inline(always)]
    fn compress_indices(bits: u32, base: u32, out: &mut [u32; 8]) -> usize {
        let mut count = 0;
        for lane in 0..8 {
            out[count & 7] = base + lane;
            count += (bits >> lane & 1) as usize;
        }
        count
    }

    #[inline(always)]
    fn classify(words: &[u32; 8]) -> [u32; 2] {
        let mut bits = [0; 2];
        for (lane, &word) in words.iter().enumerate() {
            bits[0] |= (word >> 31) << lane;
            bits[1] |= u32::from(word == u32::MAX) << lane;
        }
        bits
    }

    #[inline(always)]
    fn permute(numbers: &[f32; 8], places: &[u32; 8]) -> wide::f32x8 {
        let mut found = [0.0; 8];
        for (found, &place) in found.iter_mut().zip(places) {
            *found = numbers[place as usize & 7];
        }
        wide::f32x8::new(found)
    }

    #[inline(always)]
    fn transpose(rows: [wide::f32x8; 8]) -> [wide::f32x8; 8] {
        // `wide` mirrors eight rows with AVX or one number at a time, but four rows everywhere.
        let [low, high]: [[[wide::f32x4; 2]; 4]; 2] = bytemuck::cast(rows);
        let quarter = |rows: &[[wide::f32x4; 2]; 4], half: usize| {
            wide::f32x4::transpose([rows[0][half], rows[1][half], rows[2][half], rows[3][half]])
        };
        let (a, b, c, d) = (quarter(&low, 0), quarter(&high, 0), quarter(&low, 1), quarter(&high, 1));
        bytemuck::cast([
            [[a[0], b[0]], [a[1], b[1]], [a[2], b[2]], [a[3], b[3]]],
            [[c[0], d[0]], [c[1], d[1]], [c[2], d[2]], [c[3], d[3]]],
        ])
    }

    #[inline(always)]
    fn deinterleave(triples: &[[f32; 16]; 3]) -> [Self::F16; 3] {
        let triples: &[[f32; 3]; 16] = bytemuck::cast_ref(triples);
        let mut parts = [[0.0; 16]; 3];
        for (lane, triple) in triples.iter().enumerate() {
            for (part, number) in parts.iter_mut().zip(triple) {
                part[lane] = *number;
            }
        }
        let [first, second, third] = &parts;
        [Lanes::load(first), Lanes::load(second), Lanes::load(third)]
    }
}

macro_rules! portable {
    ($lanes:ty, $width:literal) => {
        impl Lanes<$width> for $lanes {
            type Mask = Self;

            #[inline(always)]
            fn splat(value: f32) -> Self {
                Self::new([value; $width])
            }
            #[inline(always)]
            fn load(values: &[f32; $width]) -> Self {
                Self::new(*values)
            }
            #[inline(always)]
            fn store(self) -> [f32; $width] {
                self.to_array()
            }
            #[inline(always)]
            fn mul_sub(self, factor: Self, minuend: Self) -> Self {
                self * factor - minuend
            }
            #[inline(always)]
            fn min(self, other: Self) -> Self {
                self.fast_min(other)
            }
            #[inline(always)]
            fn max(self, other: Self) -> Self {
                self.fast_max(other)
            }
            #[inline(always)]
            fn abs(self) -> Self {
                <$lanes>::abs(self)
            }
            #[inline(always)]
            fn copysign(self, other: Self) -> Self {
                <$lanes>::abs(self) | other & Self::splat(-0.0)
            }
            #[inline(always)]
            fn lt(self, other: Self) -> Self {
                self.simd_lt(other)
            }
            #[inline(always)]
            fn le(self, other: Self) -> Self {
                self.simd_le(other)
            }
            #[inline(always)]
            fn eq(self, other: Self) -> Self {
                self.simd_eq(other)
            }
            #[inline(always)]
            fn select(mask: Self, yes: Self, no: Self) -> Self {
                mask.bitselect(yes, no)
            }
        }

        impl Mask for $lanes {
            const LANES: u32 = $width;
            #[inline(always)]
            fn bits(self) -> u32 {
                self.to_bitmask()
            }
            #[inline(always)]
            fn from_bits(bits: u32) -> Self {
                let mut lanes = [0.0; $width];
                for (lane, value) in lanes.iter_mut().enumerate() {
                    *value = f32::from_bits((bits >> lane & 1).wrapping_neg());
                }
                Self::new(lanes)
            }
        }
    };
}

portable!(wide::f32x4, 4);
portable!(wide::f32x8, 8);

impl CompressChildren for wide::f32x8 {
    #[inline(always)]
    fn compress(
        near: Self,
        far: Self,
        mut order: u32,
        children: &[u32; 8],
        kept: &mut [u32; 8],
        distances: &mut [f32; 8],
    ) -> usize {
        let bits = near.le(far).bits();
        if bits == 0 {
            return 0;
        }
        let near = near.to_array();
        let mut count = 0;
        for _ in 0..8 {
            // Every child is written, and the next one over it if it is not to be kept: no branch to mispredict.
            let slot = (order & 7) as usize;
            (kept[count & 7], distances[count & 7]) = (children[slot], near[slot]);
            count += (bits >> slot & 1) as usize;
            order >>= 3;
        }
        count
    }
}
