//! Chooses the eight-wide tree of least expected cost that can be made of a binary tree, after Ylitie, Karras and Laine
//! 2017, "Efficient Incoherent Ray Traversal on GPUs Through Compressed Wide BVHs", section 3.
//!
//! For each binary node `n` and each `i` from 1 to 7, `cost(n, i)` is the least cost of showing the subtree of `n` as
//! at most `i` roots of wide subtrees; `A` is a node's surface area:
//!
//! ```text
//! cost(n, 1) = min( A(n) NODE + split(n, 8),  A(n) BLOCK blocks(n) if the primitives of n fit into a leaf )
//! cost(n, i) = min( split(n, i), cost(n, i - 1) )
//! split(n, i) = min over 0 < k < i of cost(left, k) + cost(right, i - k)
//! ```

use alloc::vec;
use alloc::vec::Vec;

use super::binary::BinaryTree;
use super::contents::LeafShape;
use super::executor::{Executor, Serial};
use super::node::WIDTH;

/// Cost of visiting a node; the unit.
pub(super) const NODE: f32 = 1.0;
/// Subtrees of at least this many nodes are a task of their own.
const TASK: usize = 1 << 12;

/// The choice for each binary node.
pub(super) struct Plan<'a> {
    tree: &'a BinaryTree,
    choices: Vec<Choice>,
}

/// The state of the dynamic program at a binary node.
#[derive(Clone, Copy)]
struct Choice {
    /// `cost[i - 1]` is `cost(n, i)`.
    cost: [f32; WIDTH - 1],
    /// `left[i - 1]` is how many of `i` roots go to the left child; 0 if `cost(n, i)` is `cost(n, i - 1)`.
    left: [u8; WIDTH - 1],
    /// The split of the roots among the children of a wide node at this node.
    node_left: u8,
    is_leaf: bool,
    prims: u32,
}

impl<'a> Plan<'a> {
    /// Runs the dynamic program over a tree whose nodes are [in order](BinaryTree::in_order).
    pub(super) fn new<E: Executor>(executor: &E, tree: &'a BinaryTree, leaf: LeafShape) -> Self {
        let mut choices = vec![Choice::NONE; tree.nodes.len()];
        choices[0] = choose(executor, tree, leaf, 0, &mut choices[1..]);
        Self { tree, choices }
    }

    /// `cost(root, 1)` in units of the root's area: the expected cost of a random ray that meets the root's box.
    pub(super) fn expected_cost(&self) -> f32 {
        let root = &self.choices[0];
        // A leaf needs a node above it.
        let node = if root.is_leaf { NODE } else { 0.0 };
        match self.tree.nodes[0].aabb.half_area() {
            area if area > 0.0 => root.cost[0] / area + node,
            _ => 0.0,
        }
    }

    /// Whether a binary node becomes a leaf.
    pub(super) fn is_leaf(&self, index: usize) -> bool {
        self.choices[index].is_leaf
    }

    /// How many primitives are below a binary node.
    pub(super) fn prims(&self, index: usize) -> u32 {
        self.choices[index].prims
    }

    /// Writes the binary nodes that become the children of the wide node made of `index`, and gives their number.
    pub(super) fn roots(&self, index: usize, found: &mut [usize; WIDTH]) -> usize {
        let choice = &self.choices[index];
        if choice.is_leaf {
            // Only a root that is a leaf gets here.
            found[0] = index;
            return 1;
        }
        let mut count = 0;
        let [left, right] = self.tree.nodes[index].children();
        self.add_roots(left, choice.node_left.into(), found, &mut count);
        self.add_roots(right, WIDTH - usize::from(choice.node_left), found, &mut count);
        count
    }

    fn add_roots(&self, index: usize, mut roots: usize, found: &mut [usize; WIDTH], count: &mut usize) {
        let choice = &self.choices[index];
        while roots > 1 && choice.left[roots - 1] == 0 {
            roots -= 1;
        }
        if roots == 1 {
            found[*count] = index;
            *count += 1;
        } else {
            let share = usize::from(choice.left[roots - 1]);
            let [left, right] = self.tree.nodes[index].children();
            self.add_roots(left, share, found, count);
            self.add_roots(right, roots - share, found, count);
        }
    }
}

/// The choice for the node at `index`, having made those for all below it: its children's come first.
fn choose<E: Executor>(executor: &E, tree: &BinaryTree, leaf: LeafShape, index: usize, below: &mut [Choice]) -> Choice {
    let node = &tree.nodes[index];
    let area = node.bounds().half_area();
    if node.is_leaf() {
        let cost = leaf_cost(leaf, area, node.count.into());
        return Choice { cost: [cost; WIDTH - 1], is_leaf: true, prims: node.count.into(), ..Choice::NONE };
    }
    let [left, right] = node.children();
    let size = below.len();
    let ([left_choice, right_choice], rest) = below.split_first_chunk_mut().expect("an inner node has children");
    // What is below the right child comes last.
    let first = match tree.nodes[right] {
        ref right if right.is_leaf() => rest.len(),
        ref right => right.first as usize - (node.first as usize + 2),
    };
    let (below_left, below_right) = rest.split_at_mut(first);
    let left = || choose(executor, tree, leaf, left, below_left);
    let right = || choose(executor, tree, leaf, right, below_right);
    (*left_choice, *right_choice) = if size < TASK { Serial.join(left, right) } else { executor.join(left, right) };
    Choice::of_inner(leaf, area, left_choice, right_choice)
}

fn leaf_cost(leaf: LeafShape, area: f32, prims: u32) -> f32 {
    leaf.blocks_of(prims) as f32 * area * leaf.cost
}

impl Choice {
    const NONE: Self =
        Self { cost: [f32::INFINITY; WIDTH - 1], left: [0; WIDTH - 1], node_left: 0, is_leaf: false, prims: 0 };

    /// The choice for a node of this area, given its children's.
    fn of_inner(leaf: LeafShape, area: f32, left: &Self, right: &Self) -> Self {
        let mut choice = Self { prims: left.prims + right.prims, ..Self::NONE };
        let (children, node_left) = Self::split(left, right, WIDTH);
        let as_node = area * NODE + children;
        let as_leaf = if choice.prims <= leaf.most() { leaf_cost(leaf, area, choice.prims) } else { f32::INFINITY };
        choice.node_left = node_left;
        choice.is_leaf = as_leaf <= as_node;
        choice.cost[0] = as_leaf.min(as_node);
        for roots in 2..WIDTH {
            let (cost, share) = Self::split(left, right, roots);
            let better = cost < choice.cost[roots - 2];
            choice.cost[roots - 1] = if better { cost } else { choice.cost[roots - 2] };
            choice.left[roots - 1] = if better { share } else { 0 };
        }
        choice
    }

    /// `split(n, roots)`, and how many of the roots are the left child's.
    #[inline(always)]
    fn split(left: &Self, right: &Self, roots: usize) -> (f32, u8) {
        let mut best = (f32::INFINITY, 0);
        for share in roots.saturating_sub(WIDTH - 1).max(1)..roots.min(WIDTH) {
            let cost = left.cost[share - 1] + right.cost[roots - share - 1];
            if cost < best.0 {
                best = (cost, share as u8);
            }
        }
        best
    }
}
