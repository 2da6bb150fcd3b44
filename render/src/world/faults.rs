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

    /// The warnings about triangles that were dropped for two equal corners: of the model, whose `file` this is, and of
    /// each object that a scene file adds.
    pub(crate) fn dropped(&self, file: Option<&Path>) -> Vec<String> {
        let mut meshes: BTreeMap<u32, usize> = BTreeMap::new();
        for record in &self.triangle_records {
            let [a, b, c] = record.corners;
            if a == b || b == c || c == a {
                *meshes.entry(record.mesh).or_insert(0) += 1;
            }
        }
        let model = file.map(|file| format!("{}: ", file.display())).unwrap_or_default();
        let mut places: BTreeMap<String, (usize, Vec<String>)> = BTreeMap::new();
        for (&mesh, number) in &meshes {
            let mesh = mesh as usize;
            let added_at = self.meshes[mesh].added_at.as_ref().map(|place| format!("{place}: "));
            let (dropped, names) = places.entry(added_at.unwrap_or_else(|| model.clone())).or_default();
            *dropped += number;
            names.push(self.mesh_name(mesh));
        }
        let warning = |(place, (dropped, names)): (String, (usize, Vec<String>))| {
            let what = count(dropped, "triangle with two equal corners is", "triangles with two equal corners are");
            format!("{place}{what} dropped: {}", listed(&names))
        };
        places.into_iter().map(warning).collect()
    }
}
