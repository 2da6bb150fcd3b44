//! All hits of a ray, not just the nearest: in no order, in order, or only counted.
//!
//! The order is by `t`, and among equal ones by `prim_id`; each triangle comes once. A ray through an edge or a corner
//! that triangles share hits all of them, at about the same `t`: whether a point is inside of a mesh cannot be told by
//! counting these.

use core::iter::FusedIterator;
use core::ops::ControlFlow;

use crate::bvh::BvhView;
use crate::geometry::{Hit, Ray};
use crate::traverse::collector::Collector;

impl<'a> BvhView<'a> {
    /// Gives `visit` every hit of `ray`, in the order of [`Verdict`](super::Verdict), until it breaks off; returns
    /// whether it did.
    pub fn for_each_hit(&self, ray: &Ray, visit: impl FnMut(&Hit) -> ControlFlow<()>) -> ControlFlow<()> {
        let mut all = Each { t_max: ray.t_max, visit, flow: ControlFlow::Continue(()) };
        self.collect(ray, &mut all);
        all.flow
    }

    /// How many triangles `ray` hits.
    pub fn count_hits(&self, ray: &Ray) -> usize {
        let mut count = 0;
        let _ = self.for_each_hit(ray, |_| {
            count += 1;
            ControlFlow::Continue(())
        });
        count
    }

    /// Writes the nearest hits of `ray`, as many as there are and as `hits` has room for, nearest first, and gives
    /// their number. The rest of `hits` is unspecified.
    ///
    /// The search skips everything behind the last of them.
    pub fn nearest_hits(&self, ray: &Ray, hits: &mut [Hit]) -> usize {
        self.nearest_after(ray, &Hit::BEFORE_ALL, hits)
    }

    /// The hits of `ray`, nearest first. They are found 16 at a time, in a search each.
    pub fn hits(&self, ray: &Ray) -> Hits<'a> {
        Hits { tree: *self, ray: *ray, last: Hit::BEFORE_ALL, found: [Hit::MISS; BATCH], next: BATCH, len: BATCH }
    }

    /// The hit that `n` others precede: 0 asks for the nearest one. Takes a search for every 16.
    pub fn nth_hit(&self, ray: &Ray, n: usize) -> Option<Hit> {
        self.hits(ray).nth(n)
    }

    /// [`nearest_hits`](Self::nearest_hits) of those that `last` precedes.
    fn nearest_after(&self, ray: &Ray, last: &Hit, hits: &mut [Hit]) -> usize {
        if hits.is_empty() {
            return 0;
        }
        let mut nearest = NearestHits { t_max: ray.t_max, last: *last, hits, len: 0 };
        self.collect(ray, &mut nearest);
        nearest.len
    }
}

impl Hit {
    /// Precedes every hit.
    const BEFORE_ALL: Self = Self { t: f32::NEG_INFINITY, prim_id: 0, ..Self::MISS };
}

/// Shows every hit.
struct Each<F> {
    t_max: f32,
    visit: F,
    flow: ControlFlow<()>,
}

impl<F: FnMut(&Hit) -> ControlFlow<()>> Collector for Each<F> {
    #[inline(always)]
    fn t_max(&self) -> f32 {
        self.t_max
    }

    #[inline(always)]
    fn report(&mut self, hit: Hit, _front: bool) -> ControlFlow<()> {
        self.flow = (self.visit)(&hit);
        self.flow
    }
}

/// The nearest hits that `last` precedes, in order.
struct NearestHits<'h> {
    /// The ray's, then that of the last hit that there is room for.
    t_max: f32,
    last: Hit,
    hits: &'h mut [Hit],
    len: usize,
}

impl Collector for NearestHits<'_> {
    #[inline(always)]
    fn t_max(&self) -> f32 {
        self.t_max
    }

    #[inline(always)]
    fn report(&mut self, hit: Hit, _front: bool) -> ControlFlow<()> {
        if self.last.precedes(&hit) {
            self.insert(hit);
        }
        ControlFlow::Continue(())
    }
}

impl NearestHits<'_> {
    /// Inserts a hit in order; the last one is dropped if there is no more room.
    fn insert(&mut self, hit: Hit) {
        let place =
            self.hits.iter().take(self.len).rposition(|other| other.precedes(&hit)).map_or(0, |before| before + 1);
        self.len = self.hits.len().min(self.len + 1);
        // None if it is as near as the last one, and comes after it.
        if let Some(behind @ [_, ..]) = self.hits.get_mut(place..self.len) {
            behind.rotate_right(1);
            behind[0] = hit;
        }
        if let Some(last) = self.hits.last().filter(|_| self.len == self.hits.len()) {
            self.t_max = last.t;
        }
    }
}

/// Hits that one search of [`Hits`] finds.
const BATCH: usize = 16;

/// All hits of a ray, nearest first; returned by [`BvhView::hits`].
#[derive(Clone, Debug)]
pub struct Hits<'a> {
    tree: BvhView<'a>,
    ray: Ray,
    /// The last hit found.
    last: Hit,
    found: [Hit; BATCH],
    /// The first of the found hits that has not been returned yet.
    next: usize,
    /// The number of found hits.
    len: usize,
}

impl Iterator for Hits<'_> {
    type Item = Hit;

    fn next(&mut self) -> Option<Hit> {
        if self.next == BATCH {
            self.len = self.tree.nearest_after(&self.ray, &self.last, &mut self.found);
            self.next = 0;
            self.last = self.found[BATCH - 1];
            self.ray.t_min = self.ray.t_min.max(self.last.t);
        }
        let hit = *self.found.get(self.next..self.len)?.first()?;
        self.next += 1;
        Some(hit)
    }
}

impl FusedIterator for Hits<'_> {}
