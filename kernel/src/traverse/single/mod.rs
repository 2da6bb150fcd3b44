//! The single-ray intersector: one ray against the eight boxes of a node, or the eight triangles of a block, at a time.
//! What becomes of the hits, a [`Collector`] decides.
//!
//! Children are visited in the order that each node keeps for the octant of the ray's direction, blocks and triangles
//! in that of memory. Backends round boxes differently, and so may visit subtrees that others leave out, but there are
//! no hits in those: the hits that a collector sees, and their order, are the same on all.

mod any;
mod closest;
pub(crate) mod moving;
pub(crate) mod round;

use core::ops::{ControlFlow, Range};

pub(crate) use super::collector::Collector;
use super::leaf_test::intersect_block;
use super::stack::TraversalStack;
use crate::bvh::{BvhView, Child, WIDTH};
use crate::geometry::setup::{Axis, RaySetup, Slabs};
use crate::geometry::triangle::LineLanes;
use crate::geometry::{Hit, Ray};
use crate::simd::{Lanes, Simd, Work, dispatch};

/// The nearest hit of one ray, or with `ANY` one that stands for any.
#[inline(always)]
pub(super) fn trace<const ANY: bool, S: Simd>(tree: &BvhView, ray: &Ray) -> Option<Hit> {
    if ANY {
        any::trace::<S>(tree, ray).then(|| Hit::any_if(true))
    } else {
        closest::trace::<S>(tree, ray, Hit::none_before(ray.t_max)).found()
    }
}

/// The nearest hit of `ray`, if it precedes `best`; else `best`.
#[inline(always)]
pub(crate) fn closest<S: Simd>(tree: &BvhView, ray: &Ray, best: Hit) -> Hit {
    closest::trace::<S>(tree, ray, best)
}

/// Whether `ray` hits anything.
#[inline(always)]
pub(crate) fn occluded<S: Simd>(tree: &BvhView, ray: &Ray) -> bool {
    any::trace::<S>(tree, ray)
}

/// Finishes the search of a ray of which `best` has been found so far, from the root.
pub(super) fn finish(tree: &BvhView, ray: &Ray, best: Hit, any: bool) -> Hit {
    dispatch(tree.isa(), Finish { tree, ray, best, any })
}

struct Finish<'a> {
    tree: &'a BvhView<'a>,
    ray: &'a Ray,
    best: Hit,
    any: bool,
}

impl Work for Finish<'_> {
    type Output = Hit;
    #[inline(always)]
    fn run<S: Simd>(self) -> Hit {
        if self.any {
            Hit::any_if(self.best.is_hit() || any::trace::<S>(self.tree, self.ray))
        } else {
            closest::trace::<S>(self.tree, self.ray, self.best)
        }
    }
}

/// Shows `collector` the hits of one ray, each at most once, and all that are not behind the collector's `t_max` at
/// their turn. `Break` if the collector ended it. `stack` is memory with any contents.
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
    let lanes = LineLanes::<S::F8>::splat(&line.numbers);
    traverse::<S, _>(
        &mut StillTriangles { tree, lanes, axes: line.axes, t_min: ray.t_min, collector },
        &slabs,
        ray.t_min,
        stack,
    )
}

/// How a ray meets a tree: the node test, and the test of what is in a leaf.
pub(crate) trait Intersector {
    /// Primitives with a greater `t` are ignored.
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
        let Some((child, near)) = stack.pop() else { return ControlFlow::Continue(()) };
        // A nearer hit may have been found since. Equal distances are kept: ties are decided by `prim_id`.
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

/// Triangles that stand still, and the collector of the hits.
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
        stack.push_children_of::<S>(self.tree.nodes(), node, slabs, octant, (t_min, self.t_max()));
    }

    #[inline(always)]
    fn visit_leaf<S: Simd>(&mut self, blocks: Range<usize>) -> ControlFlow<()> {
        for block in self.tree.blocks().get(blocks).unwrap_or(&[]) {
            intersect_block(block, &self.lanes, self.axes, self.t_min, self.collector)?;
        }
        ControlFlow::Continue(())
    }
}
