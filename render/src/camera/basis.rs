//! The position and the axes of a camera.

use glam::{DVec3, Vec3};

use crate::scene::CameraPose;

/// An eye with axes, orthonormal.
#[derive(Clone, Copy, Debug)]
pub(super) struct Basis {
    pub(super) eye: Vec3,
    pub(super) right: DVec3,
    pub(super) up: DVec3,
    pub(super) forward: DVec3,
}

impl Basis {
    pub(super) fn new(pose: &CameraPose) -> Self {
        let forward = (pose.target.as_dvec3() - pose.eye.as_dvec3()).normalize();
        let right = forward.cross(pose.up.as_dvec3()).normalize();
        let up = right.cross(forward);
        Self { eye: pose.eye, right, up, forward }
    }

    /// The vector of the world with these parts to the right, up and forward.
    pub(super) fn to_world(self, [right, up, forward]: [f64; 3]) -> DVec3 {
        self.right * right + self.up * up + self.forward * forward
    }

    /// The parts to the right, up and forward of the vector from the eye to a point.
    pub(super) fn to_view(self, point: Vec3) -> [f64; 3] {
        let vector = point.as_dvec3() - self.eye.as_dvec3();
        [self.right, self.up, self.forward].map(|axis| axis.dot(vector))
    }

    /// Rows of the matrix that takes world points, as column vectors, to camera space: right, up, backwards.
    pub(super) fn world_to_camera(&self) -> [[f32; 4]; 4] {
        let row = |axis: DVec3| {
            let shift = -axis.dot(self.eye.as_dvec3());
            [axis.x as f32, axis.y as f32, axis.z as f32, shift as f32]
        };
        [row(self.right), row(self.up), row(-self.forward), [0.0, 0.0, 0.0, 1.0]]
    }
}
