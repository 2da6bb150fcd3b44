//! A `no_std` ray-tracing kernel: triangles, wide bounding-volume hierarchies and their traversal, one ray or a packet
//! at a time, with SIMD and with the same hits everywhere.
//!
//! Data flows one way, and a module imports only from those above it:
//! [`geometry`] (rays, hits, packets, boxes, the triangle test) → [`Error`] → [`bvh`] (the tree's memory, its view, building and
//! validating) → [`traverse`] (walking it). [`sampling`] (random numbers, directions, choices) → [`irradiance`] (what a
//! hemisphere of rays says of a point and of those around it) stand beside.
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
//! # What a hit is
//! The hit of a ray with a triangle depends on these two alone: not on the tree, on other triangles, on the width of
//! the lanes or on the instruction set. Among equally near hits the lowest `prim_id` wins. All of `t`, `u`, `v` and
//! `prim_id` are equal bit for bit between the scalar reference, single rays and packets; how, [`geometry`] says.
//!
//! # Numeric limits
//! Coordinates up to [`MAX_COORDINATE`]; directions whose largest component is between [`MIN_DIRECTION`] and
//! [`MAX_DIRECTION`]. Triangles beyond are dropped and counted when a tree is built; rays beyond, or with a NaN
//! anywhere, hit nothing.
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
mod error;
pub mod geometry;
pub mod irradiance;
pub mod sampling;
#[allow(unsafe_code, reason = "intrinsics, and the instruction sets that they need")]
mod simd;
pub mod traverse;

pub use bvh::BvhView;
#[cfg(any(feature = "alloc", test))]
pub use bvh::{BuildOptions, BuildReport, Bvh, Executor, Quality, Refit, Serial};
pub use error::{Error, InvalidTree, RefitError};
pub use geometry::{
    Aabb, Hit, HitPacket, MAX_COORDINATE, MAX_DIRECTION, MIN_DIRECTION, Ray, RayPacket, SurfacePoint, Triangle,
    offset_origin, triangle_normal,
};
pub use simd::{Isa, Level};
pub use traverse::{Facing, Hits, Verdict};
