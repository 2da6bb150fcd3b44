//! One ray on its way through the tree: a step at a time against the eight boxes of a node, or the eight triangles of a
//! block.

use super::pending::{Pending, corners};
use crate::bvh::{BvhView, Child, TriangleBlock, WIDTH};
use crate::geometry::setup::{Axis, RaySetup};
use crate::geometry::triangle::{self, LineLanes};
use crate::geometry::{Hit, Ray};
use crate::simd::{Lanes, Mask, Simd, lanes_of};

/// The nearest hit of one ray, or with `ANY` the first one found.
#[inline(always)]
pub(super) fn trace<const ANY: bool, S: Simd>(tree: &BvhView, ray: &Ray) -> Option<Hit> {
    let RaySetup { slabs, line } = RaySetup::new(ray, &tree.bounds())?;
    let (octant, lanes) = (slabs.octant(), LineLanes::<S::F8>::splat(&line));
    let mut best = Hit::none_before(ray.t_max);
    let mut pending = Pending::EMPTY;
    pending.start();
    loop {
        let (child, near) = pending.take();
        if child == Pending::NONE {
            return best.found();
        }
        // Another hit may have come nearer since. As near is not nearer: there may be a tie to decide.
        if !ANY && near > best.t {
            continue;
        }
        if Child::is_node(child) {
            if let Some(node) = tree.nodes().get(child as usize) {
                pending.enter::<S>(node, &slabs, octant, ray.t_min, best.t);
            }
        } else {
            for block in tree.blocks().get(Child::leaf_blocks(child)).unwrap_or(&[]) {
                hit_block(block, &lanes, line.axes, ray.t_min, &mut best);
                if ANY && best.is_hit() {
                    return Some(best);
                }
            }
        }
    }
}

/// Replaces `best` by the block's nearest hit, if that precedes it; tells whether it did.
#[inline(always)]
pub(super) fn hit_block<L: Lanes<WIDTH>>(
    block: &TriangleBlock,
    ray: &LineLanes<L>,
    axes: [Axis; 3],
    t_min: f32,
    best: &mut Hit,
) -> bool {
    let Some(crossing) = triangle::cross(ray, corners(block, axes)) else {
        return false;
    };
    let within = L::splat(t_min).le(crossing.t) & crossing.t.le(L::splat(best.t));
    let bits = within.bits() & crossing.bits;
    if bits == 0 {
        return false;
    }
    let mut found = false;
    let (t, u, v) = (crossing.t.store(), crossing.u.store(), crossing.v.store());
    for lane in lanes_of(bits) {
        let hit = Hit { t: t[lane], u: u[lane], v: v[lane], prim_id: block.prim_id[lane] };
        if hit.precedes(best) {
            *best = hit;
            found = true;
        }
    }
    found
}
