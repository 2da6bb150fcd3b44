//! The camera's pose: from the options, the model, or the model's bounds.

use glam::Vec3;
use halfdome_kernel::MAX_COORDINATE;

use super::Overrides;
use crate::scene::framing::{frame, frame_inside};
use crate::scene::{CameraPose, Scene};
use crate::settings::Invalid;

/// The least sine of the angle between the view and the up vector: below it the up direction is undefined in 32-bit
/// floats.
const MIN_SIN_UP: f64 = 1e-4;

/// The least distance from eye to target; the square of a smaller one vanishes in 32 bits.
const MIN_VIEW_LENGTH: f64 = 1e-18;

impl Overrides {
    /// Whether the options make a camera in place of the model's.
    pub(super) fn is_new_camera(&self) -> bool {
        self.eye.is_some() && self.target.is_some()
    }

    /// With both eye and target given, a new camera; else the scene's, or without one the framing one, with what is
    /// given replaced. `vfov` is what the options say.
    pub(super) fn pose(&self, scene: &mut Scene, vfov: Option<f32>, aspect: f64) -> Result<CameraPose, Invalid> {
        let new = self.is_new_camera();
        let base = match scene.camera.filter(|_| !new) {
            Some(pose) => pose,
            None => {
                let up = self.up.unwrap_or(Vec3::Y);
                let inside = if new { None } else { frame_inside(scene, up, vfov) };
                if !new {
                    let what = if inside.is_some() { "inside its closed room" } else { "that shows all of it" };
                    let how = if scene.meshes.iter().any(|mesh| mesh.origin.is_some()) {
                        "set --eye and --target, or export one: Blender leaves cameras out unless Include > Cameras is on"
                    } else {
                        "set --eye and --target"
                    };
                    scene.warnings.push(format!("the model has no camera; one {what} is used ({how})"));
                }
                let bounds = scene.bounds().unwrap_or((Vec3::ZERO, Vec3::ZERO));
                inside.unwrap_or_else(|| frame(bounds, up, vfov.unwrap_or(CameraPose::DEFAULT_VFOV), aspect))
            }
        };
        let pose = CameraPose {
            eye: self.eye.unwrap_or(base.eye),
            target: self.target.unwrap_or(base.target),
            up: self.up.unwrap_or(base.up),
            vfov: vfov.unwrap_or(base.vfov),
        };
        check_pose(&pose)?;
        // A very long or short vector would not survive the squares of 32-bit arithmetic.
        Ok(CameraPose { up: pose.up.as_dvec3().normalize().as_vec3(), ..pose })
    }
}

/// Refuses a pose from which no picture follows.
fn check_pose(pose: &CameraPose) -> Result<(), Invalid> {
    let CameraPose { eye, target, up, .. } = *pose;
    if eye.abs().max(target.abs()).max_element() > MAX_COORDINATE {
        return Err(Invalid::new(
            format!("the camera at {eye}, looking at {target}, is too far away"),
            format!("coordinates go up to {MAX_COORDINATE:e}; scale the model down"),
        ));
    }
    let view = target.as_dvec3() - eye.as_dvec3();
    if view.length() < MIN_VIEW_LENGTH {
        return Err(Invalid::new(
            format!("the camera's eye {eye} and target {target} are the same point"),
            "give two different points: eye is where the camera stands, target what it looks at",
        ));
    }
    if view.normalize().cross(up.as_dvec3().normalize()).length() < MIN_SIN_UP {
        return Err(Invalid::new(
            format!("the camera's up vector {up} points along its view"),
            "give an up vector across the view, for example 0,0,-1 to look straight down",
        ));
    }
    Ok(())
}
