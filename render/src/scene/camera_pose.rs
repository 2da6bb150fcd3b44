//! The pose of a camera.

use glam::Vec3;

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
