//! A borrowed tree, for traversal.

use super::{Node, TriangleBlock, validate};
use crate::error::Error;
use crate::geometry::Aabb;
use crate::simd::Isa;

/// A tree in borrowed memory, checked once so that tracing needs no checks.
#[derive(Clone, Copy, Debug)]
pub struct BvhView<'a> {
    nodes: &'a [Node],
    blocks: &'a [TriangleBlock],
    bounds: Aabb,
    isa: Isa,
}

impl<'a> BvhView<'a> {
    /// Borrows a tree whose root is the first node.
    ///
    /// # Errors
    /// [`Error::InvalidTree`] says what is wrong: nodes or blocks out of the order of a depth-first walk, boxes that do
    /// not enclose what is in them, orders of children that leave one out, coordinates out of limits, or a traversal
    /// that would need more than [`MAX_STACK`](super::MAX_STACK) entries. `prim_id`s are the caller's and are not
    /// checked.
    pub fn new(nodes: &'a [Node], blocks: &'a [TriangleBlock]) -> Result<Self, Error> {
        validate::validate(nodes, blocks)?;
        Ok(Self::trusted(nodes, blocks))
    }

    /// Borrows a tree that is known to be valid.
    pub(crate) fn trusted(nodes: &'a [Node], blocks: &'a [TriangleBlock]) -> Self {
        Self::with_bounds(nodes, blocks, nodes.first().map_or(Aabb::EMPTY, Node::bounds))
    }

    /// Borrows a tree that is known to be valid, and the box around it.
    #[inline]
    pub(super) fn with_bounds(nodes: &'a [Node], blocks: &'a [TriangleBlock], bounds: Aabb) -> Self {
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

    /// The triangles.
    #[inline]
    pub fn blocks(&self) -> &'a [TriangleBlock] {
        self.blocks
    }

    /// The box around all triangles; empty if there are none.
    #[inline]
    pub fn bounds(&self) -> Aabb {
        self.bounds
    }
}
