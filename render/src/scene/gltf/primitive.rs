//! Triangles of a mesh primitive, taken to the world.
//!
//! Normals go by the inverse transpose. It is the matrix of cofactors over the determinant, and as normals become unit
//! vectors the determinant's sign suffices: M⁻ᵀ n ∥ sign(det M) cof(M) n. So a node that flattens has normals, too.

use ::gltf::json::accessor::ComponentType::{F32, U8, U16, U32};
use ::gltf::json::accessor::Type;
use ::gltf::json::mesh::{Mode, Primitive, Semantic};
use ::gltf::json::validation::Checked;
use glam::{DMat3, Vec2, Vec3, Vec4};

use super::hierarchy::Placed;
use super::{Document, Skipped, accessor};
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
    let attribute = |semantic| primitive.attributes.get(&Checked::Valid(semantic)).copied();

    let positions = attribute(Semantic::Positions)
        .ok_or_else(|| document.error(place, "it has no POSITION", "give it the attribute POSITION"))?;
    let positions: Vec<Vec3> = vectors(document, positions, place, "POSITION")?;
    if let Some(vertex) = positions.iter().position(|position| !position.is_finite()) {
        return Err(document.error(
            place,
            format!("the POSITION of vertex {vertex} is not finite"),
            "export the model again",
        ));
    }
    let normals = attribute(Semantic::Normals).map(|index| vectors(document, index, place, "NORMAL")).transpose()?;
    let coordinates = |set: u32| {
        let Some(index) = attribute(Semantic::TexCoords(set)) else { return Ok(None) };
        let name = format!("TEXCOORD_{set}");
        let pairs = accessor::read::<2>(document, index, place, &name, &[F32, U8, U16])?;
        let pairs = pairs.into_iter().map(|pair| Vec2::from(pair.map(accessor::Component::normalised)));
        Ok(Some(pairs.collect::<Vec<Vec2>>()))
    };
    let (texcoords, lightmap_texcoords) = (coordinates(0)?, coordinates(1)?);
    check_counts(document, place, positions.len(), normals.as_ref().map(Vec::len), texcoords.as_ref().map(Vec::len))?;
    check_counts(document, place, positions.len(), None, lightmap_texcoords.as_ref().map(Vec::len))?;
    let colors = attribute(Semantic::Colors(0)).map(|index| colors(document, index, place)).transpose()?;
    check_count(document, place, positions.len(), "colour", "colours", colors.as_ref().map(Vec::len))?;
    let tangents = attribute(Semantic::Tangents).map(|index| tangents(document, index, place)).transpose()?;
    check_count(document, place, positions.len(), "tangent", "tangents", tangents.as_ref().map(Vec::len))?;
    let indices = match primitive.indices {
        Some(index) => {
            let indices = accessor::read::<1>(document, index, place, "indices", &[U8, U16, U32])?;
            let indices: Vec<u32> = indices.into_iter().map(|[index]| index.index()).collect();
            if let Some(wrong) = indices.iter().find(|&&index| index as usize >= positions.len()) {
                let vertices = count(positions.len(), "vertex", "vertices");
                let problem = format!("it holds the index {wrong}, but {place} has {vertices}");
                return Err(document.error(
                    format!("accessor {}", index.value()),
                    problem,
                    "keep indices below that number",
                ));
            }
            indices
        }
        None => (0..positions.len() as u32).collect(),
    };
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
    let corners =
        |corners: &[u32; 3]| corners.map(|index| tangents.as_ref().map_or(Vec4::ZERO, |it| it[index as usize]));
    let tangents = if tangents.is_some() { triangles.iter().map(corners).collect() } else { Vec::new() };
    let mesh = Mesh {
        name: String::new(),
        positions,
        normals: normals.unwrap_or_default(),
        texcoords: texcoords.unwrap_or_default(),
        lightmap_texcoords: lightmap_texcoords.unwrap_or_default(),
        colors: colors.unwrap_or_default(),
        tangents,
        triangles,
        material,
        ..Mesh::default()
    };
    to_world(document, mesh, place, placed).map(Some)
}

fn vectors(
    document: &Document,
    index: ::gltf::json::Index<::gltf::json::Accessor>,
    place: &str,
    what: &str,
) -> Result<Vec<Vec3>, SceneError> {
    let vectors = accessor::read::<3>(document, index, place, what, &[F32])?;
    Ok(vectors.into_iter().map(|vector| Vec3::from(vector.map(accessor::Component::normalised))).collect())
}

fn check_counts(
    document: &Document,
    place: &str,
    positions: usize,
    normals: Option<usize>,
    texcoords: Option<usize>,
) -> Result<(), SceneError> {
    check_count(document, place, positions, "normal", "normals", normals)?;
    check_count(document, place, positions, "texture coordinate", "texture coordinates", texcoords)
}

fn check_count(
    document: &Document,
    place: &str,
    positions: usize,
    one: &str,
    many: &str,
    found: Option<usize>,
) -> Result<(), SceneError> {
    let Some(found) = found.filter(|&found| found != positions) else { return Ok(()) };
    let positions = count(positions, "position", "positions");
    let problem = format!("it has {positions} but {}", count(found, one, many));
    Err(document.error(place, problem, "give every vertex all attributes"))
}

/// Colours of three or four numbers, linear; what is no number is white.
fn colors(
    document: &Document,
    index: ::gltf::json::Index<::gltf::json::Accessor>,
    place: &str,
) -> Result<Vec<Vec4>, SceneError> {
    let kinds = [F32, U8, U16];
    let colors: Vec<Vec4> = if document.object(index, "accessor", place)?.type_ == Checked::Valid(Type::Vec4) {
        let colors = accessor::read::<4>(document, index, place, "COLOR_0", &kinds)?;
        colors.into_iter().map(|color| Vec4::from(color.map(accessor::Component::normalised))).collect()
    } else {
        let colors = accessor::read::<3>(document, index, place, "COLOR_0", &kinds)?;
        colors.into_iter().map(|color| Vec3::from(color.map(accessor::Component::normalised)).extend(1.0)).collect()
    };
    let usable = |color: Vec4| if color.is_finite() { color.clamp(Vec4::ZERO, Vec4::ONE) } else { Vec4::ONE };
    Ok(colors.into_iter().map(usable).collect())
}

/// Tangents, of which those without a direction are zero.
fn tangents(
    document: &Document,
    index: ::gltf::json::Index<::gltf::json::Accessor>,
    place: &str,
) -> Result<Vec<Vec4>, SceneError> {
    let tangents = accessor::read::<4>(document, index, place, "TANGENT", &[F32])?;
    let tangents = tangents.into_iter().map(|tangent| Vec4::from(tangent.map(accessor::Component::normalised)));
    Ok(tangents.map(|it| unit(it.truncate()).map_or(Vec4::ZERO, |along| along.extend(it.w))).collect())
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
