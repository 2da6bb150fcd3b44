//! Triangles that get no light of their own. The module `visibility::outside` finds them.

/// Triangles that get no light of their own.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LeftOut {
    /// Flags by mesh and triangle; no meshes if nothing is left out.
    meshes: Vec<Vec<bool>>,
}

impl LeftOut {
    /// Of a list for each mesh, which says of each triangle whether it is left out.
    pub(crate) fn new(meshes: Vec<Vec<bool>>) -> Self {
        Self { meshes }
    }

    /// Whether a triangle of a mesh is left out.
    pub fn has(&self, mesh: usize, face: usize) -> bool {
        self.meshes.get(mesh).is_some_and(|faces| faces[face])
    }

    /// The triangles of a mesh, if any is left out anywhere.
    pub(crate) fn of_mesh(&self, mesh: usize) -> Option<&[bool]> {
        self.meshes.get(mesh).map(Vec::as_slice)
    }
}
