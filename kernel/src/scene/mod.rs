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
//! counts, then the lowest `prim_id`, then the lowest indices of `instances`. So what is hit does not depend on the order of
//! the tree, and is equal bit for bit on every instruction set and to the loop in [`mod@reference`].
//!
//! The [numeric limits](crate#numeric-limits) hold in every space: where a transform takes a ray beyond them, it hits nothing
//! there.
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
pub use item::{Item, Object};
pub use quad::Quads;
pub use ray::{MAX_LEVELS, SceneHit, SceneRay};
pub use shape::Shape;
pub use sphere::{Sphere, Spheres};
pub use transform::MAX_CONDITION;
pub use view::{Part, SceneView};

use crate::simd::{Level, Simd, Work, dispatch};
use crate::traverse::{Pending, Verdict};
use walk::{Search, Visit};

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
    pub fn intersect_filtered(&self, ray: &SceneRay, filter: impl FnMut(&SceneHit) -> Verdict) -> Option<SceneHit> {
        match self.isa().level() {
            Level::Scalar => reference::intersect_filtered(self, ray, filter),
            _ => {
                let mut search = Search::new(ray, filter);
                dispatch(self.isa(), One { scene: self, ray, search: &mut search });
                search.found()
            }
        }
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
        let results = rays.iter().zip(hits);
        self.each(results, Verdict::Accept, |hit, found| *hit = found.unwrap_or(SceneHit::MISS));
    }

    /// Writes for each ray whether it hits anything. Of slices of unequal length the ends are left alone.
    pub fn occluded_many(&self, rays: &[SceneRay], occluded: &mut [bool]) {
        let results = rays.iter().zip(occluded);
        self.each(results, Verdict::Stop, |occluded, found| *occluded = found.is_some());
    }

    /// Traces each ray with the same verdict on all hits, and has the result written.
    fn each<'a, T: 'a>(
        &self,
        rays: impl Iterator<Item = (&'a SceneRay, &'a mut T)>,
        verdict: Verdict,
        write: impl Fn(&mut T, Option<SceneHit>),
    ) {
        match self.isa().level() {
            Level::Scalar => {
                rays.for_each(|(ray, result)| write(result, reference::intersect_filtered(self, ray, |_| verdict)));
            }
            _ => dispatch(self.isa(), Many { scene: self, rays, verdict, write }),
        }
    }
}

struct One<'a, F> {
    scene: &'a SceneView<'a>,
    ray: &'a SceneRay,
    search: &'a mut Search<F>,
}

impl<F: FnMut(&SceneHit) -> Verdict> Work for One<'_, F> {
    type Output = ();
    #[inline(always)]
    fn run<S: Simd>(self) {
        let mut pending = Pending::EMPTY;
        Visit::outermost(self.scene, self.ray, self.search, &mut pending).trace::<S>();
    }
}

struct Many<'a, R, W> {
    scene: &'a SceneView<'a>,
    rays: R,
    verdict: Verdict,
    write: W,
}

impl<'a, T: 'a, R, W> Work for Many<'_, R, W>
where
    R: Iterator<Item = (&'a SceneRay, &'a mut T)>,
    W: Fn(&mut T, Option<SceneHit>),
{
    type Output = ();
    #[inline(always)]
    fn run<S: Simd>(self) {
        let mut pending = Pending::EMPTY;
        let verdict = self.verdict;
        for (ray, result) in self.rays {
            let mut search = Search::new(ray, |_: &SceneHit| verdict);
            Visit::outermost(self.scene, ray, &mut search, &mut pending).trace::<S>();
            (self.write)(result, search.found());
        }
    }
}
