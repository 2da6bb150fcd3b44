//! The few vector operations that samplers in lanes need, over 4 or 8 floats.

use core::ops::{Add, Div, Mul, Sub};

use wide::{f32x4, f32x8};

/// A vector of `f32` whose every operation rounds each lane as the scalar operation does.
pub trait Lanes:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self> + 'static
{
    /// The same value in every lane.
    fn splat(value: f32) -> Self;
    /// The square roots.
    fn sqrt(self) -> Self;
    /// The absolute values.
    fn abs(self) -> Self;
    /// A mask: all bits set in the lanes where `self > other`, none elsewhere.
    fn greater(self, other: Self) -> Self;
    /// `set` in the lanes where `mask` is set, `clear` elsewhere.
    fn select(mask: Self, set: Self, clear: Self) -> Self;
    /// Applies a scalar function lane by lane.
    fn each(self, f: impl Fn(f32) -> f32) -> Self;
}

macro_rules! lanes {
    ($vector:ty) => {
        impl Lanes for $vector {
            #[inline]
            fn splat(value: f32) -> Self {
                <$vector>::splat(value)
            }
            #[inline]
            fn sqrt(self) -> Self {
                <$vector>::sqrt(self)
            }
            #[inline]
            fn abs(self) -> Self {
                <$vector>::abs(self)
            }
            #[inline]
            fn greater(self, other: Self) -> Self {
                self.simd_gt(other)
            }
            #[inline]
            fn select(mask: Self, set: Self, clear: Self) -> Self {
                mask.bitselect(set, clear)
            }
            #[inline]
            fn each(self, f: impl Fn(f32) -> f32) -> Self {
                Self::new(self.to_array().map(f))
            }
        }
    };
}

lanes!(f32x4);
lanes!(f32x8);
