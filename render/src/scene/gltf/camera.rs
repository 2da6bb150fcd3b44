//! Perspective cameras: they look along their node's -Z axis, with +Y up.
//!
//! Deviation: orthographic cameras are skipped with a warning. glTF has no lens shift and no depth of field.

use ::gltf::json::Camera;
use glam::DVec3;

use super::Document;
use super::hierarchy::Placed;
use crate::scene::{CameraPose, SceneError};

/// The camera with the number `index` at a node, and its picture's width over its height if it says; `None`, and a warning,
/// for an orthographic one. The target is one unit ahead. Clipping planes do not matter.
pub(super) fn read(
    document: &Document,
    camera: &Camera,
    index: usize,
    placed: &Placed,
    warnings: &mut Vec<String>,
) -> Result<Option<(CameraPose, Option<f32>)>, SceneError> {
    let Some(perspective) = &camera.perspective else {
        warnings.push(format!(
            "{}: camera {index} is orthographic, which cannot be rendered yet, so it is skipped; --eye, --target and --vfov \
             make a perspective one",
            document.path.display()
        ));
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
    let eye = placed.to_world.w_axis.truncate();
    let (forward, up) = (placed.direction(DVec3::NEG_Z), placed.direction(DVec3::Y));
    let pose = CameraPose { eye: eye.as_vec3(), target: (eye + forward).as_vec3(), up: up.as_vec3(), vfov };
    // Far from the origin, one unit ahead rounds to the eye itself.
    if forward.cross(up).length_squared() <= 1e-12 || pose.target == pose.eye {
        return Err(document.error(
            document.node(placed.node),
            "its camera has no direction",
            "use a scale without shear, and stay within 1e7 units of the origin",
        ));
    }
    let aspect = perspective.aspect_ratio.filter(|aspect| aspect.is_finite() && (1e-2..=1e2).contains(aspect));
    Ok(Some((pose, aspect)))
}
