//! Sixteen or thirty-two lanes where registers hold half as many: two of them side by side.

use core::ops::{Add, BitAnd, BitOr, Div, Mul, Sub};

use super::{Lanes, Mask};

/// Two sets of lanes, or two masks: the lower lanes first.
#[derive(Clone, Copy)]
pub(crate) struct Twice<T>(pub(super) T, pub(super) T);

macro_rules! operator {
    ($trait:ident, $method:ident) => {
        impl<T: $trait<Output = T>> $trait for Twice<T> {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                Self(self.0.$method(other.0), self.1.$method(other.1))
            }
        }
    };
}

operator!(Add, add);
operator!(Sub, sub);
operator!(Mul, mul);
operator!(Div, div);
operator!(BitAnd, bitand);
operator!(BitOr, bitor);

macro_rules! lanes {
    ($half:literal, $both:literal) => {
        impl<L: Lanes<$half>> Lanes<$both> for Twice<L> {
            type Mask = Twice<L::Mask>;

            #[inline(always)]
            fn splat(value: f32) -> Self {
                Self(L::splat(value), L::splat(value))
            }
            #[inline(always)]
            fn load(values: &[f32; $both]) -> Self {
                let (low, high) = values.first_chunk().zip(values.last_chunk()).expect("twice as many");
                Self(L::load(low), L::load(high))
            }
            #[inline(always)]
            fn store(self) -> [f32; $both] {
                let mut values = [0.0; $both];
                values[..$half].copy_from_slice(&self.0.store());
                values[$half..].copy_from_slice(&self.1.store());
                values
            }
            #[inline(always)]
            fn mul_sub(self, factor: Self, minuend: Self) -> Self {
                Self(self.0.mul_sub(factor.0, minuend.0), self.1.mul_sub(factor.1, minuend.1))
            }
            #[inline(always)]
            fn min(self, other: Self) -> Self {
                Self(self.0.min(other.0), self.1.min(other.1))
            }
            #[inline(always)]
            fn max(self, other: Self) -> Self {
                Self(self.0.max(other.0), self.1.max(other.1))
            }
            #[inline(always)]
            fn abs(self) -> Self {
                Self(self.0.abs(), self.1.abs())
            }
            #[inline(always)]
            fn copysign(self, other: Self) -> Self {
                Self(self.0.copysign(other.0), self.1.copysign(other.1))
            }
            #[inline(always)]
            fn lt(self, other: Self) -> Self::Mask {
                Twice(self.0.lt(other.0), self.1.lt(other.1))
            }
            #[inline(always)]
            fn le(self, other: Self) -> Self::Mask {
                Twice(self.0.le(other.0), self.1.le(other.1))
            }
            #[inline(always)]
            fn eq(self, other: Self) -> Self::Mask {
                Twice(self.0.eq(other.0), self.1.eq(other.1))
            }
            #[inline(always)]
            fn select(mask: Self::Mask, yes: Self, no: Self) -> Self {
                Self(L::select(mask.0, yes.0, no.0), L::select(mask.1, yes.1, no.1))
            }
        }
    };
}

lanes!(8, 16);
lanes!(16, 32);

impl<M: Mask> Mask for Twice<M> {
    const LANES: u32 = 2 * M::LANES;

    #[inline(always)]
    fn bits(self) -> u32 {
        self.0.bits() | self.1.bits() << M::LANES
    }
    #[inline(always)]
    fn from_bits(bits: u32) -> Self {
        Self(M::from_bits(bits), M::from_bits(bits >> M::LANES))
    }
}
