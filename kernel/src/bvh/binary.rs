//! A binary tree: what builders make and the collapse takes.

use alloc::vec::Vec;

use crate::geometry::Aabb;

/// A binary tree over primitives; the first node is the root. There is at least one node.
pub(super) struct BinaryTree {
    pub nodes: Vec<BinaryNode>,
    /// What leaves refer to: indices of primitives.
    pub prim_ids: Vec<u32>,
}

/// A node.
#[derive(Clone, Copy)]
pub(super) struct BinaryNode {
    pub aabb: Aabb,
    /// An inner node's children are `first` and `first + 1`; a leaf's primitives are `prim_ids[first..][..count]`.
    pub first: u32,
    /// Zero for an inner node.
    pub count: u32,
}

impl BinaryTree {
    /// Turns a leaf of several primitives, all with the leaf's box, into a balanced subtree of leaves of one.
    #[cfg(feature = "std")]
    pub(super) fn halve(&mut self, leaf: usize) {
        let mut todo = alloc::vec![leaf];
        while let Some(index) = todo.pop() {
            let node = self.nodes[index];
            if node.count > 1 {
                let children = self.nodes.len();
                let half = node.count / 2;
                self.nodes.push(BinaryNode { count: half, ..node });
                self.nodes.push(BinaryNode { first: node.first + half, count: node.count - half, ..node });
                self.nodes[index] = BinaryNode { first: children as u32, count: 0, ..node };
                todo.extend([children, children + 1]);
            }
        }
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
}
