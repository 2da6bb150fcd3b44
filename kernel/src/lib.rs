//! A `no_std` ray-tracing kernel: triangles, wide bounding-volume hierarchies and their traversal, one ray or a packet
//! at a time, with SIMD and with the same hits everywhere.
//!
//! Data flows one way, and a module imports only from those above it:
//! [`geometry`] (rays, hits, packets, boxes, the triangle test) → [`Error`] → [`bvh`] (the tree's memory, its view, building and
//! validating) → [`traverse`] (walking it) → [`scene`] (instances, motion, masks, geometry of the caller's). [`sampling`] (random numbers, directions, choices) → [`irradiance`] (what a
//! hemisphere of rays says of a point and of those around it) stand beside; [`columns`] turns rows of memory into lanes.
//!
//! ```
//! # #[cfg(feature = "alloc")] {
//! use glam::Vec3;
//! use halfdome_kernel::{Bvh, BuildOptions, Ray};
//!
//! let triangles = [[Vec3::ZERO, Vec3::X, Vec3::Y]];
//! let (bvh, _) = Bvh::build(&triangles, &BuildOptions::default()).unwrap();
//! let hit = bvh.view().intersect(&Ray::new(Vec3::new(0.25, 0.25, 1.0), Vec3::NEG_Z)).unwrap();
//! assert_eq!((hit.t, hit.prim_id), (1.0, 0));
//! # }
//! ```
//!
//! # What can be asked
//! | of a tree | by |
//! | --- | --- |
//! | the nearest hit, or whether there is any: of a ray, a packet, a batch | [`BvhView::intersect`], [`BvhView::occluded`] and their kin |
//! | the same through a filter, or one side only | [`BvhView::intersect_filtered`], [`BvhView::intersect_facing`] |
//! | all hits, the nearest few, the `n`-th, their number | [`BvhView::hits`], [`BvhView::nearest_hits`] |
//! | the closest point of the surface | [`BvhView::closest_point`] |
//! | the triangles that overlap a box | [`BvhView::for_each_overlap`] |
//! | to follow triangles that move | `Bvh::refit` |
//!
//! [`traverse`] has them all; [`offset_origin`] says where the next ray may start.
//!
//! # What a hit is
//! The hit of a ray with a triangle depends on these two alone: not on the tree, on other triangles, on the width of
//! the lanes or on the instruction set. Among equally near hits the lowest `prim_id` wins. All of `t`, `u`, `v` and
//! `prim_id` are equal bit for bit between the scalar reference, single rays and packets; how, [`geometry`] says.
//!
//! # Numeric limits
//! Coordinates up to [`MAX_COORDINATE`]; directions whose largest component is between [`MIN_DIRECTION`] and
//! [`MAX_DIRECTION`]. Triangles beyond are dropped and counted when a tree is built; rays beyond, or with a NaN
//! anywhere, hit nothing. In scenes this holds in every space that a transform takes a ray to, and a transform may
//! distort by [`scene::MAX_CONDITION`]. A tree holds up to 2²⁹ - 1 triangles and needs up to [`bvh::MAX_STACK`] entries of a traversal's
//! stack. What is beyond is an [`Error`]; nothing here panics for it.
//!
//! # Trees in files and in flash
//! `Bvh::to_bytes` gives a tree as bytes, which [`BvhView::from_bytes`] borrows and traces where they lie: see
//! [`bvh::blob`] for the format, and [`include_blob!`] for bytes that are part of the program.
//!
//! # Features
//! - `std` (default): detects the processor's instruction sets; implies `alloc`.
//! - `alloc`: builds trees and owns them.
//! - neither: traces trees that lie in the caller's memory.
#![cfg_attr(not(any(feature = "std", test)), no_std)]
#![deny(unsafe_code)]

#[cfg(any(feature = "alloc", test))]
extern crate alloc;

pub mod bvh;
pub mod columns;
mod error;
pub mod geometry;
pub mod irradiance;
pub mod sampling;
pub mod scene;
#[allow(unsafe_code, reason = "intrinsics, and the instruction sets that they need")]
mod simd;
pub mod traverse;

pub use bvh::BvhView;
#[cfg(any(feature = "alloc", test))]
pub use bvh::{BuildOptions, BuildReport, Bvh, Executor, Quality, Refit, Serial};
pub use error::{Error, InvalidScene, InvalidTree, RefitError};
pub use geometry::{
    Aabb, Hit, HitPacket, MAX_COORDINATE, MAX_DIRECTION, MIN_DIRECTION, Ray, RayPacket, SurfacePoint, Triangle,
    offset_distance, offset_origin, offset_point, triangle_normal,
};
#[cfg(any(feature = "alloc", test))]
pub use scene::Scene;
pub use scene::{Item, SceneHit, SceneRay, SceneView};
pub use simd::{Isa, Level, Task};
pub use traverse::{Facing, Hits, Verdict};
