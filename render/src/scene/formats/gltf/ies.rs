//! `EXT_lights_ies`: lights with photometric profiles, whose axis is their node's -Z axis and whose horizontal angle 0
//! is towards its X axis. Candela have the units that those of `KHR_lights_punctual` have.

use std::sync::Arc;

use ::gltf::json::Index;
use glam::{DVec3, Vec3};
use serde::Deserialize;

use super::extensions::Extensions;
use super::hierarchy::Placed;
use super::{Document, accessor, container};
use crate::scene::formats::ies;
use crate::scene::{Place, ProfileFrame, PunctualLight, SceneError};

const NAME: &str = "EXT_lights_ies";

/// The extension at the root.
#[derive(Default, Deserialize)]
struct Profiles {
    #[serde(default)]
    lights: Vec<File>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct File {
    uri: Option<String>,
    buffer_view: Option<u32>,
}

/// The extension of a node.
#[derive(Deserialize)]
struct Instance {
    light: usize,
    #[serde(default = "one")]
    multiplier: f32,
    #[serde(default = "white")]
    color: [f32; 3],
}

fn one() -> f32 {
    1.0
}

fn white() -> [f32; 3] {
    [1.0; 3]
}

/// The light with a profile at a node, if it has one.
pub(super) fn read(document: &Document, placed: &Placed) -> Result<Option<PunctualLight>, SceneError> {
    let place = document.node(placed.node);
    let node = document.root.nodes[placed.node].extensions.as_ref();
    let Some(instance) = Extensions::new(document, &place, node.map(|it| &it.others)).take::<Instance>(NAME)? else {
        return Ok(None);
    };
    let root = document.root.extensions.as_ref();
    let profiles: Profiles = Extensions::new(document, NAME, root.map(|it| &it.others)).take(NAME)?.unwrap_or_default();
    let Some(file) = profiles.lights.get(instance.light) else {
        let problem = format!("it refers to the light profile {}, which does not exist", instance.light);
        return Err(document.error(place, problem, "refer to one that the file has, counted from 0"));
    };
    let color = Vec3::from(instance.color);
    if !(instance.multiplier >= 0.0
        && instance.multiplier.is_finite()
        && color.is_finite()
        && color.min_element() >= 0.0)
    {
        let problem = "the colour or multiplier of its light is negative or not finite";
        return Err(document.error(place, problem, "write numbers that are 0 or more"));
    }
    let of_profile = format!("light profile {}", instance.light);
    let (bytes, path) = match (&file.uri, file.buffer_view) {
        (Some(uri), _) => {
            let is_file = !uri.starts_with("data:");
            let path = document.path.parent().filter(|_| is_file).map(|folder| folder.join(uri));
            (container::fetch(document.files, document.path, uri, &of_profile)?, path)
        }
        (None, Some(view)) => (accessor::view(document, Index::new(view), &of_profile)?.to_vec(), None),
        (None, None) => {
            return Err(document.error(of_profile, "it has no data", "give it a `uri` or a `bufferView`"));
        }
    };
    let profile =
        ies::parse(path.as_deref().unwrap_or(document.path), &bytes).map_err(|error| match (&path, &error.place) {
            // Bytes of the model have lines of their own.
            (None, Place::Line(line)) => {
                document.error(of_profile, format!("line {line}: {}", error.problem), error.remedy)
            }
            _ => error,
        })?;
    let axis = placed.direction(DVec3::NEG_Z).as_vec3();
    let zero = placed.direction(DVec3::X).as_vec3();
    Ok(Some(PunctualLight::Profiled {
        position: placed.origin(),
        frame: ProfileFrame { axis, zero },
        intensity: color.min(Vec3::ONE) * instance.multiplier,
        radius: 0.0,
        profile: Arc::new(profile),
    }))
}
