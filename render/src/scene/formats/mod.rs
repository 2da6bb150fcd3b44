//! The files of other programs: models, and what they name. Each format has a file or a folder; `model` chooses among
//! them.

mod blocks;
mod decimal;
pub(crate) mod gltf;
pub(crate) mod ies;
pub(super) mod light_units;
pub(super) mod load_options;
pub(super) mod model;
mod mtl;
mod notes;
pub(crate) mod obj;
mod pbrt;
mod ply;
mod ray_file;
pub(super) mod sharing;
mod statement;
