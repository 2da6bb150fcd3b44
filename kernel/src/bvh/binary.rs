//! A binary tree: it is built first, improved by moving subtrees, and collapsed to eight children a node.

use alloc::vec::Vec;

use super::primitive::{Bounds, Primitive, PrimitiveBounds};
use crate::geometry::Aabb;

/// A binary tree over primitives; the first node is the root. There is at least one node.
///
/// Siblings lie side by side, the first one at an odd index.
pub(super) struct BinaryTree {
    pub nodes: Vec<BinaryNode>,
    /// The primitives of the leaves.
    pub prims: Vec<Primitive>,
}

/// A node.
#[derive(Clone, Copy)]
#[repr(align(32))]
pub(super) struct BinaryNode {
    pub aabb: Aabb,
    /// An inner node's children are `first` and `first + 1`; a leaf's primitives are `prims[first..][..count]`.
    pub first: u32,
    /// Zero for an inner node.
    pub count: u16,
    /// How many of a leaf's primitives are in its first part; 0 if it has but one.
    pub middle: u16,
}

/// The most levels of a tree that is walked by recursion.
pub(super) const MAX_DEPTH: usize = 256;

impl BinaryTree {
    /// Brings the nodes into the order of a depth-first walk: after a pair of siblings come all below the first, then
    /// all below the second. Leaves of two parts are split. `None` if there are more than
    /// [`MAX_DEPTH`] levels.
    pub(super) fn in_order(self) -> Option<Self> {
        let Self { nodes: old, prims } = self;
        let mut nodes = Vec::with_capacity(2 * old.len());
        nodes.push(old[0]);
        let mut todo = Vec::from([(0, 1)]);
        while let Some((index, level)) = todo.pop() {
            let node: BinaryNode = nodes[index];
            if node.is_leaf() && node.middle == 0 {
                continue;
            }
            if level == MAX_DEPTH {
                return None;
            }
            let first = nodes.len();
            nodes[index] = BinaryNode { first: first as u32, count: 0, middle: 0, ..node };
            nodes.extend(if node.is_leaf() { node.parts(&prims) } else { node.children().map(|child| old[child]) });
            todo.extend([(first + 1, level + 1), (first, level + 1)]);
        }
        Some(Self { nodes, prims })
    }
}

impl BinaryNode {
    pub(super) fn is_leaf(&self) -> bool {
        self.count > 0
    }

    /// The two leaves that a leaf of two parts stands for.
    fn parts(&self, prims: &[Primitive]) -> [Self; 2] {
        let second = self.first + u32::from(self.middle);
        [(self.first, self.middle), (second, self.count - self.middle)].map(|(first, count)| {
            let bounds = PrimitiveBounds::of(&prims[first as usize..][..count as usize]).bounds;
            Self { aabb: bounds.to_aabb(), first, count, middle: 0 }
        })
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
