//! The meshes of nodes: each in world space, or, if shared by many nodes, once as an object with instances.

use std::collections::BTreeMap;
use std::iter::repeat_n;
use std::slice;

use ::gltf::json::mesh::Primitive;
use ::gltf::json::scene::Node;
use glam::DAffine3;

use super::hierarchy::Placed;
use super::pose::Pose;
use super::primitive::Deformation;
use super::{Document, Skipped, instancing, primitive, skin, variants};
use crate::scene::{Instance, Mesh, Object, Origin, Scene, SceneError, Sharing};

/// What the meshes of nodes are read with.
pub(super) struct Meshes<'a> {
    document: &'a Document<'a>,
    pose: &'a Pose,
    /// The scene's nodes, by index.
    nodes: BTreeMap<usize, &'a Placed>,
    /// Whether each mesh of the file is kept once.
    is_shared: Vec<bool>,
    /// The objects of those that were read.
    objects: BTreeMap<usize, usize>,
}

/// A primitive's triangles, in the mesh's coordinates.
struct Part<'a> {
    primitive: &'a Primitive,
    place: String,
    origin: Origin,
    mesh: Mesh,
}

impl<'a> Meshes<'a> {
    pub(super) fn new(
        document: &'a Document<'a>,
        pose: &'a Pose,
        nodes: &'a [Placed],
        sharing: Sharing,
    ) -> Result<Self, SceneError> {
        let is_shared = instancing::shared(document, nodes, sharing)?;
        let nodes = nodes.iter().map(|placed| (placed.node, placed)).collect();
        Ok(Self { document, pose, nodes, is_shared, objects: BTreeMap::new() })
    }

    /// Adds the mesh of a node, or instances of it.
    pub(super) fn read(&mut self, placed: &Placed, scene: &mut Scene, skipped: &mut Skipped) -> Result<(), SceneError> {
        let document = self.document;
        let node = &document.root.nodes[placed.node];
        let Some(index) = node.mesh else { return Ok(()) };
        let mesh = document.object(index, "mesh", &document.node(placed.node))?;
        let places = instancing::places(document, placed)?;
        if self.is_shared[index.value()] && !instancing::deforms(document, node) {
            let object = *self.objects.entry(index.value()).or_insert(scene.objects.len());
            if object == scene.objects.len() {
                let name = name(&mesh.name, &node.name);
                scene.objects.push(Object { name: name.clone() });
                for part in self.parts(placed.node, node, &Deformation::default(), skipped)? {
                    self.add(part, &name, Some(object), scene)?;
                }
            }
            scene.instances.extend(places.iter().map(|place| Instance { object, to_world: place.as_affine3a() }));
            return Ok(());
        }
        let skin = node.skin.map(|skin| skin::read(document, skin, &document.node(placed.node), &self.nodes));
        let weights = self.pose.weights(document, placed.node, mesh)?;
        let deformation = Deformation { skin: skin.transpose()?, weights };
        let name = name(&node.name, &mesh.name);
        for part in self.parts(placed.node, node, &deformation, skipped)? {
            let skin = deformation.skin_of(part.primitive);
            // A skin takes vertices to the world, wherever the node is.
            let places = if skin.is_some() { slice::from_ref(&DAffine3::IDENTITY) } else { &places };
            let Part { primitive, place, origin, mesh } = part;
            for (to_world, mesh) in places.iter().zip(repeat_n(mesh, places.len())) {
                let mirrored = skin.map_or(to_world.matrix3.determinant() < 0.0, |skin| skin.is_mirrored());
                let mesh = primitive::place(document, mesh, &place, placed.node, to_world)?;
                let part = Part { primitive, place: place.clone(), origin: Origin { mirrored, ..origin }, mesh };
                self.add(part, &name, None, scene)?;
            }
        }
        Ok(())
    }

    /// The triangles of a node's mesh.
    fn parts(
        &self,
        number: usize,
        node: &Node,
        deformation: &Deformation,
        skipped: &mut Skipped,
    ) -> Result<Vec<Part<'a>>, SceneError> {
        let Some(index) = node.mesh else { return Ok(Vec::new()) };
        let mesh = self.document.object(index, "mesh", &self.document.node(number))?;
        let mut parts = Vec::new();
        for (place, primitive) in mesh.primitives.iter().enumerate() {
            let origin = Origin { node: number, mesh: index.value(), primitive: place, mirrored: false };
            let place = format!("mesh {}, primitive {place}", index.value());
            if let Some(mesh) = primitive::read(self.document, primitive, &place, deformation, skipped)? {
                parts.push(Part { primitive, place, origin, mesh });
            }
        }
        Ok(parts)
    }

    /// Adds a mesh of the scene.
    fn add(&self, part: Part<'_>, name: &str, object: Option<usize>, scene: &mut Scene) -> Result<(), SceneError> {
        let Part { primitive, place, origin, mesh } = part;
        variants::add(self.document, primitive, &place, scene.meshes.len(), &mut scene.variants)?;
        // Balls and tubes are nowhere in the file.
        let origin = primitive::has_triangles(primitive).then_some(origin);
        scene.meshes.push(Mesh { name: name.to_owned(), object, origin, ..mesh });
        Ok(())
    }
}

fn name(own: &Option<String>, other: &Option<String>) -> String {
    own.as_ref().or(other.as_ref()).cloned().unwrap_or_default()
}
