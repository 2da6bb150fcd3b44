//! The lobes that filter the levels of a prefiltered cube map, and the level that a shader looks up.
//!
//! - `ggx`: the split sum's first half (Karis, "Real Shading in Unreal Engine 4", 2013) with normal, view and
//!   reflection the same: light from an angle `θ` to the reflection counts `D(h) cos θ`, `h = θ/2`, with the
//!   distribution of Trowbridge and Reitz, `D ∝ (α² cos² h + sin² h)⁻²`, and `α` the square of the roughness that
//!   artists set.
//! - `phong`: `cosᵖ θ`.
//!
//! With `n` levels, the roughness of level `i` is `i/(n - 1)`, so that the level is `roughness (n - 1)`, as in Bevy. Or
//! it is the square of that, so that the level is `√roughness (n - 1)`, as in Godot, which has more levels for smooth
//! surfaces. (three.js filters its input again for its own layout.) A power falls to a quarter from one level to the
//! next, as the lobe's width doubles with the texels', and ends at 1: the level is `n - 1 - log₂(power)/2`. The first
//! level is not filtered.

use crate::settings::named;

/// The filter of levels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Filter {
    /// Trowbridge and Reitz's distribution, by roughness.
    Ggx,
    /// A power of the cosine.
    Phong,
}

/// The mapping between roughness and levels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mapping {
    /// The level is proportional to the roughness: Bevy.
    Linear,
    /// The level is proportional to the roughness's root: Godot.
    Sqrt,
}

named!(Filter: Ggx = "ggx", Phong = "phong");
named!(Mapping: Linear = "linear", Sqrt = "sqrt");

/// A lobe about a direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Lobe {
    /// GGX by roughness, more than 0 and at most 1.
    Ggx {
        /// As artists set it: the square root of the distribution's `α`.
        roughness: f64,
    },
    /// A power of the cosine, at least 1; 1 gives irradiance over π.
    Phong {
        /// The power.
        power: f64,
    },
}

impl Lobe {
    /// The lobe of level `level`, counted from 1, of `levels`.
    pub fn of_level(filter: Filter, mapping: Mapping, level: u32, levels: u32) -> Self {
        let last = f64::from(levels - 1);
        match (filter, mapping) {
            (Filter::Ggx, Mapping::Linear) => Self::Ggx { roughness: f64::from(level) / last },
            (Filter::Ggx, Mapping::Sqrt) => Self::Ggx { roughness: (f64::from(level) / last).powi(2) },
            (Filter::Phong, _) => Self::Phong { power: 4f64.powi((levels - 1 - level) as i32) },
        }
    }

    /// The weight of light from an angle `θ`, given `sin²(θ/2)`; 1 at 0.
    pub(super) fn weight(&self, sin2: f64) -> f64 {
        let cosine = 1.0 - 2.0 * sin2;
        if cosine <= 0.0 {
            return 0.0;
        }
        match *self {
            Self::Ggx { roughness } => {
                let alpha2 = roughness.powi(4);
                let spread = alpha2 / (alpha2 * (1.0 - sin2) + sin2);
                spread * spread * cosine
            }
            Self::Phong { power } => cosine.powf(power),
        }
    }

    /// About the angle within which the weight is even.
    pub(super) fn width(&self) -> f64 {
        match *self {
            Self::Ggx { roughness } => 2.0 * roughness * roughness,
            Self::Phong { power } => 1.0 / power.sqrt(),
        }
    }

    /// The angle beyond which light counts less than a billionth.
    pub(super) fn reach(&self) -> f64 {
        const MIN_WEIGHT: f64 = 1e-9;
        match *self {
            Self::Ggx { .. } => std::f64::consts::FRAC_PI_2,
            Self::Phong { power } => MIN_WEIGHT.powf(1.0 / power).acos(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_follow_their_mappings() {
        let ggx = |mapping, level| Lobe::of_level(Filter::Ggx, mapping, level, 5);
        assert_eq!(ggx(Mapping::Linear, 1), Lobe::Ggx { roughness: 0.25 });
        assert_eq!(ggx(Mapping::Sqrt, 2), Lobe::Ggx { roughness: 0.25 });
        assert_eq!(ggx(Mapping::Sqrt, 4), Lobe::Ggx { roughness: 1.0 });
        let powers = [1, 2, 3, 4].map(|level| Lobe::of_level(Filter::Phong, Mapping::Linear, level, 5));
        assert_eq!(powers, [64.0, 16.0, 4.0, 1.0].map(|power| Lobe::Phong { power }));
    }

    #[test]
    fn weights_are_the_formulas() {
        let sin2 = |degrees: f64| (0.5 * degrees.to_radians()).sin().powi(2);
        for lobe in [Lobe::Ggx { roughness: 0.3 }, Lobe::Phong { power: 7.0 }] {
            assert_eq!((lobe.weight(0.0), lobe.weight(sin2(90.5))), (1.0, 0.0));
        }
        assert!((Lobe::Phong { power: 3.0 }.weight(sin2(60.0)) - 0.125).abs() < 1e-12);
        // α = 1 has an even distribution.
        assert!((Lobe::Ggx { roughness: 1.0 }.weight(sin2(60.0)) - 0.5).abs() < 1e-12);
        // The published form, α² / (π (cos² h (α² - 1) + 1)²), over its value at 0.
        let (alpha2, cos2): (f64, f64) = (0.3f64.powi(4), 1.0 - sin2(40.0));
        let form = |cos2: f64| alpha2 / (cos2 * (alpha2 - 1.0) + 1.0).powi(2);
        let expected = form(cos2) / form(1.0) * 40f64.to_radians().cos();
        assert!((Lobe::Ggx { roughness: 0.3 }.weight(sin2(40.0)) / expected - 1.0).abs() < 1e-12);
    }

    #[test]
    fn nothing_counts_beyond_the_reach() {
        for power in [1.0, 16.0, 4096.0] {
            let lobe = Lobe::Phong { power };
            let beyond = (0.5 * lobe.reach() + 1e-6).sin().powi(2);
            assert!(lobe.weight(beyond) <= 1e-9 && lobe.weight(0.9 * beyond) > 1e-9, "{power}");
        }
    }
}
