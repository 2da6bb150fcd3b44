//! The result of a gather, and its extrapolation to other points and normals.
//!
//! E(x, n) = E_i + (n_i × n)·∇_r + (x - x_i)·∇_t

use core::f32::consts::PI;

use glam::Vec3;

use crate::sampling::Frame;

/// Irradiance at a point with its gradients, and the distance of the surroundings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gather {
    /// E for each colour channel, in W/m².
    pub irradiance: Vec3,
    /// ∇_r, a vector for each colour channel, in W/m² a radian: an axis to turn the normal about, times how much E
    /// grows.
    pub rotational: [Vec3; 3],
    /// ∇_t, a vector for each colour channel, in W/m² a world unit.
    pub translational: [Vec3; 3],
    /// R, the harmonic mean of the distances, weighted by the cosine, in world units; +∞ if no ray hit anything.
    pub harmonic_mean_distance: f32,
    /// The least of the distances, in world units; +∞ if no ray hit anything.
    pub minimum_distance: f32,
    /// The standard error of E, in the channel where it is greatest, in W/m²: √(½ Σ (ΔL ∫ cos θ dω)²) over cells and
    /// their neighbours in a row. Neighbours see nearly the same, so half of their squared difference is the variance
    /// of one; where they do not, the estimate is too high. Parts of E below 10⁻¹⁹ are lost, above 10¹⁹ it is infinite.
    pub standard_error: f32,
}

impl Gather {
    /// From the sums in local coordinates, whose gradients have no third component; `inverse_distance` is
    /// Σ (1/r) ∫ cos θ dω, and `squares` are those of the standard_error.
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
            standard_error: libm::sqrtf(0.5 * squares.into_iter().fold(0.0, f32::max)),
        }
    }

    /// The gather with its gradients in world coordinates; `frame` is the one that transformed the directions.
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
    /// Extrapolation may give negative values, which are clamped to zero in each channel; the second result says
    /// whether any was.
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
