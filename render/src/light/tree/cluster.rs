//! Estimated contributions of eight clusters of lights to a point: the inner nodes of a light tree.
//!
//! Seen from outside, a cluster is one light at the centre of its sphere. Its radiant intensity in the direction `ω` is
//! the sum of those of its lights in zonal harmonics of the second order about their axes, `m₀ + m₁ x + m₂ (3x² - 1)/2`
//! with `x = axis · ω`, and so `M + V · ω + ωᵀ T ω`: for triangles that face one way that is within 7% of the cosine
//! law, for a closed light it is exact. From inside, where the direction is undefined, it tends to its mean `M`. Conty
//! and Kulla 2018 take bounds of all factors instead, which a cluster that faces many ways attains nowhere.
//!
//! The estimate is 0 only if nothing arrives: where the sphere lies below the receiver's horizon, or the receiver outside
//! the cone into which the cluster shines, widened by the angle that the sphere subtends.

use glam::Vec3;

use crate::light::Receiver;
use crate::light::tree::WIDTH;

/// A number of each child.
pub(crate) type Lane = [f32; WIDTH];

/// Eight clusters, in columns.
#[derive(Clone, Debug, Default)]
pub(crate) struct Clusters {
    pub center: [Lane; 3],
    pub radius: Lane,
    /// The mean radiant intensity, as luminance; 0 if there is no cluster.
    pub mean: Lane,
    pub vector: [Lane; 3],
    /// xx, yy, zz, xy, yz, zx.
    pub tensor: [Lane; 6],
    /// Unit vector along the cone.
    pub axis: [Lane; 3],
    /// The cosine of the cone's half angle, in 0..=π.
    pub cos_cone: Lane,
    pub sin_cone: Lane,
}

/// What the intensity of a cluster that shines anywhere is at least, as a part of its mean.
const LEAST: f32 = 0.02;

#[inline(always)]
pub(crate) fn at(lanes: &[Lane; 3], i: usize) -> Vec3 {
    Vec3::new(lanes[0][i], lanes[1][i], lanes[2][i])
}

pub(crate) fn set(lanes: &mut [Lane; 3], i: usize, vector: Vec3) {
    (lanes[0][i], lanes[1][i], lanes[2][i]) = (vector.x, vector.y, vector.z);
}

impl Clusters {
    /// Estimates of the irradiance that each cluster causes at the receiver, as luminance.
    #[inline(always)]
    pub(crate) fn weights(&self, receiver: &Receiver) -> Lane {
        let mut weights = [0.0; WIDTH];
        for (i, weight) in weights.iter_mut().enumerate() {
            *weight = self.weight(i, receiver);
        }
        weights
    }

    #[inline(always)]
    fn weight(&self, i: usize, receiver: &Receiver) -> f32 {
        let way = at(&self.center, i) - receiver.position;
        let (radius, squared) = (self.radius[i], way.length_squared());
        // Inside, the mean of 1/d² has a bound that goes with the square of the size.
        let inv_squared = squared.max(0.25 * radius * radius).recip();
        let inv_distance = inv_squared.sqrt();
        let towards = way * inv_distance;
        let [xx, yy, zz, xy, yz, zx] = &self.tensor;
        let Vec3 { x, y, z } = towards;
        let squares = xx[i] * x * x + yy[i] * y * y + zz[i] * z * z;
        let even = squares + 2.0 * (xy[i] * x * y + yz[i] * y * z + zx[i] * z * x);
        let intensity = (self.mean[i] - at(&self.vector, i).dot(towards) + even).max(LEAST * self.mean[i]);
        let above = height(receiver.normal.dot(way), radius);
        let below = height(-receiver.normal.dot(way), radius) * receiver.behind;
        let weight = intensity * ((above + below) * inv_distance) * inv_squared;
        if self.is_dark(i, towards, radius * inv_distance) { 0.0 } else { finite_or_zero(weight) }
    }

    /// Whether a point is so near a cluster that its lights may differ in distance by more than the factor 6.
    pub(super) fn is_near(&self, i: usize, point: Vec3) -> bool {
        at(&self.center, i).distance_squared(point) < 2.0 * self.radius[i] * self.radius[i]
    }

    /// Whether the direction to the receiver is outside the cone of a cluster whose sphere subtends the half angle with
    /// this sine, or 1 and more from inside.
    #[inline(always)]
    fn is_dark(&self, i: usize, towards: Vec3, sine: f32) -> bool {
        let (cos_cone, sin_cone) = (self.cos_cone[i], self.sin_cone[i]);
        let cosine = (1.0 - sine * sine).max(0.0).sqrt();
        let is_everywhere = (sine >= 1.0) | ((cos_cone <= 0.0) & (sine >= sin_cone));
        let border = cos_cone * cosine - sin_cone * sine;
        // A little more, for what was rounded.
        !is_everywhere & (-at(&self.axis, i).dot(towards) < border - 1e-5)
    }
}

/// The mean of `max(0, z)` for heights spread evenly by `radius` about `z`.
#[inline(always)]
pub(crate) fn height(z: f32, radius: f32) -> f32 {
    let part = z + radius;
    let partly = if part > 0.0 { part * part / (4.0 * radius) } else { 0.0 };
    if z >= radius { z } else { partly }
}

/// A weight that can be added to others: finite, and 0 instead of NaN.
#[inline(always)]
pub(crate) fn finite_or_zero(weight: f32) -> f32 {
    if weight > 0.0 { weight.min(1e30) } else { 0.0 }
}
