//! Points and curves in scenes.

use core::ops::{ControlFlow, Range};

use super::SceneHit;
use super::search::{ItemCollector, Search};
use super::space::{Proximity, Space};
use crate::bvh::{RoundBlock, RoundBvhView, used_lanes, with_blocks};
use crate::geometry::{Hit, Ray, RoundPrimitive, intersect_round};
use crate::simd::{Isa, Simd, Work, dispatch};
use crate::traverse::TraversalStack;
use crate::traverse::single::round;

/// Shows a search the hits of a ray with points or curves; all have in common what `common` says. Not inlined, so that
/// walks through scenes of triangles are not compiled with this in their midst. `stack` is memory.
#[inline(never)]
pub(super) fn enter<Q: Search>(
    tree: &RoundBvhView,
    ray: &Ray,
    isa: Isa,
    stack: &mut TraversalStack,
    search: &mut Q,
    common: SceneHit,
) -> ControlFlow<()> {
    dispatch(isa, Enter { tree, isa, ray, stack, search, common })
}

struct Enter<'a, 's, Q> {
    tree: &'a RoundBvhView<'a>,
    isa: Isa,
    ray: &'a Ray,
    stack: &'s mut TraversalStack,
    search: &'s mut Q,
    common: SceneHit,
}

impl<Q: Search> Work for Enter<'_, '_, Q> {
    type Output = ControlFlow<()>;
    #[inline(always)]
    fn run<S: Simd>(self) -> ControlFlow<()> {
        let mut collector = ItemCollector { search: self.search, common: self.common };
        round::walk::<S, _>(self.tree, self.isa, self.ray, self.stack, &mut collector)
    }
}

/// Shows all hits of a ray, one primitive after the other.
pub(super) fn for_each_hit(tree: &RoundBvhView, ray: &Ray, see: &mut dyn FnMut(Hit)) {
    with_blocks!(tree.blocks(), slice => {
        for block in slice {
            for (lane, prim_id) in used_lanes(block) {
                if let Some(hit) = intersect_round(ray, &block.primitive(lane)) {
                    see(Hit { prim_id, ..hit });
                }
            }
        }
    });
}

/// Shows a search in a space the boxes of the primitives in some blocks.
pub(super) fn meet(
    tree: &RoundBvhView,
    blocks: Range<usize>,
    space: &Space,
    search: &mut dyn Proximity,
    place: SceneHit,
) -> ControlFlow<()> {
    with_blocks!(tree.blocks(), slice => {
        for block in slice.get(blocks).unwrap_or(&[]) {
            for (lane, prim_id) in used_lanes(block) {
                let hit = Hit { prim_id, ..place.hit };
                search.meet_box(&space.aabb(&block.primitive(lane).bounds()), SceneHit { hit, ..place })?;
            }
        }
    });
    ControlFlow::Continue(())
}
