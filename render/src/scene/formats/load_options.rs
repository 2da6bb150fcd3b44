//! Options for reading a model.

use std::path::Path;

use crate::scene::{Moment, Sharing};

/// Options for reading a model.
#[derive(Clone, Default)]
pub struct LoadOptions<'a> {
    /// Whether meshes that it shows several times are kept once.
    pub sharing: Sharing,
    /// The moment of its animations; without one it is in the pose of its nodes.
    pub moment: Option<Moment>,
    /// Whether pictures are replaced by a white texel each: for callers that need only geometry.
    pub without_pictures: bool,
    /// The radius of glTF's points and lines, in the coordinates of their mesh, as spheres and cylinders. Without it
    /// they are left out.
    pub point_radius: Option<f32>,
    /// The camera to use: of glTF the name of its node or its own, or its number among those of the file, from 1; the
    /// first without it.
    pub camera: Option<&'a str>,
    /// Whether the model is an object of a scene file, whose lights and cameras are left out: nothing is said of them.
    pub is_object: bool,
    /// Hears how far the reading of a file is.
    pub watch: Option<&'a dyn LoadWatch>,
}

/// Hears how far the reading of a file is, if it is of a format that is read in parts: OBJ and PLY.
pub trait LoadWatch {
    /// `done` of the `total` bytes of the file at `path` are read.
    fn read(&self, path: &Path, done: usize, total: usize);
}

/// A file that is read in parts.
pub(super) struct Loading<'a> {
    path: &'a Path,
    done: usize,
    total: usize,
    watch: Option<&'a dyn LoadWatch>,
}

impl<'a> Loading<'a> {
    /// The progress of a file with `total` bytes.
    pub(crate) fn new(path: &'a Path, total: usize, watch: Option<&'a dyn LoadWatch>) -> Self {
        Self { path, done: 0, total, watch }
    }

    /// So many bytes more are read.
    pub(super) fn advance(&mut self, bytes: usize) {
        self.done += bytes;
        if let Some(watch) = self.watch {
            watch.read(self.path, self.done, self.total);
        }
    }
}
