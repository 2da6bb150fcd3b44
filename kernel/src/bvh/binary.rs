//! A binary tree: what is built first, improved by moving subtrees, and made eight children wide.

use alloc::vec::Vec;

use super::primitive::Bounds;
use crate::geometry::Aabb;

/// A binary tree over primitives; the first node is the root. There is at least one node.
///
/// Siblings lie side by side, the first one at an odd index. [`Layout`](super::collapse) wants more: all that is below
/// a node lies together, the left child's part first.
pub(super) struct BinaryTree {
    pub nodes: Vec<BinaryNode>,
    /// What leaves refer to: indices of primitives.
    pub prim_ids: Vec<u32>,
}

/// A node.
#[derive(Clone, Copy)]
#[repr(align(32))]
pub(super) struct BinaryNode {
    pub aabb: Aabb,
    /// An inner node's children are `first` and `first + 1`; a leaf's primitives are `prim_ids[first..][..count]`.
    pub first: u32,
    /// Zero for an inner node.
    pub count: u32,
}

/// The most levels of a tree that is walked by recursion.
pub(super) const MAX_DEPTH: usize = 256;

impl BinaryTree {
    /// Brings the nodes into the order of a depth-first walk: after a pair of siblings come all below the first, then
    /// all below the second. `None` if there are more than [`MAX_DEPTH`] levels.
    pub(super) fn in_order(self) -> Option<Self> {
        let mut nodes = Vec::with_capacity(self.nodes.len());
        nodes.push(self.nodes[0]);
        let mut todo = Vec::from([(0, 1)]);
        while let Some((index, level)) = todo.pop() {
            let node: &mut BinaryNode = &mut nodes[index];
            if node.is_leaf() {
                continue;
            }
            if level == MAX_DEPTH {
                return None;
            }
            let children = node.children().map(|child| self.nodes[child]);
            let first = nodes.len();
            nodes[index].first = first as u32;
            nodes.extend(children);
            todo.extend([(first + 1, level + 1), (first, level + 1)]);
        }
        Some(Self { nodes, prim_ids: self.prim_ids })
    }
}

impl BinaryNode {
    pub(super) fn is_leaf(&self) -> bool {
        self.count > 0
    }

    /// The children of an inner node.
    pub(super) fn children(&self) -> [usize; 2] {
        [self.first as usize, self.first as usize + 1]
    }

    #[inline(always)]
    pub(super) fn bounds(&self) -> Bounds {
        Bounds { min: self.aabb.min.into(), max: self.aabb.max.into() }
    }
}
