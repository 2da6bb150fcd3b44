//! Makes meshes with shared vertices from the faces of an OBJ file.

use std::mem;

use super::{Corner, NONE};
use crate::scene::Mesh;

/// Faces that follow each other with one name and material.
#[derive(Default)]
pub(super) struct Run {
    pub(super) name: String,
    pub(super) material: Option<usize>,
    /// Without texture coordinates and normals; with texture coordinates; with normals; with both.
    pub(super) meshes: [Mesh; 4],
}

impl Run {
    pub(super) fn into_meshes(self) -> impl Iterator<Item = Mesh> {
        let Self { name, material, meshes } = self;
        let meshes = meshes.into_iter().filter(|mesh| !mesh.triangles.is_empty());
        // Faces before any `usemtl` have an index that names no material.
        meshes.map(move |mesh| Mesh { name: name.clone(), material: material.unwrap_or(usize::MAX), ..mesh })
    }
}

/// The vertices of a run: for each position a list of those that are there. Corners of all four meshes of a run differ
/// in what they leave out, so that one table serves them.
pub(super) struct Vertices {
    /// The first of each position's list, or [`NONE`].
    first: Vec<u32>,
    list: Vec<Vertex>,
}

struct Vertex {
    corner: Corner,
    /// Its index in its mesh.
    number: u32,
    /// The next of the position's list, or [`NONE`].
    next: u32,
}

impl Vertices {
    /// A welder for a file with this many positions.
    pub(super) fn new(positions: usize) -> Self {
        Self { first: vec![NONE; positions], list: Vec::new() }
    }

    /// The index of the vertex at `corner`; `next` if there is none yet.
    pub(super) fn find_or_add(&mut self, corner: Corner, next: u32) -> u32 {
        let first = &mut self.first[corner[0] as usize];
        let mut at = *first;
        while let Some(vertex) = self.list.get(at as usize) {
            if vertex.corner == corner {
                return vertex.number;
            }
            at = vertex.next;
        }
        let new = self.list.len() as u32;
        self.list.push(Vertex { corner, number: next, next: mem::replace(first, new) });
        next
    }

    /// Begins a run.
    pub(super) fn forget(&mut self) {
        for vertex in self.list.drain(..) {
            self.first[vertex.corner[0] as usize] = NONE;
        }
    }
}
