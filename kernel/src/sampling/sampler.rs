//! One sampler for all integrators: random numbers or low-discrepancy points behind the same address.
//!
//! Numbers come in *sets* of up to four. Within a set the points of a pixel's samples are a low-discrepancy sequence;
//! between sets, and between pixels, they are independent, as each has an index shuffle and a scramble of its own
//! (padding, as Burley (2020) does it). Take a power of two of samples: then a pixel's points of a set are a net.

use glam::Vec2;

use super::rng::{Purpose, block};
use super::{Stream, nested_uniform_scramble, r2, sobol, unit_float};

/// Where the numbers of a [`Sampler`] come from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Pattern {
    /// Independent random numbers: Philox.
    Random,
    /// The Sobol' sequence with Owen scrambling.
    #[default]
    Sobol,
    /// The R2 lattice sequence with a random rotation. Its sets of four are two independent pairs.
    R2,
}

/// The numbers of one sample of one pixel, in sets addressed by their index.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sampler {
    pub(super) pattern: Pattern,
    pub(super) seed: u64,
    pub(super) pixel: u32,
    pub(super) sample: u32,
}

impl Sampler {
    /// The sampler of sample `sample` of pixel (or texel, or record) `pixel`.
    #[inline(always)]
    pub fn new(pattern: Pattern, seed: u64, pixel: u32, sample: u32) -> Self {
        Self { pattern, seed, pixel, sample }
    }

    /// The first number of set `set`, in [0, 1).
    #[inline(always)]
    pub fn uniform1(&self, set: u32) -> f32 {
        self.uniform2(set).x
    }

    /// The first two numbers of set `set`, each in [0, 1).
    #[inline(always)]
    pub fn uniform2(&self, set: u32) -> Vec2 {
        let [x, y, ..] = self.words(set);
        Vec2::new(unit_float(x), unit_float(y))
    }

    /// The four numbers of set `set`, each in [0, 1); the first two are those of [`uniform2`](Self::uniform2).
    #[inline(always)]
    pub fn uniform4(&self, set: u32) -> [f32; 4] {
        let [x, y, z, w] = self.words(set);
        [unit_float(x), unit_float(y), unit_float(z), unit_float(w)]
    }

    /// The four numbers as 32-bit fractions. Unused ones cost nothing once this is inlined.
    #[inline(always)]
    fn words(&self, set: u32) -> [u32; 4] {
        if self.pattern == Pattern::Random {
            return Stream::new(self.seed, self.pixel, self.sample).bits4(set);
        }
        let [shuffle, s, t, _] = self.seeds(set, Purpose::FirstPair);
        let [second_shuffle, p, q, _] = self.seeds(set, Purpose::SecondPair);
        let index = nested_uniform_scramble(self.sample, shuffle);
        if self.pattern == Pattern::Sobol {
            let [x, y, z, w] = sobol(index);
            [
                nested_uniform_scramble(x, s),
                nested_uniform_scramble(y, t),
                nested_uniform_scramble(z, p),
                nested_uniform_scramble(w, q),
            ]
        } else {
            let [x, y] = r2(index, [s, t]);
            let [z, w] = r2(nested_uniform_scramble(self.sample, second_shuffle), [p, q]);
            [x, y, z, w]
        }
    }

    /// The random words that a set's scramble depends on: equal for all samples of the pixel.
    #[inline(always)]
    fn seeds(&self, set: u32, purpose: Purpose) -> [u32; 4] {
        block(self.seed, self.pixel, 0, set, purpose)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::checksums::Checksum;
    use crate::sampling::tests::statistics::chi_squared;

    const PATTERNS: [Pattern; 3] = [Pattern::Random, Pattern::Sobol, Pattern::R2];

    #[test]
    fn first_samples_are_nets_in_every_pixel_and_set() {
        for (seed, pixel, set) in [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1), (u64::MAX, u32::MAX, u32::MAX)] {
            for bits in 0..=9 {
                let points: Vec<_> =
                    (0..1 << bits).map(|i| Sampler::new(Pattern::Sobol, seed, pixel, i).uniform2(set)).collect();
                for across in 0..=bits {
                    let size = Vec2::new((1 << across) as f32, (1 << (bits - across)) as f32);
                    let mut cells: Vec<_> = points.iter().map(|&p| (p * size).as_uvec2().to_array()).collect();
                    cells.sort_unstable();
                    cells.dedup();
                    assert_eq!(
                        cells.len(),
                        points.len(),
                        "pixel {pixel}, set {set}: 2^{bits} points, 2^{across} columns"
                    );
                }
            }
        }
    }

    #[test]
    fn sets_of_four_begin_with_the_pair_and_are_stratified() {
        for sample in 0..100 {
            for pattern in PATTERNS {
                let sampler = Sampler::new(pattern, 9, 4, sample);
                let [x, y, ..] = sampler.uniform4(3);
                assert_eq!(sampler.uniform2(3), Vec2::new(x, y));
                assert_eq!(sampler.uniform1(3), x);
            }
        }
        for dimension in 0..4 {
            let mut strata: Vec<_> =
                (0..64).map(|i| (Sampler::new(Pattern::Sobol, 9, 4, i).uniform4(3)[dimension] * 64.0) as u32).collect();
            strata.sort_unstable();
            assert!(strata.into_iter().eq(0..64), "dimension {dimension}");
        }
    }

    /// Sobol's property A: of 2⁴ points one is in each of the 2⁴ orthants of the cube.
    #[test]
    fn sixteen_samples_are_in_sixteen_orthants() {
        for set in 0..50 {
            let orthant = |i| Sampler::new(Pattern::Sobol, 1, 2, i).uniform4(set).map(|x| x >= 0.5);
            let mut orthants: Vec<_> = (0..16).map(orthant).collect();
            orthants.sort_unstable();
            orthants.dedup();
            assert_eq!(orthants.len(), 16, "set {set}");
        }
    }

    /// The samples of one pixel fill the square of two sets: a common index alone would leave them on a few lines.
    #[test]
    fn sets_of_one_pixel_are_shuffled() {
        for pattern in PATTERNS {
            let mut filled = 0;
            for pair in 0..20 {
                let mut cells: Vec<_> = (0..256)
                    .map(|i| [0, 1].map(|s| (Sampler::new(pattern, 0, 0, i).uniform1(2 * pair + s) * 8.0) as u32))
                    .collect();
                cells.sort_unstable();
                cells.dedup();
                filled += cells.len();
            }
            // Independent points leave 64 (63/64)^256 = 1.1 cells of 64 empty.
            assert!(filled > 20 * 56, "{pattern:?}: {filled} of {} cells", 20 * 64);
        }
    }

    /// A number of one set says nothing about that of another set, pixel or seed at the same sample.
    #[test]
    fn sets_pixels_and_seeds_are_independent() {
        // Along the sets, the pixels and the seeds.
        let axes: [fn(u32) -> [u32; 3]; 3] = [|i| [0, 0, i], |i| [0, i, 0], |i| [i, 0, 0]];
        for pattern in PATTERNS {
            for axis in axes {
                let mut counts = [0.0; 64];
                // A new pair of neighbours every 4 samples, or stratification would make the test too good.
                for i in 0..8000 {
                    let [x, y] = [2 * (i / 4), 2 * (i / 4) + 1].map(|n| {
                        let [seed, pixel, set] = axis(n);
                        Sampler::new(pattern, seed.into(), pixel, i % 4).uniform1(set)
                    });
                    counts[(x * 8.0) as usize * 8 + (y * 8.0) as usize] += 1.0;
                }
                let z = chi_squared(&counts, &[125.0; 64]);
                assert!(z < 3.5, "{pattern:?}: {z}");
            }
        }
    }

    /// Every pattern has the right mean, and those of low discrepancy a far smaller error.
    #[test]
    fn estimates_converge_without_bias() {
        // ∫∫ x y² = 1/6.
        let estimate = |pattern, pixel| {
            let sum: f64 = (0..256)
                .map(|i| {
                    let [x, y] = Sampler::new(pattern, 3, pixel, i).uniform2(7).to_array().map(f64::from);
                    x * y * y
                })
                .sum();
            sum / 256.0 - 1.0 / 6.0
        };
        let errors = PATTERNS.map(|pattern| {
            let errors: Vec<f64> = (0..400).map(|pixel| estimate(pattern, pixel)).collect();
            let mean = errors.iter().sum::<f64>() / 400.0;
            let rms = (errors.iter().map(|e| e * e).sum::<f64>() / 400.0).sqrt();
            assert!(mean.abs() < 4.0 * rms / 20.0, "{pattern:?}: bias {mean}, rms {rms}");
            rms
        });
        // The standard deviation of x y² is √(1/15 - 1/36) = .1972; a sixteenth of it remains after 256 samples.
        assert!((errors[0] - 0.01233).abs() < 0.0015, "{errors:?}");
        assert!(errors[1] < 0.05 * errors[0] && errors[2] < 0.3 * errors[0], "{errors:?}");
    }

    #[test]
    fn golden() {
        let sums = PATTERNS.map(|pattern| {
            let mut sum = Checksum::new();
            for i in 0..10_000 {
                sum.add(Sampler::new(pattern, 42, i / 100, i % 100).uniform4(i % 7));
            }
            sum.value()
        });
        assert_eq!(sums, [0x5323_FD19_9876_D24D, 0x39CE_EEE2_A63B_92E4, 0x1C3F_085B_54F6_8887], "{sums:#018X?}");
    }
}
