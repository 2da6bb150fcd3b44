//! Triangles of a mesh primitive, taken to the world.
//!
//! Normals go by the inverse transpose. It is the matrix of cofactors over the determinant, and as normals become unit
//! vectors the determinant's sign suffices: M⁻ᵀ n ∥ sign(det M) cof(M) n. So a node that flattens has normals, too.

use ::gltf::json::mesh::{Mode, Primitive};
use ::gltf::json::validation::Checked;
use glam::{DMat3, Vec3};

use super::attributes::Attributes;
use super::hierarchy::Placed;
use super::{Document, Skipped};
use crate::scene::count;
use crate::scene::description::unit;
use crate::scene::{Mesh, SceneError};

/// The triangles of `primitive`, which `place` names in errors; `None` for points and lines. The material is the number
/// of materials for a primitive without one.
pub(super) fn read(
    document: &Document,
    primitive: &Primitive,
    place: &str,
    placed: &Placed,
    skipped: &mut Skipped,
) -> Result<Option<Mesh>, SceneError> {
    let Checked::Valid(mode) = primitive.mode else {
        return Err(document.error(place, "its mode is unknown", "use a mode from 0 to 6; 4 is triangles"));
    };
    if !matches!(mode, Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan) {
        skipped.points_and_lines += 1;
        return Ok(None);
    }
    skipped.morphed += usize::from(primitive.targets.as_ref().is_some_and(|targets| !targets.is_empty()));
    let attributes = Attributes::new(document, primitive, place)?;
    let positions = attributes.positions()?;
    let vertices = positions.len();
    let tangents = attributes.tangents(vertices)?;
    let indices = attributes.indices(vertices)?;
    if mode == Mode::Triangles && indices.len() % 3 != 0 {
        let corners = count(indices.len(), "corner", "corners");
        return Err(document.error(place, format!("its triangles have {corners} together"), "give each triangle 3"));
    }

    let material = match primitive.material {
        Some(index) => {
            document.object(index, "material", place)?;
            index.value()
        }
        None => document.root.materials.len(),
    };
    let triangles = triangles(mode, &indices);
    let corners = |corners: &[u32; 3]| corners.map(|index| tangents[index as usize]);
    let tangents = if tangents.is_empty() { Vec::new() } else { triangles.iter().map(corners).collect() };
    let mesh = Mesh {
        name: String::new(),
        normals: attributes.normals(vertices)?,
        texcoords: attributes.texcoords(0, vertices)?,
        lightmap_texcoords: attributes.texcoords(1, vertices)?,
        colors: attributes.colors(vertices)?,
        positions,
        tangents,
        triangles,
        material,
        ..Mesh::default()
    };
    to_world(document, mesh, place, placed).map(Some)
}

/// Corners of triangles, strips and fans in the order that keeps the winding (glTF 2.0, section 3.7.2.1).
pub(super) fn triangles(mode: Mode, indices: &[u32]) -> Vec<[u32; 3]> {
    match mode {
        Mode::TriangleStrip => {
            let windows = indices.windows(3).enumerate();
            windows.map(|(place, v)| if place % 2 == 0 { [v[0], v[1], v[2]] } else { [v[0], v[2], v[1]] }).collect()
        }
        Mode::TriangleFan => indices.windows(2).skip(1).map(|v| [v[0], v[1], indices[0]]).collect(),
        _ => indices.chunks_exact(3).map(|v| [v[0], v[1], v[2]]).collect(),
    }
}

fn to_world(document: &Document, mut mesh: Mesh, place: &str, placed: &Placed) -> Result<Mesh, SceneError> {
    for position in &mut mesh.positions {
        *position = placed.to_world.transform_point3(position.as_dvec3()).as_vec3();
        if !position.is_finite() {
            let problem = format!("its transform takes {place} out of the range of numbers");
            return Err(document.error(document.node(placed.node), problem, "use smaller numbers"));
        }
    }
    let linear = placed.linear();
    let mirrors = linear.determinant() < 0.0;
    if mirrors {
        mesh.triangles.iter_mut().for_each(|corners| corners.swap(1, 2));
    }
    let DMat3 { x_axis: x, y_axis: y, z_axis: z } = linear;
    let cofactors = DMat3::from_cols(y.cross(z), z.cross(x), x.cross(y)) * if mirrors { -1.0 } else { 1.0 };
    let sign = if mirrors { -1.0 } else { 1.0 };
    for corners in &mut mesh.tangents {
        if mirrors {
            corners.swap(1, 2);
        }
        for tangent in corners {
            let along = (linear * tangent.truncate().as_dvec3()).normalize_or_zero().as_vec3();
            *tangent = along.extend(tangent.w * sign);
        }
    }
    // Normals without a direction leave the mesh flat.
    let normals: Option<Vec<Vec3>> = mesh.normals.iter().map(|normal| direction(cofactors, *normal)).collect();
    mesh.normals = normals.unwrap_or_default();
    Ok(mesh)
}

fn direction(cofactors: DMat3, normal: Vec3) -> Option<Vec3> {
    (cofactors * unit(normal)?.as_dvec3()).try_normalize().map(|normal| normal.as_vec3())
}
