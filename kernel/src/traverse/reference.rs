//! The reference traversal: one ray, one box or triangle at a time, in the tree's order, and a loop over all triangles
//! without any tree. Slow; all other code paths give the same hits bit for bit.

use core::ops::ControlFlow;

use glam::Vec3;

use super::collector::Collector;
use crate::bvh::{BvhView, Child, MAX_STACK, RoundBlock, RoundBvhView, TriangleBlock, WIDTH, used_lanes, with_blocks};
use crate::geometry::closest::{self, ClosestCandidate};
use crate::geometry::{Aabb, Hit, Ray, Triangle, intersect_round, intersect_side, intersect_triangle, overlaps};

/// The result of [`BvhView::intersect`].
pub fn intersect(tree: &BvhView, ray: &Ray) -> Option<Hit> {
    let mut best: Option<Hit> = None;
    let mut stack = [0u32; MAX_STACK];
    let mut height = 1;
    while height > 0 {
        height -= 1;
        match Child::unpack(stack[height]) {
            Child::Empty => {}
            Child::Node(index) => {
                let node = &tree.nodes()[index as usize];
                for slot in 0..WIDTH {
                    if entry(&node.aabb(slot), ray, &tree.bounds()).is_some() {
                        stack[height] = node.children[slot];
                        height += 1;
                    }
                }
            }
            Child::Leaf { first, count } => {
                for block in &tree.blocks()[first as usize..][..count as usize] {
                    for lane in 0..WIDTH {
                        let hit = intersect_triangle(ray, &block.triangle(lane));
                        best = nearer(best, hit.map(|hit| Hit { prim_id: block.prim_id[lane], ..hit }));
                    }
                }
            }
        }
    }
    best
}

/// The result of [`BvhView::occluded`].
pub fn occluded(tree: &BvhView, ray: &Ray) -> bool {
    intersect(tree, ray).is_some()
}

/// The work of [`single::walk`](super::single::walk): shows `collector` the hits of `ray`, in the order of the octant
/// of its direction. No box is skipped for its distance.
pub(crate) fn walk<C: Collector>(tree: &BvhView, ray: &Ray, collector: &mut C) -> ControlFlow<()> {
    let octant = (0..3).fold(0, |octant, axis| octant | usize::from(ray.direction[axis].is_sign_negative()) << axis);
    let mut stack = [0u32; MAX_STACK];
    let mut height = 1;
    while height > 0 {
        height -= 1;
        match Child::unpack(stack[height]) {
            Child::Empty => {}
            Child::Node(index) => {
                let node = &tree.nodes()[index as usize];
                for place in 0..WIDTH {
                    let slot = (node.order[octant] >> (3 * place) & 7) as usize;
                    if entry(&node.aabb(slot), ray, &tree.bounds()).is_some() {
                        stack[height] = node.children[slot];
                        height += 1;
                    }
                }
            }
            Child::Leaf { first, count } => {
                for block in &tree.blocks()[first as usize..][..count as usize] {
                    for lane in 0..WIDTH {
                        if let Some((hit, front)) = intersect_side(ray, &block.triangle(lane))
                            && hit.t <= collector.t_max()
                        {
                            collector.report(Hit { prim_id: block.prim_id[lane], ..hit }, front)?;
                        }
                    }
                }
            }
        }
    }
    ControlFlow::Continue(())
}

/// Shows `collector` the hits of `ray` with all points or curves of a tree in memory order.
pub(crate) fn walk_round<C: Collector>(tree: &RoundBvhView, ray: &Ray, collector: &mut C) -> ControlFlow<()> {
    with_blocks!(tree.blocks(), slice => {
        for block in slice {
            for (lane, prim_id) in used_lanes(block) {
                if let Some(hit) = intersect_round(ray, &block.primitive(lane))
                    && hit.t <= collector.t_max()
                {
                    collector.report(Hit { prim_id, ..hit }, true)?;
                }
            }
        }
    });
    ControlFlow::Continue(())
}

/// The result of [`BvhView::closest_point`], if it precedes `best`: a loop over the triangles in memory order.
pub(crate) fn closest_point(tree: &BvhView, point: Vec3, mut best: ClosestCandidate) -> ClosestCandidate {
    for (triangle, prim_id) in triangles(tree.blocks()) {
        let foot = ClosestCandidate { prim_id, ..closest::closest_point(point, &triangle) };
        if foot.precedes(&best) {
            best = foot;
        }
    }
    best
}

/// The work of [`BvhView::for_each_overlap`]: a walk that skips no box.
pub(crate) fn for_each_overlap(
    tree: &BvhView,
    aabb: &Aabb,
    visit: &mut impl FnMut(u32) -> ControlFlow<()>,
) -> ControlFlow<()> {
    let mut stack = [0u32; MAX_STACK];
    let mut height = 1;
    while height > 0 {
        height -= 1;
        match Child::unpack(stack[height]) {
            Child::Empty => {}
            Child::Node(index) => {
                let children = tree.nodes()[index as usize].children;
                for &child in children.iter().rev().filter(|&&child| Child::unpack(child) != Child::Empty) {
                    stack[height] = child;
                    height += 1;
                }
            }
            Child::Leaf { first, count } => {
                let blocks = &tree.blocks()[first as usize..][..count as usize];
                let mut overlapping = triangles(blocks).filter(|(triangle, _)| overlaps(triangle, aabb));
                overlapping.try_for_each(|(_, prim_id)| visit(prim_id))?;
            }
        }
    }
    ControlFlow::Continue(())
}

/// The triangles of blocks in memory order, and their indices.
fn triangles(blocks: &[TriangleBlock]) -> impl Iterator<Item = (Triangle, u32)> {
    let lanes = blocks.iter().flat_map(|block| (0..WIDTH).map(|lane| (block.triangle(lane), block.prim_id[lane])));
    lanes.filter(|&(_, prim_id)| prim_id != Hit::NO_PRIM)
}

/// The nearest hit of `ray` among all `triangles`; `prim_id` is the index.
pub fn intersect_all(triangles: &[Triangle], ray: &Ray) -> Option<Hit> {
    (0..).zip(triangles).fold(None, |best, (prim_id, triangle)| {
        nearer(best, intersect_triangle(ray, triangle).map(|hit| Hit { prim_id, ..hit }))
    })
}

/// The hit with the smaller `t`; of equal ones that with the smaller `prim_id`.
pub(super) fn nearer(a: Option<Hit>, b: Option<Hit>) -> Option<Hit> {
    match (a, b) {
        (Some(a), Some(b)) if (b.t, b.prim_id) < (a.t, a.prim_id) => Some(b),
        (a, b) => a.or(b),
    }
}

/// The slab test of Kay and Kajiya 1986 in `f64`, on a box widened by a hundred-thousandth of all that could have been
/// rounded: where the ray enters it. `None` only if no triangle in the box can have a hit.
pub(super) fn entry(aabb: &Aabb, ray: &Ray, scene: &Aabb) -> Option<f64> {
    if aabb.is_empty() {
        return None;
    }
    let (mut near, mut far) = (f64::NEG_INFINITY, f64::INFINITY);
    let reach = (scene.min - ray.origin)
        .abs()
        .max((scene.max - ray.origin).abs())
        .max_element()
        .max(ray.origin.abs().max_element());
    let pad = reach as f64 * 1e-5;
    for axis in 0..3 {
        let (origin, direction) = (ray.origin[axis] as f64, ray.direction[axis] as f64);
        let lower = aabb.min[axis] as f64 - pad - origin;
        let upper = aabb.max[axis] as f64 + pad - origin;
        if direction == 0.0 {
            if lower > 0.0 || upper < 0.0 {
                return None;
            }
            continue;
        }
        let (a, b) = (lower / direction, upper / direction);
        near = near.max(a.min(b));
        far = far.min(a.max(b));
    }
    (near <= far && near <= ray.t_max as f64 && far >= ray.t_min as f64).then_some(near)
}
