//! Points of the unit circle by their angle in turns, and back.
//!
//! With u in [0, 1) an angle is 2πu. Three reflections, each an exact subtraction, fold u to r in [0, 1/8]; there
//!
//! sin 2πr = r (2π + s S(s)),  cos 2πr = 1 + s C(s),  s = r²,
//!
//! with S and C near-minimax polynomials (interpolated at Chebyshev nodes). As the folds are exact, the error stays
//! relative even beside the zeros of either function: at most 1.6 units in the last place.

use core::f32::consts::{PI, TAU};

use super::ONE_MINUS_EPSILON;

/// What `TAU` lacks of 2π.
const TAU_LOW: f32 = -1.748_455_5e-7;
const SIN: [f32; 3] = [-41.341_663, 81.592_545, -75.401_61];
const COS: [f32; 4] = [-19.739_208, 64.939_37, -85.448_82, 59.424_107];

/// (sin 2πr, cos 2πr) for |r| ≤ 1/8.
#[inline(always)]
pub(super) fn sin_cos_octant(r: f32) -> (f32, f32) {
    let s = r * r;
    let sin = r * TAU + r * (TAU_LOW + s * (SIN[0] + s * (SIN[1] + s * SIN[2])));
    let cos = 1.0 + s * (COS[0] + s * (COS[1] + s * (COS[2] + s * COS[3])));
    (sin, cos)
}

/// (sin 2πu, cos 2πu) for u in [0, 1), each within 1.6 units in the last place. Multiples of 1/4 are exact.
#[inline(always)]
pub fn sin_cos_turns(u: f32) -> (f32, f32) {
    let lower = u >= 0.5;
    let half = if lower { u - 0.5 } else { u };
    let left = half > 0.25;
    let quarter = if left { 0.5 - half } else { half };
    let steep = quarter > 0.125;
    let (sin, cos) = sin_cos_octant(if steep { 0.25 - quarter } else { quarter });
    let (sin, cos) = if steep { (cos, sin) } else { (sin, cos) };
    (if lower { -1.0 } else { 1.0 } * sin, if lower != left { -1.0 } else { 1.0 } * cos)
}

/// The angle of (x, y) in turns, in [0, 1): the inverse of [`sin_cos_turns`]. The origin is at 0.
pub fn turns(y: f32, x: f32) -> f32 {
    let turn = libm::atan2f(y, x) / TAU;
    if turn < 0.0 { (turn + 1.0).min(ONE_MINUS_EPSILON) } else { turn }
}

/// The angle from the x axis to the line through (x, y), |y| ≤ |x|, in octants (8 to a turn): in [-1, 1].
pub(super) fn octants(y: f32, x: f32) -> f32 {
    libm::atanf(y / x) * (4.0 / PI)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::unit_float;

    /// The distance of `x` from `exact` in units of the last place of `exact` as a float.
    fn ulps(x: f32, exact: f64) -> f64 {
        let ulp = (exact.abs().log2().floor() - 23.0).exp2();
        (f64::from(x) - exact).abs() / ulp
    }

    #[test]
    fn error_is_within_the_stated_bound() {
        let mut worst = 0.0f64;
        // Every 5th value of the 24-bit grid, and values far below its spacing.
        let grid = (0..1 << 24).step_by(5).map(|k| unit_float(k << 8));
        let tiny = (1..4000).map(|k| k as f32 * 3.1e-9);
        for u in grid.chain(tiny) {
            let (sin, cos) = sin_cos_turns(u);
            // Reduced before the multiplication by 2π, whose rounding would drown the values near the zeros.
            let exact = |turns: f64| {
                let quadrant = (turns * 4.0).round();
                let (s, c) = ((turns - quadrant / 4.0) * core::f64::consts::TAU).sin_cos();
                [(s, c), (c, -s), (-s, -c), (-c, s)][quadrant as usize % 4]
            };
            let (exact_sin, exact_cos) = exact(f64::from(u));
            for (x, exact) in [(sin, exact_sin), (cos, exact_cos)] {
                if exact == 0.0 {
                    assert_eq!(x, 0.0, "u = {u}");
                } else {
                    worst = worst.max(ulps(x, exact));
                }
            }
        }
        assert!(worst <= 1.6, "{worst} ulp");
        // Rounding alone costs half a unit: less would be an error of the measurement.
        assert!(worst > 0.5, "{worst} ulp");
    }

    #[test]
    fn quarter_turns_are_exact() {
        assert_eq!(sin_cos_turns(0.0), (0.0, 1.0));
        assert_eq!(sin_cos_turns(0.25), (1.0, 0.0));
        assert_eq!(sin_cos_turns(0.5), (0.0, -1.0));
        assert_eq!(sin_cos_turns(0.75), (-1.0, 0.0));
    }

    #[test]
    fn turns_inverts() {
        for k in (0..1 << 24).step_by(997) {
            let u = unit_float(k << 8);
            let (sin, cos) = sin_cos_turns(u);
            let difference = turns(sin, cos) - u;
            assert!((difference - difference.round()).abs() < 1.5e-7, "u = {u}: {difference}");
        }
        assert_eq!(turns(0.0, 0.0), 0.0);
        assert_eq!(turns(-1e-30, 1.0), ONE_MINUS_EPSILON);
        assert_eq!(turns(-1.0, 0.0), 0.75);
    }
}
