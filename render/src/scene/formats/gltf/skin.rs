//! Skins (glTF 2.0, section 3.7.3.3): each vertex is transformed to the world by a mean of matrices `Mⱼ = Wⱼ Bⱼ`, joint
//! `j`'s transform to the world and its inverse bind matrix, weighted by the vertex's `WEIGHTS_n`. The transform of the
//! mesh's own node does not count. Normals are transformed by the mean's cofactors, as in `Mesh::placed`.
//!
//! Weights are divided by their sum. A vertex whose weights are all zero is bound to its first joint.

use std::collections::BTreeMap;

use ::gltf::json::Index;
use ::gltf::json::accessor::ComponentType::F32;
use ::gltf::json::skin::Skin as Listed;
use glam::{DMat3, DMat4, DVec4};

use super::attributes::{Attributes, Vertices};
use super::hierarchy::Placed;
use super::{Document, accessor};
use crate::scene::SceneError;
use crate::scene::count;

/// A skin in a pose.
pub(super) struct Skin {
    /// The matrix from the mesh to the world of each joint.
    joints: Vec<DMat4>,
}

/// The skin with number `index`, which `place` uses, among the nodes of the scene.
pub(super) fn read(
    document: &Document,
    index: Index<Listed>,
    place: &str,
    nodes: &BTreeMap<usize, &Placed>,
) -> Result<Skin, SceneError> {
    let skin = document.object(index, "skin", place)?;
    let place = match &skin.name {
        Some(name) => format!("skin {} ({name:?})", index.value()),
        None => format!("skin {}", index.value()),
    };
    let binds = match skin.inverse_bind_matrices {
        Some(binds) => matrices(document, binds, &place)?,
        None => vec![DMat4::IDENTITY; skin.joints.len()],
    };
    if binds.len() < skin.joints.len() {
        let (joints, binds) = (count(skin.joints.len(), "joint", "joints"), binds.len());
        let problem = format!("it has {joints} but {binds} inverse bind matrices");
        return Err(document.error(place, problem, "give each joint a matrix, or none to all"));
    }
    let mut joints = Vec::new();
    for (&joint, bind) in skin.joints.iter().zip(binds) {
        document.object(joint, "node", &place)?;
        let Some(placed) = nodes.get(&joint.value()) else {
            let problem = format!("its joint {} is not in the scene", document.node(joint.value()));
            return Err(document.error(place, problem, "put the joints into the scene of the mesh"));
        };
        joints.push(placed.to_world * bind);
    }
    if joints.is_empty() {
        return Err(document.error(place, "it has no joints", "give it the nodes that move it"));
    }
    Ok(Skin { joints })
}

fn matrices(document: &Document, index: Index<::gltf::json::Accessor>, place: &str) -> Result<Vec<DMat4>, SceneError> {
    let read = accessor::read::<16>(document, index, place, "inverse bind matrices", &[F32])?;
    let matrix = |columns: [accessor::Component; 16]| {
        let mut matrix = DMat4::from_cols_array(&columns.map(|number| f64::from(number.raw())));
        // Some exporters round it.
        let is_affine = matrix.row(3).abs_diff_eq(DVec4::W, 1e-4);
        (matrix.x_axis.w, matrix.y_axis.w, matrix.z_axis.w, matrix.w_axis.w) = (0.0, 0.0, 0.0, 1.0);
        (is_affine && matrix.is_finite()).then_some(matrix)
    };
    let matrices: Vec<_> = read.into_iter().map(matrix).collect();
    if let Some(wrong) = matrices.iter().position(Option::is_none) {
        let problem = format!("its inverse bind matrix {wrong} is not finite or not affine");
        return Err(document.error(place, problem, "end each column with 0, and the last with 1"));
    }
    Ok(matrices.into_iter().flatten().collect())
}

impl Skin {
    /// Whether most joints mirror: then the corners of triangles change places.
    pub(super) fn is_mirrored(&self) -> bool {
        let mirrors = self.joints.iter().filter(|joint| joint.determinant() < 0.0).count();
        2 * mirrors > self.joints.len()
    }

    /// Transforms vertices to the world; returns how many of them have no weight.
    pub(super) fn apply(&self, attributes: &Attributes, vertices: &mut Vertices) -> Result<usize, SceneError> {
        let sets = attributes.influences(vertices.positions.len())?;
        let mut weightless = 0;
        for vertex in 0..vertices.positions.len() {
            let influences = sets.iter().flat_map(|set| set[vertex]);
            let mut sum = 0.0;
            let mut mean = DMat4::ZERO;
            for (joint, weight) in influences.clone().filter(|&(_, weight)| weight > 0.0) {
                sum += f64::from(weight);
                mean += self.joint(attributes, vertex, joint)? * f64::from(weight);
            }
            let matrix = if sum > 0.0 {
                mean * sum.recip()
            } else {
                weightless += 1;
                let first = influences.clone().next().map_or(0, |(joint, _)| joint);
                self.joint(attributes, vertex, first)?
            };
            vertices.go(vertex, &matrix);
        }
        Ok(weightless)
    }

    fn joint(&self, attributes: &Attributes, vertex: usize, joint: u32) -> Result<DMat4, SceneError> {
        self.joints.get(joint as usize).copied().ok_or_else(|| {
            let joints = count(self.joints.len(), "joint", "joints");
            let problem = format!("vertex {vertex} follows joint {joint}, but its skin has {joints}");
            attributes.error(problem, "keep JOINTS below that number")
        })
    }
}

impl Vertices {
    /// Takes a vertex to the world.
    fn go(&mut self, vertex: usize, matrix: &DMat4) {
        let position = &mut self.positions[vertex];
        *position = matrix.transform_point3(position.as_dvec3()).as_vec3();
        let linear = DMat3::from_mat4(*matrix);
        let DMat3 { x_axis: x, y_axis: y, z_axis: z } = linear;
        let sign = if linear.determinant() < 0.0 { -1.0 } else { 1.0 };
        if let Some(normal) = self.normals.get_mut(vertex) {
            let cofactors = DMat3::from_cols(y.cross(z), z.cross(x), x.cross(y)) * sign;
            // A joint of scale 0 leaves none: then any does.
            *normal = (cofactors * normal.as_dvec3()).try_normalize().map_or(*normal, |normal| normal.as_vec3());
        }
        if let Some(tangent) = self.tangents.get_mut(vertex) {
            let along = (linear * tangent.truncate().as_dvec3()).normalize_or_zero().as_vec3();
            *tangent = along.extend(tangent.w * sign as f32);
        }
    }
}
