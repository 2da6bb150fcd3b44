//! Improves a binary tree by moving subtrees: Meister and Bittner 2018, "Parallel Reinsertion for Bounding Volume
//! Hierarchy Optimization".
//!
//! A round finds for each node the place where it would make the sum of all inner nodes' areas least, in parallel and
//! on the tree as it is; then it carries out the moves, the greatest gain first, skipping those that change a node
//! which an earlier one has changed. Deviation: a node is not moved below itself, which two moves together could cause
//! without changing the same nodes.

use alloc::vec;
use alloc::vec::Vec;

use super::binary::{BinaryNode, BinaryTree};
use super::executor::Executor;
use super::primitive::Bounds;

/// Searches that are one task.
const TASK: usize = 1 << 8;

/// A subtree and the node that it is to become the sibling of.
#[derive(Clone, Copy, Debug, Default)]
struct Move {
    from: u32,
    to: u32,
    /// By how much the sum of areas would shrink; 0 if there is no better place.
    gain: f32,
}

struct Optimizer<'a> {
    nodes: &'a mut [BinaryNode],
    parents: Vec<u32>,
}

/// When to stop.
#[derive(Clone, Copy, Debug)]
pub(super) struct Patience {
    /// Rounds, at most.
    pub rounds: u32,
    /// A round that saves less than this share of the sum of areas is the last.
    pub least_gain: f32,
}

/// Improves `tree`; `work` is its part of the whole build.
pub(super) fn optimize<E: Executor>(executor: &E, tree: &mut BinaryTree, patience: Patience, mut work: f32) {
    if tree.nodes.len() < 5 {
        // The root's children and theirs have nowhere to go.
        return;
    }
    let mut optimizer = Optimizer { parents: parents(&tree.nodes), nodes: &mut tree.nodes };
    let mut moves = vec![Move::default(); optimizer.nodes.len() - 1];
    for _ in 0..patience.rounds {
        let before = optimizer.area();
        optimizer.search_all(executor, 1, &mut moves);
        optimizer.apply(&moves);
        // The number of rounds is not known beforehand.
        work *= 0.5;
        executor.advance(work);
        if optimizer.area() > before * (1.0 - f64::from(patience.least_gain)) {
            break;
        }
    }
    executor.advance(work);
}

/// Every node's parent; the root's is itself.
fn parents(nodes: &[BinaryNode]) -> Vec<u32> {
    let mut parents = vec![0; nodes.len()];
    for (index, node) in (0..).zip(nodes) {
        if !node.is_leaf() {
            for child in node.children() {
                parents[child] = index;
            }
        }
    }
    parents
}

/// The other child of the same parent: pairs begin at odd indices.
fn sibling(index: usize) -> usize {
    ((index - 1) ^ 1) + 1
}

impl Optimizer<'_> {
    fn parent(&self, index: usize) -> usize {
        self.parents[index] as usize
    }

    fn bounds(&self, index: usize) -> Bounds {
        self.nodes[index].bounds()
    }

    /// The sum of all inner nodes' areas.
    fn area(&self) -> f64 {
        self.nodes.iter().filter(|node| !node.is_leaf()).map(|node| f64::from(node.bounds().half_area())).sum()
    }

    /// Finds the best places for the nodes from `first` on, one a move.
    fn search_all<E: Executor>(&self, executor: &E, first: usize, moves: &mut [Move]) {
        if moves.len() > TASK {
            let half = moves.len() / 2;
            let (a, b) = moves.split_at_mut(half);
            executor.join(|| self.search_all(executor, first, a), || self.search_all(executor, first + half, b));
            return;
        }
        let mut stack = Vec::new();
        for (node, found) in (first..).zip(moves) {
            *found = self.search(node, &mut stack);
        }
    }

    /// The best place for a node, which is not the root.
    fn search(&self, node: usize, stack: &mut Vec<(f32, u32)>) -> Move {
        let parent = self.parent(node);
        let bounds = self.bounds(node);
        let area = bounds.half_area();
        let mut best = Move { from: node as u32, to: 0, gain: 0.0 };
        // The lowest common ancestor of the old place and the new one, and its child on the new one's side.
        let (mut pivot, mut branch) = (parent, sibling(node));
        // What is left of the old place's side of the pivot without the node, and the area that this saves.
        let mut rest = self.bounds(branch);
        let mut saved = self.bounds(parent).half_area();
        loop {
            stack.push((saved, branch as u32));
            while let Some((saved, index)) = stack.pop() {
                // The node's new parent is at least as large as the node.
                if saved - area <= best.gain {
                    continue;
                }
                let target = &self.nodes[index as usize];
                let mut merged = target.bounds();
                let target_area = merged.half_area();
                merged.grow(&bounds);
                let gain = saved - merged.half_area();
                if gain > best.gain && index as usize != parent && index as usize != sibling(node) {
                    (best.to, best.gain) = (index, gain);
                }
                if !target.is_leaf() {
                    // Below the target, the target grows instead.
                    stack.extend(target.children().map(|child| (gain + target_area, child as u32)));
                }
            }
            if pivot != parent {
                rest.grow(&self.bounds(branch));
                saved += self.bounds(pivot).half_area() - rest.half_area();
            }
            if pivot == 0 {
                return best;
            }
            (branch, pivot) = (sibling(pivot), self.parent(pivot));
        }
    }

    /// Carries out moves of which no two change the same nodes.
    fn apply(&mut self, moves: &[Move]) {
        let mut better: Vec<Move> = moves.iter().copied().filter(|one| one.gain > 0.0).collect();
        better.sort_unstable_by(|a, b| b.gain.total_cmp(&a.gain).then(a.from.cmp(&b.from)));
        let mut changed = vec![false; self.nodes.len()];
        for one in better {
            let (from, to) = (one.from as usize, one.to as usize);
            let nodes = [from, sibling(from), self.parent(from), to, self.parent(to)];
            if !nodes.iter().any(|&node| changed[node]) && !self.is_above(from, to) {
                nodes.iter().for_each(|&node| changed[node] = true);
                self.carry_out(from, to);
            }
        }
    }

    /// Whether `below` is in the subtree of `node`, which is not the root.
    fn is_above(&self, node: usize, mut below: usize) -> bool {
        while below != 0 && below != node {
            below = self.parent(below);
        }
        below == node
    }

    /// Makes `from` and `to` siblings: the sibling of `from` takes their parent's place, and `to` the sibling's.
    fn carry_out(&mut self, from: usize, to: usize) {
        let (sibling, parent) = (sibling(from), self.parent(from));
        let place = from.min(sibling) as u32;
        let [moved_up, target] = [self.nodes[sibling], self.nodes[to]];
        let mut bounds = target.bounds();
        bounds.grow(&self.bounds(from));
        self.put(parent, moved_up);
        self.put(sibling, target);
        self.put(to, BinaryNode { aabb: bounds.to_aabb(), first: place, count: 0, middle: 0 });
        self.refit_above(to);
        self.refit_above(parent);
    }

    fn put(&mut self, index: usize, node: BinaryNode) {
        self.nodes[index] = node;
        if !node.is_leaf() {
            for child in node.children() {
                self.parents[child] = index as u32;
            }
        }
    }

    /// Makes all above a node fit what is in them.
    fn refit_above(&mut self, mut index: usize) {
        while index != 0 {
            index = self.parent(index);
            let [mut bounds, other] = self.nodes[index].children().map(|child| self.bounds(child));
            bounds.grow(&other);
            let aabb = bounds.to_aabb();
            if self.nodes[index].aabb == aabb {
                return;
            }
            self.nodes[index].aabb = aabb;
        }
    }
}
