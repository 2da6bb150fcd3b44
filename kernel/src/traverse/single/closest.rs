//! The nearest hit of one ray. Children are visited in the order of their distances: the nearest is visited at once,
//! the others wait on the stack, each with its distance. Nodes of which the ray meets no child, one, or two are most,
//! and have direct paths.

use crate::bvh::{BvhView, Child, Node};
use crate::geometry::setup::RaySetup;
use crate::geometry::triangle::LineLanes;
use crate::geometry::{Hit, Ray};
use crate::simd::{Lanes, Mask, Simd, UninitStack};
use crate::traverse::collector::ClosestHit;
use crate::traverse::leaf_test::intersect_block;
use crate::traverse::node_test::{NodeTest, prefetch};

/// A subtree on the stack: where the ray enters its box in the upper half, so that entries compare as their distances
/// do (in the wrong order if those are negative, which only costs time), and the subtree in the lower one.
#[inline(always)]
fn entry(near: f32, child: u32) -> u64 {
    u64::from(near.to_bits()) << 32 | u64::from(child)
}

/// The nearest hit of `ray`, if it precedes `best`; else `best`.
#[inline(always)]
pub(super) fn trace<S: Simd>(tree: &BvhView, ray: &Ray, best: Hit) -> Hit {
    let Some(RaySetup { slabs, line }) = RaySetup::new(ray, &tree.bounds()) else { return best };
    let test = NodeTest::<S::F8>::new(&slabs, ray.t_min);
    let lines = LineLanes::<S::F8>::splat(&line.numbers);
    let mut closest = ClosestHit { best };
    let mut stack = UninitStack::new();
    let mut child = Child::Node(0).pack();
    loop {
        if Child::is_node(child) {
            if let Some(node) = tree.nodes().get(child as usize) {
                let (near, far) = test.intersect(node, closest.best.t);
                let hits = near.le(far).bits();
                if hits != 0 {
                    child = nearest::<S>(tree, node, near, hits, &mut stack);
                    continue;
                }
            }
        } else {
            for block in tree.blocks().get(Child::leaf_blocks(child)).unwrap_or(&[]) {
                // This collector never ends the search.
                let _ = intersect_block(block, &lines, line.axes, ray.t_min, &mut closest);
            }
        }
        // Equal distances are kept: ties are decided by `prim_id`.
        child = loop {
            let Some(entry) = stack.pop() else { return closest.best };
            if f32::from_bits((entry >> 32) as u32) <= closest.best.t {
                break entry as u32;
            }
        };
    }
}

/// The nearest of the children in the non-empty mask `hits`; the others go to the stack, the farthest first.
#[inline(always)]
fn nearest<S: Simd>(tree: &BvhView, node: &Node, near: S::F8, mut hits: u32, stack: &mut UninitStack<u64>) -> u32 {
    let children = &node.children;
    let a = hits.trailing_zeros() as usize % 8;
    hits &= hits - 1;
    if hits == 0 {
        return children[a];
    }
    let near = near.store();
    let b = hits.trailing_zeros() as usize % 8;
    hits &= hits - 1;
    let (a, b) = (entry(near[a], children[a]), entry(near[b], children[b]));
    let (a, b) = (a.min(b), a.max(b));
    prefetch::<S>(tree, b as u32);
    if hits == 0 {
        stack.push(b);
        return a as u32;
    }
    let c = hits.trailing_zeros() as usize % 8;
    hits &= hits - 1;
    prefetch::<S>(tree, children[c]);
    let c = entry(near[c], children[c]);
    let (b, c) = (b.min(c), b.max(c));
    let (a, b) = (a.min(b), a.max(b));
    if hits == 0 {
        stack.push(c);
        stack.push(b);
        return a as u32;
    }
    let mut sorted = [u64::MAX; 8];
    (sorted[0], sorted[1], sorted[2]) = (a, b, c);
    let mut len = 3;
    while hits != 0 {
        let next = hits.trailing_zeros() as usize % 8;
        hits &= hits - 1;
        prefetch::<S>(tree, children[next]);
        let next = entry(near[next], children[next]);
        let mut place = len;
        while place > 0 && next < sorted[(place - 1) & 7] {
            sorted[place & 7] = sorted[(place - 1) & 7];
            place -= 1;
        }
        sorted[place & 7] = next;
        len += 1;
    }
    for &farther in sorted[1..len.min(8)].iter().rev() {
        stack.push(farther);
    }
    sorted[0] as u32
}
