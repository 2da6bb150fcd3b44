//! Builds a binary tree from the root down, splitting where the surface area heuristic says.
//!
//! Leaves hold one block of primitives; in small trees, where memory does not matter, up to half of one. Ranges whose
//! centroids coincide, and ranges below a certain depth, are halved instead, so that no tree is much deeper than it
//! needs to be.

use alloc::vec;
use alloc::vec::Vec;

use super::binary::{BinaryNode, BinaryTree};
use super::bins::{Binning, Bins};
use super::executor::Executor;
use super::node::WIDTH;
use super::primitive::{Bounds, Primitive, PrimitiveBounds};
use crate::geometry::Aabb;

/// Ranges of at least this many primitives are tasks of their own.
const TASK: usize = 1 << 12;
/// Trees of up to this many primitives are small.
const SMALL: usize = 1 << 14;

/// How to split.
#[derive(Clone, Copy, Debug)]
pub(super) struct Splitting {
    /// Bins along an axis, at most; up to [`MAX_BINS`](super::bins::MAX_BINS).
    pub bins: usize,
    /// Levels that are split by cost; those below are halved.
    pub levels: u32,
    /// Whether to prepare leaves for being [split](BinaryTree::in_order) in two.
    pub part_leaves: bool,
}

struct Builder<'a, E> {
    executor: &'a E,
    splitting: Splitting,
    /// Primitives a block.
    lanes: usize,
    /// Primitives in a leaf, at most.
    leaf: usize,
    /// What one primitive is of the whole build.
    share: f32,
}

/// Builds a tree over `prims`, of which there is at least one and `lanes` fill a block; `work` is its part of the whole
/// build.
pub(super) fn build<E: Executor>(
    executor: &E,
    mut prims: Vec<Primitive>,
    splitting: Splitting,
    lanes: usize,
    work: f32,
) -> BinaryTree {
    let leaf = if prims.len() <= SMALL { lanes.div_ceil(2) } else { lanes };
    let builder = Builder { executor, splitting, lanes, leaf, share: work / prims.len() as f32 };
    let bounds = builder.bounds(&prims);
    let nodes = builder.tree(&mut prims, 0, &bounds, splitting.levels);
    BinaryTree { nodes, prims }
}

impl<E: Executor> Builder<'_, E> {
    fn bounds(&self, prims: &[Primitive]) -> PrimitiveBounds {
        if prims.len() < TASK {
            return PrimitiveBounds::of(prims);
        }
        let (a, b) = prims.split_at(prims.len() / 2);
        let (mut bounds, other) = self.executor.join(|| self.bounds(a), || self.bounds(b));
        bounds.bounds.grow(&other.bounds);
        bounds.centers.grow(&other.centers);
        bounds
    }

    /// The tree over a range that starts at `first`.
    fn tree(&self, prims: &mut [Primitive], first: usize, bounds: &PrimitiveBounds, levels: u32) -> Vec<BinaryNode> {
        let mut nodes = vec![BinaryNode { aabb: Aabb::EMPTY, first: 0, count: 0, middle: 0 }];
        self.fill(&mut nodes, 0, prims, first, bounds, levels);
        if prims.len() < TASK {
            self.executor.advance(prims.len() as f32 * self.share);
        }
        nodes
    }

    /// Makes the node at `index` for a range that starts at `first`, and appends all below it.
    fn fill(
        &self,
        nodes: &mut Vec<BinaryNode>,
        index: usize,
        prims: &mut [Primitive],
        first: usize,
        bounds: &PrimitiveBounds,
        levels: u32,
    ) {
        let aabb = bounds.bounds.to_aabb();
        let count = prims.len();
        if count <= self.leaf {
            let middle = if self.splitting.part_leaves { part_leaf(prims) } else { 0 };
            nodes[index] = BinaryNode { aabb, first: first as u32, count: count as u16, middle: middle as u16 };
            return;
        }
        let (middle, [left, right]) = self.split(prims, bounds, levels);
        let levels = levels.saturating_sub(1);
        let (a, b) = prims.split_at_mut(middle);
        let second = first + middle;
        let children = nodes.len();
        nodes[index] = BinaryNode { aabb, first: children as u32, count: 0, middle: 0 };
        nodes.extend([nodes[index]; 2]);
        if count < TASK {
            self.fill(nodes, children, a, first, &left, levels);
            self.fill(nodes, children + 1, b, second, &right, levels);
        } else {
            let (a, b) =
                self.executor.join(|| self.tree(a, first, &left, levels), || self.tree(b, second, &right, levels));
            append(nodes, children, a);
            append(nodes, children + 1, b);
        }
    }

    /// Sorts a range of several primitives into two: where the second begins, and both extents.
    fn split(&self, prims: &mut [Primitive], bounds: &PrimitiveBounds, levels: u32) -> (usize, [PrimitiveBounds; 2]) {
        if levels > 0 {
            // As many bins as there are blocks, and some more.
            let count = (4 + prims.len() / self.lanes).min(self.splitting.bins);
            let binning = Binning::new(&bounds.centers, count);
            if let Some(split) = Bins::fill(self.executor, &binning, prims).best(&binning, self.lanes as u32) {
                return split.partition(self.executor, &binning, prims);
            }
        }
        halve(prims, bounds)
    }
}

/// Puts a tree's root at `index` and appends what is below it.
fn append(nodes: &mut Vec<BinaryNode>, index: usize, mut tree: Vec<BinaryNode>) {
    let shift = nodes.len() as u32 - 1;
    for node in tree.iter_mut().filter(|node| !node.is_leaf()) {
        node.first += shift;
    }
    nodes[index] = tree[0];
    nodes.extend_from_slice(&tree[1..]);
}

/// Splits in the middle of the longest axis: as many primitives on either side.
fn halve(prims: &mut [Primitive], bounds: &PrimitiveBounds) -> (usize, [PrimitiveBounds; 2]) {
    let axis = (bounds.centers.max - bounds.centers.min).max_position();
    let middle = prims.len() / 2;
    prims
        .select_nth_unstable_by(middle, |a, b| a.center()[axis].total_cmp(&b.center()[axis]).then(a.id().cmp(&b.id())));
    let (a, b) = prims.split_at(middle);
    (middle, [PrimitiveBounds::of(a), PrimitiveBounds::of(b)])
}

/// Sorts a leaf's primitives into two parts of least areas: where the second begins.
fn part_leaf(prims: &mut [Primitive]) -> usize {
    let mut best = (f32::INFINITY, 0, 0);
    for axis in 0..3 {
        sort(prims, axis);
        let mut right = [0.0; WIDTH];
        let mut bounds = Bounds::EMPTY;
        for i in (1..prims.len()).rev() {
            bounds.grow(&prims[i].bounds());
            right[i] = bounds.half_area();
        }
        let mut bounds = Bounds::EMPTY;
        for i in 1..prims.len() {
            bounds.grow(&prims[i - 1].bounds());
            let areas = bounds.half_area() + right[i];
            if areas < best.0 {
                best = (areas, axis, i);
            }
        }
    }
    let (_, axis, middle) = best;
    sort(prims, axis);
    middle
}

/// Sorts primitives along an axis.
fn sort(prims: &mut [Primitive], axis: usize) {
    prims.sort_unstable_by(|a, b| a.cmp_along(b, axis));
}
