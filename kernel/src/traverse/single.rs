//! One ray through the tree: against the eight boxes of a node, or the eight triangles of a block, at a time.

use super::stack::Stack;
use crate::bvh::{BvhView, Child, Node, TriangleBlock, WIDTH};
use crate::geometry::setup::{Course, RayLanes, RaySetup};
use crate::geometry::triangle;
use crate::geometry::{Hit, Ray};
use crate::simd::{Lanes, Mask, lanes_of};

/// A subtree to visit, and where the ray enters its box.
#[derive(Clone, Copy)]
struct Entry {
    child: u32,
    near: f32,
}

/// The ray's nearest hit, or with `ANY` the first one found.
#[inline(always)]
pub(super) fn trace<const ANY: bool, L: Lanes<WIDTH>>(tree: &BvhView, ray: &Ray) -> Hit {
    let mut best = Hit::none_before(ray.t_max);
    let Some(setup) = RaySetup::new(ray, &tree.bounds()) else {
        return Hit::MISS;
    };
    let lanes = RayLanes::<L>::splat(&setup);
    let planes = setup.course.planes();
    let t_min = L::splat(ray.t_min);
    let mut stack = Stack::new(Entry { child: 0, near: 0.0 });
    let mut next = Some(Entry { child: 0, near: ray.t_min });
    while let Some(entry) = next {
        // Another hit may have come nearer since this was put on the stack. As near is not nearer: the tie is decided.
        if entry.near <= best.t {
            match Child::unpack(entry.child) {
                Child::Empty => {}
                Child::Node(index) => {
                    if let Some(node) = tree.nodes().get(index as usize) {
                        let (bits, near) = enter(node, &lanes, planes, t_min, L::splat(best.t));
                        let since = stack.height();
                        for slot in lanes_of(bits) {
                            let entry = Entry { child: node.children[slot], near: near[slot] };
                            stack.insert(entry, since, |other| !ANY && other.near < entry.near);
                        }
                    }
                }
                Child::Leaf { first, count } => {
                    let range = first as usize..first as usize + count as usize;
                    for block in tree.blocks().get(range).unwrap_or(&[]) {
                        hit_block(block, &lanes, &setup.course, t_min, &mut best);
                        if ANY && best.is_hit() {
                            return best;
                        }
                    }
                }
            }
        }
        next = stack.pop();
    }
    best
}

/// The children whose boxes the ray meets within its interval, and where.
#[inline(always)]
fn enter<L: Lanes<WIDTH>>(
    node: &Node,
    ray: &RayLanes<L>,
    planes: [(usize, usize); 3],
    t_min: L,
    t_max: L,
) -> (u32, [f32; WIDTH]) {
    let near = |k: usize| (L::load(&node.planes[planes[k].0]) - ray.near_origin[k]) * ray.inverse[k];
    let far = |k: usize| (L::load(&node.planes[planes[k].1]) - ray.far_origin[k]) * ray.inverse[k];
    let enter = near(0).max(near(1)).max(near(2).max(t_min));
    let leave = far(0).min(far(1)).min(far(2).min(t_max));
    (enter.le(leave).bits(), enter.store())
}

/// Replaces `best` by the block's nearest hit, if that precedes it.
#[inline(always)]
fn hit_block<L: Lanes<WIDTH>>(block: &TriangleBlock, ray: &RayLanes<L>, course: &Course, t_min: L, best: &mut Hit) {
    let corners = [0, 1, 2].map(|corner| course.axes.map(|axis| L::load(&block.corners[corner][axis])));
    let Some(crossing) = triangle::cross(ray, corners) else {
        return;
    };
    let within = t_min.le(crossing.t) & crossing.t.le(L::splat(best.t));
    let bits = within.bits() & crossing.bits;
    if bits == 0 {
        return;
    }
    let (t, u, v) = (crossing.t.store(), crossing.u.store(), crossing.v.store());
    for lane in lanes_of(bits) {
        let hit = Hit { t: t[lane], u: u[lane], v: v[lane], prim_id: block.prim_id[lane] };
        if hit.precedes(best) {
            *best = hit;
        }
    }
}
