//! Errors of triangles, trees, scenes and blobs. Tracing itself has no errors: its preconditions are checked before.

use core::fmt;

use super::Error;
use crate::geometry::MAX_COORDINATE;

/// What is wrong with a tree.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum InvalidTree {
    /// There is no node; even an empty tree has a root.
    NoRoot,
    /// There are more nodes or blocks than an index can address.
    TooLarge {
        /// How many there may be of each.
        limit: u32,
    },
    /// A child that is out of range or not where a depth-first walk meets it.
    BadChild {
        /// The node that has it.
        node: u32,
        /// The child's place in the node.
        slot: u32,
    },
    /// An order of children that does not list each child once.
    BadOrder {
        /// The node that has it.
        node: u32,
    },
    /// A node that no other refers to.
    UnreachableNode {
        /// Its index.
        node: u32,
    },
    /// A block that no leaf refers to.
    UnreferencedBlock {
        /// Its index.
        block: u32,
    },
    /// A box that does not enclose its contents, or is not finite.
    BadBox {
        /// The node that has it.
        node: u32,
        /// The child's place in the node.
        slot: u32,
    },
    /// A triangle that is not finite or out of limits, or an unused lane that is not empty.
    BadTriangle {
        /// The block that has it.
        block: u32,
        /// Its lane.
        lane: u32,
    },
    /// A point or curve that no ray can hit, as it is not finite, out of limits or without a radius, or an unused lane
    /// that is not empty.
    BadPrimitive {
        /// The block that has it.
        block: u32,
        /// Its lane.
        lane: u32,
    },
    /// A leaf refers to an item that does not exist or has no box.
    BadItem {
        /// The place in the list of items.
        place: u32,
    },
    /// There are no keys, or they differ in their number of triangles, boxes or nodes, or in the tree's shape.
    BadKeys {
        /// The number of keys.
        keys: usize,
    },
    /// Traversal would need a larger stack than it has.
    TooDeep {
        /// Entries needed.
        needed: u32,
        /// Entries that there are.
        allowed: u32,
    },
}

/// Why a tree cannot be refitted: the triangles that can be hit are not those that are in the tree.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum RefitError {
    /// A triangle of the tree is not among those given.
    Missing {
        /// Its index.
        prim_id: u32,
        /// How many are given.
        count: usize,
    },
    /// A triangle of the tree now has a coordinate out of limits, or two equal corners.
    Vanished {
        /// Its index.
        prim_id: u32,
    },
    /// Triangles that are not in the tree can now be hit.
    Appeared {
        /// How many more.
        count: usize,
    },
}

impl core::error::Error for RefitError {}

impl core::error::Error for InvalidTree {}

impl From<RefitError> for Error {
    fn from(error: RefitError) -> Self {
        Self::Refit(error)
    }
}

impl From<InvalidTree> for Error {
    fn from(error: InvalidTree) -> Self {
        Self::InvalidTree(error)
    }
}

impl fmt::Display for RefitError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Missing { prim_id, count } => {
                write!(
                    f,
                    "triangle {prim_id} is in the tree, but there are only {count}; give all that it was built from"
                )
            }
            Self::Vanished { prim_id } => write!(
                f,
                "triangle {prim_id} is in the tree, but now has two equal corners, or a coordinate that is not finite or \
                 beyond ±{MAX_COORDINATE:e}; build the tree again"
            ),
            Self::Appeared { count } => {
                write!(f, "{count} triangles that are not in the tree can now be hit; build it again")
            }
        }
    }
}

impl fmt::Display for InvalidTree {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoRoot => write!(f, "the tree has no root node"),
            Self::TooLarge { limit } => write!(f, "the tree has more than {limit} nodes or blocks"),
            Self::BadChild { node, slot } => {
                write!(f, "child {slot} of node {node} is out of range or out of order")
            }
            Self::BadOrder { node } => {
                write!(f, "an order of the children of node {node} does not list each child once")
            }
            Self::UnreachableNode { node } => write!(f, "node {node} has no parent"),
            Self::UnreferencedBlock { block } => write!(f, "block {block} is in no leaf"),
            Self::BadBox { node, slot } => {
                write!(f, "the box of child {slot} of node {node} does not enclose what is in it")
            }
            Self::BadTriangle { block, lane } => {
                write!(
                    f,
                    "triangle {lane} of block {block} has a coordinate that is not finite or beyond ±{MAX_COORDINATE:e}"
                )
            }
            Self::BadPrimitive { block, lane } => write!(
                f,
                "primitive {lane} of block {block} has no radius, or a coordinate that is not finite or beyond \
                 ±{MAX_COORDINATE:e}"
            ),
            Self::BadItem { place } => write!(f, "item {place} in the leaves does not exist, or has no box"),
            Self::BadKeys { keys } => {
                write!(
                    f,
                    "a moving tree of {keys} keys needs at least one, and all keys need the same shape and number of parts"
                )
            }
            Self::TooDeep { needed, allowed } => {
                write!(f, "the tree is too deep: it needs a stack of {needed} entries, and there are {allowed}")
            }
        }
    }
}
