//! The pose of a camera.

use glam::{DVec3, Vec3};

/// A camera's pose.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CameraPose {
    /// The pinhole, or the middle of the lens.
    pub eye: Vec3,
    /// A point in the middle of the picture.
    pub target: Vec3,
    /// A vector that points up in the picture; not parallel to the view.
    pub up: Vec3,
    /// Vertical field of view in degrees, between 0 and 180, of perspective cameras.
    pub vfov: f32,
}

/// The part of the eye's distance from the origin that a target is ahead, at least: a rounding is 2⁻²⁴ of that
/// distance.
const MIN_AHEAD: f64 = 1.0 / 16.0;

impl CameraPose {
    /// The vertical field of view of a camera without one, in degrees.
    pub(crate) const DEFAULT_VFOV: f32 = 40.0;

    /// A camera that looks along a unit vector, at a target one unit ahead; far from the origin so far ahead that
    /// rounding of the two points does not turn the view by more than a millionth.
    pub(in crate::scene) fn along(eye: DVec3, forward: DVec3, up: DVec3, vfov: f32) -> Self {
        let ahead = (MIN_AHEAD * eye.abs().max_element()).max(1.0);
        Self { eye: eye.as_vec3(), target: (eye + ahead * forward).as_vec3(), up: up.as_vec3(), vfov }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn views_keep_their_direction_far_from_the_origin() {
        let forward = DVec3::new(0.48, -0.6, 0.64);
        for distance in [0.0, 1.0, 1e3, 1e5, 1e7] {
            let eye = distance * DVec3::new(0.3, 1.0, -0.7);
            let pose = CameraPose::along(eye, forward, DVec3::Z, 40.0);
            let view = (pose.target.as_dvec3() - pose.eye.as_dvec3()).normalize();
            assert!((view - forward).length() < 3e-6, "{distance}: {view}");
        }
    }
}
