//! The contents of a tree's leaves: triangles in blocks of eight, or the indices of boxes, one a leaf.

use super::node::{Node, TriangleBlock, WIDTH};
use super::validate;
use crate::error::InvalidTree;
use crate::mesh::Mesh;

/// How primitives lie in leaves.
#[derive(Clone, Copy, Debug)]
pub(super) struct LeafShape {
    /// Primitives a block.
    pub lanes: u32,
    /// Blocks a leaf, at most.
    pub blocks: u32,
    /// Expected cost of a block, where a node's is 1.
    pub cost: f32,
}

impl LeafShape {
    /// Primitives of a leaf, at most.
    pub(super) fn most(&self) -> u32 {
        self.lanes * self.blocks
    }

    /// The number of blocks for this many primitives.
    pub(super) fn blocks_of(&self, prims: u32) -> u32 {
        prims.div_ceil(self.lanes)
    }
}

/// Primitives that a tree is built over.
pub(super) trait Contents: Sync {
    /// The blocks of leaves.
    type Block: Copy + Send + Sync;
    /// A block without primitives.
    const EMPTY: Self::Block;
    /// The packing in leaves.
    const SHAPE: LeafShape;

    /// Puts a primitive into a lane of a block.
    fn put(&self, block: &mut Self::Block, lane: usize, prim_id: u32);

    /// Checks the invariants that traversal relies on. Returns the number of stack entries that a traversal needs.
    fn validate(&self, nodes: &[Node], blocks: &[Self::Block]) -> Result<u32, InvalidTree>;
}

/// How triangles lie in leaves.
pub(super) const TRIANGLES: LeafShape = LeafShape { lanes: WIDTH as u32, blocks: 2, cost: 0.6 };

/// The triangles of a mesh.
pub(super) struct Faces<'a, M: ?Sized>(pub &'a M);

impl<M: Mesh + ?Sized> Contents for Faces<'_, M> {
    type Block = TriangleBlock;
    const EMPTY: TriangleBlock = TriangleBlock::EMPTY;
    const SHAPE: LeafShape = TRIANGLES;

    fn put(&self, block: &mut TriangleBlock, lane: usize, prim_id: u32) {
        block.set(lane, &self.0.triangle(prim_id as usize), prim_id);
    }

    fn validate(&self, nodes: &[Node], blocks: &[TriangleBlock]) -> Result<u32, InvalidTree> {
        validate::validate(nodes, blocks)
    }
}
