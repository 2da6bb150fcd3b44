//! A file or a folder for each command; what commands share lies beside this folder.

pub(super) mod bake;
pub(super) mod cache;
pub(super) mod cubemap;
pub(super) mod denoise;
pub(super) mod info;
pub(super) mod irradiance;
pub(super) mod manual;
pub(super) mod materials;
pub(super) mod merge;
pub(super) mod probes;
pub(super) mod render;
pub(super) mod tree;
pub(super) mod validate;
pub(super) mod view;
