//! Decides which meshes are shared, and reads `EXT_mesh_gpu_instancing`: a node's mesh at many places.
//!
//! The extension's attributes are accessors of one length: `TRANSLATION`, `ROTATION` (a quaternion) and `SCALE`. Each
//! instance is at `node × translation × rotation × scale`. Other attributes are not read.

use ::gltf::json::Index;
use ::gltf::json::accessor::ComponentType::{F32, I8, I16};
use ::gltf::json::mesh::{Mode, Primitive};
use ::gltf::json::scene::Node;
use ::gltf::json::validation::Checked;
use glam::{DAffine3, DQuat, DVec3};
use serde::Deserialize;

use super::hierarchy::Placed;
use super::{Document, accessor};
use crate::scene::{SceneError, Sharing, count};

pub(super) const NAME: &str = "EXT_mesh_gpu_instancing";

#[derive(Deserialize)]
struct Extension {
    attributes: Attributes,
}

#[derive(Deserialize)]
#[serde(rename_all = "UPPERCASE")]
struct Attributes {
    translation: Option<usize>,
    rotation: Option<usize>,
    scale: Option<usize>,
}

/// The instances of a node's mesh.
pub(super) fn places(document: &Document, placed: &Placed) -> Result<Vec<DAffine3>, SceneError> {
    let Some(Attributes { translation, rotation, scale }) = attributes(document, placed.node)? else {
        return Ok(vec![placed.to_world()]);
    };
    let place = document.node(placed.node);
    let vectors = |accessor: Option<usize>, name: &str| -> Result<Option<Vec<[f64; 3]>>, SceneError> {
        let read = |index| accessor::read::<3>(document, Index::new(index as u32), &place, name, &[F32]);
        Ok(accessor.map(read).transpose()?.map(|all| all.into_iter().map(|it| it.map(|it| it.raw().into())).collect()))
    };
    let (translations, scales) = (vectors(translation, "TRANSLATION")?, vectors(scale, "SCALE")?);
    let rotations = match rotation {
        Some(index) => {
            let kinds = [F32, I8, I16];
            let all = accessor::read::<4>(document, Index::new(index as u32), &place, "ROTATION", &kinds)?;
            Some(all.into_iter().map(|it| it.map(|it| f64::from(it.normalised()))).collect::<Vec<_>>())
        }
        None => None,
    };
    let counts = [translations.as_ref().map(Vec::len), rotations.as_ref().map(Vec::len), scales.as_ref().map(Vec::len)];
    let mut counts = counts.into_iter().flatten();
    let Some(number) = counts.next() else {
        let problem = format!("its {NAME} has no attributes");
        return Err(document.error(place, problem, "give it TRANSLATION, ROTATION or SCALE"));
    };
    if let Some(other) = counts.find(|&other| other != number) {
        let problem =
            format!("its {NAME} has {} of one attribute and {other} of another", count(number, "value", "values"));
        return Err(document.error(place, problem, "give every instance all attributes"));
    }
    let instance = |number: usize| {
        let translation = translations.as_ref().map_or(DVec3::ZERO, |all| all[number].into());
        let scale = scales.as_ref().map_or(DVec3::ONE, |all| all[number].into());
        let rotation = rotations.as_ref().map_or(DQuat::IDENTITY, |all| DQuat::from_array(all[number]));
        let local = DAffine3::from_scale_rotation_translation(scale, rotation.normalize(), translation);
        let to_world = placed.to_world() * local;
        if to_world.is_finite() && to_world.to_cols_array().iter().all(|&it| (it as f32).is_finite()) {
            return Ok(to_world);
        }
        let problem = format!("instance {number} of its {NAME} has no finite transform");
        Err(document.error(place.clone(), problem, "use finite numbers, and rotations that are not zero"))
    };
    (0..number).map(instance).collect()
}

/// How often a node shows its mesh.
fn uses(document: &Document, node: usize) -> Result<usize, SceneError> {
    let Some(Attributes { translation, rotation, scale }) = attributes(document, node)? else { return Ok(1) };
    let first = [translation, rotation, scale].into_iter().flatten().next();
    Ok(first.and_then(|index| document.root.accessors.get(index)).map_or(1, |accessor| accessor.count.0 as usize))
}

fn attributes(document: &Document, node: usize) -> Result<Option<Attributes>, SceneError> {
    let extensions = document.root.nodes[node].extensions.as_ref();
    let Some(value) = extensions.and_then(|extensions| extensions.others.get(NAME)) else { return Ok(None) };
    let extension = Extension::deserialize(value).map_err(|error| {
        let remedy = format!("write it as the specification of {NAME} has it");
        document.error(document.node(node), format!("its {NAME} is wrong: {error}"), remedy)
    })?;
    Ok(Some(extension.attributes))
}

/// Whether each mesh is shared.
pub(super) fn shared(document: &Document, walk: &[Placed], sharing: Sharing) -> Result<Vec<bool>, SceneError> {
    let root = &document.root;
    let mut meshes: Vec<(usize, usize)> = root.meshes.iter().map(|_| (0, 0)).collect();
    for placed in walk {
        let node = &root.nodes[placed.node];
        let Some(index) = node.mesh.filter(|_| !deforms(document, node)) else { continue };
        let mesh = document.object(index, "mesh", &document.node(placed.node))?;
        let (triangles, times) = &mut meshes[index.value()];
        *triangles = mesh.primitives.iter().map(|primitive| triangle_count(document, primitive)).sum();
        *times += uses(document, placed.node)?;
    }
    Ok(sharing.shared(&meshes))
}

/// Whether a node's mesh has a shape that others with the same mesh may not have.
pub(super) fn deforms(document: &Document, node: &Node) -> bool {
    let mesh = node.mesh.and_then(|mesh| document.root.meshes.get(mesh.value()));
    let has_targets = |primitive: &Primitive| primitive.targets.as_ref().is_some_and(|targets| !targets.is_empty());
    node.skin.is_some() || mesh.is_some_and(|mesh| mesh.primitives.iter().any(has_targets))
}

/// The number of a primitive's triangles, as its accessors have it.
fn triangle_count(document: &Document, primitive: &Primitive) -> usize {
    use ::gltf::json::mesh::Semantic;
    let position = primitive.attributes.get(&Checked::Valid(Semantic::Positions)).copied();
    let accessor = primitive.indices.or(position).and_then(|index| document.root.accessors.get(index.value()));
    let corners = accessor.map_or(0, |accessor| accessor.count.0 as usize);
    match primitive.mode {
        Checked::Valid(Mode::Triangles) => corners / 3,
        Checked::Valid(Mode::TriangleStrip | Mode::TriangleFan) => corners.saturating_sub(2),
        _ => 0,
    }
}
