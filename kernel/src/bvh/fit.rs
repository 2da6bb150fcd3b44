//! Makes boxes fit what is in them, from the leaves up.

use core::ops::Range;

use super::node::{Child, Node, WIDTH};
use crate::geometry::Aabb;

/// Sets the boxes of a tree whose children are right, and their orders. `leaf` gives the box around a range of blocks.
pub(super) fn fit(nodes: &mut [Node], leaf: impl Fn(Range<usize>) -> Aabb) {
    // Children come behind their parents.
    for index in (0..nodes.len()).rev() {
        let mut node = nodes[index];
        for slot in 0..WIDTH {
            let child = Child::unpack(node.children[slot]);
            let aabb = match child {
                Child::Empty => continue,
                Child::Node(below) => nodes[below as usize].bounds(),
                Child::Leaf { .. } => leaf(Child::leaf_blocks(node.children[slot])),
            };
            node.set(slot, &aabb, child);
        }
        node.sort();
        nodes[index] = node;
    }
}
