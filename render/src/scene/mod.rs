//! Scenes: what they are made of, and the files they are read from.

mod description;
mod error;

pub use description::{CameraPose, Gloss, Material, Mesh, PunctualLight, Scene, Sky};
pub use error::{Place, SceneError};
