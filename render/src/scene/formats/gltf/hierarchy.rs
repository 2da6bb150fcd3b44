//! The node hierarchy: the nodes of the scene, and their transforms to the world.
//!
//! Nodes must form trees: each has one parent at most, and none is its own ancestor (glTF 2.0, section 3.5.2).

use glam::{DAffine3, DMat3, DMat4, DQuat, DVec3, Vec3};

use super::Document;
use super::pose::Pose;
use crate::scene::SceneError;

/// A node in its place.
pub(super) struct Placed {
    /// Its index.
    pub(super) node: usize,
    /// Takes its coordinates to the world; affine and finite.
    pub(super) to_world: DMat4,
    /// The rotations alone, for directions that scale leaves nothing of.
    rotation: DQuat,
}

/// The nodes of the default scene, or of all trees if there is none; parents before children, in the file's order.
pub(super) fn walk(document: &Document, pose: &Pose) -> Result<Vec<Placed>, SceneError> {
    let parents = parents(document)?;
    let roots: Vec<usize> = match document.root.scene {
        Some(index) => {
            let user = format!("scene {}", index.value());
            let roots = &document.object(index, "scene", "scene")?.nodes;
            let roots = roots.iter().map(|&root| document.object(root, "node", &user).map(|_| root.value()));
            let roots: Vec<usize> = roots.collect::<Result<_, _>>()?;
            let mut listed = vec![false; parents.len()];
            for &root in &roots {
                let twice = core::mem::replace(&mut listed[root], true).then(|| user.clone());
                let other = parents[root].map(|parent| document.node(parent));
                if let Some(other) = twice.or(other) {
                    return Err(two_parents(document, root, &user, &other));
                }
            }
            roots
        }
        None => (0..parents.len()).filter(|&node| parents[node].is_none()).collect(),
    };
    let mut stack: Vec<_> = roots.into_iter().rev().map(|root| (root, DMat4::IDENTITY, DQuat::IDENTITY)).collect();
    let mut walk = Vec::new();
    while let Some((index, parent, turned)) = stack.pop() {
        let node = &document.root.nodes[index];
        let (local, rotation) = pose.local(document, index)?;
        let (to_world, rotation) = (parent * local, turned * rotation);
        if !to_world.is_finite() {
            return Err(document.error(document.node(index), "its transform is not finite", "use smaller numbers"));
        }
        walk.push(Placed { node: index, to_world, rotation });
        stack.extend(node.children.iter().flatten().rev().map(|child| (child.value(), to_world, rotation)));
    }
    Ok(walk)
}

/// Every node's parent. All nodes are checked, also those that no scene shows.
fn parents(document: &Document) -> Result<Vec<Option<usize>>, SceneError> {
    let nodes = &document.root.nodes;
    let mut parents = vec![None; nodes.len()];
    for (index, node) in nodes.iter().enumerate() {
        for &child in node.children.iter().flatten() {
            document.object(child, "node", &document.node(index))?;
            if let Some(other) = parents[child.value()].replace(index) {
                return Err(two_parents(document, child.value(), &document.node(index), &document.node(other)));
            }
        }
    }
    // With one parent each, what the roots do not reach is on a cycle or below one.
    let mut reached: Vec<bool> = parents.iter().map(Option::is_none).collect();
    let mut stack: Vec<usize> = (0..nodes.len()).filter(|&node| reached[node]).collect();
    while let Some(index) = stack.pop() {
        for child in nodes[index].children.iter().flatten() {
            reached[child.value()] = true;
            stack.push(child.value());
        }
    }
    if let Some(below) = reached.iter().position(|reached| !reached) {
        let on_cycle = (0..nodes.len()).fold(below, |node, _| parents[node].unwrap_or(node));
        let place = document.node(on_cycle);
        return Err(document.error(place, "it is a descendant of itself", "make the nodes a tree"));
    }
    Ok(parents)
}

fn two_parents(document: &Document, node: usize, one: &str, other: &str) -> SceneError {
    let problem =
        if one == other { format!("{one} lists it twice") } else { format!("it is listed by both {one} and {other}") };
    document.error(document.node(node), problem, "list each node in one place")
}

impl Placed {
    /// The node's origin.
    pub(super) fn origin(&self) -> Vec3 {
        self.to_world.w_axis.truncate().as_vec3()
    }

    /// The transform of points.
    pub(super) fn to_world(&self) -> DAffine3 {
        DAffine3::from_mat4(self.to_world)
    }

    /// The unit vector in the world of a direction at the node, whatever its scale.
    pub(super) fn direction(&self, local: DVec3) -> DVec3 {
        (self.linear() * local).try_normalize().unwrap_or_else(|| (self.rotation * local).normalize())
    }

    /// Directions, scale and shear.
    pub(super) fn linear(&self) -> DMat3 {
        DMat3::from_mat4(self.to_world)
    }
}
