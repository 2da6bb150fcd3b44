//! Messages between the page and its workers as JSON.

use halfdome::scene::{CameraPose, IntegratorOverrides, Overrides, Scene};
use halfdome::settings::{Integrator, Settings};
use serde::{Deserialize, Serialize};

/// A camera's pose: points and vectors as x, y, z, and the vertical field of view in degrees.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub(crate) struct Pose {
    eye: [f32; 3],
    target: [f32; 3],
    up: [f32; 3],
    vfov: f32,
}

/// What is to be seen.
#[derive(Debug, Deserialize)]
pub(crate) struct View {
    width: u32,
    height: u32,
    spp: u32,
    integrator: String,
    camera: Pose,
}

/// What a scene is.
#[derive(Debug, Serialize)]
pub(crate) struct Summary {
    pub(crate) triangles: usize,
    /// The corners of a box around it.
    pub(crate) bounds: [[f32; 3]; 2],
    pub(crate) camera: Pose,
    pub(crate) warnings: Vec<String>,
}

impl From<CameraPose> for Pose {
    fn from(CameraPose { eye, target, up, vfov }: CameraPose) -> Self {
        Self { eye: eye.into(), target: target.into(), up: up.into(), vfov }
    }
}

impl View {
    /// Reads JSON.
    pub(crate) fn parse(json: &[u8]) -> Result<Self, String> {
        serde_json::from_slice(json).map_err(|error| format!("the view cannot be read: {error}"))
    }

    /// The settings and the camera of this view; those of the command line with the same options.
    pub(crate) fn apply(&self) -> Result<(Settings, CameraPose), String> {
        let integrator = Integrator::named(&self.integrator);
        let integrator = integrator.ok_or_else(|| {
            format!("there is no integrator {:?}\n  help: use {}", self.integrator, Integrator::NAMES.join(", "))
        })?;
        let Pose { eye, target, up, vfov } = self.camera;
        let overrides = Overrides {
            eye: Some(eye.into()),
            target: Some(target.into()),
            up: Some(up.into()),
            vfov: Some(vfov),
            width: Some(self.width),
            height: Some(self.height),
            spp: Some(self.spp),
            integrator: IntegratorOverrides { integrator: Some(integrator), ..Default::default() },
            ..Default::default()
        };
        let mut scene = Scene::default();
        let settings = overrides.apply(&mut scene).map_err(|conflict| conflict.to_string())?;
        Ok((settings, scene.camera.ok_or("the view has no camera")?))
    }
}
