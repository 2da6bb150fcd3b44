//! Scenes: their description, and readers of their files.

mod builtin;
mod check;
mod daylight;
mod description;
mod error;
mod files;
pub(crate) mod formats;
mod framing;
mod hash;
mod material;
mod meshes;
mod nearest;
pub(crate) mod scene_file;
mod texture;
mod union_find;

pub use builtin::cornell_box;
pub use check::SceneFault;
pub use daylight::{Daylight, DaylightModel};
pub use description::camera_pose::CameraPose;
pub use description::instance::{Instance, Object};
pub use description::moment::{Animation, Moment};
pub use description::motion::{Motion, Shutter};
pub use description::optics::{CameraKind, Clip, FisheyeMapping, Lens, Optics, Projection, RayTable, SensorFit};
pub use description::profile::{Profile, ProfileFrame};
pub use description::punctual::{PunctualLight, SpotEdge};
pub use description::sky::{Sky, SkyPicture};
pub use description::{LightLabel, LightUnits, Mesh, Origin, Scene, Variant};
pub use error::{Place, SceneError};
pub(crate) use error::{count, listed};
pub use files::{Disk, Files};
pub use formats::load_options::{LoadOptions, LoadWatch};
pub use formats::model::{load, load_from, load_with};
pub use formats::sharing::Sharing;
pub use framing::frame;
pub(crate) use hash::fnv;
pub use material::{
    BumpMap, Channel, CoatNormal, GltfAnisotropy, Input, InputMap, Material, NormalMap, Opacity, Target,
};
pub use meshes::mesh_point::{MeshPoint, ShadingFrame, ShadingInputs};
pub(crate) use meshes::position::{Key, key};
pub use meshes::turn::Turn;
pub(crate) use nearest::nearest;
pub use scene_file::file::{SceneFile, open, open_watched, open_with};
pub use scene_file::light_table::LightTable;
pub use scene_file::material_table::MaterialTable;
pub use scene_file::objects::{InstanceTable, ObjectTable};
pub(crate) use scene_file::overrides::MM_PER_UNIT;
pub use scene_file::overrides::{
    CachedOverrides, CameraOverrides, Conflict, IntegratorOverrides, LightOverrides, MomentOverrides, Overrides,
    SkyOverrides,
};
pub use scene_file::value::MatteKinds;
pub(crate) use texture::BrightnessTable;
pub use texture::{ColorSpace, Texture, TextureFilter, TextureMap, Wrap};
pub(crate) use union_find::UnionFind;
