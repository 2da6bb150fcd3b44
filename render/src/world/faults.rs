//! Faults of meshes, for warnings that name them.

use std::collections::BTreeMap;
use std::path::Path;

use super::World;
use crate::scene::{count, listed};

impl World {
    /// A mesh for messages.
    pub(crate) fn mesh_name(&self, mesh: usize) -> String {
        match self.meshes[mesh].name.as_str() {
            "" => format!("mesh {mesh}"),
            name => format!("mesh {mesh} ({name:?})"),
        }
    }

    /// The warnings about triangles that were dropped for two equal corners; `file` is the model's.
    pub(crate) fn dropped(&self, file: Option<&Path>) -> Option<String> {
        let dropped = self.build_report().degenerate;
        let mut meshes: BTreeMap<u32, usize> = BTreeMap::new();
        for record in &self.triangle_records {
            let [a, b, c] = record.corners;
            if a == b || b == c || c == a {
                *meshes.entry(record.mesh).or_insert(0) += 1;
            }
        }
        let names: Vec<String> = meshes.keys().map(|&mesh| self.mesh_name(mesh as usize)).collect();
        let file = file.map(|file| format!("{}: ", file.display())).unwrap_or_default();
        let what = count(dropped, "triangle with two equal corners is", "triangles with two equal corners are");
        (dropped > 0).then(|| format!("{file}{what} dropped: {}", listed(&names)))
    }
}
