//! glTF 2.0 (Khronos Group), as JSON text or in a binary container (GLB).
//!
//! The crate `gltf` gives the JSON its types. Its readers are not used, since they panic on indices and ranges that a
//! malformed file may have: here every index is looked up and every range checked.
//!
//! Read are the default scene (all root nodes if there is none), its nodes' transforms, triangles with normals and the
//! first two sets of texture coordinates, colours and tangents, materials (`material.rs`) with their textures
//! (`texture.rs`), cameras and `KHR_lights_punctual`. Every primitive of every node becomes a mesh in world space,
//! named like its node.
//!
//! Deviations: a primitive without a material gets the grey default, where the specification has white. Emission is
//! radiance, a light's candela are W/sr and its lux W/m², one to one. Skins, morph targets, lights' ranges,
//! points and lines are left out with a warning, animations without one.

pub(crate) mod accessor;
mod attributes;
mod camera;
pub(crate) mod container;
mod draco;
mod extensions;
mod hierarchy;
mod ies;
mod light;
mod material;
mod meshopt;
mod notes;
mod primitive;
mod texture;
mod variants;

use std::collections::BTreeMap;
use std::path::Path;

use ::gltf::json::{Index, Root, deserialize, root::Get};
use serde::Deserialize;

use super::error::count;
use super::{Disk, Files, LightUnits, Material, Place, Scene, SceneError};
use notes::Notes;

/// Reads glTF as JSON text.
pub(crate) fn read_json(files: &dyn Files, path: &Path, text: &[u8]) -> Result<Scene, SceneError> {
    let root = parse(path, text, |error| Place::Line(error.line()))?;
    read(files, path, root, None)
}

/// Reads a GLB container.
pub(crate) fn read_binary(files: &dyn Files, path: &Path, bytes: &[u8]) -> Result<Scene, SceneError> {
    let chunks = container::split(path, bytes)?;
    let root = parse(path, chunks.json, |error| {
        Place::Part(format!("JSON chunk, line {}, column {}", error.line(), error.column()))
    })?;
    read(files, path, root, chunks.binary)
}

/// A glTF file with its buffers.
pub(crate) struct Document<'a> {
    files: &'a dyn Files,
    path: &'a Path,
    pub(crate) root: Root,
    buffers: Vec<Vec<u8>>,
    /// What compressed buffer views hold, by their numbers.
    decompressed: BTreeMap<usize, Vec<u8>>,
}

/// Takes a file apart that may be JSON text or a GLB container, for those who do not want a scene of it.
pub(crate) fn open<'a>(path: &'a Path, bytes: &'a [u8]) -> Result<(Document<'a>, container::Chunks<'a>), SceneError> {
    let chunks = match bytes.starts_with(b"glTF") {
        true => container::split(path, bytes)?,
        false => container::Chunks { json: bytes, binary: None, others: Vec::new() },
    };
    let root = parse(path, chunks.json, |error| Place::Line(error.line()))?;
    let used = root.extensions_used.iter().find(|name| COMPRESSED.contains(&name.as_str()));
    if let Some(name) = used {
        let problem = format!("the file uses {name}, and cannot be changed");
        let place = Place::Part("extensionsUsed".to_owned());
        return Err(SceneError::new(path, place, problem, "export the model without compression"));
    }
    let buffers = container::buffers(&Disk, path, &root, chunks.binary)?;
    Ok((Document { files: &Disk, path, root, buffers, decompressed: BTreeMap::new() }, chunks))
}

/// What was left out, for the warnings.
#[derive(Default)]
struct Skipped {
    points_and_lines: usize,
    skinned: usize,
    morphed: usize,
    ranges: usize,
}

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

    /// For errors: "node 5" or "node 5 (\"lamp\")".
    pub(crate) fn node(&self, index: usize) -> String {
        let name = self.root.nodes.get(index).and_then(|node| node.name.as_deref());
        name.map_or_else(|| format!("node {index}"), |name| format!("node {index} ({name:?})"))
    }
}

/// The part of glTF that all its versions have.
#[derive(Deserialize)]
struct Version {
    asset: Option<Asset>,
}

#[derive(Deserialize)]
struct Asset {
    version: String,
}

fn parse(path: &Path, text: &[u8], place: impl Fn(&::gltf::json::Error) -> Place) -> Result<Root, SceneError> {
    let invalid = |error: ::gltf::json::Error| {
        // The message ends with the place, which is told on its own.
        let message = error.to_string();
        let problem = message.split(" at line ").next().unwrap_or_default();
        SceneError::new(path, place(&error), format!("this is not valid glTF: {problem}"), "export the model again")
    };
    // The version goes first, for glTF 1 differs so much that its error would be about something else.
    let Version { asset } = deserialize::from_slice(text).map_err(invalid)?;
    let version = asset.map(|asset| asset.version);
    if !version.as_deref().is_some_and(|version| version == "2" || version.starts_with("2.")) {
        let problem = version.map_or_else(
            || "it tells no glTF version".to_owned(),
            |version| format!("its version is {version:?}, which is not 2"),
        );
        return Err(SceneError::new(path, Place::Part("asset".to_owned()), problem, "export the model as glTF 2.0"));
    }
    deserialize::from_slice(text).map_err(invalid)
}

fn read(files: &dyn Files, path: &Path, root: Root, binary: Option<&[u8]>) -> Result<Scene, SceneError> {
    check_required(path, &root)?;
    let (mut warnings, mut notes) = (Vec::new(), Notes::default());
    let buffers = container::buffers(files, path, &root, binary)?;
    let decompressed = meshopt::decompress(path, &root, &buffers)?;
    let document = Document { files, path, root, buffers, decompressed };
    let (materials, textures) = material::read(&document, &mut notes)?;
    let mut scene = Scene { materials, textures, variants: variants::names(&document)?, ..Scene::default() };
    let mut skipped = Skipped::default();
    let mut cameras = Vec::new();
    for placed in hierarchy::walk(&document)? {
        let node = &document.root.nodes[placed.node];
        let place = document.node(placed.node);
        if let Some(index) = node.mesh {
            let mesh = document.object(index, "mesh", &place)?;
            let name = node.name.as_ref().or(mesh.name.as_ref()).cloned().unwrap_or_default();
            skipped.skinned += usize::from(node.skin.is_some());
            let mirrored = placed.linear().determinant() < 0.0;
            for (number, primitive) in mesh.primitives.iter().enumerate() {
                let place = format!("mesh {}, primitive {number}", index.value());
                if let Some(read) = primitive::read(&document, primitive, &place, &placed, &mut skipped)? {
                    variants::add(&document, primitive, &place, scene.meshes.len(), &mut scene.variants)?;
                    let origin = super::Origin { node: placed.node, mesh: index.value(), primitive: number, mirrored };
                    scene.meshes.push(super::Mesh { name: name.clone(), origin: Some(origin), ..read });
                }
            }
        }
        if let Some(index) = node.camera {
            let camera = document.object(index, "camera", &place)?;
            cameras.push((place.clone(), camera::read(&document, camera, index.value(), &placed)?));
        }
        let lights = node.extensions.as_ref().and_then(|extensions| extensions.khr_lights_punctual.as_ref());
        if let Some(index) = lights.map(|lights| lights.light) {
            let light = document.object(index, "light", &place)?;
            skipped.ranges += usize::from(light.range.is_some());
            scene.lights.push(light::read(&document, light, index.value(), &placed)?);
        }
        scene.lights.extend(ies::read(&document, &placed)?);
    }
    if let Some((place, camera)) = cameras.first() {
        (scene.camera, scene.camera_aspect) = (Some(camera.pose), camera.aspect);
        (scene.optics, scene.camera_clip) = (camera.optics.clone(), Some(camera.clip));
        if cameras.len() > 1 {
            warnings.push(format!("{}: of {} cameras, that of {place} is used", path.display(), cameras.len()));
        }
    }
    if !scene.lights.is_empty() {
        let units = LightUnits::guess(&scene.lights, document.is_from_blender());
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
        if scene.lights.is_empty() && cameras.is_empty() {
            notes.add_unless_told(
                "the file has neither lights nor cameras; Blender exports them with Include > Punctual Lights and Cameras",
            );
        }
        for place in empty_nodes(&document) {
            notes.add("empty nodes; Blender leaves one of each area light, which glTF does not have", place);
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

/// What is read, or is here for programs that edit the file.
const KNOWN: [&str; 24] = [
    "EXT_lights_ies",
    "EXT_meshopt_compression",
    "EXT_texture_webp",
    "KHR_draco_mesh_compression",
    "KHR_lights_punctual",
    "KHR_materials_anisotropy",
    "KHR_materials_clearcoat",
    "KHR_materials_diffuse_transmission",
    "KHR_materials_dispersion",
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
    "KHR_materials_iridescence",
    "KHR_materials_pbrSpecularGlossiness",
    "KHR_materials_sheen",
    "KHR_materials_specular",
    "KHR_materials_transmission",
    "KHR_materials_unlit",
    "KHR_materials_variants",
    "KHR_materials_volume",
    "KHR_mesh_quantization",
    "KHR_texture_basisu",
    "KHR_texture_transform",
    "KHR_xmp",
    "KHR_xmp_json_ld",
];

/// Those whose geometry is not where accessors say: files with them are read, but not edited.
const COMPRESSED: [&str; 2] = ["EXT_meshopt_compression", "KHR_draco_mesh_compression"];

/// Refuses extensions that the file requires and that would change its shape; those about surfaces are left to the
/// notes.
fn check_required(path: &Path, root: &Root) -> Result<(), SceneError> {
    const HARMLESS: [&str; 3] = ["KHR_materials_", "KHR_texture_", "EXT_texture_"];
    let is_known = |name: &&str| KNOWN.contains(name) || HARMLESS.iter().any(|prefix| name.starts_with(prefix));
    let required = root.extensions_required.iter().map(String::as_str);
    let refused: Vec<&str> = required.filter(|name| !is_known(name)).collect();
    if refused.is_empty() {
        return Ok(());
    }
    let (names, remedy) = (refused.join(", "), "export the model without these extensions");
    let problem = format!("the file requires {names}, which cannot be read");
    Err(SceneError::new(path, Place::Part("extensionsRequired".to_owned()), problem, remedy))
}

/// Notes the extensions that the file uses and that are not read.
fn note_extensions(root: &Root, notes: &mut Notes) {
    for name in root.extensions_used.iter().chain(&root.extensions_required) {
        if !KNOWN.contains(&name.as_str()) {
            notes.add_unless_told(&format!("{name} is not read"));
        }
    }
}

/// Nodes that show nothing, hold nothing and move nothing.
fn empty_nodes(document: &Document) -> Vec<String> {
    let nodes = &document.root.nodes;
    let joints = document.root.skins.iter().flat_map(|skin| &skin.joints).map(|joint| joint.value());
    let joints: std::collections::BTreeSet<usize> = joints.collect();
    let is_empty = |&index: &usize| {
        let node = &nodes[index];
        let light = node.extensions.as_ref().is_some_and(|extensions| {
            extensions.khr_lights_punctual.is_some() || extensions.others.contains_key("EXT_lights_ies")
        });
        let has_children = node.children.as_ref().is_some_and(|children| !children.is_empty());
        node.mesh.is_none() && node.camera.is_none() && !light && !has_children && !joints.contains(&index)
    };
    (0..nodes.len()).filter(is_empty).map(|index| document.node(index)).collect()
}

impl Skipped {
    fn warnings(&self, path: &Path) -> Vec<String> {
        let counts = [
            (self.points_and_lines, "primitive of points or lines is", "primitives of points or lines are", "skipped"),
            (self.skinned, "mesh is", "meshes are", "shown without the skin"),
            (self.morphed, "primitive is", "primitives are", "shown without the morph targets"),
            (self.ranges, "light has", "lights have", "a range, which is ignored"),
        ];
        let counts = counts.iter().filter(|(number, ..)| *number > 0);
        counts
            .map(|&(number, one, many, what)| format!("{}: {} {what}", path.display(), count(number, one, many)))
            .collect()
    }
}

#[cfg(test)]
pub(super) mod tests;
