//! Perspective cameras: they look along their node's -Z axis, with +Y up.

use ::gltf::json::Camera;
use glam::DVec3;

use super::Document;
use super::hierarchy::Placed;
use crate::scene::{CameraPose, SceneError};

/// The camera with the number `index` at a node; `None`, and a warning, for an orthographic one. The target is one unit
/// ahead. Neither aspect ratio nor clipping planes matter.
pub(super) fn read(
    document: &Document,
    camera: &Camera,
    index: usize,
    placed: &Placed,
    warnings: &mut Vec<String>,
) -> Result<Option<CameraPose>, SceneError> {
    let Some(perspective) = &camera.perspective else {
        warnings.push(format!("{}: camera {index} is not a perspective one and is skipped", document.path.display()));
        return Ok(None);
    };
    let vfov = perspective.yfov.to_degrees();
    if !(vfov > 0.0 && vfov < 180.0) {
        return Err(document.error(
            format!("camera {index}"),
            format!("its yfov is {} radians", perspective.yfov),
            "write an angle between 0 and pi",
        ));
    }
    let linear = placed.linear();
    let eye = placed.to_world.w_axis.truncate();
    let pose = |forward: DVec3, up: DVec3| CameraPose {
        eye: eye.as_vec3(),
        target: (eye + forward).as_vec3(),
        up: up.as_vec3(),
        vfov,
    };
    let pose = match ((linear * DVec3::NEG_Z).try_normalize(), (linear * DVec3::Y).try_normalize()) {
        (Some(forward), Some(up)) if forward.cross(up).length_squared() > 1e-12 => Some(pose(forward, up)),
        _ => None,
    };
    // Far from the origin, one unit ahead rounds to the eye itself.
    pose.filter(|pose| pose.target != pose.eye).map(Some).ok_or_else(|| {
        document.error(
            document.node(placed.node),
            "its camera has no direction",
            "use a scale that is not 0, and stay within 1e7 units of the origin",
        )
    })
}
