//! Cameras: `Camera`, and the picture's size and samples by `Film` and `Sampler`.
//!
//! pbrt's cameras look along +z with +y up and +x to the right, which is left-handed; so a scene's coordinates are
//! left-handed unless the camera's transform mirrors (`Scale -1 1 1`). Coordinates are right-handed here: where the
//! transform does not mirror, the world's x is negated, so that pictures match pbrt's.
//!
//! `fov` is of the shorter side. A `screenwindow` may be anywhere and of any shape: it gives the lens's shift, the
//! height of the view and the picture's aspect.

use glam::{DAffine3, DVec3, Vec2};

use super::Reader;
use super::parameters::Parameters;
use crate::scene::nearest::suggestion;
use crate::scene::{CameraPose, Lens, Optics, Projection, SceneError};

/// The contents of a `Camera` directive.
pub(super) struct Camera {
    is_orthographic: bool,
    fov: f32,
    window: Option<[f32; 4]>,
    aspect: Option<f32>,
    lens_radius: f32,
    focal_distance: f32,
    /// The camera's transform, with negated x if the world is mirrored.
    to_world: DAffine3,
}

impl Reader<'_> {
    /// `Camera`.
    pub(super) fn camera(&mut self, kind: &str, parameters: &Parameters) -> Result<(), SceneError> {
        parameters.ignore(&["shutteropen", "shutterclose"]);
        let world_to_camera = self.state.transform;
        self.is_mirrored = world_to_camera.matrix3.determinant() > 0.0;
        self.systems.insert("camera".to_owned(), world_to_camera.inverse());
        match kind {
            "perspective" | "orthographic" => {}
            "realistic" | "spherical" => {
                self.note(&parameters.at, &format!("a camera {kind:?} is not read; a perspective one instead"));
                parameters.unused().for_each(|unused| parameters.ignore(&[&unused.name]));
            }
            "environment" => return Err(super::of_v3(&parameters.at, "the camera \"environment\"")),
            _ => {
                let problem = format!("there is no camera {kind:?}");
                return Err(parameters.at.error(problem, suggestion(kind, &["perspective", "orthographic"])));
            }
        }
        let fov = parameters.float("fov", 90.0)?;
        if !(fov > 0.0 && fov < 180.0) {
            let at = parameters.get("fov").map_or(&parameters.at, |found| &found.at);
            return Err(at.error(format!("`fov` of {} is {fov}", parameters.of), "write degrees between 0 and 180"));
        }
        let window = match parameters.floats("screenwindow")? {
            Some(&[x0, x1, y0, y1]) if x0 < x1 && y0 < y1 => Some([x0, x1, y0, y1]),
            Some(_) => {
                let at = parameters.get("screenwindow").map_or(&parameters.at, |found| &found.at);
                let remedy = "write four numbers: the least and greatest x, then y";
                return Err(at.error(format!("`screenwindow` of {} is no rectangle", parameters.of), remedy));
            }
            None => None,
        };
        let aspect = match parameters.has("frameaspectratio") {
            true => Some(parameters.positive("frameaspectratio", 1.0)?),
            false => None,
        };
        self.file_camera = Some(Camera {
            is_orthographic: kind == "orthographic",
            fov,
            window,
            aspect,
            lens_radius: parameters.float("lensradius", 0.0)?,
            focal_distance: parameters.positive("focaldistance", 1e6)?,
            to_world: self.mirror() * world_to_camera.inverse(),
        });
        self.warn_of_unused(parameters);
        Ok(())
    }

    /// `Film`.
    pub(super) fn film(&mut self, kind: &str, parameters: &Parameters) -> Result<(), SceneError> {
        if kind == "image" {
            return Err(super::of_v3(&parameters.at, "the film \"image\""));
        }
        let side = |name: &str, default: i32| match parameters.integer(name, default) {
            Ok(pixels) if pixels < 1 => {
                Err(parameters.at.error(format!("`{name}` of Film is {pixels}"), "write a number of pixels"))
            }
            pixels => pixels.map(|pixels| pixels as u32),
        };
        self.film_size = Some((side("xresolution", 1280)?, side("yresolution", 720)?));
        for name in ["cropwindow", "pixelbounds", "iso", "exposuretime", "whitebalance"] {
            if parameters.has(name) {
                self.note(&parameters.at, &format!("`{name}` of Film is not read"));
            }
        }
        if parameters.text("sensor")?.is_some_and(|sensor| sensor != "cie1931") {
            self.note(&parameters.at, "the `sensor` of Film is not read: pictures are linear sRGB, white stays white");
        }
        Ok(())
    }

    /// `Sampler`: how many samples a pixel has. Which ones is an option here.
    pub(super) fn sampler(&mut self, kind: &str, parameters: &Parameters) -> Result<(), SceneError> {
        let count = match kind {
            "stratified" => {
                let [x, y] = [parameters.integer("xsamples", 4)?, parameters.integer("ysamples", 4)?];
                x.saturating_mul(y.max(0))
            }
            _ => parameters.integer("pixelsamples", 16)?,
        };
        if count < 1 {
            let problem = format!("{} takes {count} samples a pixel", parameters.of);
            return Err(parameters.at.error(problem, "write numbers of 1 or more"));
        }
        self.scene.film_spp = Some(count as u32);
        Ok(())
    }

    /// Gives the scene its camera, now that the film is known.
    pub(super) fn finish_camera(&mut self) {
        let Some(camera) = self.file_camera.take() else { return };
        let (width, height) = self.film_size.unwrap_or((1280, 720));
        let aspect = camera.aspect.unwrap_or(width as f32 / height as f32);
        let (x, y) = if aspect > 1.0 { (aspect, 1.0) } else { (1.0, aspect.recip()) };
        let [x0, x1, y0, y1] = camera.window.unwrap_or([-x, x, -y, y]);
        let half_height = 0.5 * (y1 - y0);
        let (eye, linear) = (camera.to_world.translation, camera.to_world.matrix3);
        let [up, forward] = [linear * DVec3::Y, linear * DVec3::Z].map(|axis| axis.normalize_or_zero());
        let vfov = match camera.is_orthographic {
            true => CameraPose::DEFAULT_VFOV,
            false => 2.0 * (half_height * (0.5 * camera.fov).to_radians().tan()).atan().to_degrees(),
        };
        self.scene.camera = Some(CameraPose::along(eye, forward, up, vfov));
        let scale = linear.y_axis.length() as f32;
        let depth = linear.z_axis.length() as f32;
        self.scene.optics = Optics {
            projection: match camera.is_orthographic {
                true => Projection::Orthographic { height: 2.0 * half_height * scale },
                false => Projection::Perspective,
            },
            lens: (camera.lens_radius > 0.0).then_some(Lens {
                radius: camera.lens_radius * scale,
                focus: camera.focal_distance * depth,
                blades: 0,
                rotation: 0.0,
                ratio: 1.0,
            }),
            shift: 0.5 * Vec2::new(x0 + x1, y0 + y1) / (x1 - x0).max(y1 - y0),
            ..Optics::default()
        };
        self.scene.camera_aspect = Some((x1 - x0) / (y1 - y0));
        self.scene.film_size = self.film_size;
    }
}
