//! Nodes without anything: what Blender leaves of objects that it cannot write.

use std::collections::BTreeSet;

use super::Document;

/// Said of them.
pub(super) const NOTE: &str = "empty nodes; Blender leaves one of each area light, which glTF does not have, and of \
                               each mesh without faces";

/// Nodes that show nothing, hold nothing and move nothing.
pub(super) fn find(document: &Document) -> Vec<String> {
    let nodes = &document.root.nodes;
    let joints = document.root.skins.iter().flat_map(|skin| &skin.joints).map(|joint| joint.value());
    let joints: BTreeSet<usize> = joints.collect();
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
