//! Lights without a surface: points, spots and suns.

use std::f64::consts::{PI, TAU};
use std::sync::Arc;

use glam::Vec3;

use crate::scene::{Profile, ProfileFrame};

/// A light that has no triangles and stops no ray. The camera itself does not see it; mirrors, gloss and glass show one
/// of a size. It shines through panes of glass. Intensities are per linear sRGB channel.
#[derive(Clone, Debug, PartialEq)]
pub enum PunctualLight {
    /// Shines alike in every direction.
    Point {
        /// The position.
        position: Vec3,
        /// Radiant intensity from afar, W/sr.
        intensity: Vec3,
        /// Radius of the sphere that shines, in the scene's units; 0 is a delta light, with hard shadows.
        radius: f32,
    },
    /// Shines into a cone.
    Spot {
        /// The position.
        position: Vec3,
        /// Unit vector along the cone's axis.
        direction: Vec3,
        /// Radiant intensity on the axis from afar, W/sr.
        intensity: Vec3,
        /// Radius of the sphere that shines, as that of a point light. The cone is that of the directions in which it
        /// is left.
        radius: f32,
        /// Cosine of the angle up to which the intensity is full.
        cos_inner: f32,
        /// Cosine of the angle from which it is zero; less than `cos_inner`.
        cos_outer: f32,
        /// The rise in between.
        edge: SpotEdge,
    },
    /// Shines as was measured.
    Profiled {
        /// The position.
        position: Vec3,
        /// The rotation.
        frame: ProfileFrame,
        /// W/sr from afar for each candela of the profile.
        intensity: Vec3,
        /// Radius of the sphere that shines, as that of a spot.
        radius: f32,
        /// Candela by direction.
        profile: Arc<Profile>,
    },
    /// Shines from infinitely far away.
    Directional {
        /// Unit vector along which the light travels.
        direction: Vec3,
        /// Irradiance on a surface that faces it, W/m².
        irradiance: Vec3,
        /// Half the angle that its disc subtends, radians, below π/2; 0 is a delta light, with hard shadows.
        half_angle: f32,
    },
}

impl PunctualLight {
    /// The largest radius, in metres: its square stays within 32 bits.
    pub(crate) const MAX_RADIUS: f32 = 1e15;

    /// Its strength, and what gives its power if multiplied by it; of a directional light, which has none, the
    /// irradiance.
    pub(crate) fn power(&self) -> (Vec3, f64) {
        match self {
            Self::Point { intensity, .. } => (*intensity, 4.0 * PI),
            Self::Spot { intensity, cos_inner, cos_outer, edge, .. } => {
                (*intensity, edge.solid_angle(*cos_inner, *cos_outer))
            }
            Self::Profiled { intensity, profile, .. } => (*intensity, profile.lumens()),
            Self::Directional { irradiance, .. } => (*irradiance, 1.0),
        }
    }
}

/// How a spot's intensity rises from its outer to its inner cone, by the ramp `t` that is linear in the cosine.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum SpotEdge {
    /// `t²`, as `KHR_lights_punctual` recommends.
    #[default]
    Square,
    /// `3t² - 2t³`, as Blender has it.
    Smooth,
}

impl SpotEdge {
    /// The factor of the part that a smooth edge has more than a square one.
    pub(crate) fn smoothness(self) -> f32 {
        match self {
            Self::Square => 0.0,
            Self::Smooth => 1.0,
        }
    }

    /// The part of the full intensity at this place of the ramp, from 0 to 1, by the [smoothness](Self::smoothness).
    #[inline(always)]
    pub(crate) fn part(ramp: f32, smoothness: f32) -> f32 {
        ramp * ramp * (1.0 + smoothness * (2.0 - 2.0 * ramp))
    }

    /// The cosines of the inner and outer cone of a smooth edge, for half the angle of a spot of Blender's and its
    /// blend: the ramp is this part of the way in the cosine from the edge to the axis.
    pub(crate) fn blended(half_angle: f32, blend: f32) -> (f32, f32) {
        // 1 - cos, without the rounding of a cosine near 1.
        let depth = 2.0 * (0.5 * half_angle).sin().powi(2);
        (1.0 - depth * (1.0 - blend), 1.0 - depth)
    }

    /// Cosines as spots need them: not negative, and the outer one less, though equal angles are a hard edge, and
    /// cosines of narrow cones may round to the same number.
    pub(crate) fn apart(cos_inner: f32, cos_outer: f32) -> (f32, f32) {
        let cos_inner = cos_inner.max(f32::MIN_POSITIVE);
        (cos_inner, cos_outer.max(0.0).min(cos_inner.next_down()))
    }

    /// The mean over the ramp.
    fn mean(self) -> f64 {
        match self {
            Self::Square => 1.0 / 3.0,
            Self::Smooth => 0.5,
        }
    }

    /// The solid angle that a spot's full intensity would fill with all of its power.
    pub(crate) fn solid_angle(self, cos_inner: f32, cos_outer: f32) -> f64 {
        let [inner, outer] = [cos_inner, cos_outer].map(f64::from);
        TAU * (1.0 - inner + (inner - outer) * self.mean())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn edges_go_from_0_to_1_and_have_their_mean() {
        for edge in [SpotEdge::Square, SpotEdge::Smooth] {
            let part = |ramp: f32| f64::from(SpotEdge::part(ramp, edge.smoothness()));
            assert_eq!([part(0.0), part(1.0)], [0.0, 1.0]);
            let mean = (0..1000).map(|i| part((i as f32 + 0.5) / 1000.0)).sum::<f64>() / 1000.0;
            assert!((mean - edge.mean()).abs() < 1e-5, "{edge:?}: {mean}");
        }
        assert_eq!(SpotEdge::part(0.5, SpotEdge::Smooth.smoothness()), 0.5);
        assert_eq!(SpotEdge::part(0.5, SpotEdge::Square.smoothness()), 0.25);
    }
}
