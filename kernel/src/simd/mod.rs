//! Lanes of `f32`: the few operations that the kernels are written in, and their backends.
//!
//! The kernels are generic over [`Lanes`], so that one loop serves every width and instruction set. Every operation is
//! IEEE 754 exact (correctly rounded, nothing fused), which is what makes results equal bit for bit on all backends.
//! [`min`](Lanes::min) and [`max`](Lanes::max) are the exception: on NaN, or on zeros of both signs, backends may
//! differ, so no kernel lets such a difference reach a result.

mod portable;

use core::ops::{Add, BitAnd, BitOr, Div, Mul, Sub};

/// `N` numbers that are computed with together.
pub(crate) trait Lanes<const N: usize>:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self>
{
    /// What comparisons give: all or no bits set in each lane.
    type Mask: Mask;

    /// `value` in every lane.
    fn splat(value: f32) -> Self;
    /// The array's elements, in order.
    fn load(values: &[f32; N]) -> Self;
    /// The lanes, in order.
    fn store(self) -> [f32; N];
    /// The smaller of each pair; no NaN may be among them.
    fn min(self, other: Self) -> Self;
    /// The larger of each pair; no NaN may be among them.
    fn max(self, other: Self) -> Self;
    /// Absolute values.
    fn abs(self) -> Self;
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
    /// Bit `i` is lane `i`.
    fn bits(self) -> u32;
}

/// The lanes set in a bit mask, lowest first.
pub(crate) fn lanes_of(mut bits: u32) -> impl Iterator<Item = usize> {
    core::iter::from_fn(move || {
        let lane = bits.trailing_zeros() as usize;
        bits &= bits.wrapping_sub(1);
        (lane < 32).then_some(lane)
    })
}
