//! Validates a tree once, so that traversal needs no checks.
//!
//! Nodes and blocks are stored in depth-first order, the inner children of a node side by side. The walk here expects
//! exactly this order, so it visits each of them once, and finds cycles and shared or unreferenced nodes without any
//! memory but its stack. It also counts the stack entries that a traversal can need, whatever its order of children.

use super::node::{Child, WIDTH};
use super::{MAX_STACK, Node, TriangleBlock};
use crate::error::InvalidTree;
use crate::geometry::{Aabb, Hit, MAX_COORDINATE};

/// Checks a tree; see [`BvhView::new`](super::BvhView::new). Gives the number of entries that the stack of a traversal
/// needs, whatever the order in which it visits children.
pub(super) fn validate(nodes: &[Node], blocks: &[TriangleBlock]) -> Result<u32, InvalidTree> {
    validate_nodes(nodes, blocks.len(), |first, end| leaf_bounds(&blocks[first..end], first as u32))
}

/// Checks a tree of any blocks, `bounds` of which gives the box around a range that exists.
pub(super) fn validate_nodes(
    nodes: &[Node],
    blocks: usize,
    mut bounds: impl FnMut(usize, usize) -> Result<Aabb, InvalidTree>,
) -> Result<u32, InvalidTree> {
    if nodes.is_empty() {
        return Err(InvalidTree::NoRoot);
    }
    if nodes.len() > Child::MAX_INDEX as usize || blocks > Child::MAX_INDEX as usize {
        return Err(InvalidTree::TooLarge { limit: Child::MAX_INDEX });
    }
    // Nodes to visit, each with the number of entries that a traversal may hold when it gets there.
    let mut stack = [(0u32, 0usize); MAX_STACK];
    let mut height = 1;
    let (mut next_node, mut next_block) = (1, 0);
    // The root is an entry.
    let mut most_needed = 1;
    while height > 0 {
        height -= 1;
        let (index, held) = stack[height];
        let node = &nodes[index as usize];
        if !node.orders_are_permutations() {
            return Err(InvalidTree::BadOrder { node: index });
        }
        let children = node.children.iter().filter(|&&child| Child::unpack(child) != Child::Empty).count();
        let needed = held + children;
        if needed > MAX_STACK {
            return Err(InvalidTree::TooDeep { needed: needed as u32, allowed: MAX_STACK as u32 });
        }
        most_needed = most_needed.max(needed);
        let first_inner = next_node;
        for slot in 0..WIDTH {
            let bad_child = InvalidTree::BadChild { node: index, slot: slot as u32 };
            let contents = match Child::unpack(node.children[slot]) {
                // Any other box would get into the bounds of the node, and so of the scene.
                Child::Empty if node.aabb(slot) == Aabb::EMPTY => continue,
                Child::Empty => return Err(bad_child),
                Child::Node(child) if child == next_node && (child as usize) < nodes.len() => {
                    next_node += 1;
                    nodes[child as usize].bounds()
                }
                Child::Node(_) => return Err(bad_child),
                Child::Leaf { first, count } if first == next_block => {
                    next_block += count;
                    if next_block as usize > blocks {
                        return Err(bad_child);
                    }
                    bounds(first as usize, next_block as usize)?
                }
                Child::Leaf { .. } => return Err(bad_child),
            };
            let aabb = node.aabb(slot);
            let limit = glam::Vec3::splat(MAX_COORDINATE);
            let finite = aabb.min.abs().cmple(limit).all() && aabb.max.abs().cmple(limit).all();
            let encloses = aabb.min.cmple(contents.min).all() && contents.max.cmple(aabb.max).all();
            if !(finite && encloses) || aabb.is_empty() {
                return Err(InvalidTree::BadBox { node: index, slot: slot as u32 });
            }
        }
        for inner in (first_inner..next_node).rev() {
            // There is room: inner nodes on the stack are among the entries just counted.
            stack[height] = (inner, needed - 1);
            height += 1;
        }
    }
    if next_node as usize != nodes.len() {
        return Err(InvalidTree::UnreachableNode { node: next_node });
    }
    if next_block as usize != blocks {
        return Err(InvalidTree::UnreferencedBlock { block: next_block });
    }
    Ok(most_needed as u32)
}

/// The box around a leaf's triangles.
fn leaf_bounds(blocks: &[TriangleBlock], first: u32) -> Result<Aabb, InvalidTree> {
    let mut bounds = Aabb::EMPTY;
    for (index, block) in (first..).zip(blocks) {
        for lane in 0..WIDTH {
            let triangle = block.triangle(lane);
            let used = block.prim_id[lane] != Hit::NO_PRIM;
            let good = if used {
                triangle.iter().all(|p| p.abs().cmple(glam::Vec3::splat(MAX_COORDINATE)).all())
            } else {
                triangle.iter().all(|p| p.is_nan_mask().all())
            };
            if !good {
                return Err(InvalidTree::BadTriangle { block: index, lane: lane as u32 });
            }
            if used {
                bounds = bounds.union(&Aabb::around(&triangle));
            }
        }
    }
    Ok(bounds)
}
