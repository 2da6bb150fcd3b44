//! Scenes: what they are made of, and the files they are read from.

mod description;
mod error;
mod gltf;
mod model;
mod mtl;
mod obj;
mod ply;
mod wavefront;

pub use description::{CameraPose, Gloss, Material, Mesh, PunctualLight, Scene, Sky};
pub use error::{Place, SceneError};
pub use model::load;
