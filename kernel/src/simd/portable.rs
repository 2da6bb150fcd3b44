//! The backend for every target, by the crate `wide`: SSE2, NEON, wasm's simd128, or plain code where there is none.

use super::{Lanes, Mask};

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
            #[inline(always)]
            fn bits(self) -> u32 {
                self.to_bitmask()
            }
        }
    };
}

portable!(wide::f32x4, 4);
portable!(wide::f32x8, 8);

#[cfg(test)]
mod tests {
    use super::*;

    /// Every operation against the same operation on plain numbers, over pairs that include zeros, infinities and NaN.
    fn check<const N: usize, L: Lanes<N>>() {
        let values = [0.0, -0.0, 1.0, -1.5, 1e-40, -3e38, f32::INFINITY, f32::NEG_INFINITY, f32::NAN, 0.1, 7.0, 1e30];
        for (i, _) in values.iter().enumerate() {
            for (j, _) in values.iter().enumerate() {
                let a: [f32; N] = core::array::from_fn(|k| values[(i + k) % values.len()]);
                let b: [f32; N] = core::array::from_fn(|k| values[(j + 3 * k) % values.len()]);
                let (x, y) = (L::load(&a), L::load(&b));
                let same = |lanes: L, scalar: &dyn Fn(f32, f32) -> f32| {
                    for (k, value) in lanes.store().into_iter().enumerate() {
                        let expected = scalar(a[k], b[k]);
                        assert!(value.to_bits() == expected.to_bits() || value.is_nan() && expected.is_nan());
                    }
                };
                same(x + y, &|p, q| p + q);
                same(x - y, &|p, q| p - q);
                same(x * y, &|p, q| p * q);
                same(x / y, &|p, q| p / q);
                same(x.abs(), &|p, _| p.abs());
                same(L::splat(2.5), &|_, _| 2.5);
                same(L::select(x.lt(y), x, y), &|p, q| if p < q { p } else { q });
                let bits = |mask: L::Mask, scalar: &dyn Fn(f32, f32) -> bool| {
                    let expected = (0..N).map(|k| (scalar(a[k], b[k]) as u32) << k).sum::<u32>();
                    assert_eq!(mask.bits(), expected);
                };
                bits(x.lt(y), &|p, q| p < q);
                bits(x.le(y), &|p, q| p <= q);
                bits(x.eq(y), &|p, q| p == q);
                bits(x.lt(y) | x.eq(y), &|p, q| p <= q);
                bits(x.le(y) & y.le(x), &|p, q| p == q);
                for k in 0..N {
                    if !a[k].is_nan() && !b[k].is_nan() {
                        assert_eq!(x.min(y).store()[k], a[k].min(b[k]));
                        assert_eq!(x.max(y).store()[k], a[k].max(b[k]));
                    }
                }
            }
        }
    }

    #[test]
    fn lanes_compute_as_scalars_do() {
        check::<4, wide::f32x4>();
        check::<8, wide::f32x8>();
    }

    #[test]
    fn set_lanes_are_listed_in_order() {
        assert!(super::super::lanes_of(0b1010_0001).eq([0, 5, 7]));
        assert!(super::super::lanes_of(0).next().is_none());
        assert!(super::super::lanes_of(u32::MAX).eq(0..32));
    }
}
