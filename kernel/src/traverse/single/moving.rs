//! Walks through trees that move: nodes and blocks are interpolated when they are visited, each operation rounded as
//! [`Moment`](crate::geometry::moment::Moment) says.

use core::ops::{ControlFlow, Range};

use super::{Collector, Intersector, traverse};
use crate::bvh::{MovingBvhView, Node, TriangleBlock, WIDTH};
use crate::geometry::Ray;
use crate::geometry::moment::Moment;
use crate::geometry::setup::{Axis, RaySetup, Slabs};
use crate::geometry::triangle::LineLanes;
use crate::simd::{Lanes, Simd};
use crate::traverse::leaf_test::intersect_block;
use crate::traverse::stack::TraversalStack;

/// Shows `collector` the hits of one ray with the triangles where they are at `time`, in 0..=1 or moved there; see
/// [`super::walk`]. At a key, this is the walk through the tree of that key.
#[inline(always)]
pub(crate) fn walk<S: Simd, C: Collector>(
    tree: &MovingBvhView,
    ray: &Ray,
    time: f32,
    stack: &mut TraversalStack,
    collector: &mut C,
) -> ControlFlow<()> {
    let Some(moment) = Moment::new(time, tree.keys()) else {
        return ControlFlow::Continue(());
    };
    if moment.fraction == 0.0 {
        return super::walk::<S, C>(&tree.at_key(moment.key), ray, stack, collector);
    }
    let Some(RaySetup { slabs, line }) = RaySetup::new(ray, &tree.bounds()) else {
        return ControlFlow::Continue(());
    };
    let mut triangles = MovingTriangles {
        nodes: [tree.nodes(moment.key), tree.nodes(moment.key + 1)],
        blocks: [tree.blocks(moment.key), tree.blocks(moment.key + 1)],
        fraction: moment.fraction,
        lanes: LineLanes::<S::F8>::splat(&line.numbers),
        axes: line.axes,
        t_min: ray.t_min,
        collector,
    };
    traverse::<S, _>(&mut triangles, &slabs, ray.t_min, stack)
}

/// Triangles between two keys, and the collector of the hits.
struct MovingTriangles<'a, L, C> {
    nodes: [&'a [Node]; 2],
    blocks: [&'a [TriangleBlock]; 2],
    fraction: f32,
    lanes: LineLanes<L>,
    axes: [Axis; 3],
    t_min: f32,
    collector: &'a mut C,
}

impl<L: Lanes<WIDTH>, C: Collector> Intersector for MovingTriangles<'_, L, C> {
    #[inline(always)]
    fn t_max(&self) -> f32 {
        self.collector.t_max()
    }

    #[inline(always)]
    fn visit_node<S: Simd>(&self, node: u32, stack: &mut TraversalStack, slabs: &Slabs, octant: u8, t_min: f32) {
        push_children_between::<S>(self.nodes, self.fraction, node, stack, slabs, octant, (t_min, self.t_max()));
    }

    #[inline(always)]
    fn visit_leaf<S: Simd>(&mut self, blocks: Range<usize>) -> ControlFlow<()> {
        let [from, to] = self.blocks;
        for (from, to) in from.get(blocks.clone()).unwrap_or(&[]).iter().zip(to.get(blocks).unwrap_or(&[])) {
            let block = block_between::<S>(from, to, self.fraction);
            intersect_block(&block, &self.lanes, self.axes, self.t_min, self.collector)?;
        }
        ControlFlow::Continue(())
    }
}

/// [Enters](TraversalStack::push_children) a node between two keys.
#[inline(always)]
pub(crate) fn push_children_between<S: Simd>(
    [from, to]: [&[Node]; 2],
    fraction: f32,
    node: u32,
    stack: &mut TraversalStack,
    slabs: &Slabs,
    octant: u8,
    (t_min, t_max): (f32, f32),
) {
    if let (Some(from), Some(to)) = (from.get(node as usize), to.get(node as usize)) {
        stack.push_children::<S>(&node_between::<S>(from, to, fraction), slabs, octant, t_min, t_max);
    }
}

/// A node between two keys, with the children's order of the first.
#[inline(always)]
pub(crate) fn node_between<S: Simd>(from: &Node, to: &Node, fraction: f32) -> Node {
    let mut node = *from;
    for axis in 0..3 {
        for side in 0..2 {
            node.planes[axis][side] = between::<S>(&from.planes[axis][side], &to.planes[axis][side], fraction);
        }
    }
    node
}

/// Triangles between two keys.
#[inline(always)]
pub(crate) fn block_between<S: Simd>(from: &TriangleBlock, to: &TriangleBlock, fraction: f32) -> TriangleBlock {
    let mut block = *from;
    for corner in 0..3 {
        for axis in 0..3 {
            block.corners[corner][axis] =
                between::<S>(&from.corners[corner][axis], &to.corners[corner][axis], fraction);
        }
    }
    block
}

#[inline(always)]
fn between<S: Simd>(from: &[f32; WIDTH], to: &[f32; WIDTH], fraction: f32) -> [f32; WIDTH] {
    let (a, b) = (S::F8::splat(1.0 - fraction), S::F8::splat(fraction));
    (S::F8::load(from) * a + S::F8::load(to) * b).store()
}
