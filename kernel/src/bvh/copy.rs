//! Copies of trees in borrowed memory.

use super::refit::expected_cost;
use super::{Bvh, BvhView, MAX_STACK, Node, TriangleBlock, pages, validate};

impl Bvh {
    /// A copy of a tree. Its cost when built is what it is now.
    pub(crate) fn copy_of(tree: &BvhView) -> Self {
        let mut nodes = pages::filled(Node::EMPTY, tree.nodes().len());
        let mut blocks = pages::filled(TriangleBlock::EMPTY, tree.blocks().len());
        nodes.copy_from_slice(tree.nodes());
        blocks.copy_from_slice(tree.blocks());
        let cost = expected_cost(&nodes);
        // It is valid, as it is in a view.
        let stack = validate::validate(&nodes, &blocks).unwrap_or(MAX_STACK as u32);
        Self { nodes, blocks, bounds: tree.bounds(), cost, built_cost: cost, stack }
    }
}
