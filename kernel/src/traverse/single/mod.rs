//! The single-ray intersector: one ray against the eight boxes of a node, or the eight triangles of a block, at a time.
//! What becomes of the hits, a [`Collector`] decides.
//!
//! Children are visited in the order that each node keeps for the octant of the ray's direction, blocks and triangles in
//! that of memory. Backends round boxes differently, and so may visit subtrees that others leave out, but there are no
//! hits in those: the hits that a collector sees, and their order, are the same on all.

pub(crate) mod moving;

use core::ops::{ControlFlow, Range};

use super::collector::ClosestHit;
pub(crate) use super::collector::Collector;
use super::leaf_test::{corners, intersect_block};
use super::node_test::visit_octant;
use super::stack::TraversalStack;
use crate::bvh::{BvhView, Child, WIDTH};
use crate::geometry::setup::{Axis, RaySetup, Slabs};
use crate::geometry::triangle::{self, LineLanes};
use crate::geometry::{Hit, Ray};
use crate::simd::{Lanes, Simd};

/// The nearest hit of one ray, or with `ANY` one that stands for any.
#[inline(always)]
pub(super) fn trace<const ANY: bool, S: Simd>(tree: &BvhView, ray: &Ray) -> Option<Hit> {
    let mut stack = TraversalStack::EMPTY;
    if ANY {
        return is_occluded::<S>(tree, ray, &mut stack).then(|| Hit::any_if(true));
    }
    let mut nearest = ClosestHit { best: Hit::none_before(ray.t_max) };
    // This collector never breaks off.
    let _ = walk::<S, _>(tree, ray, &mut stack, &mut nearest);
    nearest.best.found()
}

#[inline(always)]
fn is_occluded<S: Simd>(tree: &BvhView, ray: &Ray, stack: &mut TraversalStack) -> bool {
    let Some(RaySetup { slabs, line }) = RaySetup::new(ray, &tree.bounds()) else {
        return false;
    };
    let interval = [S::F8::splat(ray.t_min), S::F8::splat(ray.t_max)];
    let mut occluders = Occluders { tree, lanes: LineLanes::splat(&line), axes: line.axes, interval, t_max: ray.t_max };
    traverse::<S, _>(&mut occluders, &slabs, ray.t_min, stack).is_break()
}

/// Shows `collector` the hits of one ray, each at most once, and all that are not behind the collector's `t_max` at
/// their turn. `Break` if the collector ended it. `stack` is memory, whatever is in it.
#[inline(always)]
pub(crate) fn walk<S: Simd, C: Collector>(
    tree: &BvhView,
    ray: &Ray,
    stack: &mut TraversalStack,
    collector: &mut C,
) -> ControlFlow<()> {
    let Some(RaySetup { slabs, line }) = RaySetup::new(ray, &tree.bounds()) else {
        return ControlFlow::Continue(());
    };
    let lanes = LineLanes::<S::F8>::splat(&line);
    traverse::<S, _>(
        &mut StillTriangles { tree, lanes, axes: line.axes, t_min: ray.t_min, collector },
        &slabs,
        ray.t_min,
        stack,
    )
}

/// How a ray meets a tree: the node test, and the test of what is in a leaf.
pub(crate) trait Intersector {
    /// What has a greater `t` is of no interest.
    fn t_max(&self) -> f32;

    /// Tests the node of this index, and [pushes](TraversalStack::push_children) the children that the ray meets.
    fn visit_node<S: Simd>(&self, node: u32, stack: &mut TraversalStack, slabs: &Slabs, octant: u8, t_min: f32);

    /// Tests what is in a leaf's blocks. `Break` ends the search.
    fn visit_leaf<S: Simd>(&mut self, blocks: Range<usize>) -> ControlFlow<()>;
}

/// Takes a ray through a tree, roughly from near to far.
#[inline(always)]
pub(crate) fn traverse<S: Simd, G: Intersector>(
    intersector: &mut G,
    slabs: &Slabs,
    t_min: f32,
    stack: &mut TraversalStack,
) -> ControlFlow<()> {
    let octant = slabs.octant();
    stack.reset_to_root();
    loop {
        let (child, near) = stack.pop();
        if child == TraversalStack::NONE {
            return ControlFlow::Continue(());
        }
        // A nearer hit may have been found since. As near is not nearer: there may be a tie to decide.
        if near > intersector.t_max() {
            continue;
        }
        if Child::is_node(child) {
            intersector.visit_node::<S>(child, stack, slabs, octant, t_min);
        } else {
            intersector.visit_leaf::<S>(Child::leaf_blocks(child))?;
        }
    }
}

/// Triangles that stand still, and who hears of the hits.
struct StillTriangles<'a, L, C> {
    tree: &'a BvhView<'a>,
    lanes: LineLanes<L>,
    axes: [Axis; 3],
    t_min: f32,
    collector: &'a mut C,
}

impl<L: Lanes<WIDTH>, C: Collector> Intersector for StillTriangles<'_, L, C> {
    #[inline(always)]
    fn t_max(&self) -> f32 {
        self.collector.t_max()
    }

    #[inline(always)]
    fn visit_node<S: Simd>(&self, node: u32, stack: &mut TraversalStack, slabs: &Slabs, octant: u8, t_min: f32) {
        if let Some(node) = self.tree.nodes().get(node as usize) {
            stack.push_children::<S>(node, slabs, octant, t_min, self.t_max());
        }
    }

    #[inline(always)]
    fn visit_leaf<S: Simd>(&mut self, blocks: Range<usize>) -> ControlFlow<()> {
        for block in self.tree.blocks().get(blocks).unwrap_or(&[]) {
            intersect_block(block, &self.lanes, self.axes, self.t_min, self.collector)?;
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

impl<L: Lanes<WIDTH>> Intersector for Occluders<'_, L> {
    #[inline(always)]
    fn t_max(&self) -> f32 {
        self.t_max
    }

    #[inline(always)]
    fn visit_node<S: Simd>(&self, node: u32, stack: &mut TraversalStack, slabs: &Slabs, octant: u8, t_min: f32) {
        if let Some(node) = self.tree.nodes().get(node as usize) {
            stack.push_children::<S>(node, slabs, visit_octant::<true>(octant), t_min, self.t_max);
        }
    }

    #[inline(always)]
    fn visit_leaf<S: Simd>(&mut self, blocks: Range<usize>) -> ControlFlow<()> {
        for block in self.tree.blocks().get(blocks).unwrap_or(&[]) {
            if triangle::occludes(&self.lanes, corners(block, self.axes), self.interval) != 0 {
                return ControlFlow::Break(());
            }
        }
        ControlFlow::Continue(())
    }
}
