//! What a gather gives, and what it says of other points and normals.
//!
//! E(x, n) = E_i + (n_i × n)·∇_r + (x - x_i)·∇_t

use core::f32::consts::PI;

use glam::Vec3;

use crate::sampling::Frame;

/// Irradiance at a point with its gradients, and how far away the surroundings are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gather {
    /// E for each colour channel, in W/m².
    pub irradiance: Vec3,
    /// ∇_r, a vector for each colour channel, in W/m² a radian: an axis to turn the normal about, times how much E
    /// grows.
    pub rotational: [Vec3; 3],
    /// ∇_t, a vector for each colour channel, in W/m² a world unit.
    pub translational: [Vec3; 3],
    /// R, the harmonic mean of the distances, weighted by the cosine; +∞ if no ray hit anything.
    pub harmonic_mean_distance: f32,
    /// The least of the distances; +∞ if no ray hit anything.
    pub minimum_distance: f32,
    /// The standard deviation of E, of the channel where it is greatest, in W/m²: √(½ Σ (ΔL ∫ cos θ dω)²) over cells and
    /// their neighbours in a row, which see about the same, so that half of their squared difference is the variance of
    /// one. Where they do not it is too much. Parts of E below 10⁻¹⁹ are lost, above 10¹⁹ it is infinite.
    pub deviation: f32,
}

impl Gather {
    /// From the sums in local coordinates, whose gradients have no third component; `inverse_distance` is
    /// Σ (1/r) ∫ cos θ dω, and `squares` are those of the deviation.
    pub(super) fn from_sums(
        irradiance: [f32; 3],
        [rotational, translational]: [[[f32; 2]; 3]; 2],
        inverse_distance: f32,
        minimum_distance: f32,
        squares: [f32; 3],
    ) -> Self {
        let local = |[x, y]: [f32; 2]| Vec3::new(x, y, 0.0);
        Self {
            irradiance: irradiance.into(),
            rotational: rotational.map(local),
            translational: translational.map(local),
            harmonic_mean_distance: PI / inverse_distance,
            minimum_distance,
            deviation: libm::sqrtf(0.5 * squares.into_iter().fold(0.0, f32::max)),
        }
    }

    /// The same with the gradients in world coordinates; `frame` is the one that took the directions there.
    pub fn to_world(&self, frame: &Frame) -> Self {
        Self {
            rotational: self.rotational.map(|gradient| frame.to_world(gradient)),
            translational: self.translational.map(|gradient| frame.to_world(gradient)),
            ..*self
        }
    }

    /// The irradiance at `displacement` = x - x_i from the record, on a surface with the unit normal `normal`;
    /// `record_normal` is n_i. All three vectors are in the coordinates of the gradients.
    ///
    /// Gradients know nothing of zero, so what falls below it in a channel becomes zero; the second result says whether
    /// any did.
    #[inline]
    pub fn extrapolate(&self, displacement: Vec3, record_normal: Vec3, normal: Vec3) -> (Vec3, bool) {
        let turn = record_normal.cross(normal);
        let mut irradiance = self.irradiance;
        for channel in 0..3 {
            irradiance[channel] += turn.dot(self.rotational[channel]) + displacement.dot(self.translational[channel]);
        }
        (irradiance.max(Vec3::ZERO), irradiance.min_element() < 0.0)
    }
}
