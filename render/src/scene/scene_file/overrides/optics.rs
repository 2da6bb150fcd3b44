//! From the camera's options to its optics: millimetres, f-numbers and sensors become lengths of the model and angles.

use std::sync::Arc;

use glam::{Vec2, Vec3};

use super::{CameraOverrides, Overrides};
use crate::scene::{
    CameraKind, CameraPose, Clip, Lens, Optics, Place, Projection, RayTable, Scene, SceneError, SensorFit,
};
use crate::settings::Invalid;

/// Width and height of a 35 mm film's frame, in mm; Blender's sensor, too.
const SENSOR: Vec2 = Vec2::new(36.0, 24.0);
/// Millimetres in a metre, glTF's unit.
pub(crate) const MM_PER_UNIT: f32 = 1000.0;
/// What a fisheye's disc sees, in degrees.
const FISHEYE_FOV: f32 = 180.0;

impl Overrides {
    /// Gives the scene the camera that these options and its own make, for a picture of this size.
    pub(super) fn apply_camera(&self, scene: &mut Scene, (width, height): (u32, u32)) -> Result<(), Invalid> {
        let kind = self.camera_kind(&scene.optics);
        self.check_camera(kind)?;
        let film = Film { width: width.into(), height: height.into(), options: &self.camera };
        let vfov = match self.camera.focal_length {
            Some(focal_length) => Some(film.vfov(focal_length)?),
            None => self.vfov,
        };
        // A camera that is made up looks at the middle of the model.
        let has_target = self.target.is_some() || scene.camera.is_none();
        let pose = match kind {
            CameraKind::Rays => scene.camera.unwrap_or(NO_POSE),
            _ => self.pose(scene, vfov, film.width / film.height)?,
        };
        self.move_camera(scene, kind, vfov, film.width / film.height)?;
        // What is seen from and what of it, if it was the aim.
        let target = has_target.then(|| pose.target.distance(pose.eye));
        let base = if self.is_new_camera() || CameraKind::of(&scene.optics) != kind {
            Optics::default()
        } else {
            scene.optics.clone()
        };
        let optics = Optics {
            projection: self.projection(scene, kind, &base, &pose, target, &film)?,
            lens: self.lens(&base, &pose, target, &film)?,
            shift: self.camera.shift.map_or(base.shift, |shift| film.in_longer_sides(shift)),
            clip: self.clip(scene, base.clip)?,
        };
        (scene.camera, scene.optics) = (Some(pose), optics);
        Ok(())
    }

    /// Applies the options to the camera at the shutter's keys.
    fn move_camera(&self, scene: &mut Scene, kind: CameraKind, vfov: Option<f32>, aspect: f64) -> Result<(), Invalid> {
        let Some(mut motion) = scene.motion.take() else { return Ok(()) };
        let middle = scene.camera;
        if self.is_new_camera() || kind == CameraKind::Rays {
            motion.cameras.clear();
        }
        for pose in &mut motion.cameras {
            scene.camera = Some(*pose);
            *pose = self.pose(scene, vfov, aspect)?;
        }
        scene.camera = middle;
        scene.motion = (!motion.is_still()).then_some(motion);
        Ok(())
    }

    fn projection(
        &self,
        scene: &mut Scene,
        kind: CameraKind,
        base: &Optics,
        pose: &CameraPose,
        target: Option<f32>,
        film: &Film,
    ) -> Result<Projection, Invalid> {
        let CameraOverrides { ortho_height, ortho_width, ipd, fisheye, fov, rays, .. } = &self.camera;
        Ok(match kind {
            CameraKind::Perspective => Projection::Perspective,
            CameraKind::Cube if film.width != 6.0 * film.height => {
                return Err(Invalid::new(
                    format!("a picture of {}x{} does not hold the six faces of a cube", film.width, film.height),
                    "give it six times its height for a width: the faces stand side by side",
                ));
            }
            CameraKind::Cube => Projection::Cube,
            CameraKind::Panorama if ipd.is_some() && film.height % 2.0 != 0.0 => {
                return Err(Invalid::new(
                    format!("a picture of {} rows has no two halves for two eyes", film.height),
                    "give it an even height, or leave `ipd` out",
                ));
            }
            CameraKind::Panorama => {
                let of_base = match base.projection {
                    Projection::Panorama { eye_distance } => eye_distance,
                    _ => None,
                };
                Projection::Panorama { eye_distance: ipd.map(|mm| film.units(mm)).or(of_base) }
            }
            CameraKind::Fisheye => {
                let (of_base, fov_of_base) = match base.projection {
                    Projection::Fisheye { mapping, field_of_view } => (mapping, field_of_view),
                    _ => (Default::default(), FISHEYE_FOV),
                };
                let (mapping, field_of_view) = (fisheye.unwrap_or(of_base), fov.unwrap_or(fov_of_base));
                Projection::Fisheye { mapping, field_of_view }
            }
            CameraKind::Orthographic => {
                let of_width = ortho_width.map(|width| (f64::from(width) * film.height / film.width) as f32);
                let of_base = match base.projection {
                    Projection::Orthographic { height } => Some(height),
                    _ => target.map(|distance| 2.0 * distance * (0.5 * pose.vfov.to_radians()).tan()),
                };
                let height = ortho_height.or(of_width).or(of_base).ok_or_else(|| {
                    let remedy = "give ortho_height or ortho_width in the model's units, or a target";
                    Invalid::new("the orthographic camera has no height or width", remedy)
                })?;
                Projection::Orthographic { height }
            }
            CameraKind::Rays => match (rays, &base.projection) {
                (Some(path), _) => {
                    let table = RayTable::read(path, film.width as u32, film.height as u32).map_err(of_file)?;
                    scene.files.push(path.clone());
                    Projection::Rays(Arc::new(table))
                }
                (None, Projection::Rays(table)) => Projection::Rays(table.clone()),
                (None, _) => {
                    let remedy = "name a file by --camera-rays, or rays in [camera]";
                    return Err(Invalid::new("the rays camera has no rays", remedy));
                }
            },
        })
    }

    /// The lens, if it has a width.
    fn lens(
        &self,
        base: &Optics,
        pose: &CameraPose,
        target: Option<f32>,
        film: &Film,
    ) -> Result<Option<Lens>, Invalid> {
        let CameraOverrides { aperture, f_number, focus, focus_at, blades, blade_rotation, anamorphic, .. } =
            self.camera;
        let diameter = aperture.or(f_number.map(|number| film.focal_length(pose.vfov) / number));
        let radius = match (diameter, base.lens) {
            (Some(mm), _) => 0.5 * film.units(mm),
            (None, Some(lens)) => lens.radius,
            (None, None) => {
                let given = [
                    ("focus", focus.is_some()),
                    ("focus_at", focus_at.is_some()),
                    ("blades", blades.is_some()),
                    ("blade_rotation", blade_rotation.is_some()),
                    ("anamorphic", anamorphic.is_some()),
                ];
                return match given.iter().find(|(_, given)| *given) {
                    Some((name, _)) => Err(Invalid::new(
                        format!("there is no lens that `{name}` could be of"),
                        "give aperture in mm or f_number, or leave it out",
                    )),
                    None => Ok(None),
                };
            }
        };
        let focus = match focus_at {
            Some(point) => Some(depth(pose, point)?),
            None => focus.or(base.lens.map(|lens| lens.focus)).or(target),
        };
        let focus = focus.ok_or_else(|| {
            let remedy = "give focus, a distance in the model's units, or focus_at, a point";
            Invalid::new("the lens has no focus distance", remedy)
        })?;
        let (blades_of_base, rotation, ratio) =
            base.lens.map_or((0, 0.0, 1.0), |lens| (lens.blades, lens.rotation, lens.ratio));
        let lens = Lens {
            radius,
            focus,
            blades: blades.unwrap_or(blades_of_base),
            rotation: blade_rotation.unwrap_or(rotation),
            ratio: anamorphic.unwrap_or(ratio),
        };
        Ok((radius > 0.0).then_some(lens))
    }

    fn clip(&self, scene: &Scene, base: Clip) -> Result<Clip, Invalid> {
        let CameraOverrides { near, far, model_clip, .. } = self.camera;
        let base = match (model_clip, scene.camera_clip.filter(|_| !self.is_new_camera())) {
            (Some(true), Some(clip)) => clip,
            (Some(true), None) => {
                let remedy = "leave `model_clip` out, or give near and far";
                return Err(Invalid::new(
                    "the camera is not one of a glTF file, which would have clipping planes",
                    remedy,
                ));
            }
            _ => base,
        };
        let clip = Clip { near: near.unwrap_or(base.near), far: far.unwrap_or(base.far) };
        if clip.near >= clip.far {
            return Err(Invalid::new(
                format!("`near` is {} and `far` is {}, so nothing is in between", clip.near, clip.far),
                "give a near that is less than far",
            ));
        }
        Ok(clip)
    }
}

/// The pose of a camera with rays from a file; it is unused.
const NO_POSE: CameraPose = CameraPose { eye: Vec3::ZERO, target: Vec3::NEG_Z, up: Vec3::Y, vfov: 90.0 };

/// The distance of a point along the view.
fn depth(pose: &CameraPose, point: Vec3) -> Result<f32, Invalid> {
    let eye = pose.eye.as_dvec3();
    let depth = (pose.target.as_dvec3() - eye).normalize().dot(point.as_dvec3() - eye) as f32;
    match depth > 0.0 {
        true => Ok(depth),
        false => Err(Invalid::new(
            format!("`focus_at` {point} is not in front of the camera at {}", pose.eye),
            "give a point that the camera could see",
        )),
    }
}

fn of_file(error: SceneError) -> Invalid {
    let file = error.file.display();
    let place = match error.place {
        Place::File => format!("{file}"),
        Place::Line(line) => format!("{file}:{line}"),
        Place::Part(part) => format!("{file}: {part}"),
    };
    Invalid::new(format!("{place}: {}", error.problem), error.remedy)
}

/// A picture's sides in pixels, with what they are in millimetres.
struct Film<'a> {
    width: f64,
    height: f64,
    options: &'a CameraOverrides,
}

impl Film<'_> {
    /// The side in pixels that the sensor fits, and its size in mm.
    fn fitted(&self) -> (f64, f64) {
        let sensor = self.options.sensor.unwrap_or(SENSOR).as_dvec2();
        match self.options.sensor_fit.unwrap_or_default() {
            SensorFit::Auto => (self.width.max(self.height), sensor.x),
            SensorFit::Horizontal => (self.width, sensor.x),
            SensorFit::Vertical => (self.height, sensor.y),
        }
    }

    /// Half the picture's height in mm.
    fn half_height(&self) -> f64 {
        let (pixels, mm) = self.fitted();
        0.5 * self.height * mm / pixels
    }

    /// The vertical field of view in degrees of a focal length in mm.
    fn vfov(&self, focal_length: f32) -> Result<f32, Invalid> {
        let vfov = (2.0 * (self.half_height() / f64::from(focal_length)).atan()).to_degrees() as f32;
        match vfov > 0.0 && vfov < 180.0 {
            true => Ok(vfov),
            false => Err(Invalid::new(
                format!("a `focal_length` of {focal_length} mm makes a field of view of {vfov} degrees"),
                "give a focal length nearer to the sensor's size",
            )),
        }
    }

    /// The focal length in mm of a vertical field of view in degrees.
    fn focal_length(&self, vfov: f32) -> f32 {
        (self.half_height() / (0.5 * f64::from(vfov).to_radians()).tan()) as f32
    }

    /// Millimetres in the model's units.
    fn units(&self, mm: f32) -> f32 {
        mm / self.options.mm_per_unit.unwrap_or(MM_PER_UNIT)
    }

    /// A shift in parts of the longer side, from parts of the side that the sensor fits.
    fn in_longer_sides(&self, shift: Vec2) -> Vec2 {
        let longer = self.width.max(self.height);
        (shift.as_dvec2() * (self.fitted().0 / longer)).as_vec2()
    }
}

#[cfg(test)]
mod tests;
