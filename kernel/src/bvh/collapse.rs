//! Makes the eight-wide tree of least expected cost out of a binary tree, after Ylitie, Karras and Laine 2017,
//! "Efficient Incoherent Ray Traversal on GPUs Through Compressed Wide BVHs", section 3.
//!
//! For each binary node `n` and each `i` from 1 to 7, `cost(n, i)` is the least cost of showing the subtree of `n` as at
//! most `i` roots of wide subtrees; `A` is a node's surface area:
//!
//! ```text
//! cost(n, 1) = min( A(n) NODE + split(n, 8),  A(n) BLOCK ceil(prims(n) / 8) if prims(n) <= MAX_LEAF )
//! cost(n, i) = min( split(n, i), cost(n, i - 1) )
//! split(n, i) = min over 0 < k < i of cost(left, k) + cost(right, i - k)
//! ```

use alloc::vec;
use alloc::vec::Vec;

use super::binary::BinaryTree;
use super::node::{Child, Node, TriangleBlock, WIDTH};
use crate::geometry::Triangle;

/// Cost of visiting a node; the unit.
const NODE: f32 = 1.0;
/// Cost of testing a block of triangles.
const BLOCK: f32 = 0.6;
/// Triangles in a leaf, at most.
const MAX_LEAF: u32 = 2 * WIDTH as u32;

/// What the dynamic program knows of a binary node.
#[derive(Clone, Copy)]
struct Plan {
    /// `cost[i - 1]` is `cost(n, i)`.
    cost: [f32; WIDTH - 1],
    /// `left[i - 1]` is how many of `i` roots go to the left child; 0 if `cost(n, i)` is `cost(n, i - 1)`.
    left: [u8; WIDTH - 1],
    /// The same for the children of a wide node here.
    node_left: u8,
    is_leaf: bool,
    prims: u32,
}

/// The wide tree, in the order that [`validate`](super::validate) describes, and its expected cost.
pub(super) struct Collapsed {
    pub nodes: Vec<Node>,
    pub blocks: Vec<TriangleBlock>,
    /// `cost(root, 1)` in units of the root's area: the expected cost of a random ray that meets the root's box.
    pub cost: f32,
}

/// Collapses `tree` over `triangles`.
pub(super) fn collapse(tree: &BinaryTree, triangles: &[Triangle]) -> Collapsed {
    let plans = plan(tree);
    let mut out = Collapsed { nodes: vec![Node::EMPTY], blocks: Vec::new(), cost: expected_cost(tree, &plans) };
    let mut todo = vec![(0usize, 0usize)];
    while let Some((source, target)) = todo.pop() {
        let mut node = Node::EMPTY;
        let inner = todo.len();
        for (slot, child) in roots(tree, &plans, source).into_iter().enumerate() {
            let contents = if plans[child].is_leaf {
                out.push_leaf(tree, triangles, child)
            } else {
                let index = out.nodes.len();
                out.nodes.push(Node::EMPTY);
                todo.push((child, index));
                Child::Node(index as u32)
            };
            node.set(slot, &tree.nodes[child].aabb, contents);
        }
        // The first child is to be met first.
        todo[inner..].reverse();
        node.sort();
        out.nodes[target] = node;
    }
    out
}

/// Runs the dynamic program from the leaves up.
fn plan(tree: &BinaryTree) -> Vec<Plan> {
    let nothing =
        Plan { cost: [f32::INFINITY; WIDTH - 1], left: [0; WIDTH - 1], node_left: 0, is_leaf: false, prims: 0 };
    let mut plans = vec![nothing; tree.nodes.len()];
    for index in depth_first(tree).into_iter().rev() {
        let node = &tree.nodes[index];
        let area = node.aabb.half_area();
        let leaf_cost = |prims: u32| (prims as usize).div_ceil(WIDTH) as f32 * area * BLOCK;
        plans[index] = if node.is_leaf() {
            Plan { cost: [leaf_cost(node.count); WIDTH - 1], is_leaf: true, prims: node.count, ..nothing }
        } else {
            let [left, right] = node.children().map(|child| plans[child]);
            let split = |roots: usize| {
                let cost = |k: usize| left.cost[k - 1] + right.cost[roots - k - 1];
                let best =
                    (1..roots).filter(|&k| k < WIDTH && roots - k < WIDTH).min_by(|&a, &b| cost(a).total_cmp(&cost(b)));
                best.map_or((f32::INFINITY, 0), |k| (cost(k), k as u8))
            };
            let mut plan = Plan { prims: left.prims + right.prims, ..nothing };
            let (children, node_left) = split(WIDTH);
            let as_node = area * NODE + children;
            let as_leaf = if plan.prims <= MAX_LEAF { leaf_cost(plan.prims) } else { f32::INFINITY };
            plan.node_left = node_left;
            plan.is_leaf = as_leaf <= as_node;
            plan.cost[0] = as_leaf.min(as_node);
            for roots in 2..WIDTH {
                let (cost, k) = split(roots);
                let better = cost < plan.cost[roots - 2];
                plan.cost[roots - 1] = if better { cost } else { plan.cost[roots - 2] };
                plan.left[roots - 1] = if better { k } else { 0 };
            }
            plan
        };
    }
    plans
}

/// All nodes, parents before children.
fn depth_first(tree: &BinaryTree) -> Vec<usize> {
    let mut order = Vec::with_capacity(tree.nodes.len());
    let mut todo = vec![0];
    while let Some(index) = todo.pop() {
        order.push(index);
        if !tree.nodes[index].is_leaf() {
            todo.extend(tree.nodes[index].children());
        }
    }
    order
}

fn expected_cost(tree: &BinaryTree, plans: &[Plan]) -> f32 {
    match tree.nodes[0].aabb.half_area() {
        area if area > 0.0 => plans[0].cost[0] / area,
        _ => 0.0,
    }
}

/// The binary nodes that become the children of the wide node made of `index`: up to eight.
fn roots(tree: &BinaryTree, plans: &[Plan], index: usize) -> Vec<usize> {
    let mut found = Vec::with_capacity(WIDTH);
    if plans[index].is_leaf {
        // Only a root that is a leaf gets here.
        found.push(index);
        return found;
    }
    let share = |index: usize, left: u8, roots: usize| {
        let [l, r] = tree.nodes[index].children();
        [(r, roots - left as usize), (l, left as usize)]
    };
    let mut todo = Vec::from(share(index, plans[index].node_left, WIDTH));
    while let Some((index, mut roots)) = todo.pop() {
        let plan = &plans[index];
        while roots > 1 && plan.left[roots - 1] == 0 {
            roots -= 1;
        }
        if roots == 1 {
            found.push(index);
        } else {
            todo.extend(share(index, plan.left[roots - 1], roots));
        }
    }
    found
}

impl Collapsed {
    /// Appends the triangles below `index`, the lowest `prim_id` first.
    fn push_leaf(&mut self, tree: &BinaryTree, triangles: &[Triangle], index: usize) -> Child {
        let mut prim_ids = Vec::with_capacity(MAX_LEAF as usize);
        let mut todo = vec![index];
        while let Some(index) = todo.pop() {
            let node = &tree.nodes[index];
            if node.is_leaf() {
                prim_ids.extend_from_slice(&tree.prim_ids[node.first as usize..][..node.count as usize]);
            } else {
                todo.extend(node.children());
            }
        }
        prim_ids.sort_unstable();
        let first = self.blocks.len() as u32;
        for ids in prim_ids.chunks(WIDTH) {
            let mut block = TriangleBlock::EMPTY;
            for (lane, &id) in ids.iter().enumerate() {
                block.set(lane, &triangles[id as usize], id);
            }
            self.blocks.push(block);
        }
        Child::Leaf { first, count: self.blocks.len() as u32 - first }
    }
}
