//! Walks through trees of points and curves. The margins of a block's eight primitives are computed in lanes; which of
//! the few that are near are hit, and where, the scalar definition says.

use core::ops::{ControlFlow, Range};

use super::{Collector, Intersector, traverse};
use crate::bvh::{RoundBlock, RoundBvhView, WIDTH, with_blocks};
use crate::geometry::round::{self, RayFrame};
use crate::geometry::setup::{RaySetup, Slabs};
use crate::geometry::{Hit, Ray};
use crate::simd::{Isa, Simd, Work, dispatch, lanes_of};
use crate::traverse::stack::TraversalStack;

/// Shows `collector` the hits of one ray, as [`super::walk`] does; all of them count as from the front.
#[inline(always)]
pub(crate) fn walk<S: Simd, C: Collector>(
    tree: &RoundBvhView,
    isa: Isa,
    ray: &Ray,
    stack: &mut TraversalStack,
    collector: &mut C,
) -> ControlFlow<()> {
    let (Some(setup), Some(frame)) = (RaySetup::new(ray, &tree.bounds()), RayFrame::new(ray)) else {
        return ControlFlow::Continue(());
    };
    traverse::<S, _>(&mut Rounds { tree, isa, ray, frame, collector }, &setup.slabs, ray.t_min, stack)
}

/// Points or curves, and the collector of the hits.
struct Rounds<'a, C> {
    tree: &'a RoundBvhView<'a>,
    isa: Isa,
    ray: &'a Ray,
    frame: RayFrame,
    collector: &'a mut C,
}

impl<C: Collector> Intersector for Rounds<'_, C> {
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
        with_blocks!(self.tree.blocks(), slice => {
            for block in slice.get(blocks).unwrap_or(&[]) {
                self.visit_block(block)?;
            }
        });
        ControlFlow::Continue(())
    }
}

impl<C: Collector> Rounds<'_, C> {
    #[inline(always)]
    fn visit_block<B: RoundBlock>(&mut self, block: &B) -> ControlFlow<()> {
        let mut hits = [Hit::MISS; WIDTH];
        let test = BlockTest { block, frame: &self.frame, ray: self.ray, hits: &mut hits };
        for lane in lanes_of(dispatch(self.isa, test)) {
            let hit = hits[lane & (WIDTH - 1)];
            if hit.t <= self.collector.t_max() {
                self.collector.report(hit, true)?;
            }
        }
        ControlFlow::Continue(())
    }
}

/// The hits of a ray with the primitives of a block. A piece of work of its own, so that it is compiled once for each
/// instruction set and not in the midst of every walk.
struct BlockTest<'a, B> {
    block: &'a B,
    frame: &'a RayFrame,
    ray: &'a Ray,
    hits: &'a mut [Hit; WIDTH],
}

impl<B: RoundBlock> Work for BlockTest<'_, B> {
    /// The lanes of the hits.
    type Output = u32;
    #[inline(always)]
    fn run<S: Simd>(self) -> u32 {
        let mut found = 0;
        for lane in lanes_of(self.block.lanes_near(self.frame)) {
            let lane = lane & (WIDTH - 1);
            if let Some(hit) = round::intersect(self.frame, self.ray, &self.block.primitive(lane)) {
                self.hits[lane] = Hit { prim_id: self.block.prim_ids()[lane], ..hit };
                found |= 1 << lane;
            }
        }
        found
    }
}
