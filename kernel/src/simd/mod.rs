//! SIMD lanes of `f32`: the operations that the kernels use, and their backends. All of the kernel's `unsafe` is in
//! this folder.
//!
//! Code in lanes is written in `#[inline(always)]` functions, never in closures or `array::map`: intrinsics are inlined
//! only into code that is compiled for their instruction set, which the kernels are once all of their parts have become
//! part of [`dispatch`]'s entry points. A closure that stays a function of its own makes every operation a call.
//!
//! The kernels are generic over [`Simd`], an instruction set, and compiled once for each; [`dispatch`] picks one a
//! batch. Operations are IEEE 754 exact (correctly rounded, nothing fused), which is what makes results equal bit for
//! bit on all backends. The exceptions are [`min`](Lanes::min) and [`max`](Lanes::max) on NaN or on zeros of both
//! signs, and [`mul_sub`](Lanes::mul_sub), which may be fused: no kernel lets such a difference reach a result.

#[cfg(all(target_arch = "x86_64", target_feature = "sse2"))]
mod avx2;
#[cfg(all(target_arch = "x86_64", target_feature = "sse2"))]
mod avx512;
mod isa;
mod portable;
#[cfg(test)]
pub(crate) mod tests;
mod twice;
mod uninit;

use core::ops::{Add, BitAnd, BitOr, Div, Mul, Sub};

#[cfg(test)]
pub(crate) use isa::isas;
pub use isa::{Isa, Level, Task, UnknownLevel};
pub(crate) use isa::{Work, dispatch};
pub(crate) use portable::Portable;
pub(crate) use uninit::UninitStack;

/// An instruction set.
pub(crate) trait Simd: Copy {
    /// Four lanes.
    type F4: Lanes<4>;
    /// Eight lanes.
    type F8: Lanes<8> + CompressChildren;
    /// Sixteen lanes.
    type F16: Lanes<16>;
    /// Thirty-two lanes.
    type F32: Lanes<32>;
    /// Whether sixteen lanes are one register: otherwise code with many live registers is faster with eight.
    const WIDE: bool;

    /// Fetches the `BYTES` bytes at an address into the first-level cache, if the address is valid and such an
    /// instruction exists.
    fn prefetch<const BYTES: usize>(start: *const u8);

    /// Writes `base` plus the index of each set bit among the lowest eight to the start of `out`, lowest first, and
    /// returns their count; the rest of `out` is unspecified.
    fn compress_indices(bits: u32, base: u32, out: &mut [u32; 8]) -> usize;

    /// Of eight words, those whose highest bit is set, and those with all bits set: bit `i` is word `i`.
    fn classify(words: &[u32; 8]) -> [u32; 2];

    /// In each lane that of eight numbers whose index the lane of `places` holds, in its lowest three bits.
    fn permute(numbers: &[f32; 8], places: &[u32; 8]) -> Self::F8;

    /// Eight times eight numbers, transposed: lane `i` of row `j` becomes lane `j` of row `i`.
    fn transpose(rows: [Self::F8; 8]) -> [Self::F8; 8];

    /// Of sixteen triples that follow each other the first numbers, the second and the third ones.
    fn deinterleave(triples: &[[f32; 16]; 3]) -> [Self::F16; 3];
}

/// `N` numbers in lanes.
pub(crate) trait Lanes<const N: usize>:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self>
{
    /// The result of comparisons: all or no bits set in each lane.
    type Mask: Mask;

    /// `value` in every lane.
    fn splat(value: f32) -> Self;
    /// The array's elements, in order.
    fn load(values: &[f32; N]) -> Self;
    /// The lanes, in order.
    fn store(self) -> [f32; N];
    /// `self * factor - minuend`, fused or not: for box tests, which leave room for the difference.
    fn mul_sub(self, factor: Self, minuend: Self) -> Self;
    /// The smaller of each pair: of two NaN one of them, of a NaN and a number either.
    fn min(self, other: Self) -> Self;
    /// The larger of each pair: of two NaN one of them, of a NaN and a number either.
    fn max(self, other: Self) -> Self;
    /// Absolute values.
    fn abs(self) -> Self;
    /// The magnitudes of `self` with the signs of `other`, those of zeros and NaN too.
    fn copysign(self, other: Self) -> Self;
    /// `self < other`; false for NaN.
    fn lt(self, other: Self) -> Self::Mask;
    /// `self <= other`; false for NaN.
    fn le(self, other: Self) -> Self::Mask;
    /// `self == other`; false for NaN.
    fn eq(self, other: Self) -> Self::Mask;
    /// `yes` where `mask` is set, else `no`.
    fn select(mask: Self::Mask, yes: Self, no: Self) -> Self;
}

/// One truth value a lane.
pub(crate) trait Mask: Copy + BitAnd<Output = Self> + BitOr<Output = Self> {
    /// How many lanes.
    const LANES: u32;

    /// Bit `i` is lane `i`.
    fn bits(self) -> u32;
    /// The inverse of [`bits`](Self::bits); bits without a lane do not count.
    fn from_bits(bits: u32) -> Self;
}

/// Compression of the eight children of a node in traversal.
pub(crate) trait CompressChildren: Sized {
    /// Writes those children for which `near <= far` to the start of `kept`, and their `near` to that of `distances`,
    /// in `order`: three bits a child, the first one lowest. Returns their count; the rest of the arrays is
    /// unspecified.
    fn compress(
        near: Self,
        far: Self,
        order: u32,
        children: &[u32; 8],
        kept: &mut [u32; 8],
        distances: &mut [f32; 8],
    ) -> usize;
}

/// The lanes set in a bit mask, lowest first.
#[inline(always)]
pub(crate) fn lanes_of(mut bits: u32) -> impl Iterator<Item = usize> {
    core::iter::from_fn(move || {
        let lane = bits.trailing_zeros() as usize;
        bits &= bits.wrapping_sub(1);
        (lane < 32).then_some(lane)
    })
}
