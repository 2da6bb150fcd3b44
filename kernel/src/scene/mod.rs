//! Scenes: triangles, geometry of the caller's and other scenes, each where a transform puts it, standing still or moving.
//!
//! | rays | closest hit | any hit |
//! | --- | --- | --- |
//! | one | [`SceneView::intersect`] | [`SceneView::occluded`] |
//! | a slice | [`SceneView::intersect_many`] | [`SceneView::occluded_many`] |
//! | one, with a filter | [`SceneView::intersect_filtered`] | [`SceneView::occluded_filtered`] |
//!
//! An [`Item`] is an object and its place. Objects are borrowed: ten thousand items may be the same million triangles. A
//! [`Scene`] has a tree over its items' boxes, and may be an object in another.
//!
//! # What a hit is
//! The ray is taken into the item's own space by the inverse of its transform, in `f64`, rounded once, and is there what it
//! would be in a tree of its own: the hit is that of [`BvhView::intersect`](crate::BvhView::intersect) with that local ray. Its
//! direction is not normalised, so that `t` is the same in all spaces. Of equally near hits that with the lowest `geometry_id`
//! counts, then the lowest `prim_id`, then the lowest `path`. So what is hit does not depend on the order of
//! the tree, and is equal bit for bit on every instruction set and to the loop in [`mod@reference`].
//!
//! The [numeric limits](crate#numeric-limits) hold in every space: where a transform takes a ray beyond them, it hits nothing
//! there.
//!
//! # Instances
//! A scene has a path for itself and those of each scene in it, as often as that is in it. They are numbered depth first: those
//! through the first item, those through the second and so on, and last the scene's own. So one number says which items a
//! hit lies in, however deep. Tracing recurses once a level, with some 3 KB of stack each; how deep that will be
//! [`SceneView::levels`] says.
//!
//! # Motion
//! Times are 0..=1; what lies beyond counts as the nearer end, and at a time that is NaN a ray hits nothing. What moves has
//! keys, evenly spaced over that time: triangles ([`MovingView`](crate::bvh::MovingView)), whose corners are interpolated as
//! `(1 - f) a + f b` with each operation rounded, and items ([`Item::moving`]), whose transform's elements are. At a key
//! both are exactly what stands still there. A scene's tree has as many keys as the item that has most; its boxes are
//! interpolated, and an item whose own keys do not fall on the tree's has one box around all places that it gets to.
//!
//! Nothing here allocates or panics while tracing.

#[cfg(any(feature = "alloc", test))]
mod build;
mod inverse;
mod item;
mod quad;
mod ray;
pub mod reference;
mod shape;
mod sphere;
#[cfg(test)]
mod tests;
mod transform;
mod view;
mod walk;

#[cfg(any(feature = "alloc", test))]
pub use build::Scene;
pub use inverse::MAX_CONDITION;
pub use item::{Item, Object};
pub use quad::Quads;
pub use ray::{SceneHit, SceneRay};
pub use shape::Shape;
pub use sphere::{Sphere, Spheres};
pub use view::{Instances, Part, SceneView};

use core::slice;

use crate::simd::{Level, dispatch};
use crate::traverse::Verdict;
use walk::Trace;

impl SceneView<'_> {
    /// The nearest hit of `ray`; which of equally near ones, the [module](self) says.
    pub fn intersect(&self, ray: &SceneRay) -> Option<SceneHit> {
        self.intersect_filtered(ray, |_| Verdict::Accept)
    }

    /// Whether `ray` hits anything: `intersect(ray).is_some()`, but quicker.
    pub fn occluded(&self, ray: &SceneRay) -> bool {
        self.intersect_filtered(ray, |_| Verdict::Stop).is_some()
    }

    /// The nearest hit of `ray` that `filter` accepts. If the filter stops the search, the hit that it stopped at.
    ///
    /// The filter sees those hits that precede the nearest one accepted so far: each triangle and each primitive of a
    /// shape at most once for each way to it, roughly from near to far. The order is the same on all instruction sets but
    /// [`Isa::SCALAR`](crate::Isa::SCALAR).
    pub fn intersect_filtered(&self, ray: &SceneRay, mut filter: impl FnMut(&SceneHit) -> Verdict) -> Option<SceneHit> {
        let mut result = None;
        self.trace(slice::from_ref(ray), &mut filter, &mut |_, found| result = found);
        result
    }

    /// Whether `ray` hits anything that `filter` accepts: `intersect_filtered(ray, filter).is_some()`, but quicker. The
    /// filter sees the ray's hits up to the first that it accepts or stops at.
    pub fn occluded_filtered(&self, ray: &SceneRay, mut filter: impl FnMut(&SceneHit) -> Verdict) -> bool {
        let stop = |hit: &SceneHit| match filter(hit) {
            Verdict::Reject => Verdict::Reject,
            Verdict::Accept | Verdict::Stop => Verdict::Stop,
        };
        self.intersect_filtered(ray, stop).is_some()
    }

    /// Writes the nearest hit of each ray, or [`SceneHit::MISS`]. Of slices of unequal length the ends are left alone.
    pub fn intersect_many(&self, rays: &[SceneRay], hits: &mut [SceneHit]) {
        let rays = &rays[..rays.len().min(hits.len())];
        self.trace(rays, &mut |_| Verdict::Accept, &mut |number, found| hits[number] = found.unwrap_or(SceneHit::MISS));
    }

    /// Writes for each ray whether it hits anything. Of slices of unequal length the ends are left alone.
    pub fn occluded_many(&self, rays: &[SceneRay], occluded: &mut [bool]) {
        let rays = &rays[..rays.len().min(occluded.len())];
        self.trace(rays, &mut |_| Verdict::Stop, &mut |number, found| occluded[number] = found.is_some());
    }

    /// Traces rays, and has `write` hear of the result of each, by its number.
    fn trace(
        &self,
        rays: &[SceneRay],
        filter: &mut dyn FnMut(&SceneHit) -> Verdict,
        write: &mut dyn FnMut(usize, Option<SceneHit>),
    ) {
        match self.isa().level() {
            Level::Scalar => rays.iter().enumerate().for_each(|(number, ray)| {
                write(number, reference::intersect_filtered(self, ray, &mut *filter));
            }),
            _ => dispatch(self.isa(), Trace { scene: self, rays, filter, write }),
        }
    }
}
