//! Directions of the hemisphere z > 0. Measure: solid angle.
//!
//! The direct (polar) maps have azimuth 2πu_y and an elevation that inverts its distribution:
//!
//! - uniform, p = 1/2π: cos θ = 1 - u_x;
//! - cosine, p = cos θ / π: sin θ = √u_x;
//! - power cosine, p = (n + 1)/2π cosⁿ θ: cos θ = (1 - u_x)^(1/(n + 1)).
//!
//! The concentric ones go by the disc instead: Malley's to the cosine, Shirley and Chiu's to the uniform hemisphere.
//!
//! No direction lies on the horizon, where densities vanish: cos θ is at least 2⁻¹² for the cosine, and about 2⁻²⁴ for
//! the others.

use core::f32::consts::{FRAC_1_PI, TAU};

use glam::{Vec2, Vec3};

use super::{ConcentricDisc, Warp};
use crate::sampling::{into_unit, sin_cos_turns, sqrt, turns};

/// The least 1 - r² of a point of the disc: rounding may carry its border to 1 and past it.
const MIN_COSINE_SQUARED: f32 = f32::EPSILON / 2.0;

/// Directions with equal density 1/2π, directly by inverting its distribution.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct UniformHemisphere;

impl Warp for UniformHemisphere {
    type Point = Vec3;

    #[inline(always)]
    fn map(&self, u: Vec2) -> Vec3 {
        // 1 - (1 - u)² = u (2 - u) loses nothing near the pole.
        let sin_theta = sqrt(u.x * (2.0 - u.x));
        let (sin_phi, cos_phi) = sin_cos_turns(u.y);
        Vec3::new(sin_theta * cos_phi, sin_theta * sin_phi, 1.0 - u.x)
    }

    #[inline]
    fn pdf(&self, direction: Vec3) -> f32 {
        uniform_pdf(direction)
    }

    fn inverse(&self, direction: Vec3) -> Vec2 {
        // 1 - z = sin² θ / (1 + z) loses nothing near the pole.
        let height = direction.truncate().length_squared() / (1.0 + direction.z);
        Vec2::new(into_unit(height), turns(direction.y, direction.x))
    }
}

/// Directions with density cos θ / π, directly by inverting its distribution. It keeps rings of elevation and sectors
/// of azimuth, so strata of u are strata of the hemisphere.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct CosineHemisphere;

impl Warp for CosineHemisphere {
    type Point = Vec3;

    #[inline(always)]
    fn map(&self, u: Vec2) -> Vec3 {
        let sin_theta = sqrt(u.x);
        let (sin_phi, cos_phi) = sin_cos_turns(u.y);
        Vec3::new(sin_theta * cos_phi, sin_theta * sin_phi, sqrt(1.0 - u.x))
    }

    #[inline]
    fn pdf(&self, direction: Vec3) -> f32 {
        cosine_pdf(direction)
    }

    fn inverse(&self, direction: Vec3) -> Vec2 {
        Vec2::new(into_unit(direction.truncate().length_squared()), turns(direction.y, direction.x))
    }
}

/// Directions with density cos θ / π by Malley's method: points of the unit disc, here the concentric one, projected up
/// to the hemisphere. It is continuous and stretches little, so it keeps the distances of low-discrepancy points better
/// than the polar map.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct MalleyHemisphere;

impl Warp for MalleyHemisphere {
    type Point = Vec3;

    #[inline(always)]
    fn map(&self, u: Vec2) -> Vec3 {
        let disc = ConcentricDisc.map(u);
        disc.extend(sqrt(at_least(1.0 - disc.length_squared(), MIN_COSINE_SQUARED)))
    }

    #[inline]
    fn pdf(&self, direction: Vec3) -> f32 {
        cosine_pdf(direction)
    }

    fn inverse(&self, direction: Vec3) -> Vec2 {
        ConcentricDisc.inverse(direction.truncate())
    }
}

/// Directions with equal density 1/2π by the concentric map: Shirley and Chiu's disc (1997) lifted to the hemisphere by
/// z = 1 - r², (x, y) √(2 - r²), which keeps areas. Continuous and of low distortion, as [`MalleyHemisphere`] is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ConcentricHemisphere;

impl Warp for ConcentricHemisphere {
    type Point = Vec3;

    #[inline(always)]
    fn map(&self, u: Vec2) -> Vec3 {
        let disc = ConcentricDisc.map(u);
        let z = at_least(1.0 - disc.length_squared(), MIN_COSINE_SQUARED);
        (disc * sqrt(1.0 + z)).extend(z)
    }

    #[inline]
    fn pdf(&self, direction: Vec3) -> f32 {
        uniform_pdf(direction)
    }

    fn inverse(&self, direction: Vec3) -> Vec2 {
        ConcentricDisc.inverse(direction.truncate() / sqrt(1.0 + direction.z))
    }
}

/// The larger of two numbers by one comparison, which vectorises everywhere.
#[inline(always)]
fn at_least(x: f32, least: f32) -> f32 {
    if x > least { x } else { least }
}

fn uniform_pdf(direction: Vec3) -> f32 {
    if direction.z > 0.0 { 1.0 / TAU } else { 0.0 }
}

fn cosine_pdf(direction: Vec3) -> f32 {
    direction.z.max(0.0) * FRAC_1_PI
}

/// Directions with density (n + 1)/2π cosⁿ θ: Phong's lobe. n = 0 is the uniform and n = 1 the cosine hemisphere.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PowerCosineHemisphere {
    /// n ≥ 0.
    pub exponent: f32,
}

impl PowerCosineHemisphere {
    /// (sin θ, cos θ) for u_x. Logarithms keep sin θ exact where a high power crowds all directions about the pole.
    fn elevation(&self, ux: f32) -> (f32, f32) {
        let log_cos = libm::log1pf(-ux) / (self.exponent + 1.0);
        (sqrt(-libm::expm1f(2.0 * log_cos)), libm::expf(log_cos))
    }
}

impl Warp for PowerCosineHemisphere {
    type Point = Vec3;

    #[inline(always)]
    fn map(&self, u: Vec2) -> Vec3 {
        let (sin_theta, cos_theta) = self.elevation(u.x);
        let (sin_phi, cos_phi) = sin_cos_turns(u.y);
        Vec3::new(sin_theta * cos_phi, sin_theta * sin_phi, cos_theta)
    }

    #[inline]
    fn pdf(&self, direction: Vec3) -> f32 {
        if direction.z > 0.0 { (self.exponent + 1.0) / TAU * libm::powf(direction.z, self.exponent) } else { 0.0 }
    }

    fn inverse(&self, direction: Vec3) -> Vec2 {
        // From whichever of sin θ and cos θ is far from 1.
        let log_cos = if direction.z > 0.5 {
            0.5 * libm::log1pf(-direction.truncate().length_squared())
        } else {
            libm::logf(direction.z.max(0.0))
        };
        let ux = -libm::expm1f((self.exponent + 1.0) * log_cos);
        Vec2::new(into_unit(ux), turns(direction.y, direction.x))
    }
}
