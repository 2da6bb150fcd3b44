//! Contributions of up to eight lights to a point: the leaves of a light tree. For delta lights they are exact except
//! for shadows. A spot with a radius counts as if it shone into a cone that is wider by the angle that its sphere
//! subtends.
//!
//! The irradiance by a triangle of radiance `L` is estimated as `L Ω` times the mean cosine at the receiver of its
//! corners and its centroid: its solid angle `Ω` is exact, however near it is. The estimate is 0 only if all corners
//! lie below the receiver's horizon, or the receiver lies behind the triangle, and `π L` at most.

use std::f32::consts::PI;

use std::f64::consts::FRAC_PI_2;

use glam::{DVec3, Vec3};
use halfdome_kernel::Triangle;

use crate::light::Receiver;
use crate::light::tree::WIDTH;
use crate::light::tree::cluster::{Lane, at, finite_or_zero, height, set};
use crate::scene::SpotEdge;

/// Lights side by side.
pub(crate) trait LeafLights: Default {
    /// One of them.
    type Light;

    /// Puts a light into a place that is free.
    fn put(&mut self, i: usize, light: &Self::Light);

    /// The approximate unoccluded irradiance of each at the receiver, as luminance; 0 in free places.
    fn weights(&self, receiver: &Receiver) -> Lane;
}

/// The data of a light for building.
pub(crate) trait Emits {
    /// Corners of a triangle, which may be one point; no part of the light is farther from it than the
    /// [radius](Self::radius).
    fn corners(&self) -> Triangle;

    /// The radius by which the light exceeds its triangle.
    fn radius(&self) -> f64;

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

/// The falloff of a spot's intensity with the cosine about its axis.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SpotCone {
    /// The cosine from which on the intensity is 0; -2 for what shines everywhere.
    pub cos_outer: f32,
    /// 1 over the length of the ramp from there to full intensity.
    pub slope: f32,
    /// The smoothness of the [edge](SpotEdge::smoothness).
    pub smoothness: f32,
}

/// A sphere or a point that shines, into a cone or everywhere.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PointLight {
    pub position: Vec3,
    /// Unit vector.
    pub axis: Vec3,
    /// Radiant intensity where it is greatest, as luminance.
    pub intensity: f32,
    /// The sphere's radius; 0 for a delta light.
    pub radius: f32,
    pub cone: SpotCone,
    /// What [`Emits::moments`] gives, if that does not follow from intensity and cone.
    pub moments: Option<[f64; 3]>,
    /// Bounds of its intensity about the axis.
    pub envelope: Option<Envelope>,
}

/// Bounds of an intensity as parts of the greatest, by the sine of half the angle from the axis.
pub(crate) type Envelope = [f32; 32];

impl Emits for TriangleLight {
    fn corners(&self) -> Triangle {
        self.corners
    }

    fn radius(&self) -> f64 {
        0.0
    }

    fn cone(&self) -> (DVec3, f64) {
        (self.normal.as_dvec3(), if self.both_sides { 2.0 * FRAC_PI_2 } else { FRAC_PI_2 })
    }

    fn moments(&self) -> [f64; 3] {
        let greatest = f64::from(self.radiance) * f64::from(self.area);
        // Coefficients of max(0, x) and of |x|.
        if self.both_sides {
            [0.5, 0.0, 0.625].map(|m| m * greatest)
        } else {
            [0.25, 0.5, 0.3125].map(|m| m * greatest)
        }
    }
}

impl SpotCone {
    /// The cone of a spot with these cosines.
    pub(crate) fn new(cos_inner: f32, cos_outer: f32, edge: SpotEdge) -> Self {
        Self { cos_outer, slope: (cos_inner - cos_outer).max(1e-6).recip(), smoothness: edge.smoothness() }
    }

    /// The part of the greatest intensity at this cosine about the axis.
    #[inline(always)]
    pub(crate) fn part(&self, cosine: f32) -> f32 {
        SpotEdge::part(((cosine - self.cos_outer) * self.slope).clamp(0.0, 1.0), self.smoothness)
    }
}

impl Emits for PointLight {
    fn corners(&self) -> Triangle {
        [self.position; 3]
    }

    fn radius(&self) -> f64 {
        self.radius.into()
    }

    fn cone(&self) -> (DVec3, f64) {
        (self.axis.as_dvec3(), f64::from(self.cone.cos_outer.max(-1.0)).acos())
    }

    fn moments(&self) -> [f64; 3] {
        if let Some(moments) = self.moments {
            return moments;
        }
        const STEPS: u32 = 256;
        let first = f64::from(self.cone.cos_outer.max(-1.0));
        let step = (1.0 - first) / f64::from(STEPS);
        let mut moments = [0.0; 3];
        for i in 0..STEPS {
            let x = first + (f64::from(i) + 0.5) * step;
            let power = step * f64::from(self.intensity * self.cone.part(x as f32));
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

/// No part of a triangle counts as lower than this part of the sine of its highest corner's elevation.
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
    // The distance of the receiver before the triangle.
    let before = -normal.dot(middle);
    let before = if both_sides > 0.0 { before.abs() } else { before };
    let per_length = |way: Vec3| way.length_squared().sqrt().recip();
    let (per_a, per_b, per_c, per_middle) = (per_length(a), per_length(b), per_length(c), per_length(middle));
    // Van Oosterom and Strackee's tangent of half the solid angle; six times the volume of the tetrahedron is its
    // height times twice the area, as no product of far corners is that exact.
    let volume = (2.0 * area * per_a * per_b) * (before * per_c);
    let cosines = a.dot(b) * (per_a * per_b) + b.dot(c) * (per_b * per_c) + c.dot(a) * (per_c * per_a);
    let solid_angle = 2.0 * angle(volume, 1.0 + cosines);
    let [u, v, w] = [receiver.normal.dot(a) * per_a, receiver.normal.dot(b) * per_b, receiver.normal.dot(c) * per_c];
    let least = LIFT * u.max(v).max(w).max(-u.min(v).min(w) * receiver.behind);
    let sine = |sine: f32| (if receiver.behind > 0.0 { sine.abs() } else { sine }).max(least);
    let mean = 0.25 * ((sine(u) + sine(v)) + (sine(w) + sine(receiver.normal.dot(middle) * per_middle)));
    let irradiance = radiance * (solid_angle * mean).min(PI);
    let is_lit = (before > 0.0) & (least > 0.0);
    if is_lit { finite_or_zero(irradiance) } else { 0.0 }
}

/// The angle in 0..=π of a vector whose `y` is not negative, to 2e-5 of itself.
#[inline(always)]
fn angle(y: f32, x: f32) -> f32 {
    let is_steep = y > x.abs();
    let t = if is_steep { x / y } else { y / x };
    let s = t * t;
    // Minimax on -1..=1 (Abramowitz and Stegun 4.4.49, shortened).
    let arc = t
        * (0.999_977_2
            + s * (-0.332_623_5 + s * (0.193_543_5 + s * (-0.116_432_9 + s * (0.052_653_3 - s * 0.011_721_2)))));
    let base = if is_steep { 0.5 * PI } else { 0.0 };
    let turned = if is_steep { base - arc } else { arc };
    if !is_steep & (x < 0.0) { turned + PI } else { turned }
}

/// Up to eight points and spheres.
#[derive(Clone, Debug, Default)]
pub(crate) struct Points {
    position: [Lane; 3],
    axis: [Lane; 3],
    intensity: Lane,
    radius: Lane,
    cos_outer: Lane,
    slope: Lane,
    smoothness: Lane,
    /// The envelope of each light, if any has one.
    envelopes: Option<Box<[Envelope; WIDTH]>>,
}

impl LeafLights for Points {
    type Light = PointLight;

    fn put(&mut self, i: usize, light: &PointLight) {
        set(&mut self.position, i, light.position);
        set(&mut self.axis, i, light.axis);
        (self.intensity[i], self.radius[i]) = (light.intensity, light.radius);
        if let Some(envelope) = light.envelope {
            self.envelopes.get_or_insert_with(|| Box::new([[1.0; 32]; WIDTH]))[i] = envelope;
        }
        let SpotCone { cos_outer, slope, smoothness } = light.cone;
        (self.cos_outer[i], self.slope[i], self.smoothness[i]) = (cos_outer, slope, smoothness);
    }

    #[inline(always)]
    fn weights(&self, receiver: &Receiver) -> Lane {
        let mut weights = [0.0; WIDTH];
        for (i, weight) in weights.iter_mut().enumerate() {
            let (way, radius) = (at(&self.position, i) - receiver.position, self.radius[i]);
            // Within the sphere light is as strong as at its surface.
            let inv_squared = way.length_squared().max(radius * radius).recip();
            let inv_distance = inv_squared.sqrt();
            let cosine = widened(-at(&self.axis, i).dot(way) * inv_distance, radius * inv_distance);
            let (cos_outer, slope, smoothness) = (self.cos_outer[i], self.slope[i], self.smoothness[i]);
            let part = SpotCone { cos_outer, slope, smoothness }.part(cosine);
            let z = receiver.normal.dot(way);
            let heights = height(z, radius) + height(-z, radius) * receiver.behind;
            *weight = finite_or_zero(self.intensity[i] * part * (heights * inv_distance) * inv_squared);
        }
        if let Some(envelopes) = &self.envelopes {
            self.bound(envelopes, receiver, &mut weights);
        }
        weights
    }
}

impl Points {
    /// Multiplies weights by their envelopes.
    #[cold]
    fn bound(&self, envelopes: &[Envelope; WIDTH], receiver: &Receiver, weights: &mut Lane) {
        for (i, (weight, envelope)) in weights.iter_mut().zip(envelopes).enumerate() {
            let way = at(&self.position, i) - receiver.position;
            let cosine = -at(&self.axis, i).dot(way.normalize_or_zero());
            let sine = (0.5 * (1.0 - cosine)).max(0.0).sqrt();
            let bin = (sine * envelope.len() as f32) as usize;
            *weight *= envelope[bin.min(envelope.len() - 1)];
        }
    }
}

/// The greatest cosine with an axis of a direction that differs from one of this cosine by an angle of this sine, at
/// most.
#[inline(always)]
fn widened(cosine: f32, sine: f32) -> f32 {
    let rim = (1.0 - sine * sine).max(0.0).sqrt();
    let turned = cosine * rim + (1.0 - cosine * cosine).max(0.0).sqrt() * sine;
    if (cosine >= rim) | (sine >= 1.0) { 1.0 } else { turned }
}
