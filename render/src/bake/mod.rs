//! Lightmaps: what surrounds the baker.

pub mod gltf;
pub mod manifest;
pub mod report;
