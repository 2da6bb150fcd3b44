//! The numbers of one set for many samples at once, for a wavefront of paths at a bounce.

use bytemuck::{Pod, Zeroable};
use glam::Vec2;

use super::batch::{Function, apply_many};
use super::{Pattern, Sampler};
use crate::simd::Isa;

/// A sample of a pixel, which together with a pattern and a seed is a [`Sampler`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub struct SampleId {
    /// The pixel (or texel, or record).
    pub pixel: u32,
    /// The index of the sample in it.
    pub sample: u32,
}

/// Writes [`Sampler::uniform2`] of set `set` for each address, with the instructions of `isa`: several times as fast,
/// and equal bit for bit. Elements beyond the end of the shorter slice are left unchanged.
pub fn fill2(isa: Isa, pattern: Pattern, seed: u64, set: u32, addresses: &[SampleId], numbers: &mut [Vec2]) {
    apply_many(isa, Uniform2 { pattern, seed, set }, addresses, numbers);
}

/// Writes [`Sampler::uniform4`] of set `set` for each address, as [`fill2`] writes pairs.
pub fn fill4(isa: Isa, pattern: Pattern, seed: u64, set: u32, addresses: &[SampleId], numbers: &mut [[f32; 4]]) {
    apply_many(isa, Uniform4 { pattern, seed, set }, addresses, numbers);
}

impl Sampler {
    /// The sample and pixel of a sampler; the other parameters are the same for a whole picture.
    #[inline]
    pub fn address(&self) -> SampleId {
        SampleId { pixel: self.pixel, sample: self.sample }
    }

    /// Writes [`uniform2`](Self::uniform2) of set `set` for the samplers of other addresses, as [`fill2`] does.
    #[inline]
    pub fn fill2(&self, isa: Isa, set: u32, addresses: &[SampleId], numbers: &mut [Vec2]) {
        fill2(isa, self.pattern, self.seed, set, addresses, numbers);
    }
}

struct Uniform2 {
    pattern: Pattern,
    seed: u64,
    set: u32,
}

impl Function for Uniform2 {
    type Input = SampleId;
    type Output = Vec2;
    #[inline(always)]
    fn apply(&self, SampleId { pixel, sample }: SampleId) -> Vec2 {
        Sampler::new(self.pattern, self.seed, pixel, sample).uniform2(self.set)
    }
}

struct Uniform4 {
    pattern: Pattern,
    seed: u64,
    set: u32,
}

impl Function for Uniform4 {
    type Input = SampleId;
    type Output = [f32; 4];
    #[inline(always)]
    fn apply(&self, SampleId { pixel, sample }: SampleId) -> [f32; 4] {
        Sampler::new(self.pattern, self.seed, pixel, sample).uniform4(self.set)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simd::isas;

    #[test]
    fn batches_equal_samplers_bit_for_bit() {
        // Many pixels with few samples, one pixel with many, and the ends of the range.
        let mut addresses: Vec<_> = (0..4000).map(|i| SampleId { pixel: i / 4, sample: i % 4 }).collect();
        addresses.extend((0..4003).map(|sample| SampleId { pixel: 7, sample }));
        addresses.extend([0, u32::MAX].map(|end| SampleId { pixel: end, sample: !end }));
        let mut pairs = vec![Vec2::ZERO; addresses.len()];
        let mut fours = vec![[0.0; 4]; addresses.len()];
        for isa in isas() {
            for pattern in [Pattern::Random, Pattern::Sobol, Pattern::R2] {
                for (seed, set) in [(0, 0), (0x0123_4567_89AB_CDEF, 5), (u64::MAX, u32::MAX)] {
                    fill2(isa, pattern, seed, set, &addresses, &mut pairs);
                    fill4(isa, pattern, seed, set, &addresses, &mut fours);
                    for ((&SampleId { pixel, sample }, pair), four) in addresses.iter().zip(&pairs).zip(&fours) {
                        let sampler = Sampler::new(pattern, seed, pixel, sample);
                        assert_eq!(*pair, sampler.uniform2(set), "{pattern:?} of {pixel}, {sample} on {isa:?}");
                        assert_eq!(*four, sampler.uniform4(set), "{pattern:?} of {pixel}, {sample} on {isa:?}");
                    }
                }
            }
        }
    }

    #[test]
    fn ends_of_unequal_slices_are_left_alone() {
        let mut numbers = [Vec2::NEG_ONE; 20];
        fill2(Isa::detect(), Pattern::Sobol, 1, 2, &[SampleId::default(); 17], &mut numbers);
        assert!(numbers[..17].iter().all(|n| n.min_element() >= 0.0) && numbers[17..] == [Vec2::NEG_ONE; 3]);
        fill2(Isa::detect(), Pattern::Sobol, 1, 2, &[SampleId::default(); 5], &mut numbers[..2]);
    }
}
