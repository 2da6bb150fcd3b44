//! Scenes: what they are made of, and the files they are read from.

mod builtin;
mod daylight;
mod description;
mod error;
mod file;
mod files;
mod framing;
pub(crate) mod gltf;
mod hash;
mod model;
mod mtl;
mod nearest;
mod obj;
mod overrides;
mod ply;
mod sky;
mod statement;
mod texture;
pub(crate) mod value;

pub use builtin::cornell_box;
pub use daylight::Daylight;
pub use description::{CameraPose, Cutout, Gloss, Material, Mesh, Origin, PunctualLight, Scene, Specular};
pub(crate) use error::count;
pub use error::{Place, SceneError};
pub use file::{SceneFile, open};
pub use files::{Disk, Files};
pub use framing::frame;
pub use model::{load, load_from};
pub use overrides::{CachedOverrides, Conflict, IntegratorOverrides, Overrides, SkyOverrides};
pub use sky::{Sky, SkyPicture};
pub use texture::{Texture, TextureFilter, TextureMap, Wrap};
