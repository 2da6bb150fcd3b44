//! How a model is read.

use super::{Moment, Sharing};

/// What can be chosen when a model is read.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LoadOptions {
    /// Whether meshes that it shows several times are kept once.
    pub sharing: Sharing,
    /// The moment of its animations; without one it is in the pose of its nodes.
    pub moment: Option<Moment>,
    /// Whether pictures are left out, each a white texel instead: for those who want to know where things are.
    pub without_pictures: bool,
}
