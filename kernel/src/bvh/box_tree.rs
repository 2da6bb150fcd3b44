//! Builds a tree over boxes and owns it.

use alloc::vec::Vec;
use core::ops::Range;

use super::build::{BuildReport, build_tree};
use super::contents::{Contents, LeafShape};
use super::executor::Executor;
use super::options::BuildOptions;
use super::primitive::Primitive;
use super::{BoxTreeView, Node, WIDTH, fit, validate};
use crate::error::{Error, InvalidTree};
use crate::geometry::{Aabb, PrimitiveFault};

/// A tree over boxes that owns its memory.
#[derive(Clone, Debug)]
pub struct BoxTree {
    nodes: Vec<Node>,
    items: Vec<u32>,
    keys: usize,
    bounds: Aabb,
    cost: f32,
}

impl BoxTree {
    /// Builds a tree over `boxes`, which come in groups of equal length, one for each of `keys`. Boxes that are empty,
    /// at any key, or reach beyond the [numeric limits](crate#numeric-limits) are left out and counted.
    ///
    /// # Errors
    /// [`InvalidTree::BadKeys`] if there are no keys or they do not divide the boxes, and [`InvalidTree::TooLarge`] if
    /// there are more boxes than a tree can hold.
    pub fn build_on<E: Executor>(
        executor: &E,
        boxes: &[Aabb],
        keys: usize,
        options: &BuildOptions,
    ) -> Result<(Self, BuildReport), Error> {
        if keys == 0 || !boxes.len().is_multiple_of(keys) {
            return Err(InvalidTree::BadKeys { keys }.into());
        }
        let count = boxes.len() / keys;
        let mut report = BuildReport::default();
        let at_keys = |item: usize| (0..keys).map(move |key| &boxes[key * count + item]);
        let prims = || {
            report = BuildReport::default();
            let mut prims = Vec::with_capacity(count);
            for item in 0..count {
                if at_keys(item).any(Aabb::is_empty) {
                    report.drop(item as u32, PrimitiveFault::Degenerate);
                } else if !at_keys(item).all(Aabb::is_usable) {
                    report.drop(item as u32, PrimitiveFault::OutOfRange);
                } else {
                    prims.push(Primitive::new(&mean(at_keys(item).copied(), keys), item as u32));
                }
            }
            report.kept = prims.len();
            prims
        };
        let built = build_tree(executor, &Boxes, prims, options.quality)?;
        report.rejected_builds = built.rejected_builds;
        let items = built.collapsed.blocks;
        let mut nodes = Vec::with_capacity(keys * built.collapsed.nodes.len());
        for key in 0..keys {
            let mut moved = built.collapsed.nodes.clone();
            let around = |leaf: Range<usize>| items[leaf].iter().map(|&item| &boxes[key * count + item as usize]);
            fit::fit(&mut moved, |leaf| around(leaf).fold(Aabb::EMPTY, |a, b| a.union(b)));
            nodes.append(&mut moved);
        }
        let mut tree = Self { nodes, items, keys, bounds: Aabb::EMPTY, cost: 0.0 };
        tree.measure();
        Ok((tree, report))
    }

    /// The empty tree.
    pub(crate) fn empty() -> Self {
        Self { nodes: Vec::from([Node::EMPTY]), items: Vec::new(), keys: 1, bounds: Aabb::EMPTY, cost: 0.0 }
    }

    /// Fits the tree to boxes that have moved: `aabb` gives the box of an item at a key. Items with empty boxes cannot
    /// be found until they get another box.
    pub(crate) fn fit<E: Executor>(&mut self, executor: &E, aabb: impl Fn(usize, u32) -> Aabb + Sync) {
        let (items, count) = (&self.items, self.nodes.len() / self.keys);
        for (key, nodes) in self.nodes.chunks_mut(count).enumerate() {
            let leaf = |leaf: Range<usize>| items[leaf].iter().fold(Aabb::EMPTY, |a, &b| a.union(&aabb(key, b)));
            fit::fit_on(executor, nodes, &leaf);
        }
        self.measure();
    }

    /// The expected number of nodes visited by a random ray that meets the root's box, as a mean over the keys.
    pub(crate) fn cost(&self) -> f32 {
        self.cost
    }

    fn measure(&mut self) {
        let count = self.nodes.len() / self.keys;
        let costs = self.nodes.chunks(count).map(|nodes| {
            let whole = nodes[0].bounds().half_area();
            let below = |node: &Node| (0..WIDTH).map(|slot| node.aabb(slot).half_area()).sum::<f32>();
            if whole > 0.0 { 1.0 + nodes.iter().map(below).sum::<f32>() / whole } else { 0.0 }
        });
        self.cost = costs.sum::<f32>() / self.keys as f32;
        self.bounds = self.nodes.chunks(count).fold(Aabb::EMPTY, |sum, nodes| sum.union(&nodes[0].bounds()));
    }

    /// Memory of nodes and indices in bytes.
    pub fn memory_bytes(&self) -> usize {
        size_of_val(&self.nodes[..]) + size_of_val(&self.items[..])
    }

    /// Borrows the tree.
    pub fn view(&self) -> BoxTreeView<'_> {
        BoxTreeView::with_bounds(&self.nodes, &self.items, self.keys, self.bounds)
    }
}

/// The mean of a moving box over its keys.
pub(super) fn mean(boxes: impl Iterator<Item = Aabb>, count: usize) -> Aabb {
    let sum = boxes.fold((glam::Vec3::ZERO, glam::Vec3::ZERO), |(min, max), aabb| (min + aabb.min, max + aabb.max));
    let each = 1.0 / count as f32;
    Aabb { min: sum.0 * each, max: sum.1 * each }
}

/// Leaves of one box, by its index.
struct Boxes;

impl Contents for Boxes {
    type Block = u32;
    const EMPTY: u32 = u32::MAX;
    // Each box is a leaf of its own, whatever the tree: its cost decides nothing.
    const SHAPE: LeafShape = LeafShape { lanes: 1, blocks: 1, cost: 1.0 };

    fn put(&self, block: &mut u32, _lane: usize, prim_id: u32) {
        *block = prim_id;
    }

    fn validate(&self, nodes: &[Node], blocks: &[u32]) -> Result<u32, InvalidTree> {
        // The boxes are set later, to fit.
        validate::validate_nodes(nodes, blocks.len(), |_, _| Ok(Aabb::EMPTY))
    }
}

#[cfg(test)]
mod tests {
    use alloc::vec;

    use glam::{Vec3, vec3};

    use super::super::{BoxTreeView, Quality, Serial};
    use super::*;
    use crate::geometry::MAX_COORDINATE;

    /// Boxes along a curve, at several keys.
    fn boxes(count: usize, keys: usize) -> Vec<Aabb> {
        let aabb = |i: usize| {
            let center = (i as f32 * vec3(0.754_877_7, 0.569_840_3, 0.438_579_3)).fract();
            Aabb { min: center - 0.01, max: center + 0.01 * (i % 5) as f32 }
        };
        (0..keys * count).map(aabb).collect()
    }

    fn build(boxes: &[Aabb], keys: usize) -> (BoxTree, BuildReport) {
        BoxTree::build_on(&Serial, boxes, keys, &Quality::High.into()).unwrap()
    }

    #[test]
    fn every_box_is_in_one_leaf_and_enclosed_at_every_key() {
        for count in [0, 1, 2, 8, 9, 70, 3000] {
            for keys in 1..4 {
                let boxes = boxes(count, keys);
                let (tree, report) = build(&boxes, keys);
                assert_eq!((report.kept, report.degenerate, report.out_of_range), (count, 0, 0));
                let around = |key: usize, item: u32| boxes.get(key * count + item as usize).copied();
                let view = BoxTreeView::new(&tree.nodes, &tree.items, keys, around).unwrap();
                let mut items = view.items().to_vec();
                items.sort_unstable();
                assert!(items.into_iter().eq(0..count as u32));
                let all = boxes.iter().fold(Aabb::EMPTY, |a, b| a.union(b));
                assert_eq!((view.bounds(), view.keys()), (all, keys));
                // The root fits at each key.
                for key in 0..keys {
                    let all = boxes[key * count..][..count].iter().fold(Aabb::EMPTY, |a, b| a.union(b));
                    assert_eq!(view.nodes(key)[0].bounds(), all);
                }
                assert!(view.nodes(keys).is_empty());
            }
        }
    }

    #[test]
    fn boxes_that_nothing_can_hit_are_left_out() {
        let mut boxes = boxes(10, 2);
        boxes[3] = Aabb::EMPTY;
        boxes[14].min.x = f32::NAN;
        boxes[5].max.y = f32::INFINITY;
        boxes[17].min.z = -2.0 * MAX_COORDINATE;
        let (tree, report) = build(&boxes, 2);
        assert_eq!((report.kept, report.degenerate, report.out_of_range), (6, 2, 2));
        let mut items = tree.items.clone();
        items.sort_unstable();
        assert_eq!(items, [0, 1, 2, 6, 8, 9]);
    }

    #[test]
    fn equal_boxes_make_no_deep_tree() {
        let same = vec![Aabb { min: Vec3::ZERO, max: Vec3::ONE }; 20_000];
        let (tree, report) = build(&same, 1);
        assert_eq!((report.kept, report.rejected_builds), (20_000, 0));
        // Seven inner children or boxes more for each node: not many nodes are half empty.
        assert!(tree.nodes.len() < 20_000 / 3, "{}", tree.nodes.len());
    }

    #[test]
    fn what_is_no_tree_is_refused() {
        let boxes = boxes(40, 2);
        let (tree, _) = build(&boxes, 2);
        let around = |key: usize, item: u32| boxes.get(key * 40 + item as usize).copied();
        let check = |tree: &BoxTree, keys: usize| BoxTreeView::new(&tree.nodes, &tree.items, keys, around).err();
        assert_eq!(check(&tree, 2), None);
        for keys in [0, tree.nodes.len() + 1] {
            assert_eq!(check(&tree, keys), Some(InvalidTree::BadKeys { keys }.into()));
            let error = BoxTree::build_on(&Serial, &boxes, if keys == 0 { 0 } else { 3 }, &Quality::High.into()).err();
            assert!(matches!(error, Some(Error::InvalidTree(InvalidTree::BadKeys { .. }))));
        }
        let mut other = tree.clone();
        other.items[7] = 4000;
        assert_eq!(check(&other, 2), Some(InvalidTree::BadItem { place: 7 }.into()));
        let mut other = tree.clone();
        let last = other.nodes.len() - 1;
        other.nodes[last].planes[0][1][0] -= 0.5;
        assert!(matches!(check(&other, 2), Some(Error::InvalidTree(InvalidTree::BadBox { .. }))));
        let mut other = tree.clone();
        other.nodes[last].children.swap(0, 1);
        assert!(check(&other, 2).is_some());
        let mut other = tree;
        other.items.pop();
        assert!(check(&other, 2).is_some());
    }
}
