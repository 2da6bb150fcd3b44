//! What up to eight lights send to a point: the leaves of a light tree. Of points and spots it is exact but for shadows.
//!
//! The irradiance by a triangle of radiance `L`, `L ∫ cos θ cos θ_y / d² dA`, is estimated by the centroids of the four
//! triangles into which the middles of its edges divide it. It is 0 only if all corners lie below the receiver's horizon, or
//! the receiver lies behind the triangle, and `π L` at most.

use std::f32::consts::PI;

use std::f64::consts::FRAC_PI_2;

use glam::{DVec3, Vec3};
use halfdome_kernel::Triangle;

use crate::light::Receiver;
use crate::light::tree::WIDTH;
use crate::light::tree::cluster::{Lane, at, set, tame};

/// Lights side by side.
pub(crate) trait LeafLights: Default {
    /// One of them.
    type Light;

    /// Puts a light into a place that is free.
    fn put(&mut self, i: usize, light: &Self::Light);

    /// The irradiance that each causes at the receiver if nothing is in between, about, as luminance; 0 in places that are
    /// free.
    fn weights(&self, receiver: &Receiver) -> Lane;
}

/// What building needs to know of a light.
pub(crate) trait Emits {
    /// Corners of the triangle that encloses it, which may be one point.
    fn corners(&self) -> Triangle;

    /// The unit vector about which it shines, and the half angle of the cone into which it does.
    fn cone(&self) -> (DVec3, f64);

    /// Its radiant intensity about that vector in zonal harmonics, as luminance: `m₀ + m₁ x + m₂ (3x² - 1)/2`.
    fn moments(&self) -> [f64; 3];
}

/// A triangle that emits.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TriangleLight {
    pub corners: Triangle,
    /// Unit normal on the side that emits.
    pub normal: Vec3,
    /// Mean radiance, as luminance.
    pub radiance: f32,
    pub area: f32,
    /// Whether both sides emit.
    pub both_sides: bool,
}

/// A light at a point, the square of whose fall-off is linear in the cosine about its axis.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PointLight {
    pub position: Vec3,
    /// Unit vector.
    pub axis: Vec3,
    /// Radiant intensity where it is greatest, as luminance.
    pub intensity: f32,
    /// The cosine from which on the intensity is 0; -2 for what shines everywhere.
    pub cos_outer: f32,
    /// 1 over the length of the ramp from there to full intensity.
    pub slope: f32,
}

impl Emits for TriangleLight {
    fn corners(&self) -> Triangle {
        self.corners
    }

    fn cone(&self) -> (DVec3, f64) {
        (self.normal.as_dvec3(), if self.both_sides { 2.0 * FRAC_PI_2 } else { FRAC_PI_2 })
    }

    fn moments(&self) -> [f64; 3] {
        let greatest = f64::from(self.radiance) * f64::from(self.area);
        // Of max(0, x) and of |x|.
        if self.both_sides {
            [0.5, 0.0, 0.625].map(|m| m * greatest)
        } else {
            [0.25, 0.5, 0.3125].map(|m| m * greatest)
        }
    }
}

impl PointLight {
    /// The part of the greatest intensity at this cosine about the axis.
    #[inline(always)]
    pub(crate) fn part(cosine: f32, cos_outer: f32, slope: f32) -> f32 {
        // The square of a linear ramp, as KHR_lights_punctual recommends.
        let ramp = ((cosine - cos_outer) * slope).clamp(0.0, 1.0);
        ramp * ramp
    }
}

impl Emits for PointLight {
    fn corners(&self) -> Triangle {
        [self.position; 3]
    }

    fn cone(&self) -> (DVec3, f64) {
        (self.axis.as_dvec3(), f64::from(self.cos_outer.max(-1.0)).acos())
    }

    fn moments(&self) -> [f64; 3] {
        const STEPS: u32 = 256;
        let first = f64::from(self.cos_outer.max(-1.0));
        let step = (1.0 - first) / f64::from(STEPS);
        let mut moments = [0.0; 3];
        for i in 0..STEPS {
            let x = first + (f64::from(i) + 0.5) * step;
            let power = step * f64::from(self.intensity * Self::part(x as f32, self.cos_outer, self.slope));
            let harmonics = [0.5, 1.5 * x, 2.5 * (1.5 * x * x - 0.5)];
            moments.iter_mut().zip(harmonics).for_each(|(moment, harmonic)| *moment += power * harmonic);
        }
        moments
    }
}

/// Up to eight triangles.
#[derive(Clone, Debug, Default)]
pub(crate) struct Triangles {
    corners: [[Lane; 3]; 3],
    normal: [Lane; 3],
    radiance: Lane,
    area: Lane,
    both_sides: Lane,
}

impl LeafLights for Triangles {
    type Light = TriangleLight;

    fn put(&mut self, i: usize, light: &TriangleLight) {
        self.corners.iter_mut().zip(light.corners).for_each(|(lanes, corner)| set(lanes, i, corner));
        set(&mut self.normal, i, light.normal);
        (self.radiance[i], self.area[i]) = (light.radiance, light.area);
        self.both_sides[i] = light.both_sides.into();
    }

    #[inline(always)]
    fn weights(&self, receiver: &Receiver) -> Lane {
        let mut weights = [0.0; WIDTH];
        for (i, weight) in weights.iter_mut().enumerate() {
            let corners = [at(&self.corners[0], i), at(&self.corners[1], i), at(&self.corners[2], i)];
            let normal = at(&self.normal, i);
            *weight = triangle(receiver, corners, normal, self.radiance[i], self.area[i], self.both_sides[i]);
        }
        weights
    }
}

/// No part of a triangle counts as lower than this part of the height of its highest corner.
const LIFT: f32 = 0.1;

/// The estimate of the irradiance by a triangle.
#[inline(always)]
pub(crate) fn triangle(
    receiver: &Receiver,
    [a, b, c]: Triangle,
    normal: Vec3,
    radiance: f32,
    area: f32,
    both_sides: f32,
) -> f32 {
    let [a, b, c] = [a - receiver.position, b - receiver.position, c - receiver.position];
    let middle = (a + b + c) * (1.0 / 3.0);
    // How far before the triangle the receiver is.
    let before = -normal.dot(middle);
    let before = if both_sides > 0.0 { before.abs() } else { before };
    let [u, v, w] = [receiver.normal.dot(a), receiver.normal.dot(b), receiver.normal.dot(c)];
    let highest = u.max(v).max(w);
    let lowest = u.min(v).min(w);
    let least = LIFT * highest.max(-lowest * receiver.behind);
    let mut sum = 0.0;
    for way in [middle, 0.5 * (a + middle), 0.5 * (b + middle), 0.5 * (c + middle)] {
        let inv_squared = way.length_squared().recip();
        sum += (receiver.height(way).max(least) * inv_squared) * (before * inv_squared);
    }
    let irradiance = (0.25 * radiance * area) * sum;
    let is_lit = (before > 0.0) & (least > 0.0);
    if is_lit { tame(irradiance.min(PI * radiance)) } else { 0.0 }
}

/// Up to eight lights without a surface.
#[derive(Clone, Debug, Default)]
pub(crate) struct Points {
    position: [Lane; 3],
    axis: [Lane; 3],
    intensity: Lane,
    cos_outer: Lane,
    slope: Lane,
}

impl LeafLights for Points {
    type Light = PointLight;

    fn put(&mut self, i: usize, light: &PointLight) {
        set(&mut self.position, i, light.position);
        set(&mut self.axis, i, light.axis);
        (self.intensity[i], self.cos_outer[i], self.slope[i]) = (light.intensity, light.cos_outer, light.slope);
    }

    #[inline(always)]
    fn weights(&self, receiver: &Receiver) -> Lane {
        let mut weights = [0.0; WIDTH];
        for (i, weight) in weights.iter_mut().enumerate() {
            let way = at(&self.position, i) - receiver.position;
            let inv_squared = way.length_squared().recip();
            let inv_distance = inv_squared.sqrt();
            let cosine = -at(&self.axis, i).dot(way) * inv_distance;
            let part = PointLight::part(cosine, self.cos_outer[i], self.slope[i]);
            *weight = tame(self.intensity[i] * part * (receiver.height(way) * inv_distance) * inv_squared);
        }
        weights
    }
}
