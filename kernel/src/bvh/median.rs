//! Builds a binary tree by halving: sort by centroid along the longest axis, split in the middle.
//!
//! Needs no `std` and always gives the least possible depth, `ceil(log2 n)`, which is why it is also the way out when a
//! better tree would be too deep. Its trees are slower to trace than obvhs's.

use alloc::vec;
use alloc::vec::Vec;

use super::binary::{BinaryNode, BinaryTree};
use crate::geometry::Aabb;

/// Builds a tree over the boxes of `prim_ids`, one primitive a leaf; `prim_ids` is not empty.
pub(super) fn build(aabbs: &[Aabb], mut prim_ids: Vec<u32>) -> BinaryTree {
    let placeholder = BinaryNode { aabb: Aabb::EMPTY, first: 0, count: 0 };
    let mut nodes = vec![placeholder];
    let mut todo = vec![(0usize, 0usize..prim_ids.len())];
    while let Some((node, range)) = todo.pop() {
        let prims = &mut prim_ids[range.clone()];
        let bounds = |ids: &[u32]| ids.iter().fold(Aabb::EMPTY, |sum, &id| sum.union(&aabbs[id as usize]));
        let aabb = bounds(prims);
        if let [_] = prims {
            nodes[node] = BinaryNode { aabb, first: range.start as u32, count: 1 };
            continue;
        }
        let centers = prims.iter().map(|&id| aabbs[id as usize].center());
        let spread = centers.fold(Aabb::EMPTY, |sum, p| sum.union(&Aabb { min: p, max: p }));
        let axis = (spread.max - spread.min).max_position();
        let middle = prims.len() / 2;
        let center = |id: u32| aabbs[id as usize].center()[axis];
        prims.select_nth_unstable_by(middle, |&a, &b| center(a).total_cmp(&center(b)).then(a.cmp(&b)));
        let first = nodes.len();
        nodes[node] = BinaryNode { aabb, first: first as u32, count: 0 };
        nodes.extend([placeholder; 2]);
        todo.push((first, range.start..range.start + middle));
        todo.push((first + 1, range.start + middle..range.end));
    }
    BinaryTree { nodes, prim_ids }
}
