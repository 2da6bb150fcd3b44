//! Scenes: what they are made of, and the files they are read from.

mod builtin;
mod description;
mod error;
mod file;
mod files;
mod framing;
mod gltf;
mod hash;
mod model;
mod mtl;
mod nearest;
mod obj;
mod overrides;
mod ply;
mod statement;
pub(crate) mod value;

pub use builtin::cornell_box;
pub use description::{CameraPose, Gloss, Material, Mesh, PunctualLight, Scene, Sky, Specular};
pub use error::{Place, SceneError};
pub use file::{SceneFile, open};
pub use files::{Disk, Files};
pub use framing::frame;
#[cfg(feature = "cli")]
pub(crate) use model::count;
pub use model::{load, load_from};
pub use overrides::{CachedOverrides, Conflict, IntegratorOverrides, Overrides};
