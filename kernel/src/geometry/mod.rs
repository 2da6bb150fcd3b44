//! Rays, hits, packets, boxes, and the test that decides a hit.
//!
//! # The triangle test
//! Woop, Benthin and Wald 2013, "Watertight Ray/Triangle Intersection": vertices are moved to the ray's origin and
//! sheared so that the ray runs along one axis; the signs of three 2D edge functions then decide. A vertex lands on
//! the same point whichever triangle it belongs to, and the sign of an edge function is exact (an exact zero is decided
//! in `f64`, where the products are exact), so no ray slips through between triangles that share an edge or a vertex.
//!
//! Three deviations. Barycentric weights are found before `t`, so that `t` is a combination of the vertices' depths
//! however thin the triangle. The weights are then refined: the sheared corners' mean by them should be the origin, and
//! is moved there along the longest edge, which takes most of the error out of `t`, `u` and `v`; only what is reported
//! of the weights is then clamped to 0..=1, as `t` is right only while their sum is one. And `t` is clamped to the
//! interval in which the ray is inside the triangle's own box, widened by a bound of the shear's rounding: every box of
//! a tree that encloses the triangle then contains `t` in *its* interval too, since every rounded operation is
//! monotonic. So culling by boxes never loses a hit, ties included, and a tree gives exactly what a loop over all
//! triangles gives.
//!
//! # Error bounds
//! For extents above 1e-30 (smaller ones are subject to underflow, and may leak).
//!
//! With `u = 2⁻²⁴` and `A` a vertex relative to the origin, the sheared `A.x - (d.x / d.z) A.z` is off by at most
//! `u |A.x| + 4 u |A.z|`, and the distance to a plane of the box by `3 u` of itself. `setup::OWN_PAD` covers both for
//! the triangle's own box. `setup::NODE_PAD` covers them twice over for the nodes, plus the rounding of the shifted
//! origin, so that a node's interval always contains that of each triangle in it, even if a backend fuses multiply
//! and add in the nodes' test.

mod aabb;
pub(crate) mod box_lanes;
pub(crate) mod bundle;
pub(crate) mod closest;
mod fault;
pub(crate) mod moment;
mod offset;
pub(crate) mod overlap;
pub(crate) mod own_box;
mod packet;
mod ray;
mod reference;
pub mod round;
pub(crate) mod setup;
pub(crate) mod setup_lanes;
pub(crate) mod setup_rows;
pub(crate) mod shaft;
mod side;
pub(crate) mod triangle;

pub use aabb::Aabb;
pub use closest::SurfacePoint;
pub use fault::PrimitiveFault;
pub use moment::Moment;
pub use offset::{offset_distance, offset_origin, offset_point, triangle_normal};
pub use overlap::overlaps;
pub use packet::{HitPacket, RayPacket};
pub use ray::{Hit, Ray};
pub(crate) use reference::intersect_side;
pub use reference::intersect_triangle;
pub use round::{CubicCurve, Disc, LinearCurve, RoundPrimitive, RoundSurface, Sphere, intersect_round};
pub use setup::{MAX_COORDINATE, MAX_DIRECTION, MIN_DIRECTION};
pub use side::Surface;

/// Three corners; counter-clockwise when seen from the front.
pub type Triangle = [glam::Vec3; 3];
