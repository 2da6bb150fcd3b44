//! Lays out the eight-wide tree: nodes and blocks in the order that [`validate`](super::validate) describes.
//!
//! One walk finds where everything goes; the expensive steps, filling blocks and ordering children, then run in
//! parallel.

use alloc::vec;
use alloc::vec::Vec;

use super::binary::BinaryTree;
use super::contents::Contents;
use super::executor::Executor;
use super::node::{Child, Node, WIDTH};
use super::pages;
use super::plan::Plan;
use crate::error::InvalidTree;

/// Nodes or leaves that are one task.
const TASK: usize = 1 << 10;

/// The wide tree and its expected cost.
pub(super) struct Collapsed<B> {
    pub nodes: Vec<Node>,
    pub blocks: Vec<B>,
    /// Expected cost of a random ray that meets the root's box.
    pub cost: f32,
}

/// A leaf: the binary node it is made of, and where its blocks begin.
#[derive(Clone, Copy)]
struct Leaf {
    source: u32,
    first: u32,
}

/// The source of the leaves' contents.
struct Source<'a, C: ?Sized> {
    tree: &'a BinaryTree,
    contents: &'a C,
}

/// Collapses `tree`, whose nodes are [in order](BinaryTree::in_order); `work` is its part of the whole build. Fails if
/// there are more nodes or blocks than a child can refer to.
pub(super) fn collapse<E: Executor, C: Contents + ?Sized>(
    executor: &E,
    tree: &BinaryTree,
    contents: &C,
    work: f32,
) -> Result<Collapsed<C::Block>, InvalidTree> {
    let plan = Plan::new(executor, tree, C::SHAPE);
    executor.advance(0.4 * work);
    let mut nodes = vec![Node::EMPTY];
    let mut leaves = Vec::new();
    let mut blocks = 0;
    let mut todo = vec![(0, 0)];
    while let Some((binary, target)) = todo.pop() {
        let mut node = Node::EMPTY;
        let inner = todo.len();
        let mut roots = [0; WIDTH];
        // A node adds eight of each at most, and a leaf has two blocks at most.
        let room = Child::MAX_INDEX - 2 * WIDTH as u32;
        if nodes.len() > room as usize || blocks > room {
            return Err(InvalidTree::TooLarge { limit: Child::MAX_INDEX });
        }
        let count = plan.roots(binary, &mut roots);
        for (slot, &root) in roots[..count].iter().enumerate() {
            let contents = if plan.is_leaf(root) {
                leaves.push(Leaf { source: root as u32, first: blocks });
                let count = C::SHAPE.blocks_of(plan.prims(root));
                let first = blocks;
                blocks += count;
                Child::Leaf { first, count }
            } else {
                let index = nodes.len();
                nodes.push(Node::EMPTY);
                todo.push((root, index));
                Child::Node(index as u32)
            };
            node.set(slot, &tree.nodes[root].aabb, contents);
        }
        // The first child is to be met first.
        todo[inner..].reverse();
        nodes[target] = node;
    }
    let cost = plan.expected_cost();
    drop(plan);
    executor.advance(0.2 * work);
    let mut nodes = pages::moved(nodes);
    let mut filled = pages::filled(C::EMPTY, blocks as usize);
    executor.join(|| sort(executor, &mut nodes), || Source { tree, contents }.fill(executor, &leaves, &mut filled));
    executor.advance(0.4 * work);
    Ok(Collapsed { nodes, blocks: filled, cost })
}

/// Orders the children of each node.
fn sort<E: Executor>(executor: &E, nodes: &mut [Node]) {
    if nodes.len() > TASK {
        let (a, b) = nodes.split_at_mut(nodes.len() / 2);
        executor.join(|| sort(executor, a), || sort(executor, b));
    } else {
        nodes.iter_mut().for_each(Node::sort);
    }
}

impl<C: Contents + ?Sized> Source<'_, C> {
    /// Fills the blocks of leaves, which lie in order.
    fn fill<E: Executor>(&self, executor: &E, leaves: &[Leaf], blocks: &mut [C::Block]) {
        if leaves.len() > TASK {
            let (a, b) = leaves.split_at(leaves.len() / 2);
            let (c, d) = blocks.split_at_mut((b[0].first - a[0].first) as usize);
            executor.join(|| self.fill(executor, a, c), || self.fill(executor, b, d));
            return;
        }
        let mut prim_ids = Vec::with_capacity(C::SHAPE.most() as usize);
        let mut blocks = blocks.iter_mut();
        for leaf in leaves {
            prim_ids.clear();
            self.collect(leaf.source as usize, &mut prim_ids);
            // The lowest index first.
            prim_ids.sort_unstable();
            for (ids, block) in prim_ids.chunks(C::SHAPE.lanes as usize).zip(&mut blocks) {
                for (lane, &id) in ids.iter().enumerate() {
                    self.contents.put(block, lane, id);
                }
            }
        }
    }

    /// Appends the primitives below a binary node.
    fn collect(&self, index: usize, prim_ids: &mut Vec<u32>) {
        let node = &self.tree.nodes[index];
        if node.is_leaf() {
            prim_ids.extend(self.tree.prims[node.first as usize..][..node.count as usize].iter().map(|p| p.id()));
        } else {
            node.children().into_iter().for_each(|child| self.collect(child, prim_ids));
        }
    }
}
