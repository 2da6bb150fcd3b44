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
pub(crate) mod ies;
mod lamp;
mod light_table;
mod light_units;
mod material;
mod material_table;
mod material_text;
mod mesh_point;
mod model;
mod mtl;
mod nearest;
mod obj;
mod optics;
mod overrides;
mod ply;
mod profile;
mod punctual;
mod ray_file;
mod sky;
mod statement;
mod table_reader;
mod tangents;
mod texture;
mod toml_text;
pub(crate) mod value;

pub use builtin::cornell_box;
pub use daylight::{Daylight, DaylightModel};
pub use description::{CameraPose, LightUnits, Mesh, Origin, Scene, Variant};
pub(crate) use error::count;
pub use error::{Place, SceneError};
pub use file::{SceneFile, open};
pub use files::{Disk, Files};
pub use framing::frame;
pub use light_table::LightTable;
pub use material::{BumpMap, Channel, GltfAnisotropy, Input, InputMap, Material, NormalMap, Opacity, Target};
pub use material_table::MaterialTable;
pub use mesh_point::{MeshPoint, ShadingFrame, ShadingInputs};
pub use model::{load, load_from};
pub use optics::{CameraKind, Clip, FisheyeMapping, Lens, Optics, Projection, RayTable, SensorFit};
pub use overrides::{
    CachedOverrides, CameraOverrides, Conflict, IntegratorOverrides, LightOverrides, Overrides, SkyOverrides,
};
pub use profile::{Profile, ProfileFrame};
pub use punctual::{PunctualLight, SpotEdge};
pub use sky::{Sky, SkyPicture};
pub use texture::{ColorSpace, Texture, TextureFilter, TextureMap, Wrap};
