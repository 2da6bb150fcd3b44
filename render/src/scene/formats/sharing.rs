//! Decides whether repeated meshes of a file are shared.
//!
//! Copies cost memory, instances time: a ray is transformed for each instance that it enters. So files whose copies are
//! small in total are read as copies.

/// Triangles of copies that a file may have together before they are shared.
const MAX_COPIED_TRIANGLES: usize = 1_000_000;
/// Copies of a mesh with fewer triangles in all stay copies.
const MIN_SHARED_TRIANGLES: usize = 1000;

/// The treatment of meshes shared by several nodes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Sharing {
    /// Each is kept once if the file's copies would have over a million triangles.
    #[default]
    Auto,
    /// Each is kept once.
    Always,
    /// Each node gets a copy, with a surface of its own for lightmaps.
    Never,
}

impl Sharing {
    /// Which meshes to keep once, by the number of triangles of each and how often it is shown.
    pub(crate) fn shared(self, meshes: &[(usize, usize)]) -> Vec<bool> {
        let copied = |&(triangles, uses): &(usize, usize)| triangles.saturating_mul(uses.saturating_sub(1));
        let all = meshes.iter().map(copied).fold(0, usize::saturating_add);
        let is_shared = |mesh: &(usize, usize)| match self {
            Self::Auto => all > MAX_COPIED_TRIANGLES && copied(mesh) >= MIN_SHARED_TRIANGLES,
            Self::Always => mesh.1 > 1,
            Self::Never => false,
        };
        meshes.iter().map(is_shared).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_shown_often_is_shared_if_it_saves_much() {
        let few = [(10, 50), (999_000, 1), (1000, 900)];
        assert_eq!(Sharing::Auto.shared(&few), [false; 3]);
        assert_eq!(Sharing::Always.shared(&few), [true, false, true]);
        let many = [(10, 50), (999_000, 1), (1000, 1100), (usize::MAX, 0)];
        assert_eq!(Sharing::Auto.shared(&many), [false, false, true, false]);
        assert_eq!(Sharing::Never.shared(&many), [false; 4]);
    }
}
