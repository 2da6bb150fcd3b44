//! glTF 2.0 (Khronos Group), as JSON text or in a binary container (GLB).
//!
//! The crate `gltf` gives the JSON its types. Its readers are not used, since they panic on indices and ranges that a
//! malformed file may have: here every index and every range is checked.
//!
//! The reader takes the default scene (all root nodes if there is none), its nodes' transforms, triangles with normals
//! and the first two sets of texture coordinates, colours and tangents, materials (`material.rs`) with their textures
//! (`texture.rs`), cameras and `KHR_lights_punctual`. Every primitive of every node becomes a mesh in world space,
//! named like its node; meshes shared by many nodes become objects with instances (`instancing.rs`).
//!
//! Deviations: a primitive without a material gets the grey default, where the specification has white. Emission is
//! radiance, a light's candela are W/sr and its lux W/m², one to one. Lights' ranges are left out
//! with a warning, and points and lines too if they are given no radius (`meshes/round.rs`).

pub(crate) mod accessor;
mod animation;
mod attributes;
mod camera;
pub(crate) mod container;
mod draco;
mod empty_nodes;
mod extensions;
mod hierarchy;
mod ies;
mod instancing;
mod light;
mod material;
mod mesh;
mod meshopt;
mod morph;
mod pose;
mod primitive;
mod required;
mod skin;
mod skipped;
mod texture;
mod variants;

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::path::Path;

use ::gltf::json::{Index, Root, deserialize, root::Get};
use serde::Deserialize;
use serde_json::value::RawValue;

use super::notes::Notes;
use crate::scene::{
    Animation, Disk, Files, LightLabel, LightUnits, LoadOptions, Material, Moment, Place, Scene, SceneError,
};
use mesh::Meshes;
use pose::Pose;
use required::{NOT_EDITED, check_required, note_extensions};
use skipped::Skipped;

/// Reads glTF as JSON text.
pub(crate) fn read_json(
    files: &dyn Files,
    path: &Path,
    text: &[u8],
    options: &LoadOptions,
) -> Result<Scene, SceneError> {
    let parsed = parse(path, text, |error| Place::Line(error.line()))?;
    read(files, path, parsed, None, options)
}

/// Reads a GLB container.
pub(crate) fn read_binary(
    files: &dyn Files,
    path: &Path,
    bytes: &[u8],
    options: &LoadOptions,
) -> Result<Scene, SceneError> {
    let chunks = container::split(path, bytes)?;
    let parsed = parse(path, chunks.json, |error| {
        Place::Part(format!("JSON chunk, line {}, column {}", error.line(), error.column()))
    })?;
    read(files, path, parsed, chunks.binary, options)
}

/// A glTF file with its buffers.
pub(crate) struct Document<'a> {
    files: &'a dyn Files,
    path: &'a Path,
    /// Without animations.
    pub(crate) root: Root,
    animations: Vec<animation::Listed>,
    buffers: Vec<Cow<'a, [u8]>>,
    /// What compressed buffer views hold, by their indices.
    decompressed: BTreeMap<usize, Vec<u8>>,
    /// See [`LoadOptions`].
    without_pictures: bool,
    /// The radius of points and lines, in the coordinates of their mesh; without it they are left out.
    point_radius: Option<f32>,
}

/// Splits a file that may be JSON text or a GLB container, for callers that need no scene.
pub(crate) fn open<'a>(path: &'a Path, bytes: &'a [u8]) -> Result<(Document<'a>, container::Chunks<'a>), SceneError> {
    let chunks = match bytes.starts_with(b"glTF") {
        true => container::split(path, bytes)?,
        false => container::Chunks { json: bytes, binary: None, others: Vec::new() },
    };
    let (root, animations) = parse(path, chunks.json, |error| Place::Line(error.line()))?;
    let used = root.extensions_used.iter().find(|name| NOT_EDITED.contains(&name.as_str()));
    if let Some(name) = used {
        let problem = format!("the file uses {name}, and cannot be changed");
        let place = Place::Part("extensionsUsed".to_owned());
        return Err(SceneError::new(path, place, problem, "export the model without it"));
    }
    let buffers = container::buffers(&Disk, path, &root, chunks.binary)?;
    let decompressed = BTreeMap::new();
    Ok((
        Document {
            files: &Disk,
            path,
            root,
            animations,
            buffers,
            decompressed,
            without_pictures: false,
            point_radius: None,
        },
        chunks,
    ))
}

/// The least number of elements for a thread.
const PARALLEL: usize = 1 << 14;

impl Document<'_> {
    /// An error about a part of the file.
    pub(crate) fn error(
        &self,
        part: impl Into<String>,
        problem: impl Into<String>,
        remedy: impl Into<String>,
    ) -> SceneError {
        SceneError::new(self.path, Place::Part(part.into()), problem, remedy)
    }

    /// The object at `index`. `kind` names such objects ("mesh"), `user` what refers to it ("node 3").
    pub(crate) fn object<T>(&self, index: Index<T>, kind: &str, user: &str) -> Result<&T, SceneError>
    where
        Root: Get<T>,
    {
        self.root.get(index).ok_or_else(|| {
            let problem = format!("it refers to {kind} {}, which does not exist", index.value());
            self.error(user, problem, "refer to one that the file has, counted from 0")
        })
    }

    /// Whether the file says that it uses an extension.
    fn uses(&self, name: &str) -> bool {
        self.root.extensions_used.iter().chain(&self.root.extensions_required).any(|used| used == name)
    }

    /// Whether Blender's exporter wrote the file.
    pub(crate) fn is_from_blender(&self) -> bool {
        self.root.asset.generator.as_deref().is_some_and(|generator| generator.contains("Blender"))
    }

    /// The node's name in errors: "node 5" or "node 5 (\"lamp\")".
    pub(crate) fn node(&self, index: usize) -> String {
        let name = self.root.nodes.get(index).and_then(|node| node.name.as_deref());
        name.map_or_else(|| format!("node {index}"), |name| format!("node {index} ({name:?})"))
    }
}

/// The part of glTF that all its versions have, and what is read apart.
#[derive(Deserialize)]
struct Outline<'a> {
    asset: Option<Asset>,
    #[serde(borrow)]
    animations: Option<&'a RawValue>,
}

#[derive(Deserialize)]
struct Asset {
    version: String,
}

fn parse(
    path: &Path,
    text: &[u8],
    place: impl Fn(&::gltf::json::Error) -> Place,
) -> Result<(Root, Vec<animation::Listed>), SceneError> {
    let wrong = |error: ::gltf::json::Error, place: Place| {
        // The message ends with the place, which is reported separately.
        let message = error.to_string();
        let problem = message.split(" at line ").next().unwrap_or_default();
        SceneError::new(path, place, format!("this is not valid glTF: {problem}"), "export the model again")
    };
    let invalid = |error| {
        let place = place(&error);
        wrong(error, place)
    };
    // The version goes first, for glTF 1 differs so much that its error would be about something else.
    let Outline { asset, animations } = deserialize::from_slice(text).map_err(invalid)?;
    let version = asset.map(|asset| asset.version);
    if !version.as_deref().is_some_and(|version| version == "2" || version.starts_with("2.")) {
        let problem = version.map_or_else(
            || "it has no glTF version".to_owned(),
            |version| format!("its version is {version:?}, which is not 2"),
        );
        return Err(SceneError::new(path, Place::Part("asset".to_owned()), problem, "export the model as glTF 2.0"));
    }
    let (animations, rest) =
        animation::cut(text, animations).map_err(|error| wrong(error, Place::Part("animations".to_owned())))?;
    Ok((deserialize::from_slice(&rest).map_err(invalid)?, animations))
}

fn read(
    files: &dyn Files,
    path: &Path,
    (root, animations): (Root, Vec<animation::Listed>),
    binary: Option<&[u8]>,
    options: &LoadOptions,
) -> Result<Scene, SceneError> {
    check_required(path, &root)?;
    let (mut warnings, mut notes) = (Vec::new(), Notes::default());
    let buffers = container::buffers(files, path, &root, binary)?;
    let decompressed = meshopt::decompress(path, &root, &buffers)?;
    let LoadOptions { without_pictures, point_radius, .. } = *options;
    let document = Document { files, path, root, animations, buffers, decompressed, without_pictures, point_radius };
    let (materials, textures) = material::read(&document, &mut notes)?;
    let mut scene = Scene { materials, textures, variants: variants::names(&document)?, ..Scene::default() };
    let mut skipped = Skipped::default();
    let mut cameras = Vec::new();
    let pose = pose(&document, options.moment.as_ref(), &mut scene, &mut notes)?;
    let nodes = hierarchy::walk(&document, &pose)?;
    let mut meshes = Meshes::new(&document, &pose, &nodes, options.sharing)?;
    for placed in &nodes {
        let node = &document.root.nodes[placed.node];
        let place = document.node(placed.node);
        let lights_before = scene.lights.len();
        if node.mesh.is_some() {
            meshes.read(placed, &mut scene, &mut skipped)?;
        }
        if let Some(index) = node.camera {
            let camera = document.object(index, "camera", &place)?;
            let names = [&node.name, &camera.name].map(|name| name.as_deref().unwrap_or_default());
            cameras.push((place.clone(), names, camera::read(&document, camera, index.value(), placed)?));
        }
        let lights = node.extensions.as_ref().and_then(|extensions| extensions.khr_lights_punctual.as_ref());
        if let Some(index) = lights.map(|lights| lights.light) {
            let light = document.object(index, "light", &place)?;
            skipped.ranges += usize::from(light.range.is_some());
            skipped.stretched_spots += usize::from(light::is_stretched_spot(light, placed));
            let name = node.name.as_ref().or(light.name.as_ref()).cloned().unwrap_or_default();
            let label = LightLabel { name, ..LightLabel::default() };
            scene.add_light(light::read(&document, light, index.value(), placed)?, label);
        }
        if let Some(light) = ies::read(&document, placed)? {
            let name = node.name.clone().unwrap_or_default();
            scene.add_light(light, LightLabel { name, ..LightLabel::default() });
        }
        if scene.lights[lights_before..].iter().any(|light| light.power().0 == glam::Vec3::ZERO) {
            notes.add(NO_STRENGTH, place);
        }
    }
    let chosen = match options.camera {
        Some(name) => Some(camera::choose(&document, name, cameras.iter().map(|(_, names, _)| *names))?),
        None => (!cameras.is_empty()).then_some(0),
    };
    if let Some((place, _, camera)) = chosen.map(|number| &cameras[number]) {
        (scene.camera, scene.camera_aspect) = (Some(camera.pose), camera.aspect);
        (scene.optics, scene.camera_clip) = (camera.optics.clone(), Some(camera.clip));
        if cameras.len() > 1 && options.camera.is_none() && !options.is_object {
            warnings.push(format!(
                "{}: of {} cameras, that of {place} is used; --model-camera NAME chooses another",
                path.display(),
                cameras.len()
            ));
        }
    }
    if !scene.lights.is_empty() {
        let units = light::units(&document);
        scene.set_light_units(units);
        if units == LightUnits::Photometric {
            warnings.push(format!(
                "{}: lights are taken as candela and lux, as Blender exports watts by default, and divided by 683 lm/W; if \
                 they were exported as unitless, give --light-units radiometric",
                path.display()
            ));
        }
    }
    if document.is_from_blender() {
        if scene.lights.is_empty() && cameras.is_empty() && !options.is_object {
            notes.add_unless_told(
                "the file has neither lights nor cameras; Blender exports them with Include > Punctual Lights and Cameras",
            );
        }
        for place in empty_nodes::find(&document) {
            notes.add(empty_nodes::NOTE, place);
        }
    }
    if scene.meshes.iter().any(|mesh| mesh.material == scene.materials.len()) {
        scene.materials.push(Material::default());
    }
    note_extensions(&document.root, &mut notes);
    warnings.extend(notes.warnings(path));
    warnings.extend(skipped.warnings(path));
    Ok(Scene { warnings, ..scene })
}

/// Said of lights that were turned off, maybe by a mistake, which would only be missed in the picture.
const NO_STRENGTH: &str = "lights with a strength of 0 emit nothing";

/// The pose at a moment, or of the nodes themselves; the scene receives the animations. Invalid ones are errors only if
/// they are played.
fn pose(
    document: &Document,
    moment: Option<&Moment>,
    scene: &mut Scene,
    notes: &mut Notes,
) -> Result<Pose, SceneError> {
    let animations = match (animation::read(document, notes), moment) {
        (Ok(animations), _) => animations,
        (Err(error), Some(_)) => return Err(error),
        (Err(SceneError { place, problem, .. }), None) => {
            let place = if let Place::Part(part) = place { part } else { String::new() };
            notes.add("animations that are not played are wrong", format!("{place}: {problem}"));
            Vec::new()
        }
    };
    scene.animations.extend(animations.iter().map(|animation| {
        let (begin, end) = animation.span();
        Animation { name: animation.name.clone(), begin, end }
    }));
    let Some(moment) = moment else { return Ok(Pose::default()) };
    let playing = animation::playing(document, &animations, &moment.animations, notes)?;
    Ok(Pose::at(&playing, moment.time))
}

#[cfg(test)]
pub(super) mod tests;
