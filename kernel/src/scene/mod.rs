//! Scenes: triangles, points, curves, custom geometry and other scenes, each with a transform, static or moving.
//!
//! | rays | closest hit | any hit |
//! | --- | --- | --- |
//! | one | [`SceneView::intersect`] | [`SceneView::occluded`] |
//! | 4 to 32 that run alike | [`SceneView::intersect_packet`] | [`SceneView::occluded_packet`] |
//! | a slice | [`SceneView::intersect_many`] | [`SceneView::occluded_many`] |
//! | a slice, of one origin | [`SceneView::intersect_gather`] | [`SceneView::occluded_gather`] |
//! | one, with a filter | [`SceneView::intersect_filtered`] | [`SceneView::occluded_filtered`] |
//! | all hits of one | [`SceneView::for_each_hit`], [`SceneView::nearest_hits`] | [`SceneView::count_hits`] |
//!
//! [`SceneView::closest_point`] finds the point of the surface that is closest to a point,
//! [`SceneView::for_each_overlap`] the primitives that overlap a box.
//!
//! An [`Item`] is an object with a transform. Objects are borrowed or shared: ten thousand items may have the same
//! million triangles. A `Scene` has a tree over its items' boxes, and may be an object in another.
//!
//! # Scenes that change
//! With `alloc`, a `Scene` owns its items. An inserted item has a `Handle`, which stays valid until the item is
//! removed. Changes are staged: rays see the scene as of its last `commit`, which checks all changes before it makes
//! any, and refits or rebuilds the tree. Without a commit the scene does not change; `Scene::is_committed` tells
//! whether changes are pending. A `Scene<'static>`, whose items share their objects by `Arc`, is `Send` and `Sync` and
//! can be an engine's resource.
//!
//! ```
//! # #[cfg(feature = "alloc")] {
//! # extern crate alloc;
//! use alloc::sync::Arc;
//!
//! use glam::{Affine3A, Vec3};
//! use halfdome_kernel::{Bvh, BuildOptions, Item, Ray, Scene};
//!
//! let (mesh, _) = Bvh::build(&[[Vec3::ZERO, Vec3::X, Vec3::Y]], &BuildOptions::default())?;
//! let mut scene: Scene<'static> = Scene::new(BuildOptions::default());
//! let handle = scene.insert(Item::new(Arc::new(mesh)))?;
//! // Each frame:
//! scene.set_transform(handle, &Affine3A::from_translation(Vec3::NEG_Z))?;
//! scene.commit()?;
//! let hit = scene.view().intersect(&Ray::new(Vec3::new(0.25, 0.25, 1.0), Vec3::NEG_Z).into()).unwrap();
//! assert_eq!((hit.hit.t, scene.handle(hit.item)), (2.0, Some(handle)));
//! # }
//! # Ok::<(), halfdome_kernel::Error>(())
//! ```
//!
//! # What a hit is
//! The ray is transformed into the item's own space by the inverse of its transform, in `f64`, and rounded once: the
//! hit is that of [`BvhView::intersect`](crate::BvhView::intersect) with this local ray. Its direction is not
//! normalised, so that `t` is the same in all spaces. Of equally near hits that with the lowest `item` counts,
//! then the lowest `prim_id`, then the lowest `path`. So what is hit does not depend on the order of the tree, and is
//! equal bit for bit on every instruction set and to the loop in [`mod@reference`].
//!
//! The [numeric limits](crate#numeric-limits) hold in every space: a ray that a transform takes beyond them hits
//! nothing there.
//!
//! # Instances
//! A scene has a path for itself and the paths of each nested scene, once for each item that has it. They are numbered
//! depth first: the paths through the first item, those through the second and so on, and last the scene's own. So one
//! number identifies the items around a hit, at any depth. Tracing recurses once a level, with up to 9 KB of stack
//! each; [`SceneView::levels`] gives the depth. There are [`MAX_LEVELS`] at most.
//!
//! # Motion
//! Times are 0..=1; other times are clamped, and a ray whose time is NaN hits nothing. Motion has keys, evenly spaced
//! over that time: triangles ([`MovingBvhView`](crate::bvh::MovingBvhView)), whose corners are interpolated as
//! `(1 - f) a + f b` with each operation rounded, and items ([`Item::moving`]), whose transform's elements are. At a
//! key both equal static geometry exactly. A scene's tree has as many keys as the item with the most keys; its boxes
//! are interpolated, and an item whose own keys do not coincide with the tree's has one box around its whole motion.
//!
//! Nothing here allocates or panics while tracing.

mod answers;
pub mod blob;
mod debug;
#[cfg(any(feature = "alloc", test))]
mod handle;
mod image;
mod image_box;
mod inverse;
mod item;
mod near;
mod object;
#[cfg(any(feature = "alloc", test))]
mod owned;
mod packet;
mod quad;
mod ray;
mod ray_packet;
pub mod reference;
mod round;
mod search;
mod shape;
mod space;
mod sphere;
mod stream;
#[cfg(test)]
mod tests;
#[cfg(any(feature = "alloc", test))]
mod top_level;
mod transform;
mod view;
mod walk;
mod widening;

pub use blob::{SCENE_BLOB_VERSION, SceneBlob};
#[cfg(any(feature = "alloc", test))]
pub use handle::Handle;
pub use inverse::MAX_CONDITION;
pub use item::Item;
pub use object::Object;
#[cfg(any(feature = "alloc", test))]
pub use owned::{Commit, Scene};
pub use quad::Quads;
pub use ray::{SceneHit, ScenePoint, SceneRay};
pub use ray_packet::{SceneHitPacket, SceneRayPacket};
pub use shape::Shape;
pub use sphere::Spheres;
pub use view::MAX_LEVELS;
pub use view::{Instances, Part, SceneView};

use core::ops::ControlFlow;
use core::slice;

use crate::simd::{Level, dispatch};
use crate::traverse::Verdict;
use crate::traverse::stream::MIN_STREAM_RAYS;
use answers::{Answers, Nearest, Occluded};
use search::Judged;
use stream::StreamAll;
use walk::{Trace, TraceAll};

impl SceneView<'_> {
    /// The nearest hit of `ray`; the [module](self) defines the order of equally near ones.
    pub fn intersect(&self, ray: &SceneRay) -> Option<SceneHit> {
        let mut hit = SceneHit::MISS;
        self.intersect_many(slice::from_ref(ray), slice::from_mut(&mut hit));
        hit.is_hit().then_some(hit)
    }

    /// Whether `ray` hits anything: `intersect(ray).is_some()`, but faster.
    pub fn occluded(&self, ray: &SceneRay) -> bool {
        let mut occluded = false;
        self.occluded_many(slice::from_ref(ray), slice::from_mut(&mut occluded));
        occluded
    }

    /// The nearest hit of `ray` that `filter` accepts. If the filter stops the search, the hit that it stopped at.
    ///
    /// The filter sees those hits that precede the nearest one accepted so far: each triangle and each primitive of a
    /// shape at most once for each path to it, roughly from near to far. The order is the same on all instruction sets
    /// but [`Isa::SCALAR`](crate::Isa::SCALAR).
    pub fn intersect_filtered(&self, ray: &SceneRay, filter: impl FnMut(&SceneHit) -> Verdict) -> Option<SceneHit> {
        match self.isa().level() {
            Level::Scalar => reference::intersect_filtered(self, ray, filter),
            _ => walk::filtered(self, ray, filter),
        }
    }

    /// Whether `ray` hits anything that `filter` accepts: `intersect_filtered(ray, filter).is_some()`, but faster. The
    /// filter sees the ray's hits up to the first that it accepts or stops at.
    pub fn occluded_filtered(&self, ray: &SceneRay, mut filter: impl FnMut(&SceneHit) -> Verdict) -> bool {
        let stop = |hit: &SceneHit| match filter(hit) {
            Verdict::Reject => Verdict::Reject,
            Verdict::Accept | Verdict::Stop => Verdict::Stop,
        };
        self.intersect_filtered(ray, stop).is_some()
    }

    /// Gives `visit` every hit of `ray`, each once for each path to it and roughly from near to far, until it breaks
    /// off; returns whether it did.
    pub fn for_each_hit(&self, ray: &SceneRay, mut visit: impl FnMut(&SceneHit) -> ControlFlow<()>) -> ControlFlow<()> {
        let mut flow = ControlFlow::Continue(());
        let t_max = ray.ray.t_max;
        let mut judge = |hit: &SceneHit| {
            if flow.is_continue() {
                flow = visit(hit);
            }
            flow.map_continue(|()| t_max)
        };
        match self.isa().level() {
            Level::Scalar => reference::for_each_hit(self, ray, &mut |hit| {
                let _ = judge(&hit);
            }),
            _ => {
                let mut search = Judged { t_max, judge: &mut judge };
                dispatch(self.isa(), Trace { scene: self, ray, search: &mut search });
            }
        }
        flow
    }

    /// How many hits `ray` has.
    pub fn count_hits(&self, ray: &SceneRay) -> usize {
        let mut count = 0;
        let _ = self.for_each_hit(ray, |_| {
            count += 1;
            ControlFlow::Continue(())
        });
        count
    }

    /// Writes the nearest hits of `ray`, as many as there are and as `hits` has room for, nearest first, and gives
    /// their number. The rest of `hits` is unspecified. The search skips everything behind the last of them.
    pub fn nearest_hits(&self, ray: &SceneRay, hits: &mut [SceneHit]) -> usize {
        let mut len = 0;
        let room = hits.len();
        if room == 0 {
            return 0;
        }
        let mut judge = |hit: &SceneHit| {
            let place = hits[..len].partition_point(|other| other.precedes(hit));
            len = room.min(len + 1);
            if place < len {
                hits[place..len].rotate_right(1);
                hits[place] = *hit;
            }
            ControlFlow::Continue(if len == room { hits[len - 1].hit.t } else { ray.ray.t_max })
        };
        match self.isa().level() {
            Level::Scalar => reference::for_each_hit(self, ray, &mut |hit| {
                let _ = judge(&hit);
            }),
            _ => {
                let mut search = Judged { t_max: ray.ray.t_max, judge: &mut judge };
                dispatch(self.isa(), Trace { scene: self, ray, search: &mut search });
            }
        }
        len
    }

    /// Writes the nearest hit of each ray, or [`SceneHit::MISS`]. Elements beyond the end of the shorter slice are left
    /// unchanged.
    ///
    /// The fastest way for many incoherent rays: 32 of them are traced at the same time, as a stream, unless there are
    /// nested scenes.
    pub fn intersect_many(&self, rays: &[SceneRay], hits: &mut [SceneHit]) {
        let rays = &rays[..rays.len().min(hits.len())];
        match self.isa().level() {
            Level::Scalar => {
                for (ray, hit) in rays.iter().zip(hits) {
                    *hit = reference::intersect(self, ray).unwrap_or(SceneHit::MISS);
                }
            }
            _ => trace_many(self, rays, Nearest(hits)),
        }
    }

    /// Writes for each ray whether it hits anything. Elements beyond the end of the shorter slice are left unchanged.
    pub fn occluded_many(&self, rays: &[SceneRay], occluded: &mut [bool]) {
        let rays = &rays[..rays.len().min(occluded.len())];
        match self.isa().level() {
            Level::Scalar => {
                for (ray, occluded) in rays.iter().zip(occluded) {
                    *occluded = reference::intersect(self, ray).is_some();
                }
            }
            _ => trace_many(self, rays, Occluded(occluded)),
        }
    }
}

/// Rays by the method that suits their number and the scene: one by one where they are too few for a stream, or the
/// stack has no room for one, as below nested scenes.
fn trace_many<A: Answers>(scene: &SceneView, rays: &[SceneRay], answers: A) {
    if cfg!(target_os = "none") || rays.len() < MIN_STREAM_RAYS || scene.levels() > 0 {
        dispatch(scene.isa(), TraceAll { scene, rays, answers });
    } else {
        dispatch(scene.isa(), StreamAll { scene, rays, answers });
    }
}
