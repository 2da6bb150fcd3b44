//! A borrowed tree over points or curves, for traversal.

use super::round_block::{leaf_bounds, with_blocks};
use super::{Node, RoundBlocks, validate};
use crate::error::Error;
use crate::geometry::Aabb;
use crate::simd::Isa;

/// A tree over spheres, discs or round curves in borrowed memory, checked once so that tracing needs no checks.
#[derive(Clone, Copy, Debug)]
pub struct RoundBvhView<'a> {
    nodes: &'a [Node],
    blocks: RoundBlocks<'a>,
    bounds: Aabb,
    isa: Isa,
}

impl<'a> RoundBvhView<'a> {
    /// Borrows a tree whose root is the first node.
    ///
    /// # Errors
    /// [`InvalidTree`](crate::InvalidTree) says what is wrong, as for a tree of triangles;
    /// [`InvalidTree::BadPrimitive`](crate::InvalidTree::BadPrimitive) is a primitive that no ray can hit, or an unused
    /// lane that holds numbers. `prim_id`s are the caller's and are not checked.
    pub fn new(nodes: &'a [Node], blocks: impl Into<RoundBlocks<'a>>) -> Result<Self, Error> {
        let blocks = blocks.into();
        with_blocks!(blocks, slice => {
            validate::validate_nodes(nodes, slice.len(), |first, end| leaf_bounds(&slice[first..end], first as u32))
        })?;
        Ok(Self::trusted(nodes, blocks))
    }

    /// Borrows a tree that is known to be valid.
    pub(crate) fn trusted(nodes: &'a [Node], blocks: RoundBlocks<'a>) -> Self {
        Self::with_bounds(nodes, blocks, nodes.first().map_or(Aabb::EMPTY, Node::bounds))
    }

    /// Borrows a tree that is known to be valid, and the box around it.
    #[inline]
    pub(super) fn with_bounds(nodes: &'a [Node], blocks: RoundBlocks<'a>, bounds: Aabb) -> Self {
        Self { nodes, blocks, bounds, isa: Isa::detect() }
    }

    /// The tree, traced with the instructions of `isa` instead of those of [`Isa::detect`].
    #[must_use]
    #[inline]
    pub fn with_isa(self, isa: Isa) -> Self {
        Self { isa, ..self }
    }

    /// The instruction set that the tree is traced with.
    #[inline]
    pub fn isa(&self) -> Isa {
        self.isa
    }

    /// The nodes; the first one is the root.
    #[inline]
    pub fn nodes(&self) -> &'a [Node] {
        self.nodes
    }

    /// The primitives.
    #[inline]
    pub fn blocks(&self) -> RoundBlocks<'a> {
        self.blocks
    }

    /// The box around all primitives; empty if there are none.
    #[inline]
    pub fn bounds(&self) -> Aabb {
        self.bounds
    }
}
