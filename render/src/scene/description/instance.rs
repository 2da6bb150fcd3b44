//! Objects that are stored once, with instances.
//!
//! A mesh with an [`object`](super::Mesh::object) is in that object's own coordinates and appears at the object's
//! [instances](Instance); all other meshes are in world space. Emissive surfaces are not shared: each copy of them is a
//! light of its own (`placement.rs`).

use glam::Affine3A;

/// Meshes that are placed together; those whose [`object`](crate::scene::Mesh::object) is its index.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Object {
    /// The file's own name for it, or empty.
    pub name: String,
}

/// An object in the world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Instance {
    /// A valid index into [`Scene::objects`](crate::scene::Scene::objects).
    pub object: usize,
    /// Takes the object's coordinates to the world; finite. What it flattens is not seen.
    pub to_world: Affine3A,
}
