//! Time: motion is given at keys, evenly spaced over 0..=1, and is linear between them.
//!
//! `lerp(a, b, f) = (1 - f) a + f b`, each operation rounded. None of them reverses an order, so if `a` is at most `c`
//! and `b` at most `d`, then `lerp(a, b, f)` is at most `lerp(c, d, f)`, rounding included: an interpolated box
//! encloses everything that it encloses at both keys, without a tolerance.

use glam::Vec3;

use super::Aabb;

/// A time between two keys: the key interval and fraction at which a [`MovingBvh`](crate::bvh::MovingBvh) is
/// interpolated for a ray's time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moment {
    /// The key at or before the time.
    pub key: usize,
    /// The fraction of the interval to the next key: 0 at the key itself, never 1.
    pub fraction: f32,
}

impl Moment {
    /// The moment of `time`, clamped to 0..=1, where there are `keys`, at least one; `None` if it is NaN.
    ///
    /// The product is exact and then rounded once, so that different numbers of keys agree on a time.
    #[inline(always)]
    pub fn new(time: f32, keys: usize) -> Option<Self> {
        if time.is_nan() {
            return None;
        }
        let place = f64::from(time.clamp(0.0, 1.0)) * (keys - 1) as f64;
        let key = place as usize;
        let fraction = (place - key as f64) as f32;
        Some(if fraction < 1.0 { Self { key, fraction } } else { Self { key: key + 1, fraction: 0.0 } })
    }

    /// The box between those of two keys.
    pub(crate) fn aabb(self, from: &Aabb, to: &Aabb) -> Aabb {
        Aabb { min: self.vector(from.min, to.min), max: self.vector(from.max, to.max) }
    }

    /// The vector between those of this key and the next, or that of this key at the key itself.
    #[inline(always)]
    pub fn vector(self, from: Vec3, to: Vec3) -> Vec3 {
        from * (1.0 - self.fraction) + to * self.fraction
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_are_met_exactly() {
        for keys in 1..20 {
            for key in 0..keys {
                let time = key as f64 / (keys - 1).max(1) as f64;
                let moment = Moment::new(time as f32, keys).unwrap();
                let place = moment.key as f64 + f64::from(moment.fraction);
                assert!((place - key as f64).abs() < 1e-6 * keys as f64, "{keys} {key} {moment:?}");
            }
        }
        let at = |key, fraction| Some(Moment { key, fraction });
        assert_eq!(Moment::new(0.5, 3), at(1, 0.0));
        assert_eq!(Moment::new(0.75, 5), at(3, 0.0));
        assert_eq!(Moment::new(0.625, 3), at(1, 0.25));
        assert_eq!(
            (Moment::new(-7.0, 3), Moment::new(9.0, 3), Moment::new(0.3, 1)),
            (at(0, 0.0), at(2, 0.0), at(0, 0.0))
        );
        assert_eq!(Moment::new(f32::NAN, 2), None);
        // Just before a key: rounded to it.
        assert_eq!(Moment::new(0.5f32.next_down(), (1 << 24) + 1).unwrap().fraction, 0.5);
        assert_eq!(Moment::new(1.0f32.next_down(), 2).unwrap(), Moment { key: 0, fraction: 1.0f32.next_down() });
        assert_eq!(Moment::new(0.5f32.next_down(), 3).unwrap(), Moment { key: 0, fraction: 1.0f32.next_down() });
    }
}
