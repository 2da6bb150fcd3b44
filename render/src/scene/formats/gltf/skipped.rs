//! What was left out of a file, counted for the warnings.

use std::path::Path;

use crate::scene::error::count;

/// Skipped content, for the warnings.
#[derive(Default)]
pub(super) struct Skipped {
    pub(super) points_and_lines: usize,
    /// Primitives.
    pub(super) skinless: usize,
    /// Vertices.
    pub(super) weightless: usize,
    /// Primitives.
    pub(super) miscounted: usize,
    pub(super) ranges: usize,
    pub(super) stretched_spots: usize,
}

impl Skipped {
    pub(super) fn warnings(&self, path: &Path) -> Vec<String> {
        let counts = [
            (
                self.points_and_lines,
                "primitive of points or lines is",
                "primitives of points or lines are",
                "skipped: --point-radius shows them",
            ),
            (self.skinless, "primitive is", "primitives are", "shown without the skin: JOINTS_0 is missing"),
            (self.miscounted, "primitive has", "primitives have", "not as many morph targets as weights"),
            (self.weightless, "vertex is", "vertices are", "bound to the first listed joint: weights are missing"),
            (self.ranges, "light has", "lights have", "a range, which is ignored"),
            (
                self.stretched_spots,
                "spot has",
                "spots have",
                "a node that is scaled unevenly: cones stay round, where Blender makes them ellipses",
            ),
        ];
        let counts = counts.iter().filter(|(number, ..)| *number > 0);
        counts
            .map(|&(number, one, many, what)| format!("{}: {} {what}", path.display(), count(number, one, many)))
            .collect()
    }
}
