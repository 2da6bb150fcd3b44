//! Cameras: they look along their node's -Z axis, with +Y up.
//!
//! The magnifications of an orthographic camera are half the width and half the height of its view. Clipping planes are
//! stored, but not used unless requested. glTF has no lens shift and no depth of field.

use ::gltf::json::Camera;
use ::gltf::json::camera::{Orthographic, Perspective};
use glam::DVec3;

use super::Document;
use super::hierarchy::Placed;
use crate::scene::nearest::suggestion;
use crate::scene::{CameraPose, Clip, Optics, Projection, SceneError};

/// A camera of a file.
#[derive(Clone, Debug)]
pub(super) struct FileCamera {
    pub(super) pose: CameraPose,
    pub(super) optics: Optics,
    /// The width of its picture over the height, if it says.
    pub(super) aspect: Option<f32>,
    pub(super) clip: Clip,
}

/// Which camera is meant by a name, that of its node or its own, or by a number from 1. `cameras`: both names of each.
pub(super) fn choose<'a>(
    document: &Document,
    name: &str,
    cameras: impl Iterator<Item = [&'a str; 2]> + Clone,
) -> Result<usize, SceneError> {
    let count = cameras.clone().count();
    let by_name = |which: usize| cameras.clone().position(|names| names[which] == name);
    let by_number =
        || name.parse::<usize>().ok().filter(|number| (1..=count).contains(number)).map(|number| number - 1);
    by_name(0).or_else(|| by_name(1)).or_else(by_number).ok_or_else(|| {
        let names: Vec<&str> = cameras.clone().map(|names| names[0]).filter(|name| !name.is_empty()).collect();
        let remedy = match (count, names.is_empty()) {
            (0, _) => "the file has none: leave `model_camera` out".to_owned(),
            (_, true) => format!("give a number from 1 to {count}"),
            (_, false) => suggestion(name, &names),
        };
        document.error("cameras", format!("there is no camera {name:?}"), remedy)
    })
}

/// Camera `index` of the file at a node.
pub(super) fn read(
    document: &Document,
    camera: &Camera,
    index: usize,
    placed: &Placed,
) -> Result<FileCamera, SceneError> {
    let wrong = |problem: String, remedy: &str| document.error(format!("camera {index}"), problem, remedy);
    let (vfov, projection, aspect, clip) = match (&camera.perspective, &camera.orthographic) {
        (Some(Perspective { yfov, aspect_ratio, znear, zfar, .. }), _) => {
            let vfov = yfov.to_degrees();
            if !(vfov > 0.0 && vfov < 180.0) {
                return Err(wrong(format!("its yfov is {yfov} radians"), "write an angle between 0 and pi"));
            }
            let clip = Clip { near: *znear, far: zfar.unwrap_or(f32::INFINITY) };
            (vfov, Projection::Perspective, *aspect_ratio, clip)
        }
        (None, Some(Orthographic { xmag, ymag, znear, zfar, .. })) => {
            // Some writers flip an axis by a negative magnification, which the specification says not to do.
            let [half_width, half_height] = [xmag.abs(), ymag.abs()];
            let is_size = |length: f32| length > 0.0 && length.is_finite();
            if !is_size(half_width) || !is_size(half_height) {
                let problem = format!("its xmag and ymag are {xmag} and {ymag}");
                return Err(wrong(problem, "write half the width and half the height of what it sees"));
            }
            let projection = Projection::Orthographic { height: 2.0 * half_height };
            (CameraPose::DEFAULT_VFOV, projection, Some(half_width / half_height), Clip { near: *znear, far: *zfar })
        }
        (None, None) => {
            let problem = "it is neither perspective nor orthographic".to_owned();
            return Err(wrong(problem, "give it one of these properties"));
        }
    };
    let eye = placed.to_world.w_axis.truncate();
    let (forward, up) = (placed.direction(DVec3::NEG_Z), placed.direction(DVec3::Y));
    let pose = CameraPose::along(eye, forward, up, vfov);
    if forward.cross(up).length_squared() <= 1e-12 {
        return Err(document.error(
            document.node(placed.node),
            "its camera has no direction",
            "use a scale without shear",
        ));
    }
    let aspect = aspect.filter(|aspect| aspect.is_finite() && (1e-2..=1e2).contains(aspect));
    Ok(FileCamera { pose, optics: Optics { projection, ..Optics::default() }, aspect, clip })
}
