//! A ray-tracing kernel for embedding: bounding-volume hierarchies, traversal with SIMD, scenes of instances, samplers,
//! and irradiance with gradients. It is `no_std`, does not allocate or panic while it traces, and finds the same hits
//! to the bit on every instruction set, alone, in packets or in batches.
//!
//! # What one can do
//!
//! Build a tree and trace a ray. Vectors are those of [glam](https://docs.rs/glam/0.34) 0.34, which is re-exported as
//! [`glam`](mod@glam): use that, or depend on the same version.
//!
//! ```
//! # #[cfg(feature = "alloc")] {
//! use glam::Vec3;
//! use halfdome_kernel::{BuildOptions, Bvh, Ray};
//!
//! let triangles = [[Vec3::ZERO, Vec3::X, Vec3::Y]];
//! let (bvh, report) = Bvh::build(&triangles, &BuildOptions::default()).unwrap();
//! assert_eq!(report.kept, 1);   // triangles with two equal corners, NaN or infinity are dropped and counted
//! let hit = bvh.view().intersect(&Ray::new(Vec3::new(0.25, 0.25, 1.0), Vec3::NEG_Z)).unwrap();
//! assert_eq!((hit.t, hit.prim_id), (1.0, 0));
//! # }
//! ```
//!
//! Trace many rays: slices are the fastest way.
//!
//! ```
//! # #[cfg(feature = "alloc")] {
//! # use glam::{Vec3, vec3};
//! # use halfdome_kernel::{BuildOptions, Bvh, Hit, Ray};
//! # let (bvh, _) = Bvh::build(&[[Vec3::ZERO, Vec3::X, Vec3::Y]], &BuildOptions::default()).unwrap();
//! let rays: Vec<Ray> = (0..100).map(|i| Ray::new(vec3(i as f32 * 0.02, 0.1, 1.0), Vec3::NEG_Z)).collect();
//! let mut hits = vec![Hit::MISS; rays.len()];
//! bvh.view().intersect_many(&rays, &mut hits);
//! let mut shadowed = vec![false; rays.len()];
//! bvh.view().occluded_many(&rays, &mut shadowed);   // whether there is any hit between `t_min` and `t_max`
//! assert!(hits.iter().zip(&shadowed).all(|(hit, shadowed)| hit.is_hit() == *shadowed));
//! # }
//! ```
//!
//! Place instances of a tree in a [`scene`], with motion, masks, and shapes of your own:
//!
//! ```
//! # #[cfg(feature = "alloc")] {
//! # use glam::{Affine3A, Vec3};
//! # use halfdome_kernel::{BuildOptions, Bvh, Ray};
//! use halfdome_kernel::{Item, Scene};
//!
//! let (bvh, _) = Bvh::build(&[[Vec3::ZERO, Vec3::X, Vec3::Y]], &BuildOptions::default()).unwrap();
//! let right = Affine3A::from_translation(Vec3::new(5.0, 0.0, 0.0));
//! let items = vec![Item::new(bvh.view()), Item::new(bvh.view()).placed(&right).unwrap()];
//! let (scene, _) = Scene::build(items, &BuildOptions::default()).unwrap();
//! let hit = scene.view().intersect(&Ray::new(Vec3::new(5.25, 0.25, 1.0), Vec3::NEG_Z).into()).unwrap();
//! assert_eq!((hit.item, hit.hit.prim_id, hit.hit.t), (1, 0, 1.0));
//! # }
//! ```
//!
//! Write a tree as bytes, and trace it where they lie, in flash or a memory map, without an allocator:
//!
//! ```
//! # #[cfg(feature = "alloc")] {
//! # use glam::Vec3;
//! # use halfdome_kernel::{BuildOptions, Bvh, BvhView, Ray};
//! # let (bvh, _) = Bvh::build(&[[Vec3::ZERO, Vec3::X, Vec3::Y]], &BuildOptions::default()).unwrap();
//! let bytes = bvh.to_bytes();
//! let tree = BvhView::from_bytes(&bytes).unwrap();   // checked once: bytes may come from anywhere
//! assert!(tree.occluded(&Ray::new(Vec3::new(0.25, 0.25, 1.0), Vec3::NEG_Z)));
//! # }
//! ```
//!
//! Scenes of instances are written and traced in place likewise: see [`scene::blob`].
//!
//! Sample a hemisphere, or gather irradiance over it: see [`sampling`] and [`irradiance`], which have examples.
//!
//! | of a tree | by |
//! | --- | --- |
//! | the nearest hit, or whether there is any: of a ray, a packet, a batch | [`BvhView::intersect`], [`BvhView::occluded`] and their kin |
//! | the same through a filter, or one side only | [`BvhView::intersect_filtered`], [`BvhView::intersect_facing`] |
//! | all hits, the nearest few, the `n`-th, their number | [`BvhView::hits`], [`BvhView::nearest_hits`] |
//! | the closest point of the surface | [`BvhView::closest_point`] |
//! | the triangles that overlap a box | [`BvhView::for_each_overlap`] |
//! | to follow triangles that move | `Bvh::refit` |
//! | where the next ray may start | [`offset_origin`] |
//! | spheres, discs, round curves in place of triangles | [`RoundBvhView`], [`geometry::round`] |
//!
//! # Modules
//!
//! | module | has |
//! | --- | --- |
//! | [`geometry`] | rays, hits, packets, boxes, the triangle test; spheres, discs and round curves |
//! | [`mesh`] | triangles as others keep them: indexed, strided, quantised |
//! | [`bvh`] | the tree: building, refitting, validating, as bytes |
//! | [`traverse`] | tracing rays through a tree, and the scalar reference |
//! | [`scene`] | instances, nesting, motion, masks, points and curves, quads, shapes of the caller's |
//! | [`sampling`] | random numbers, Sobol' points, warps of directions and points with densities, alias tables |
//! | [`irradiance`] | irradiance of a point, its gradients and Hessian, from the rays of a gather |
//! | [`columns`] | rows of memory transposed into SIMD lanes |
//!
//! Modules depend on each other in one direction: `geometry`, `mesh`, `bvh`, `traverse`, `scene`. `sampling`, then
//! `irradiance`, stand beside them. No module imports from those after it.
//!
//! # Features and instruction sets
//!
//! - `std` (default): detects AVX2 and AVX-512 at run time, and asks for large pages; implies `alloc`.
//! - `alloc`: builds trees and scenes, and owns them.
//! - `rayon`: builds, refits and commits on rayon's threads, by `RayonExecutor`; implies `std`.
//! - `obvhs`: makes trees of the binary trees that the crate obvhs builds, by `Bvh::from_obvhs`; implies `std`.
//! - none of them: traces trees that lie in the caller's memory.
//!
//! Without `std` the processor is not detected. The instruction set is then the target's portable one (SSE2 on x86-64,
//! NEON on AArch64) unless you choose another by `-C target-cpu` or `-C target-feature`, or by [`Isa::assume`] and
//! [`BvhView::with_isa`]. It is several times slower than AVX-512; hits are the same.
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
//! distort by [`scene::MAX_CONDITION`]. A tree holds up to 2²⁹ - 1 triangles and needs up to [`bvh::MAX_STACK`] entries
//! of a traversal's stack. Exceeding a limit gives an [`Error`], not a panic.
//!
//! # Trees in files and in flash
//! `Bvh::to_bytes` gives a tree as bytes, which [`BvhView::from_bytes`] borrows and traces where they lie: see
//! [`bvh::blob`] for the format, and [`include_blob!`] for bytes that are part of the program.
#![cfg_attr(not(any(feature = "std", test)), no_std)]
#![deny(unsafe_code)]

#[cfg(any(feature = "alloc", test))]
extern crate alloc;

pub mod bvh;
#[cfg(test)]
mod checksums;
pub mod columns;
mod error;
pub mod geometry;
pub mod irradiance;
pub mod mesh;
pub mod sampling;
pub mod scene;
#[allow(unsafe_code, reason = "intrinsics, and the instruction sets that they need")]
mod simd;
pub mod traverse;

#[cfg(feature = "rayon")]
pub use bvh::RayonExecutor;
#[cfg(any(feature = "alloc", test))]
pub use bvh::{
    BuildOptions, BuildReport, Bvh, Executor, MovingBvh, Quality, Refit, RoundBvh, Serial, TreeStatistics,
    UnknownQuality,
};
pub use bvh::{BvhView, MovingBvhView, RoundBvhView};
pub use error::{Error, InvalidMesh, InvalidScene, InvalidTree, RefitError};
pub use geometry::{
    Aabb, CubicCurve, Disc, Hit, HitPacket, LinearCurve, MAX_COORDINATE, MAX_DIRECTION, MIN_DIRECTION, Ray, RayPacket,
    RoundSurface, Sphere, Surface, SurfacePoint, Triangle, offset_distance, offset_origin, offset_point,
    triangle_normal,
};
/// The crate of the vectors and transforms in this crate's interface, version 0.34: types of other versions do not
/// match.
pub use glam;
#[cfg(any(feature = "alloc", test))]
pub use scene::Scene;
pub use scene::{Item, SceneHit, SceneHitPacket, ScenePoint, SceneRay, SceneRayPacket, SceneView};
pub use simd::{Isa, Level, Task, UnknownLevel};
pub use traverse::{Facing, Hits, Verdict};

/// Runs the examples of the crate's README.
#[cfg(all(doctest, feature = "std"))]
#[doc = include_str!("../README.md")]
struct Readme;
