//! Poses: the local transforms of nodes and the weights of their morph targets at a moment.

use std::collections::BTreeMap;

use ::gltf::json::mesh::Mesh;
use glam::{DMat4, DQuat, DVec3, DVec4, Vec3};

use super::Document;
use super::animation::{Animation, Property};
use crate::scene::SceneError;

/// The properties of nodes that animations set; nodes keep all others.
#[derive(Default)]
pub(super) struct Pose {
    nodes: BTreeMap<usize, Posed>,
}

#[derive(Default)]
struct Posed {
    translation: Option<DVec3>,
    rotation: Option<DQuat>,
    scale: Option<DVec3>,
    weights: Option<Vec<f64>>,
}

impl Pose {
    /// The pose by animations of different properties, at a time in seconds.
    pub(super) fn at(playing: &[&Animation], time: f64) -> Self {
        let mut pose = Self::default();
        for channel in playing.iter().flat_map(|animation| &animation.channels) {
            let (posed, value) = (pose.nodes.entry(channel.node).or_default(), channel.at(time));
            match channel.property {
                Property::Translation => posed.translation = Some(DVec3::from_slice(&value)),
                // A spline may pass through zero.
                Property::Rotation => {
                    let (turn, length) = (DVec4::from_slice(&value), DVec4::from_slice(&value).length());
                    posed.rotation = (length > 0.0).then(|| DQuat::from_vec4(turn / length));
                }
                Property::Scale => posed.scale = Some(DVec3::from_slice(&value)),
                Property::Weights => posed.weights = Some(value),
            }
        }
        pose
    }

    /// A node's transform to its parent's coordinates, and its rotation; of a matrix that of its columns if they have
    /// one.
    pub(super) fn local(&self, document: &Document, index: usize) -> Result<(DMat4, DQuat), SceneError> {
        let node = &document.root.nodes[index];
        let moved = self.nodes.get(&index).map(|posed| (posed.translation, posed.rotation, posed.scale));
        let moved = moved.filter(|&moved| moved != (None, None, None));
        let (scale, rotation, translation) = if let Some(columns) = node.matrix {
            let matrix = DMat4::from_cols_array(&columns.map(f64::from));
            if matrix.row(3) != DVec4::W {
                let problem = "its matrix is not affine";
                let remedy = "end each column with 0, and the last with 1";
                return Err(document.error(document.node(index), problem, remedy));
            }
            let (scale, rotation, translation) = matrix.to_scale_rotation_translation();
            let rotation = if rotation.is_normalized() { rotation } else { DQuat::IDENTITY };
            if moved.is_none() {
                return Ok((matrix, rotation));
            }
            (scale, rotation, translation)
        } else {
            let rotation = DQuat::from_array(node.rotation.unwrap_or_default().0.map(f64::from));
            if rotation.length_squared() == 0.0 {
                return Err(document.error(document.node(index), "its rotation is zero", "write a unit quaternion"));
            }
            let vector =
                |vector: Option<[f32; 3]>, default| vector.map_or(default, |vector| Vec3::from(vector).as_dvec3());
            (vector(node.scale, DVec3::ONE), rotation.normalize(), vector(node.translation, DVec3::ZERO))
        };
        let (to, turn, by) = moved.unwrap_or_default();
        let (scale, rotation, translation) = (by.unwrap_or(scale), turn.unwrap_or(rotation), to.unwrap_or(translation));
        Ok((DMat4::from_scale_rotation_translation(scale, rotation, translation), rotation))
    }

    /// The weights of morph targets of `mesh` at a node: animated, the node's own, or the mesh's.
    pub(super) fn weights(&self, document: &Document, index: usize, mesh: &Mesh) -> Result<Vec<f64>, SceneError> {
        if let Some(weights) = self.nodes.get(&index).and_then(|posed| posed.weights.as_ref()) {
            return Ok(weights.clone());
        }
        let weights = document.root.nodes[index].weights.as_ref().or(mesh.weights.as_ref());
        let weights = weights.map(Vec::as_slice).unwrap_or_default();
        if let Some(wrong) = weights.iter().find(|weight| !weight.is_finite()) {
            let problem = format!("a weight of its morph targets is {wrong}");
            return Err(document.error(document.node(index), problem, "write finite numbers"));
        }
        Ok(weights.iter().copied().map(f64::from).collect())
    }
}
