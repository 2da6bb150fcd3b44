//! Pixel filters: the weight that a pixel gives to light around its centre.
//!
//! Every filter is separable, `f(x, y) = p(x / r) p(y / r) / r²` with half the width `r` and a profile `p` on [-1, 1]
//! that integrates to one. So every filter integrates to one, whatever its width, and a wider one only blurs more.
//!
//! The Gaussian's standard deviation is a sixth of the width: the border lies at three deviations, and what the
//! filter cuts off there is 0.3 % of a Gaussian's mass.
//!
//! Sources: Mitchell and Netravali, "Reconstruction Filters in Computer Graphics", 1988; Pharr, Jakob and Humphreys,
//! "Physically Based Rendering", 4th edition, 8.8, for the choice of filters.

use core::fmt;

/// A separable pixel filter, centred on the pixel. Widths are full widths in pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Filter {
    /// Constant.
    Box {
        /// Full width.
        width: f32,
    },
    /// Linear fall-off to zero at the border.
    Tent {
        /// Full width.
        width: f32,
    },
    /// A Gaussian less its value at the border, so that it ends at zero. Its standard deviation is `width / 6`.
    Gaussian {
        /// Full width.
        width: f32,
    },
    /// Mitchell and Netravali's cubic with `C = sharpness / 2` and `B = 1 - sharpness`.
    Mitchell {
        /// Full width; the paper's cubic is 4 wide.
        width: f32,
        /// From 0 (soft, the cubic B-spline) to 1 (Catmull-Rom); 2/3 is what the authors recommend.
        sharpness: f32,
    },
}

/// A filter that cannot be used: what is wrong, and what would be right.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub struct FilterError {
    /// The problem, as a sentence without a capital or a full stop.
    pub problem: String,
    /// The remedy, likewise.
    pub remedy: String,
}

impl fmt::Display for FilterError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}\n  help: {}", self.problem, self.remedy)
    }
}

impl Default for Filter {
    fn default() -> Self {
        Self::Box { width: 1.0 }
    }
}

impl Filter {
    /// The names that [`Filter::from_name`] knows.
    pub const NAMES: [&'static str; 4] = ["box", "tent", "gaussian", "mitchell"];

    /// The widest filter that is allowed, in pixels. Larger widths would blur the picture away.
    pub const MAX_WIDTH: f32 = 64.0;

    /// The filter called `name`, with its own width (box 1, tent 2, Gaussian 3, Mitchell 4) and sharpness (2/3) unless
    /// they are given.
    ///
    /// # Errors
    /// An unknown name, a sharpness for a filter that has none, or what [`Filter::validate`] finds.
    pub fn from_name(name: &str, width: Option<f32>, sharpness: Option<f32>) -> Result<Self, FilterError> {
        let filter = match name {
            "box" => Self::Box { width: width.unwrap_or(1.0) },
            "tent" => Self::Tent { width: width.unwrap_or(2.0) },
            "gaussian" => Self::Gaussian { width: width.unwrap_or(3.0) },
            "mitchell" => Self::Mitchell { width: width.unwrap_or(4.0), sharpness: sharpness.unwrap_or(2.0 / 3.0) },
            _ => {
                return Err(FilterError {
                    problem: format!("there is no pixel filter {name:?}"),
                    remedy: format!("choose one of {}", Self::NAMES.join(", ")),
                });
            }
        };
        if sharpness.is_some() && !matches!(filter, Self::Mitchell { .. }) {
            return Err(FilterError {
                problem: format!("the {name} filter has no sharpness"),
                remedy: "leave the sharpness out, or choose mitchell".to_owned(),
            });
        }
        filter.validate()?;
        Ok(filter)
    }

    /// The name that [`Filter::from_name`] takes.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Box { .. } => "box",
            Self::Tent { .. } => "tent",
            Self::Gaussian { .. } => "gaussian",
            Self::Mitchell { .. } => "mitchell",
        }
    }

    /// Full width in pixels, along either axis.
    pub fn width(&self) -> f32 {
        match *self {
            Self::Box { width } | Self::Tent { width } | Self::Gaussian { width } | Self::Mitchell { width, .. } => {
                width
            }
        }
    }

    /// Checks the width (above 0, up to [`Filter::MAX_WIDTH`]) and the sharpness (0 to 1).
    ///
    /// # Errors
    /// Says which of them is out of its range.
    pub fn validate(&self) -> Result<(), FilterError> {
        let width = self.width();
        if !(width > 0.0 && width <= Self::MAX_WIDTH) {
            return Err(FilterError {
                problem: format!("the {} filter cannot be {width} pixels wide", self.name()),
                remedy: format!("give a width above 0, up to {} pixels", Self::MAX_WIDTH),
            });
        }
        match *self {
            Self::Mitchell { sharpness, .. } if !(0.0..=1.0).contains(&sharpness) => Err(FilterError {
                problem: format!("the sharpness {sharpness} of the mitchell filter is out of range"),
                remedy: "give a sharpness from 0 (soft) to 1 (sharp)".to_owned(),
            }),
            _ => Ok(()),
        }
    }

    /// The filter at `x` and `y` pixels from the pixel's centre, per square pixel; zero at the border and beyond.
    pub fn value(&self, x: f32, y: f32) -> f32 {
        let radius = 0.5 * f64::from(self.width());
        let along = |offset: f32| self.profile(f64::from(offset) / radius) / radius;
        (along(x) * along(y)) as f32
    }

    /// The profile along one axis: even, zero from `|t| = 1` on, with integral one over [-1, 1].
    pub(crate) fn profile(&self, t: f64) -> f64 {
        let t = t.abs();
        if t >= 1.0 {
            return 0.0;
        }
        match *self {
            Self::Box { .. } => 0.5,
            Self::Tent { .. } => 1.0 - t,
            Self::Gaussian { .. } => {
                // Three deviations fit into 1: exp(-t² / (2 (1/3)²)). The integral is √(2π)/3 erf(3/√2) - 2 exp(-4.5).
                const INTEGRAL: f64 = 0.811_068_970_084_546_9;
                ((-4.5 * t * t).exp() - (-4.5_f64).exp()) / INTEGRAL
            }
            Self::Mitchell { sharpness, .. } => 2.0 * mitchell(2.0 * t, f64::from(sharpness)),
        }
    }
}

/// Mitchell and Netravali's cubic, equation 8, at distance `x` in 0..2, along the line `B + 2C = 1` of their figure 13.
fn mitchell(x: f64, sharpness: f64) -> f64 {
    let (b, c) = (1.0 - sharpness, 0.5 * sharpness);
    let polynomial = if x < 1.0 {
        [12.0 - 9.0 * b - 6.0 * c, -18.0 + 12.0 * b + 6.0 * c, 0.0, 6.0 - 2.0 * b]
    } else {
        [-b - 6.0 * c, 6.0 * b + 30.0 * c, -12.0 * b - 48.0 * c, 8.0 * b + 24.0 * c]
    };
    polynomial.iter().fold(0.0, |sum, coefficient| sum * x + coefficient) / 6.0
}

#[cfg(test)]
mod tests {
    use super::*;

    fn filters() -> Vec<Filter> {
        let mut filters = Vec::new();
        for width in [0.5, 1.0, 3.0, 4.0] {
            filters.extend([Filter::Box { width }, Filter::Tent { width }, Filter::Gaussian { width }]);
            filters.extend([0.0, 0.3, 2.0 / 3.0, 1.0].map(|sharpness| Filter::Mitchell { width, sharpness }));
        }
        filters
    }

    #[test]
    fn every_filter_integrates_to_one() {
        for filter in filters() {
            // Midpoints: exact for constant and linear pieces, and of second order for the others.
            let cells = 400;
            let step = filter.width() / cells as f32;
            let at = |i: usize| (i as f32 + 0.5) * step - 0.5 * filter.width();
            let sum: f64 =
                (0..cells).flat_map(|i| (0..cells).map(move |j| f64::from(filter.value(at(i), at(j))))).sum();
            let integral = sum * f64::from(step * step);
            assert!((integral - 1.0).abs() < 2e-5, "{filter:?}: {integral}");
        }
    }

    #[test]
    fn every_profile_integrates_to_one() {
        for filter in filters() {
            // Simpson's rule, which is exact for cubics; cells end where the pieces of the profiles do. The nudge keeps
            // clear of the border, where the box jumps.
            let (cells, end) = (256, 1.0 - 1e-13);
            let h = 1.0 / f64::from(cells);
            let at = |t: f64| filter.profile(t.min(end));
            let cell = |i: i32| at(h * f64::from(i)) + 4.0 * at(h * (f64::from(i) + 0.5)) + at(h * f64::from(i + 1));
            let integral: f64 = (0..cells).map(cell).sum::<f64>() * h / 3.0;
            assert!((integral - 1.0).abs() < 1e-9, "{filter:?}: {integral}");
        }
    }

    #[test]
    fn every_filter_is_even_separable_and_ends_at_its_border() {
        for filter in filters() {
            let r = 0.5 * filter.width();
            let (x, y) = (0.3 * r, 0.7 * r);
            let value = filter.value(x, y);
            assert_eq!(value, filter.value(-x, y));
            assert_eq!(value, filter.value(y, x));
            let product = filter.value(x, 0.0) * filter.value(0.0, y);
            assert!((value * filter.value(0.0, 0.0) - product).abs() <= 1e-6 * product.abs());
            assert_eq!(filter.value(r, 0.0), 0.0);
            assert_eq!(filter.value(0.0, -1.01 * r), 0.0);
        }
    }

    #[test]
    fn the_simple_filters_have_the_values_of_their_formulas() {
        assert_eq!(Filter::Box { width: 2.0 }.value(0.9, -0.9), 0.25);
        assert_eq!(Filter::Tent { width: 2.0 }.value(0.25, 0.5), 0.75 * 0.5);
        assert_eq!(Filter::Tent { width: 4.0 }.value(0.0, 1.0), 0.5 * 0.25);
        // A deviation of half a pixel: the ratio of two values above the border's.
        let gaussian = Filter::Gaussian { width: 3.0 };
        let border = (-4.5_f32).exp();
        let ratio = ((-0.5_f32).exp() - border) / (1.0 - border);
        assert!((gaussian.value(0.5, 0.0) / gaussian.value(0.0, 0.0) - ratio).abs() < 1e-6);
    }

    #[test]
    fn mitchell_has_the_published_values() {
        // B = C = 1/3: 8/9 at the centre, 1/18 one pixel away.
        let filter = Filter::Mitchell { width: 4.0, sharpness: 2.0 / 3.0 };
        assert!((filter.value(0.0, 0.0) - 64.0 / 81.0).abs() < 1e-6);
        assert!((filter.value(1.0, 0.0) - 8.0 / 162.0).abs() < 1e-6);
        assert!(filter.value(1.5, 0.0) < 0.0, "the lobe is negative");
    }

    #[test]
    fn mitchell_of_width_4_is_a_partition_of_unity() {
        for sharpness in [0.0, 0.25, 2.0 / 3.0, 1.0] {
            let filter = Filter::Mitchell { width: 4.0, sharpness };
            for x in [0.0, 0.125, 0.5, 0.9] {
                let sum: f64 = (-3..=3).map(|k| 0.5 * filter.profile(0.5 * (x + f64::from(k)))).sum();
                assert!((sum - 1.0).abs() < 1e-12, "sharpness {sharpness}, {x}: {sum}");
            }
        }
    }

    #[test]
    fn the_extremes_of_sharpness_are_the_b_spline_and_catmull_rom() {
        let along = |sharpness, x: f64| 0.5 * Filter::Mitchell { width: 4.0, sharpness }.profile(0.5 * x);
        for i in 0..20 {
            let x = 0.1 * f64::from(i);
            let b_spline = if x < 1.0 { 2.0 / 3.0 - x * x + x.powi(3) / 2.0 } else { (2.0 - x).powi(3) / 6.0 };
            assert!((along(0.0, x) - b_spline).abs() < 1e-12);
            let catmull_rom = if x < 1.0 {
                1.0 - 2.5 * x * x + 1.5 * x.powi(3)
            } else {
                2.0 - 4.0 * x + 2.5 * x * x - 0.5 * x.powi(3)
            };
            assert!((along(1.0, x) - catmull_rom).abs() < 1e-12);
        }
    }

    #[test]
    fn names_lead_to_filters_and_back() {
        let defaults = [
            Filter::Box { width: 1.0 },
            Filter::Tent { width: 2.0 },
            Filter::Gaussian { width: 3.0 },
            Filter::Mitchell { width: 4.0, sharpness: 2.0 / 3.0 },
        ];
        for (name, filter) in Filter::NAMES.into_iter().zip(defaults) {
            assert_eq!(Filter::from_name(name, None, None), Ok(filter));
            assert_eq!(filter.name(), name);
            assert_eq!(Filter::from_name(name, Some(2.5), None).map(|filter| filter.width()), Ok(2.5));
        }
        let sharp = Filter::Mitchell { width: 4.0, sharpness: 1.0 };
        assert_eq!(Filter::from_name("mitchell", None, Some(1.0)), Ok(sharp));
    }

    #[test]
    fn errors_say_what_would_be_right() {
        let message = |name, width, sharpness| Filter::from_name(name, width, sharpness).unwrap_err().to_string();
        assert_eq!(
            message("lanczos", None, None),
            "there is no pixel filter \"lanczos\"\n  help: choose one of box, tent, gaussian, mitchell"
        );
        assert_eq!(
            message("tent", Some(0.0), None),
            "the tent filter cannot be 0 pixels wide\n  help: give a width above 0, up to 64 pixels"
        );
        for width in [-1.0, 64.5, f32::NAN, f32::INFINITY] {
            assert!(message("box", Some(width), None).contains("pixels wide"));
        }
        for sharpness in [-0.1, 1.1, f32::NAN] {
            assert!(message("mitchell", None, Some(sharpness)).contains("from 0 (soft) to 1 (sharp)"));
        }
        assert!(message("box", None, Some(0.5)).contains("the box filter has no sharpness"));
    }
}
