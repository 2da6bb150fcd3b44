//! Searches with a filter that decides which hits count: for cut-out leaves, the triangle that a ray leaves,
//! selections. Of one ray, or of many as a stream.
//!
//! A search never passes a triangle to its filter twice, as every triangle is in one leaf. [`Verdict`] and the two
//! searches define which hits it passes, and in which order.

use core::ops::ControlFlow;

use crate::bvh::BvhView;
use crate::geometry::{Hit, Ray};
use crate::simd::{Level, Simd, Work, dispatch};
use crate::traverse::collector::Collector;
use crate::traverse::stream::{self, HitFilter};
use crate::traverse::{write_hits, write_occluded};

/// A filter's decision about a hit.
///
/// A filter sees the hits with each triangle at most once. They come in the order of the tree for the octant of the
/// ray's direction: roughly from near to far, not that of `t`, and the same on every instruction set. So where the
/// verdict depends on the hit alone and is never [`Stop`](Self::Stop), the result depends on the triangles alone, as
/// without a filter; what is stopped at depends on the tree too.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// The hit counts.
    Accept,
    /// The hit does not count: the ray passes through the triangle.
    Reject,
    /// The hit counts and ends the search, even if there are nearer ones.
    Stop,
}

impl BvhView<'_> {
    /// The nearest hit of `ray` that `filter` accepts; among equally near ones that of the lowest `prim_id`. If the
    /// filter stops the search, the hit that it stopped at.
    ///
    /// The filter sees those hits that are nearer than the nearest one accepted so far (or as near, with a lower
    /// `prim_id`): once each, in the order of [`Verdict`].
    pub fn intersect_filtered(&self, ray: &Ray, filter: impl FnMut(&Hit) -> Verdict) -> Option<Hit> {
        let mut nearest = Filtered { best: Hit::none_before(ray.t_max), filter };
        self.collect(ray, &mut nearest);
        nearest.best.found()
    }

    /// Whether `ray` hits anything that `filter` accepts: `intersect_filtered(ray, filter).is_some()`, but faster.
    ///
    /// The filter sees the ray's hits, once each and in the order of [`Verdict`], up to the first
    /// that it accepts or stops at.
    pub fn occluded_filtered(&self, ray: &Ray, mut filter: impl FnMut(&Hit) -> Verdict) -> bool {
        let stop = |hit: &Hit| match filter(hit) {
            Verdict::Reject => Verdict::Reject,
            Verdict::Accept | Verdict::Stop => Verdict::Stop,
        };
        self.intersect_filtered(ray, stop).is_some()
    }
}

impl BvhView<'_> {
    /// Writes the nearest hit of each ray that `accepts` takes, or [`Hit::MISS`]: the result of
    /// [`intersect_filtered`](Self::intersect_filtered) for each, traced as a stream. Elements beyond the end of the shorter
    /// slice are left unchanged.
    ///
    /// The filter sees a ray's index and a hit, in any order, perhaps twice, and must decide by these alone.
    pub fn intersect_many_filtered(&self, rays: &[Ray], hits: &mut [Hit], accepts: impl FnMut(usize, &Hit) -> bool) {
        let rays = &rays[..rays.len().min(hits.len())];
        self.trace_filtered::<false>(rays, By(accepts), write_hits(hits));
    }

    /// Writes for each ray whether it has a hit that `accepts` takes, likewise: the result of
    /// [`occluded_filtered`](Self::occluded_filtered).
    pub fn occluded_many_filtered(
        &self,
        rays: &[Ray],
        occluded: &mut [bool],
        accepts: impl FnMut(usize, &Hit) -> bool,
    ) {
        let rays = &rays[..rays.len().min(occluded.len())];
        self.trace_filtered::<true>(rays, By(accepts), write_occluded(occluded));
    }

    fn trace_filtered<const ANY: bool>(
        &self,
        rays: &[Ray],
        mut filter: impl HitFilter,
        mut write: impl FnMut(usize, Hit),
    ) {
        let is_few = cfg!(target_os = "none") || rays.len() < stream::MIN_STREAM_RAYS;
        if is_few || self.isa().level() == Level::Scalar {
            for (index, ray) in rays.iter().enumerate() {
                write(index, filter.finish(self, (index, ray), Hit::none_before(ray.t_max), ANY).or_miss());
            }
        } else {
            dispatch(self.isa(), FilteredStream::<ANY, _, _> { tree: self, rays, filter, write });
        }
    }
}

struct FilteredStream<'a, const ANY: bool, F, W> {
    tree: &'a BvhView<'a>,
    rays: &'a [Ray],
    filter: F,
    write: W,
}

impl<const ANY: bool, F: HitFilter, W: FnMut(usize, Hit)> Work for FilteredStream<'_, ANY, F, W> {
    type Output = ();
    #[inline(always)]
    fn run<S: Simd>(self) {
        stream::trace_filtered::<ANY, S>(self.tree, self.rays, self.filter, self.write);
    }
}

/// A filter by a function.
struct By<F>(F);

impl<F: FnMut(usize, &Hit) -> bool> HitFilter for By<F> {
    const DECIDES: bool = true;

    #[inline(always)]
    fn accepts(&mut self, ray: usize, hit: &Hit) -> bool {
        (self.0)(ray, hit)
    }

    fn finish(&mut self, tree: &BvhView, (index, ray): (usize, &Ray), best: Hit, any: bool) -> Hit {
        let accepted = if any { Verdict::Stop } else { Verdict::Accept };
        let filter = |hit: &Hit| if (self.0)(index, hit) { accepted } else { Verdict::Reject };
        let mut nearest = Filtered { best, filter };
        if !(any && best.is_hit()) {
            tree.collect(ray, &mut nearest);
        }
        nearest.best
    }
}

/// The nearest hit that is accepted.
struct Filtered<F> {
    best: Hit,
    filter: F,
}

impl<F: FnMut(&Hit) -> Verdict> Collector for Filtered<F> {
    #[inline(always)]
    fn t_max(&self) -> f32 {
        self.best.t
    }

    #[inline(always)]
    fn report(&mut self, hit: Hit, _front: bool) -> ControlFlow<()> {
        if !hit.precedes(&self.best) {
            return ControlFlow::Continue(());
        }
        let verdict = (self.filter)(&hit);
        if verdict != Verdict::Reject {
            self.best = hit;
        }
        if verdict == Verdict::Stop { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }
}

// Miri would take hours.
#[cfg(all(test, not(miri)))]
mod tests {
    use alloc::vec::Vec;

    use super::*;
    use crate::geometry::intersect_triangle;
    use crate::simd::isas;
    use crate::traverse::reference;
    use crate::traverse::tests::{Random, rays_at, soup};
    use crate::{Bvh, Quality, Triangle};

    /// A verdict that looks arbitrary, and depends on the hit alone.
    fn verdict(hit: &Hit) -> Verdict {
        if (hit.prim_id ^ hit.u.to_bits() >> 9).is_multiple_of(3) { Verdict::Accept } else { Verdict::Reject }
    }

    /// All hits of `ray`, by a loop over all triangles.
    fn all_hits(triangles: &[Triangle], ray: &Ray) -> Vec<Hit> {
        let hit = |(prim_id, triangle)| intersect_triangle(ray, triangle).map(|hit| Hit { prim_id, ..hit });
        (0..).zip(triangles).filter_map(hit).collect()
    }

    #[test]
    fn the_nearest_accepted_hit_is_that_of_a_loop_and_of_every_instruction_set() {
        let mut random = Random(21);
        for (count, size) in [(1, 1.0), (9, 0.7), (80, 0.6), (500, 0.3)] {
            let triangles = soup(&mut random, count, size);
            let rays = rays_at(&triangles, &mut random, 40);
            for quality in Quality::ALL {
                let (bvh, _) = Bvh::build(&triangles, &quality.into()).unwrap();
                for ray in &rays {
                    let accepted = all_hits(&triangles, ray).into_iter().filter(|hit| verdict(hit) == Verdict::Accept);
                    let expected = accepted.min_by(|a, b| a.t.total_cmp(&b.t).then(a.prim_id.cmp(&b.prim_id)));
                    for isa in isas() {
                        let tree = bvh.view().with_isa(isa);
                        assert_eq!(tree.intersect_filtered(ray, verdict), expected, "{isa:?}");
                        assert_eq!(tree.occluded_filtered(ray, verdict), expected.is_some(), "{isa:?}");
                    }
                }
            }
        }
    }

    #[test]
    fn streams_find_what_single_rays_find() {
        let mut random = Random(25);
        for (count, size) in [(1, 1.0), (9, 0.7), (80, 0.6), (2000, 0.3)] {
            let triangles = soup(&mut random, count, size);
            let (bvh, _) = Bvh::build(&triangles, &Quality::High.into()).unwrap();
            for number in [0, 7, 24, 200, 500] {
                let rays: Vec<_> = rays_at(&triangles, &mut random, number).into_iter().take(number).collect();
                let rays = &rays[..];
                // Each ray has verdicts of its own.
                let accepts =
                    |ray: usize, hit: &Hit| !(ray as u32 ^ hit.prim_id ^ hit.u.to_bits() >> 9).is_multiple_of(3);
                let alone = |index: usize| {
                    let verdict = |hit: &Hit| if accepts(index, hit) { Verdict::Accept } else { Verdict::Reject };
                    bvh.view().intersect_filtered(&rays[index], verdict).unwrap_or(Hit::MISS)
                };
                let expected: Vec<Hit> = (0..rays.len()).map(alone).collect();
                for isa in isas() {
                    let tree = bvh.view().with_isa(isa);
                    let (mut hits, mut occluded) = (alloc::vec![Hit::MISS; rays.len()], alloc::vec![true; rays.len()]);
                    tree.intersect_many_filtered(rays, &mut hits, accepts);
                    assert_eq!(hits, expected, "{isa:?}, {count} triangles, {number} rays");
                    tree.occluded_many_filtered(rays, &mut occluded, accepts);
                    assert!(occluded.iter().eq(expected.iter().map(Hit::is_hit).collect::<Vec<_>>().iter()), "{isa:?}");
                }
            }
        }
    }

    /// In a stack of sheets that all rays cross, streams have no room for some, and the filter is asked for all.
    #[test]
    fn streams_pass_through_all_that_is_rejected() {
        let sheet =
            |z: u16| [[0.0, 0.0], [9.0, 0.0], [0.0, 9.0]].map(|[x, y]: [f32; 2]| glam::Vec3::new(x, y, f32::from(z)));
        let triangles: Vec<Triangle> = (0..400).map(sheet).collect();
        let (bvh, _) = Bvh::build(&triangles, &Quality::Fast.into()).unwrap();
        let from = |i: u16| glam::Vec3::new(0.01 * f32::from(i), 1.0, -1.0);
        let rays: Vec<Ray> = (0..100).map(|i| Ray::new(from(i), glam::Vec3::Z)).collect();
        let last = |ray: usize, hit: &Hit| hit.prim_id as usize >= 300 + ray % 100;
        for isa in isas() {
            let (mut hits, mut occluded) = ([Hit::MISS; 100], [false; 100]);
            let tree = bvh.view().with_isa(isa);
            tree.intersect_many_filtered(&rays, &mut hits, last);
            assert!((300..).zip(&hits).all(|(prim_id, hit)| hit.prim_id == prim_id), "{isa:?}");
            tree.occluded_many_filtered(&rays, &mut occluded, last);
            assert_eq!(occluded, [true; 100], "{isa:?}");
            tree.occluded_many_filtered(&rays, &mut occluded, |_, _| false);
            assert_eq!(occluded, [false; 100], "{isa:?}");
        }
    }

    #[test]
    fn filters_see_the_same_hits_in_the_same_order_everywhere() {
        let mut random = Random(22);
        let triangles = soup(&mut random, 300, 0.6);
        let rays = rays_at(&triangles, &mut random, 60);
        let (bvh, _) = Bvh::build(&triangles, &Quality::High.into()).unwrap();
        let mut full = 0;
        for ray in &rays {
            let mut expected: Option<(Vec<Hit>, Option<Hit>)> = None;
            for isa in isas() {
                let tree = bvh.view().with_isa(isa);
                let mut seen = Vec::new();
                let stopped = tree.intersect_filtered(ray, |hit| {
                    seen.push(*hit);
                    if seen.len() == 7 { Verdict::Stop } else { verdict(hit) }
                });
                // The seventh one, if there was one, is the result.
                assert!(seen.len() <= 7 && seen.get(6).is_none_or(|&seventh| stopped == Some(seventh)));
                full += usize::from(seen.len() == 7);
                let result = (seen, stopped);
                assert_eq!(*expected.get_or_insert_with(|| result.clone()), result, "{isa:?}");
            }
        }
        assert!(full > 40, "only {full} searches were stopped");
    }

    #[test]
    fn what_is_rejected_is_seen_once_and_nothing_is_left_out() {
        let mut random = Random(23);
        let triangles = soup(&mut random, 200, 0.8);
        let (bvh, _) = Bvh::build(&triangles, &Quality::High.into()).unwrap();
        for ray in rays_at(&triangles, &mut random, 40) {
            let mut seen = Vec::new();
            let none = bvh.view().occluded_filtered(&ray, |hit| {
                seen.push(*hit);
                Verdict::Reject
            });
            assert!(!none);
            seen.sort_unstable_by_key(|hit| hit.prim_id);
            assert_eq!(seen, all_hits(&triangles, &ray));
        }
    }

    #[test]
    fn accepting_all_is_no_filter_and_skipping_a_triangle_leaves_it() {
        let mut random = Random(24);
        let triangles = soup(&mut random, 100, 0.5);
        let (bvh, _) = Bvh::build(&triangles, &Quality::High.into()).unwrap();
        let tree = bvh.view();
        for ray in rays_at(&triangles, &mut random, 40) {
            let first = reference::intersect_all(&triangles, &ray);
            assert_eq!(tree.intersect_filtered(&ray, |_| Verdict::Accept), first);
            let mut others = triangles.clone();
            if let Some(first) = first {
                others[first.prim_id as usize] = [glam::Vec3::NAN; 3];
                let skip = |hit: &Hit| if hit.prim_id == first.prim_id { Verdict::Reject } else { Verdict::Accept };
                assert_eq!(tree.intersect_filtered(&ray, skip), reference::intersect_all(&others, &ray));
            }
        }
    }
}
