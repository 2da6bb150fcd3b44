//! One ray on its way through the tree: a step at a time against the eight boxes of a node, or the eight triangles of a
//! block. What becomes of the hits, a [`Collector`] decides.
//!
//! Children are visited in the order that each node keeps for the octant of the ray's direction, blocks and triangles in
//! that of memory. Backends round boxes differently, and so may visit subtrees that others leave out, but there are no
//! hits in those: the hits that a collector sees, and their order, are the same on all.

use core::ops::ControlFlow;

use super::pending::{Pending, corners};
use crate::bvh::{BvhView, Child, TriangleBlock, WIDTH};
use crate::geometry::setup::{Axis, RaySetup};
use crate::geometry::triangle::{self, LineLanes};
use crate::geometry::{Hit, Ray};
use crate::simd::{Lanes, Mask, Simd, lanes_of};

/// What becomes of the hits that a ray finds.
pub(crate) trait Collector {
    /// Hits with a greater `t` are of no interest. It starts at the ray's `t_max` or less, and never grows.
    fn t_max(&self) -> f32;

    /// Sees a hit between the ray's `t_min` and [`t_max`](Self::t_max), and whether it is from the front. `Break` ends
    /// the search.
    fn see(&mut self, hit: Hit, front: bool) -> ControlFlow<()>;
}

/// The nearest hit; with `ANY` the first one seen.
struct Nearest<const ANY: bool> {
    best: Hit,
}

impl<const ANY: bool> Collector for Nearest<ANY> {
    #[inline(always)]
    fn t_max(&self) -> f32 {
        self.best.t
    }

    #[inline(always)]
    fn see(&mut self, hit: Hit, _front: bool) -> ControlFlow<()> {
        if hit.precedes(&self.best) {
            self.best = hit;
        }
        if ANY { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }
}

/// The nearest hit of one ray, or with `ANY` the first one found.
#[inline(always)]
pub(super) fn trace<const ANY: bool, S: Simd>(tree: &BvhView, ray: &Ray) -> Option<Hit> {
    let mut nearest = Nearest::<ANY> { best: Hit::none_before(ray.t_max) };
    // Whether it was ended early does not matter.
    let _ = walk::<S, _>(tree, ray, &mut nearest);
    nearest.best.found()
}

/// Shows `collector` the hits of one ray, each at most once, and all that are not behind the collector's `t_max` at
/// their turn. `Break` if the collector ended it.
#[inline(always)]
pub(crate) fn walk<S: Simd, C: Collector>(tree: &BvhView, ray: &Ray, collector: &mut C) -> ControlFlow<()> {
    let Some(RaySetup { slabs, line }) = RaySetup::new(ray, &tree.bounds()) else {
        return ControlFlow::Continue(());
    };
    let (octant, lanes) = (slabs.octant(), LineLanes::<S::F8>::splat(&line));
    let mut pending = Pending::EMPTY;
    pending.start();
    loop {
        let (child, near) = pending.take();
        if child == Pending::NONE {
            return ControlFlow::Continue(());
        }
        // A nearer hit may have been found since. As near is not nearer: there may be a tie to decide.
        let t_max = collector.t_max();
        if near > t_max {
            continue;
        }
        if Child::is_node(child) {
            if let Some(node) = tree.nodes().get(child as usize) {
                pending.enter::<S>(node, &slabs, octant, ray.t_min, t_max);
            }
        } else {
            for block in tree.blocks().get(Child::leaf_blocks(child)).unwrap_or(&[]) {
                hit_block(block, &lanes, line.axes, ray.t_min, collector)?;
            }
        }
    }
}

/// Shows `collector` the hits with the triangles of one block.
#[inline(always)]
fn hit_block<L: Lanes<WIDTH>, C: Collector>(
    block: &TriangleBlock,
    ray: &LineLanes<L>,
    axes: [Axis; 3],
    t_min: f32,
    collector: &mut C,
) -> ControlFlow<()> {
    let Some(crossing) = triangle::cross(ray, corners(block, axes)) else {
        return ControlFlow::Continue(());
    };
    let within = L::splat(t_min).le(crossing.t) & crossing.t.le(L::splat(collector.t_max()));
    let bits = within.bits() & crossing.bits;
    if bits == 0 {
        return ControlFlow::Continue(());
    }
    let (t, u, v) = (crossing.t.store(), crossing.u.store(), crossing.v.store());
    for lane in lanes_of(bits) {
        // The lanes before this one may have lowered it.
        if t[lane] <= collector.t_max() {
            let hit = Hit { t: t[lane], u: u[lane], v: v[lane], prim_id: block.prim_id[lane] };
            collector.see(hit, crossing.front >> lane & 1 != 0)?;
        }
    }
    ControlFlow::Continue(())
}
