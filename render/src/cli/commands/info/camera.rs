//! The camera of a scene.

use glam::{Vec2, Vec3};
use serde::Serialize;

use super::coordinates;
use crate::scene::{CameraPose, Clip, Lens, Projection, Scene};

/// Lengths in the model's units, angles in degrees; what the kind does not have is left out.
#[derive(Serialize)]
pub(crate) struct Camera {
    #[serde(rename = "type")]
    kind: &'static str,
    #[serde(flatten)]
    pose: Option<Pose>,
    #[serde(skip_serializing_if = "Option::is_none")]
    vfov: Option<f32>,
    #[serde(skip_serializing_if = "Option::is_none")]
    ortho_height: Option<f32>,
    #[serde(skip_serializing_if = "Option::is_none")]
    eye_distance: Option<f32>,
    #[serde(skip_serializing_if = "Option::is_none")]
    fisheye: Option<&'static str>,
    #[serde(skip_serializing_if = "Option::is_none")]
    fov: Option<f32>,
    #[serde(skip_serializing_if = "Option::is_none")]
    rays: Option<usize>,
    #[serde(skip_serializing_if = "Option::is_none")]
    lens: Option<LensInfo>,
    #[serde(skip_serializing_if = "Option::is_none")]
    shift: Option<Vec2>,
    #[serde(skip_serializing_if = "Option::is_none")]
    near: Option<f32>,
    #[serde(skip_serializing_if = "Option::is_none")]
    far: Option<f32>,
}

#[derive(Serialize)]
struct Pose {
    eye: Vec3,
    target: Vec3,
    up: Vec3,
}

#[derive(Serialize)]
struct LensInfo {
    aperture: f32,
    focus: f32,
    blades: u32,
    blade_rotation: f32,
    anamorphic: f32,
}

impl Camera {
    pub(crate) fn of(scene: &Scene) -> Self {
        let CameraPose { eye, target, up, vfov } = scene.camera.expect("overrides give every scene a camera");
        let projection = &scene.optics.projection;
        let Clip { near, far } = scene.optics.clip;
        let lens = |Lens { radius, focus, blades, rotation, ratio }: Lens| LensInfo {
            aperture: 2.0 * radius,
            focus,
            blades,
            blade_rotation: rotation,
            anamorphic: ratio,
        };
        let mut camera = Self {
            kind: projection.name(),
            pose: Some(Pose { eye, target, up }),
            vfov: None,
            ortho_height: None,
            eye_distance: None,
            fisheye: None,
            fov: None,
            rays: None,
            lens: scene.optics.lens.map(lens),
            shift: Some(scene.optics.shift).filter(|shift| *shift != Vec2::ZERO),
            near: Some(near).filter(|near| *near > 0.0),
            far: Some(far).filter(|far| far.is_finite()),
        };
        match projection {
            Projection::Perspective => camera.vfov = Some(vfov),
            Projection::Orthographic { height } => camera.ortho_height = Some(*height),
            Projection::Panorama { eye_distance } => camera.eye_distance = *eye_distance,
            Projection::Fisheye { mapping, field_of_view } => {
                (camera.fisheye, camera.fov) = (Some(mapping.name()), Some(*field_of_view));
            }
            Projection::Cube => {}
            Projection::Rays(table) => (camera.pose, camera.rays) = (None, Some(table.rays.len())),
        }
        camera
    }

    /// Rows of the table.
    pub(crate) fn rows(&self, row: &mut impl FnMut(&str, String)) {
        let kind = match (self.fisheye, self.fov, self.rays) {
            (Some(mapping), Some(fov), _) => format!("{}, {mapping}, {fov}°", self.kind),
            (.., Some(rays)) => format!("{rays} {} of a file", self.kind),
            _ => self.kind.to_owned(),
        };
        row("camera", kind);
        if let Some(Pose { eye, target, up }) = &self.pose {
            row("camera eye", coordinates(*eye));
            row("camera target", coordinates(*target));
            row("camera up", coordinates(*up));
        }
        if let Some(vfov) = self.vfov {
            row("camera vfov", format!("{vfov}°"));
        }
        if let Some(height) = self.ortho_height {
            row("camera height", height.to_string());
        }
        if let Some(distance) = self.eye_distance {
            row("camera eyes", format!("two, {distance} apart: the left one's picture is the upper half"));
        }
        if let Some(LensInfo { aperture, focus, blades, blade_rotation, anamorphic }) = &self.lens {
            let shape = match blades {
                0 => "round".to_owned(),
                _ => format!("{blades} blades turned by {blade_rotation}°"),
            };
            let ratio =
                if *anamorphic == 1.0 { String::new() } else { format!(", {anamorphic} times as high as wide") };
            row("camera lens", format!("aperture {aperture}, focus {focus}, {shape}{ratio}"));
        }
        if let Some(shift) = self.shift {
            row("camera shift", format!("{} {} of the longer side", shift.x, shift.y));
        }
        if self.near.is_some() || self.far.is_some() {
            let far = self.far.map_or("infinity".to_owned(), |far| far.to_string());
            row("camera clip", format!("from {} to {far}", self.near.unwrap_or(0.0)));
        }
    }
}
