//! Points of discs, the sphere, cones and triangles.

use core::f32::consts::{FRAC_1_PI, TAU};

use glam::{Vec2, Vec3};

use super::Warp;
use crate::sampling::circle::{octants, sin_cos_octant};
use crate::sampling::{into_unit, sin_cos_turns, sqrt, turns};

/// Points of the unit disc with equal density 1/π (measure: area), by r = √u_x, φ = 2πu_y.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PolarDisc;

impl Warp for PolarDisc {
    type Point = Vec2;

    #[inline(always)]
    fn map(&self, u: Vec2) -> Vec2 {
        let (sin, cos) = sin_cos_turns(u.y);
        sqrt(u.x) * Vec2::new(cos, sin)
    }

    #[inline]
    fn pdf(&self, point: Vec2) -> f32 {
        disc_pdf(point)
    }

    fn inverse(&self, point: Vec2) -> Vec2 {
        Vec2::new(into_unit(point.length_squared()), turns(point.y, point.x))
    }
}

/// Points of the unit disc with equal density 1/π (measure: area), by Shirley and Chiu's "A low distortion map between
/// disk and square" (1997): concentric squares become concentric circles. With (a, b) = 2u - 1, where |a| > |b| the
/// radius is a and the angle π/4 b/a, elsewhere they are b and π/2 - π/4 a/b.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ConcentricDisc;

impl Warp for ConcentricDisc {
    type Point = Vec2;

    #[inline(always)]
    fn map(&self, u: Vec2) -> Vec2 {
        let Vec2 { x: a, y: b } = 2.0 * u - Vec2::ONE;
        let flat = a.abs() > b.abs();
        let (radius, other) = if flat { (a, b) } else { (b, a) };
        // The centre is 0/0.
        let (sin, cos) = sin_cos_octant(if radius != 0.0 { 0.125 * (other / radius) } else { 0.0 });
        let (along, across) = (radius * cos, radius * sin);
        if flat { Vec2::new(along, across) } else { Vec2::new(across, along) }
    }

    #[inline]
    fn pdf(&self, point: Vec2) -> f32 {
        disc_pdf(point)
    }

    fn inverse(&self, point: Vec2) -> Vec2 {
        let radius = sqrt(point.length_squared());
        let square = if point.x.abs() > point.y.abs() {
            let a = radius.copysign(point.x);
            Vec2::new(a, a * octants(point.y, point.x))
        } else if radius > 0.0 {
            let b = radius.copysign(point.y);
            Vec2::new(b * octants(point.x, point.y), b)
        } else {
            Vec2::ZERO
        };
        Vec2::new(into_unit(0.5 * (square.x + 1.0)), into_unit(0.5 * (square.y + 1.0)))
    }
}

/// 1/π in the unit disc, whose border has a tolerance for rounding.
fn disc_pdf(point: Vec2) -> f32 {
    if point.length_squared() <= 1.0 + 4.0 * f32::EPSILON { FRAC_1_PI } else { 0.0 }
}

/// Directions with equal density 1/4π (measure: solid angle), by Archimedes' z = 1 - 2u_x.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct UniformSphere;

impl Warp for UniformSphere {
    type Point = Vec3;

    #[inline(always)]
    fn map(&self, u: Vec2) -> Vec3 {
        let sin_theta = 2.0 * sqrt(u.x * (1.0 - u.x));
        let (sin_phi, cos_phi) = sin_cos_turns(u.y);
        Vec3::new(sin_theta * cos_phi, sin_theta * sin_phi, 1.0 - 2.0 * u.x)
    }

    #[inline]
    fn pdf(&self, _direction: Vec3) -> f32 {
        0.5 / TAU
    }

    fn inverse(&self, direction: Vec3) -> Vec2 {
        Vec2::new(into_unit(0.5 * height(direction)), turns(direction.y, direction.x))
    }
}

/// Directions with equal density within an angle of the z axis (measure: solid angle): a spherical cap.
///
/// The cap is kept by its height 1 - cos θ_max, as the cosine of a narrow cone (the sun's is .99999) has hardly a
/// digit left to tell it from 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cone {
    height: f32,
}

impl Cone {
    /// The cone of half-angle `theta_max` radians, in (0, π]; others are clamped to that range.
    pub fn from_angle(theta_max: f32) -> Self {
        let sin_half = libm::sinf(0.5 * theta_max.clamp(1e-9, core::f32::consts::PI));
        Self { height: 2.0 * sin_half * sin_half }
    }

    /// The cone with sin² θ_max = `sin_squared`, in (0, 1], and θ_max ≤ π/2: a sphere of radius r at distance d is
    /// seen under r²/d². Others are clamped to that range.
    pub fn from_sin_squared(sin_squared: f32) -> Self {
        let sin_squared = sin_squared.clamp(1e-18, 1.0);
        Self { height: sin_squared / (1.0 + sqrt(1.0 - sin_squared)) }
    }

    /// 1 - cos θ_max, in (0, 2].
    pub fn height(&self) -> f32 {
        self.height
    }

    /// The solid angle 2π(1 - cos θ_max), in steradians.
    pub fn solid_angle(&self) -> f32 {
        TAU * self.height
    }
}

impl Warp for Cone {
    type Point = Vec3;

    #[inline(always)]
    fn map(&self, u: Vec2) -> Vec3 {
        let height = u.x * self.height;
        let sin_theta = sqrt(height * (2.0 - height));
        let (sin_phi, cos_phi) = sin_cos_turns(u.y);
        Vec3::new(sin_theta * cos_phi, sin_theta * sin_phi, 1.0 - height)
    }

    /// The border has a tolerance for rounding.
    #[inline]
    fn pdf(&self, direction: Vec3) -> f32 {
        if height(direction) <= self.height * (1.0 + 8.0 * f32::EPSILON) { 1.0 / self.solid_angle() } else { 0.0 }
    }

    fn inverse(&self, direction: Vec3) -> Vec2 {
        Vec2::new(into_unit(height(direction) / self.height), turns(direction.y, direction.x))
    }
}

/// 1 - z of a direction; by sin² θ / (1 + z) near the pole, where that loses nothing.
fn height(direction: Vec3) -> f32 {
    if direction.z > 0.0 { direction.truncate().length_squared() / (1.0 + direction.z) } else { 1.0 - direction.z }
}

/// Points of a triangle by barycentric coordinates (β, γ), the weights of its second and third vertex: the point is
/// v0 + β (v1 - v0) + γ (v2 - v0).
///
/// Heitz, "A low-distortion map between triangle and square" (2019), in its division-free form. The measure is dβ dγ,
/// by which the density is 2; by the surface's it is 1/A for a triangle of area A.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Triangle;

impl Warp for Triangle {
    type Point = Vec2;

    #[inline(always)]
    fn map(&self, u: Vec2) -> Vec2 {
        // Half of the lesser one is exact, and so is what it leaves of itself: there is nothing to choose.
        u - Vec2::splat(0.5 * if u.y > u.x { u.x } else { u.y })
    }

    #[inline]
    fn pdf(&self, point: Vec2) -> f32 {
        if point.x >= 0.0 && point.y >= 0.0 && point.x + point.y <= 1.0 { 2.0 } else { 0.0 }
    }

    fn inverse(&self, point: Vec2) -> Vec2 {
        let sum = point.x + point.y;
        let u = if point.y > point.x { Vec2::new(2.0 * point.x, sum) } else { Vec2::new(sum, 2.0 * point.y) };
        Vec2::new(into_unit(u.x), into_unit(u.y))
    }
}
