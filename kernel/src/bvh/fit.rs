//! Fits boxes to their contents, from the leaves up.

use core::ops::Range;

use super::executor::{Executor, Serial};
use super::node::{Child, Node, WIDTH};
use crate::geometry::Aabb;

/// Subtrees of this many nodes are one task.
const TASK: usize = 1 << 9;

/// Sets the boxes of a tree whose children are right, and their orders. `leaf` gives the box around a range of blocks.
pub(super) fn fit(nodes: &mut [Node], leaf: impl Fn(Range<usize>) -> Aabb + Sync) {
    fit_on(&Serial, nodes, &leaf);
}

/// [`fit`], on the threads of `executor`.
pub(super) fn fit_on<E: Executor>(executor: &E, nodes: &mut [Node], leaf: &(impl Fn(Range<usize>) -> Aabb + Sync)) {
    if let Some((root, below)) = nodes.split_first_mut() {
        fit_below(executor, root, below, 1, leaf);
    }
}

/// Fits a node and all `below` it, of which the first has the index `first`: the node's inner children, then what is
/// below the first of them, then what is below the second …
fn fit_below<E: Executor, F: Fn(Range<usize>) -> Aabb + Sync>(
    executor: &E,
    node: &mut Node,
    below: &mut [Node],
    first: usize,
    leaf: &F,
) {
    if below.len() < TASK {
        // Children come behind their parents.
        for index in (0..below.len()).rev() {
            let (before, behind) = below.split_at_mut(index + 1);
            fit_node(&mut before[index], behind, first + index + 1, leaf);
        }
    } else {
        let inner = node.children.iter().filter(|&&child| matches!(Child::unpack(child), Child::Node(_))).count();
        let (children, rest) = below.split_at_mut(inner);
        fit_children(executor, children, rest, first + inner, leaf);
    }
    fit_node(node, below, first, leaf);
}

/// Fits siblings and what is below them.
fn fit_children<E: Executor, F: Fn(Range<usize>) -> Aabb + Sync>(
    executor: &E,
    children: &mut [Node],
    below: &mut [Node],
    first: usize,
    leaf: &F,
) {
    match children {
        [] => {}
        [only] => fit_below(executor, only, below, first, leaf),
        _ => {
            let (left, right) = children.split_at_mut(children.len() / 2);
            // What is below the right ones begins with the first child that one of them has.
            let inner = |&child: &u32| match Child::unpack(child) {
                Child::Node(index) => Some(index as usize),
                _ => None,
            };
            let begin = right.iter().flat_map(|node| &node.children).filter_map(inner).next();
            let (below_left, below_right) = below.split_at_mut(begin.map_or(below.len(), |begin| begin - first));
            let second = first + below_left.len();
            executor.join(
                || fit_children(executor, left, below_left, first, leaf),
                || fit_children(executor, right, below_right, second, leaf),
            );
        }
    }
}

/// Fits a node to its children, which have been fitted. `behind` are the nodes from the index `first` on.
fn fit_node(node: &mut Node, behind: &[Node], first: usize, leaf: &impl Fn(Range<usize>) -> Aabb) {
    let before = node.planes;
    for slot in 0..WIDTH {
        let child = Child::unpack(node.children[slot]);
        let aabb = match child {
            Child::Empty => continue,
            Child::Node(index) => behind[index as usize - first].bounds(),
            Child::Leaf { .. } => leaf(Child::leaf_blocks(node.children[slot])),
        };
        node.set(slot, &aabb, child);
    }
    if node.planes != before {
        node.sort();
    }
}
