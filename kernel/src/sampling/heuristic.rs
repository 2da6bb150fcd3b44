//! Weights for multiple importance sampling (Veach and Guibas, 1995).
//!
//! A sample of strategy a that strategy b could have made too counts with w = a^β / (a^β + b^β), where a and b are the
//! strategies' densities times their numbers of samples. The weights of both strategies add up to 1.
//!
//! An infinite density is a delta distribution: against a finite one it takes all the weight. Two of them share it,
//! and if neither density is positive the weight is 0.

/// The balance heuristic, β = 1. `a` and `b` are at least 0.
#[inline]
pub fn balance(a: f32, b: f32) -> f32 {
    share(a, b, |ratio| ratio)
}

/// The power heuristic, β = 2. `a` and `b` are at least 0. No square overflows or vanishes: only ratios are squared.
#[inline]
pub fn power(a: f32, b: f32) -> f32 {
    share(a, b, |ratio| ratio * ratio)
}

/// a^β / (a^β + b^β) by `raise` of the lesser over the greater.
#[inline]
fn share(a: f32, b: f32, raise: impl Fn(f32) -> f32) -> f32 {
    if a == b {
        if a > 0.0 { 0.5 } else { 0.0 }
    } else if a > b {
        1.0 / (1.0 + raise(b / a))
    } else {
        let part = raise(a / b);
        part / (1.0 + part)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_are_the_published_ones() {
        assert_eq!(balance(3.0, 1.0), 0.75);
        assert_eq!(balance(1.0, 3.0), 0.25);
        assert_eq!(power(3.0, 1.0), 0.9);
        assert_eq!(power(1.0, 3.0), 0.1);
        assert_eq!((balance(2.0, 2.0), power(2.0, 2.0)), (0.5, 0.5));
    }

    #[test]
    fn extremes_are_finite() {
        for weight in [balance, power] {
            assert_eq!(weight(f32::INFINITY, 2.0), 1.0);
            assert_eq!(weight(2.0, f32::INFINITY), 0.0);
            assert_eq!(weight(f32::INFINITY, f32::INFINITY), 0.5);
            assert_eq!(weight(0.0, 0.0), 0.0);
            assert_eq!(weight(2.0, 0.0), 1.0);
            assert_eq!(weight(0.0, 2.0), 0.0);
            assert_eq!(weight(f32::MAX, f32::MIN_POSITIVE), 1.0);
        }
        assert!((power(3e30, 1e30) - 0.9).abs() < 1e-7);
        assert!((power(3e-30, 1e-30) - 0.9).abs() < 1e-7);
    }

    #[test]
    fn weights_add_up_to_one() {
        for i in 1..200 {
            for j in 1..200 {
                let (a, b) = (i as f32 * 0.37, 1.0 / j as f32);
                assert!((balance(a, b) + balance(b, a) - 1.0).abs() < 1.2e-7);
                assert!((power(a, b) + power(b, a) - 1.0).abs() < 1.2e-7);
                assert!((f64::from(balance(a, b)) - f64::from(a) / (f64::from(a) + f64::from(b))).abs() < 1.2e-7);
            }
        }
    }
}
