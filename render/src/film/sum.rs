//! Sums that do not depend on the order of what is added, so that tiles, threads, processes and machines may divide a
//! picture's samples among them at will and arrive at the same bytes.
//!
//! A sum is an integer of 128 bits in units of 2⁻⁶⁴. What is added is rounded once, towards zero, to such a unit, and
//! bounded by 2⁴⁰; then all is exact: 2²³ samples of the greatest value fit, and any number of a picture's usual ones.
//! A `f64` that is the product of two `f32`, as a weight and a radiance, loses nothing if it is more than 2⁻¹⁶.

/// The greatest magnitude of what is added.
pub(crate) const MAX: f64 = (1_u64 << 40) as f64;

/// A one in units.
const ONE: f64 = 18_446_744_073_709_551_616.0;
const UNIT: f64 = 1.0 / ONE;

/// The significand's bits in a `f64`, without the first.
const FRACTION: u32 = 52;
/// The exponent field of a `f64` whose significand, as an integer, counts units of a sum.
const EXPONENT_OF_UNIT: i32 = 1023 + FRACTION as i32 - 64;

/// A sum of numbers of either sign.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Sum(pub(super) i128);

/// A sum of numbers that are not negative and of which large ones matter little: it stays at 2⁶⁴ once it is there.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct PositiveSum(pub(super) u128);

impl Sum {
    /// Adds a finite number, or the bound of its sign if it is beyond.
    #[inline]
    pub(crate) fn add(&mut self, value: f64) {
        self.0 = self.0.wrapping_add(signed_units(value.clamp(-MAX, MAX)));
    }

    /// Adds all that another sum has.
    pub(crate) fn merge(&mut self, other: Self) {
        self.0 = self.0.wrapping_add(other.0);
    }

    /// What the others of all have.
    pub(crate) fn without(self, part: Self) -> Self {
        Self(self.0.wrapping_sub(part.0))
    }

    /// The sum, rounded once.
    pub(crate) fn value(self) -> f64 {
        self.0 as f64 * UNIT
    }
}

impl PositiveSum {
    /// Adds a finite number that is not negative.
    #[inline]
    pub(crate) fn add(&mut self, value: f64) {
        self.0 = self.0.saturating_add(units(value.min(ONE / 2.0)));
    }

    /// Adds all that another sum has.
    pub(crate) fn merge(&mut self, other: Self) {
        self.0 = self.0.saturating_add(other.0);
    }

    /// The sum, rounded once.
    pub(crate) fn value(self) -> f64 {
        self.0 as f64 * UNIT
    }
}

/// The units in a number of at most 2⁴⁰: those of its multiple of 2⁻¹² and of the rest, both exact. (The compiler's own
/// conversion is a call, and takes longer.)
#[inline]
fn signed_units(value: f64) -> i128 {
    const UPPER: f64 = (1 << 12) as f64;
    let upper = (value * UPPER) as i64;
    let lower = ((value - upper as f64 / UPPER) * ONE) as i64;
    (i128::from(upper) << 52) + i128::from(lower)
}

/// The units in a number from 0 to 2⁶³.
#[inline]
fn units(value: f64) -> u128 {
    let bits = value.to_bits();
    let significand = (bits & ((1 << FRACTION) - 1)) | (1 << FRACTION);
    let shift = (bits >> FRACTION) as i32 - EXPONENT_OF_UNIT;
    // Numbers without the first bit are far below a unit, as all are that are shifted out.
    if shift >= 0 { u128::from(significand) << shift } else { u128::from(significand >> (-shift).min(63)) }
}

#[cfg(test)]
mod tests {
    use halfdome_kernel::sampling::Stream;

    use super::*;

    #[test]
    fn units_are_those_of_the_compilers_conversion() {
        let edges = [0.0, f64::MIN_POSITIVE, 5e-324, UNIT, (-65.0_f64).exp2(), 1.0, MAX, ONE / 2.0];
        for value in edges {
            assert_eq!(units(value), (value * ONE) as u128, "{value}");
        }
        for value in [0.0, -0.0, 1.0, -1.0, MAX, -MAX, -0.1, UNIT, UNIT / 2.0] {
            assert_eq!(signed_units(value), (value * ONE) as i128, "{value}");
        }
        for i in 0..100_000 {
            let [a, b, c, _] = Stream::new(1, i, 0).uniform4(0);
            let value = f64::from(a) * f64::from(b) * f64::from(c * 140.0 - 80.0).exp2().min(ONE / 2.0);
            assert_eq!(units(value), (value * ONE) as u128, "{value}");
            let value = value.min(MAX) * if i % 2 == 0 { 1.0 } else { -1.0 };
            assert_eq!(signed_units(value), (value * ONE) as i128, "{value}");
        }
    }

    #[test]
    fn sums_are_exact_in_any_order_and_split() {
        let values: Vec<f64> = (0..1000)
            .map(|i| {
                let [a, b, c, _] = Stream::new(2, i, 0).uniform4(0);
                f64::from(a - 0.3) * f64::from(b) * f64::from((c * 60.0 - 30.0).exp2())
            })
            .collect();
        let sum = |values: &mut dyn Iterator<Item = f64>| {
            let mut sum = Sum::default();
            values.for_each(|value| sum.add(value));
            sum
        };
        let all = sum(&mut values.iter().copied());
        assert_eq!(all, sum(&mut values.iter().rev().copied()));
        let (first, second) = values.split_at(377);
        let (first, second) = (sum(&mut first.iter().copied()), sum(&mut second.iter().copied()));
        let mut merged = second;
        merged.merge(first);
        assert_eq!((merged, all.without(first)), (all, second));
        let expected: f64 = values.iter().sum();
        assert!((all.value() - expected).abs() < 1e-9 * values.iter().map(|value| value.abs()).sum::<f64>());
        assert_eq!(sum(&mut [0.1_f32, 0.1, 0.1].map(f64::from).into_iter()).value(), 3.0 * f64::from(0.1_f32));
    }

    #[test]
    fn what_is_too_great_is_bounded() {
        let mut sum = Sum::default();
        [f64::MAX, -1e300, -1.5].into_iter().for_each(|value| sum.add(value));
        assert_eq!(sum.value(), -1.5);
        let mut squares = PositiveSum::default();
        [1e30, 3.0, 1e30, 1e30].into_iter().for_each(|value| squares.add(value));
        assert_eq!(squares.value(), ONE);
    }
}
