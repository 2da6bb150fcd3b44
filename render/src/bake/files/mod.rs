//! What a bake reads and writes besides its maps: models with lightmap coordinates, manifest, report, checkpoint,
//! pictures of charts.

pub(super) mod checkpoint;
pub mod gltf;
pub(super) mod hashes;
pub mod manifest;
pub mod obj;
pub(super) mod picture;
pub(super) mod relocated;
pub mod report;
