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
mod light_units;
mod material;
mod material_table;
mod material_text;
mod mesh_point;
mod model;
mod mtl;
mod nearest;
mod obj;
mod overrides;
mod ply;
mod sky;
mod statement;
mod tangents;
mod texture;
mod toml_text;
pub(crate) mod value;

pub use builtin::cornell_box;
pub use daylight::Daylight;
pub use description::{CameraPose, LightUnits, Mesh, Origin, PunctualLight, Scene, Variant};
pub(crate) use error::count;
pub use error::{Place, SceneError};
pub use file::{SceneFile, open};
pub use files::{Disk, Files};
pub use framing::frame;
pub use material::{
    BumpMap, Channel, Cutout, Gloss, GltfAnisotropy, Input, InputMap, Material, NormalMap, Opacity, Specular, Target,
};
pub use material_table::MaterialTable;
pub use mesh_point::{MeshPoint, ShadingFrame, ShadingInputs};
pub use model::{load, load_from};
pub use overrides::{CachedOverrides, Conflict, IntegratorOverrides, Overrides, SkyOverrides};
pub use sky::{Sky, SkyPicture};
pub use texture::{ColorSpace, Texture, TextureFilter, TextureMap, Wrap};
