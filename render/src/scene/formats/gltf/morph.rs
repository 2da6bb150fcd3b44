//! Morph targets (glTF 2.0, section 3.7.2.2): `v + Σ wᵢ Δᵢ` for positions, normals and tangents, of which normals and
//! tangents are unit vectors again afterwards. Deltas of colours and texture coordinates are not read.

use ::gltf::json::mesh::MorphTarget;
use glam::Vec3;

use super::attributes::{Attributes, Vertices};
use crate::scene::SceneError;

/// Moves vertices towards `targets`. Weights that are missing are 0.
pub(super) fn apply(
    attributes: &Attributes,
    targets: &[MorphTarget],
    weights: &[f64],
    vertices: &mut Vertices,
) -> Result<(), SceneError> {
    let count = vertices.positions.len();
    let sums = |known: usize, of: fn(&MorphTarget) -> Option<_>, name: &str| {
        let mut sums = None;
        for (number, (target, &weight)) in targets.iter().zip(weights).enumerate() {
            let Some(index) = of(target).filter(|_| weight != 0.0 && known > 0) else { continue };
            let deltas = attributes.deltas(index, &format!("target {number}, {name}"), count)?;
            let sums = sums.get_or_insert_with(|| vec![glam::DVec3::ZERO; count]);
            sums.iter_mut().zip(deltas).for_each(|(sum, delta)| *sum += delta.as_dvec3() * weight);
        }
        Ok::<_, SceneError>(sums)
    };
    let moved = |from: Vec3, by: &glam::DVec3| (from.as_dvec3() + by).as_vec3();
    if let Some(sums) = sums(count, |target| target.positions, "POSITION")? {
        vertices.positions.iter_mut().zip(&sums).for_each(|(position, by)| *position = moved(*position, by));
    }
    if let Some(sums) = sums(vertices.normals.len(), |target| target.normals, "NORMAL")? {
        vertices.normals.iter_mut().zip(&sums).for_each(|(normal, by)| *normal = moved(*normal, by));
    }
    if let Some(sums) = sums(vertices.tangents.len(), |target| target.tangents, "TANGENT")? {
        vertices.tangents.iter_mut().zip(&sums).for_each(|(tangent, by)| {
            let along = crate::scene::description::unit(moved(tangent.truncate(), by)).unwrap_or_default();
            *tangent = along.extend(tangent.w);
        });
    }
    Ok(())
}
