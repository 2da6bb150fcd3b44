//! Directions of the hemisphere z > 0. Measure: solid angle.
//!
//! Each polar map has azimuth 2πu_y and an elevation that inverts its distribution:
//!
//! - uniform, p = 1/2π: cos θ = 1 - u_x;
//! - cosine, p = cos θ / π: sin θ = √u_x;
//! - power cosine, p = (n + 1)/2π cosⁿ θ: cos θ = (1 - u_x)^(1/(n + 1)).
//!
//! No direction lies on the horizon, where densities vanish: cos θ is at least 2⁻¹² for the cosine, and about 2⁻²⁴ for
//! the others.

use core::f32::consts::{FRAC_1_PI, TAU};

use glam::{Vec2, Vec3};

use super::{ConcentricDisc, Warp, WarpLanes};
use crate::sampling::{Lanes, into_unit, sin_cos_turns, sin_cos_turns_lanes, turns};

/// The least 1 - sin² θ of the cosine maps.
const LEAST_COS_SQUARED: f32 = f32::EPSILON / 2.0;

/// Directions with equal density 1/2π.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct UniformHemisphere;

impl Warp for UniformHemisphere {
    type Point = Vec3;

    #[inline]
    fn map(&self, u: Vec2) -> Vec3 {
        // 1 - (1 - u)² = u (2 - u) loses nothing near the pole.
        let sin_theta = libm::sqrtf(u.x * (2.0 - u.x));
        let (sin_phi, cos_phi) = sin_cos_turns(u.y);
        Vec3::new(sin_theta * cos_phi, sin_theta * sin_phi, 1.0 - u.x)
    }

    #[inline]
    fn pdf(&self, direction: Vec3) -> f32 {
        if direction.z > 0.0 { 1.0 / TAU } else { 0.0 }
    }

    fn inverse(&self, direction: Vec3) -> Vec2 {
        // 1 - z = sin² θ / (1 + z) loses nothing near the pole.
        let height = direction.truncate().length_squared() / (1.0 + direction.z);
        Vec2::new(into_unit(height), turns(direction.y, direction.x))
    }
}

impl WarpLanes for UniformHemisphere {
    #[inline]
    fn map_lanes<L: Lanes>(&self, [ux, uy]: [L; 2]) -> [L; 3] {
        let sin_theta = (ux * (L::splat(2.0) - ux)).sqrt();
        let (sin_phi, cos_phi) = sin_cos_turns_lanes(uy);
        [sin_theta * cos_phi, sin_theta * sin_phi, L::splat(1.0) - ux]
    }
}

/// Directions with density cos θ / π, by the polar map. It keeps rings of elevation and sectors of azimuth, so strata
/// of u are strata of the hemisphere.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct CosineHemisphere;

impl Warp for CosineHemisphere {
    type Point = Vec3;

    #[inline]
    fn map(&self, u: Vec2) -> Vec3 {
        let sin_theta = libm::sqrtf(u.x);
        let (sin_phi, cos_phi) = sin_cos_turns(u.y);
        Vec3::new(sin_theta * cos_phi, sin_theta * sin_phi, libm::sqrtf(1.0 - u.x))
    }

    #[inline]
    fn pdf(&self, direction: Vec3) -> f32 {
        cosine_pdf(direction)
    }

    fn inverse(&self, direction: Vec3) -> Vec2 {
        Vec2::new(into_unit(direction.truncate().length_squared()), turns(direction.y, direction.x))
    }
}

impl WarpLanes for CosineHemisphere {
    #[inline]
    fn map_lanes<L: Lanes>(&self, [ux, uy]: [L; 2]) -> [L; 3] {
        let sin_theta = ux.sqrt();
        let (sin_phi, cos_phi) = sin_cos_turns_lanes(uy);
        [sin_theta * cos_phi, sin_theta * sin_phi, (L::splat(1.0) - ux).sqrt()]
    }
}

/// Directions with density cos θ / π by Malley's method: points of the concentric disc, raised to the hemisphere. It
/// is continuous and stretches little, so it keeps the distances of low-discrepancy points better than the polar map.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ConcentricCosineHemisphere;

impl Warp for ConcentricCosineHemisphere {
    type Point = Vec3;

    #[inline]
    fn map(&self, u: Vec2) -> Vec3 {
        let disc = ConcentricDisc.map(u);
        disc.extend(libm::sqrtf((1.0 - disc.length_squared()).max(LEAST_COS_SQUARED)))
    }

    #[inline]
    fn pdf(&self, direction: Vec3) -> f32 {
        cosine_pdf(direction)
    }

    fn inverse(&self, direction: Vec3) -> Vec2 {
        ConcentricDisc.inverse(direction.truncate())
    }
}

impl WarpLanes for ConcentricCosineHemisphere {
    #[inline]
    fn map_lanes<L: Lanes>(&self, u: [L; 2]) -> [L; 3] {
        let [x, y] = ConcentricDisc.map_lanes(u);
        let least = L::splat(LEAST_COS_SQUARED);
        let cos_squared = L::splat(1.0) - (x * x + y * y);
        [x, y, L::select(cos_squared.greater(least), cos_squared, least).sqrt()]
    }
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
        (libm::sqrtf(-libm::expm1f(2.0 * log_cos)), libm::expf(log_cos))
    }
}

impl Warp for PowerCosineHemisphere {
    type Point = Vec3;

    #[inline]
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

impl WarpLanes for PowerCosineHemisphere {
    /// The logarithm and exponentials are taken lane by lane.
    #[inline]
    fn map_lanes<L: Lanes>(&self, [ux, uy]: [L; 2]) -> [L; 3] {
        let log_cos = ux.each(|ux| libm::log1pf(-ux)) / L::splat(self.exponent + 1.0);
        let sin_theta = log_cos.each(|log_cos| -libm::expm1f(2.0 * log_cos)).sqrt();
        let (sin_phi, cos_phi) = sin_cos_turns_lanes(uy);
        [sin_theta * cos_phi, sin_theta * sin_phi, log_cos.each(libm::expf)]
    }
}
