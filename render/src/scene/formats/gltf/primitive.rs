//! Triangles of a mesh primitive, or spheres and cylinders for its points and lines, in the mesh's coordinates, or with
//! a skin in the world's.

use ::gltf::json::mesh::{Mode, Primitive, Semantic};
use ::gltf::json::validation::Checked;
use glam::{DAffine3, Mat3};

use super::attributes::{Attributes, Vertices};
use super::skin::Skin;
use super::{Document, Skipped, morph};
use crate::scene::meshes::round;
use crate::scene::{Mesh, SceneError};

/// The deformation of a node's mesh.
#[derive(Default)]
pub(super) struct Deformation {
    pub(super) skin: Option<Skin>,
    /// The weights of morph targets.
    pub(super) weights: Vec<f64>,
}

impl Deformation {
    /// The skin, if the vertices of `primitive` have joints.
    pub(super) fn skin_of(&self, primitive: &Primitive) -> Option<&Skin> {
        let is_skinned = primitive.attributes.contains_key(&Checked::Valid(Semantic::Joints(0)));
        self.skin.as_ref().filter(|_| is_skinned)
    }
}

/// The triangles of `primitive`, which `place` names in errors; `None` for points and lines if they have no radius. The
/// material is the number of materials for a primitive without one.
pub(super) fn read(
    document: &Document,
    primitive: &Primitive,
    place: &str,
    deformation: &Deformation,
    skipped: &mut Skipped,
) -> Result<Option<Mesh>, SceneError> {
    let Checked::Valid(mode) = primitive.mode else {
        return Err(document.error(place, "its mode is unknown", "use a mode from 0 to 6; 4 is triangles"));
    };
    let has_triangles = has_triangles(primitive);
    if !has_triangles && document.point_radius.is_none() {
        skipped.points_and_lines += 1;
        return Ok(None);
    }
    let attributes = Attributes::new(document, primitive, place)?;
    let positions = attributes.positions()?;
    let vertices = positions.len();
    let mut moved = Vertices { tangents: attributes.tangents(vertices)?, positions, normals: Vec::new() };
    let mut triangles = if has_triangles { attributes.triangles(mode, vertices)? } else { Vec::new() };

    let material = match primitive.material {
        Some(index) => {
            document.object(index, "material", place)?;
            index.value()
        }
        None => document.root.materials.len(),
    };
    moved.normals = attributes.normals(vertices)?;
    let (targets, weights) = (primitive.targets.as_deref().unwrap_or_default(), &deformation.weights);
    skipped.miscounted += usize::from(!weights.is_empty() && weights.len() != targets.len());
    morph::apply(&attributes, targets, weights, &mut moved)?;
    if let Some(skin) = deformation.skin_of(primitive) {
        skipped.weightless += skin.apply(&attributes, &mut moved)?;
        if skin.is_mirrored() {
            triangles.iter_mut().for_each(|corners| corners.swap(1, 2));
        }
    } else {
        skipped.skinless += usize::from(deformation.skin.is_some());
    }
    let Vertices { positions, normals, tangents } = moved;
    let corners = |corners: &[u32; 3]| corners.map(|index| tangents[index as usize]);
    let tangents = if tangents.is_empty() { Vec::new() } else { triangles.iter().map(corners).collect() };
    let mesh = Mesh {
        name: String::new(),
        normals,
        texcoords: attributes.texcoords(0, vertices)?,
        lightmap_texcoords: attributes.texcoords(1, vertices)?,
        colors: attributes.colors(vertices)?,
        positions,
        tangents,
        map_space: document.is_from_blender().then_some(Mat3::IDENTITY),
        triangles,
        material,
        ..Mesh::default()
    };
    Ok(Some(match document.point_radius {
        Some(radius) if !has_triangles => solid(mesh, mode, &attributes.indices(vertices)?, radius),
        _ => mesh,
    }))
}

/// Whether the primitive has triangles of its own.
pub(super) fn has_triangles(primitive: &Primitive) -> bool {
    matches!(primitive.mode, Checked::Valid(Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan))
}

/// The mesh with balls or tubes for its points or lines (glTF 2.0, section 3.7.2.1).
fn solid(mesh: Mesh, mode: Mode, indices: &[u32], radius: f32) -> Mesh {
    let pairs = indices.windows(2).map(|pair| [pair[0], pair[1]]);
    let lines: Vec<[u32; 2]> = match mode {
        Mode::Lines => indices.as_chunks().0.to_vec(),
        Mode::LineLoop => pairs.chain(indices.last().map(|&last| [last, indices[0]])).collect(),
        Mode::LineStrip => pairs.collect(),
        _ => return round::balls(mesh, indices, radius),
    };
    round::tubes(mesh, &lines, radius)
}

/// The mesh where a node shows it; an error if the transform takes it out of the range of numbers.
pub(super) fn place(
    document: &Document,
    mesh: Mesh,
    place: &str,
    node: usize,
    to_world: &DAffine3,
) -> Result<Mesh, SceneError> {
    let mesh = mesh.placed(to_world);
    if !mesh.positions.iter().all(|position| position.is_finite()) {
        let problem = format!("its transform takes {place} out of the range of numbers");
        return Err(document.error(document.node(node), problem, "use smaller numbers"));
    }
    Ok(mesh)
}
