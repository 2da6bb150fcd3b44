//! Meshes, whatever file they came from: how polygons, lamps, points and lines become triangles, tangents, places, and
//! what a mesh and its material say at a point.

pub(super) mod lamp;
pub(super) mod mesh_point;
mod placement;
pub(super) mod polygon;
pub(super) mod position;
pub(super) mod round;
mod tangents;
pub(super) mod turn;
