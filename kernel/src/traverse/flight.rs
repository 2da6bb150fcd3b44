//! One ray on its way through the tree: a step at a time against the eight boxes of a node, or the eight triangles of a
//! block. What becomes of the hits, a [`Collector`] decides.
//!
//! Children are visited in the order that each node keeps for the octant of the ray's direction, blocks and triangles in
//! that of memory. Backends round boxes differently, and so may visit subtrees that others leave out, but there are no
//! hits in those: the hits that a collector sees, and their order, are the same on all.

use core::ops::{ControlFlow, Range};

use super::pending::{Pending, corners, first_octant};
use crate::bvh::{BvhView, Child, TriangleBlock, WIDTH};
use crate::geometry::setup::{Axis, RaySetup, Slabs};
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

/// The nearest hit.
pub(super) struct Nearest {
    pub(super) best: Hit,
}

impl Collector for Nearest {
    #[inline(always)]
    fn t_max(&self) -> f32 {
        self.best.t
    }

    #[inline(always)]
    fn see(&mut self, hit: Hit, _front: bool) -> ControlFlow<()> {
        if hit.precedes(&self.best) {
            self.best = hit;
        }
        ControlFlow::Continue(())
    }
}

/// The nearest hit of one ray, or with `ANY` one that stands for any.
#[inline(always)]
pub(super) fn trace<const ANY: bool, S: Simd>(tree: &BvhView, ray: &Ray) -> Option<Hit> {
    let mut pending = Pending::EMPTY;
    if ANY {
        return is_occluded::<S>(tree, ray, &mut pending).then(|| Hit::any_if(true));
    }
    let mut nearest = Nearest { best: Hit::none_before(ray.t_max) };
    // This collector never breaks off.
    let _ = walk::<S, _>(tree, ray, &mut pending, &mut nearest);
    nearest.best.found()
}

#[inline(always)]
fn is_occluded<S: Simd>(tree: &BvhView, ray: &Ray, pending: &mut Pending) -> bool {
    let Some(RaySetup { slabs, line }) = RaySetup::new(ray, &tree.bounds()) else {
        return false;
    };
    let interval = [S::F8::splat(ray.t_min), S::F8::splat(ray.t_max)];
    let mut occluders = Occluders { tree, lanes: LineLanes::splat(&line), axes: line.axes, interval, t_max: ray.t_max };
    descend::<S, _>(&mut occluders, &slabs, ray.t_min, pending).is_break()
}

/// Shows `collector` the hits of one ray, each at most once, and all that are not behind the collector's `t_max` at
/// their turn. `Break` if the collector ended it. `pending` is memory, whatever is in it.
#[inline(always)]
pub(crate) fn walk<S: Simd, C: Collector>(
    tree: &BvhView,
    ray: &Ray,
    pending: &mut Pending,
    collector: &mut C,
) -> ControlFlow<()> {
    let Some(RaySetup { slabs, line }) = RaySetup::new(ray, &tree.bounds()) else {
        return ControlFlow::Continue(());
    };
    let lanes = LineLanes::<S::F8>::splat(&line);
    descend::<S, _>(
        &mut Triangles { tree, lanes, axes: line.axes, t_min: ray.t_min, collector },
        &slabs,
        ray.t_min,
        pending,
    )
}

/// What a ray descends through: nodes, and what is in their leaves.
pub(crate) trait Ground {
    /// What has a greater `t` is of no interest.
    fn t_max(&self) -> f32;

    /// [Enters](Pending::enter) the node of this index.
    fn enter<S: Simd>(&self, node: u32, pending: &mut Pending, slabs: &Slabs, octant: u8, t_min: f32);

    /// Looks at a leaf's blocks. `Break` ends the search.
    fn look<S: Simd>(&mut self, blocks: Range<usize>) -> ControlFlow<()>;
}

/// Takes a ray through a tree, roughly from near to far.
#[inline(always)]
pub(crate) fn descend<S: Simd, G: Ground>(
    ground: &mut G,
    slabs: &Slabs,
    t_min: f32,
    pending: &mut Pending,
) -> ControlFlow<()> {
    let octant = slabs.octant();
    pending.start();
    loop {
        let (child, near) = pending.take();
        if child == Pending::NONE {
            return ControlFlow::Continue(());
        }
        // A nearer hit may have been found since. As near is not nearer: there may be a tie to decide.
        if near > ground.t_max() {
            continue;
        }
        if Child::is_node(child) {
            ground.enter::<S>(child, pending, slabs, octant, t_min);
        } else {
            ground.look::<S>(Child::leaf_blocks(child))?;
        }
    }
}

/// Triangles that stand still, and who hears of the hits.
struct Triangles<'a, L, C> {
    tree: &'a BvhView<'a>,
    lanes: LineLanes<L>,
    axes: [Axis; 3],
    t_min: f32,
    collector: &'a mut C,
}

impl<L: Lanes<WIDTH>, C: Collector> Ground for Triangles<'_, L, C> {
    #[inline(always)]
    fn t_max(&self) -> f32 {
        self.collector.t_max()
    }

    #[inline(always)]
    fn enter<S: Simd>(&self, node: u32, pending: &mut Pending, slabs: &Slabs, octant: u8, t_min: f32) {
        if let Some(node) = self.tree.nodes().get(node as usize) {
            pending.enter::<S>(node, slabs, octant, t_min, self.t_max());
        }
    }

    #[inline(always)]
    fn look<S: Simd>(&mut self, blocks: Range<usize>) -> ControlFlow<()> {
        for block in self.tree.blocks().get(blocks).unwrap_or(&[]) {
            hit_block(block, &self.lanes, self.axes, self.t_min, self.collector)?;
        }
        ControlFlow::Continue(())
    }
}

/// Triangles that stand still, of which any that is hit ends the search.
struct Occluders<'a, L> {
    tree: &'a BvhView<'a>,
    lanes: LineLanes<L>,
    axes: [Axis; 3],
    interval: [L; 2],
    t_max: f32,
}

impl<L: Lanes<WIDTH>> Ground for Occluders<'_, L> {
    #[inline(always)]
    fn t_max(&self) -> f32 {
        self.t_max
    }

    #[inline(always)]
    fn enter<S: Simd>(&self, node: u32, pending: &mut Pending, slabs: &Slabs, octant: u8, t_min: f32) {
        if let Some(node) = self.tree.nodes().get(node as usize) {
            pending.enter::<S>(node, slabs, first_octant::<true>(octant), t_min, self.t_max);
        }
    }

    #[inline(always)]
    fn look<S: Simd>(&mut self, blocks: Range<usize>) -> ControlFlow<()> {
        for block in self.tree.blocks().get(blocks).unwrap_or(&[]) {
            if triangle::occludes(&self.lanes, corners(block, self.axes), self.interval) != 0 {
                return ControlFlow::Break(());
            }
        }
        ControlFlow::Continue(())
    }
}

/// Shows `collector` the hits with the triangles of one block.
#[inline(always)]
pub(super) fn hit_block<L: Lanes<WIDTH>, C: Collector>(
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
