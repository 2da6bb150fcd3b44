//! Sixteen lanes where registers hold eight: two of them side by side.

use core::ops::{Add, BitAnd, BitOr, Div, Mul, Sub};

use super::{Lanes, Mask};

/// Two sets of lanes, or two masks: the lower lanes first.
#[derive(Clone, Copy)]
pub(crate) struct Twice<T>(T, T);

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

impl<L: Lanes<8>> Lanes<16> for Twice<L> {
    type Mask = Twice<L::Mask>;

    #[inline(always)]
    fn splat(value: f32) -> Self {
        Self(L::splat(value), L::splat(value))
    }
    #[inline(always)]
    fn load(values: &[f32; 16]) -> Self {
        let (low, high) = halves(values);
        Self(L::load(low), L::load(high))
    }
    #[inline(always)]
    fn store(self) -> [f32; 16] {
        let mut values = [0.0; 16];
        values[..8].copy_from_slice(&self.0.store());
        values[8..].copy_from_slice(&self.1.store());
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

impl<M: Mask> Mask for Twice<M> {
    #[inline(always)]
    fn bits(self) -> u32 {
        self.0.bits() | self.1.bits() << 8
    }
    #[inline(always)]
    fn from_bits(bits: u32) -> Self {
        Self(M::from_bits(bits), M::from_bits(bits >> 8))
    }
}

#[inline(always)]
fn halves(values: &[f32; 16]) -> (&[f32; 8], &[f32; 8]) {
    values.first_chunk().zip(values.last_chunk()).expect("sixteen are twice eight")
}
