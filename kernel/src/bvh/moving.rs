//! Builds a tree of moving triangles and owns it.

use alloc::vec::Vec;

use super::box_tree::mean;
use super::build::{BuildReport, build_tree, check_count, in_range};
use super::contents::{Contents, LeafShape, TRIANGLES};
use super::executor::{Executor, Serial};
use super::options::BuildOptions;
use super::primitive::Primitive;
use super::{MovingBvhView, Node, TriangleBlock, fit, validate};
use crate::error::{Error, InvalidTree};
use crate::geometry::{Aabb, PrimitiveFault, Triangle};

/// A tree of moving triangles that owns its memory.
#[derive(Clone, Debug)]
pub struct MovingBvh {
    nodes: Vec<Node>,
    blocks: Vec<TriangleBlock>,
    keys: usize,
    /// The box around all triangles at all times.
    bounds: Aabb,
}

impl MovingBvh {
    /// Builds a tree over triangles that are where `keys` say at times evenly spaced over 0..=1, and move in straight
    /// lines between. A hit's `prim_id` is an index into each of the keys. Triangles that no ray can hit at any time
    /// are left out and counted, and those that are beyond the limits at some time.
    ///
    /// # Errors
    /// [`InvalidTree::BadKeys`] if there are no keys or they differ in length, [`Error::TooManyPrimitives`], and
    /// [`InvalidTree::TooLarge`].
    pub fn build(keys: &[&[Triangle]], options: &BuildOptions) -> Result<(Self, BuildReport), Error> {
        Self::build_on(&Serial, keys, options)
    }

    /// Like [`build`](Self::build), on the threads of `executor`. The tree does not depend on it.
    ///
    /// # Errors
    /// The errors of [`build`](Self::build).
    pub fn build_on<E: Executor>(
        executor: &E,
        keys: &[&[Triangle]],
        options: &BuildOptions,
    ) -> Result<(Self, BuildReport), Error> {
        let count = keys.first().map_or(0, |triangles| triangles.len());
        if keys.is_empty() || keys.iter().any(|triangles| triangles.len() != count) {
            return Err(InvalidTree::BadKeys { keys: keys.len() }.into());
        }
        check_count(count)?;
        let mut report = BuildReport::default();
        let prims = || {
            report = BuildReport::default();
            let mut prims = Vec::with_capacity(count);
            for index in 0..count {
                let at_keys = || keys.iter().map(|triangles| &triangles[index]);
                if !at_keys().all(in_range) {
                    report.drop(index as u32, PrimitiveFault::OutOfRange);
                } else if never_has_area(at_keys()) {
                    report.drop(index as u32, PrimitiveFault::Degenerate);
                } else {
                    let boxes = at_keys().map(|triangle| Aabb::around(triangle));
                    prims.push(Primitive::new(&mean(boxes, keys.len()), index as u32));
                }
            }
            report.kept = prims.len();
            prims
        };
        let built = build_tree(executor, &FirstKey(keys[0]), prims, options.quality)?;
        report.rejected_builds = built.rejected_builds;
        let (shape, first) = (built.collapsed.nodes, built.collapsed.blocks);
        let mut tree = Self {
            nodes: Vec::with_capacity(keys.len() * shape.len()),
            blocks: Vec::with_capacity(keys.len() * first.len()),
            keys: keys.len(),
            bounds: Aabb::EMPTY,
        };
        for triangles in keys {
            let mut blocks = first.clone();
            blocks.iter_mut().for_each(|block| block.place(*triangles));
            let mut nodes = shape.clone();
            fit::fit(&mut nodes, |leaf| TriangleBlock::bounds_of(&blocks[leaf]));
            tree.nodes.append(&mut nodes);
            tree.blocks.append(&mut blocks);
        }
        tree.bounds = MovingBvhView::trusted(&tree.nodes, &tree.blocks, tree.keys).bounds();
        Ok((tree, report))
    }

    /// A copy of a tree in borrowed memory.
    pub(crate) fn copy_of(tree: &MovingBvhView) -> Self {
        let keys = 0..tree.keys();
        let nodes = keys.clone().flat_map(|key| tree.nodes(key)).copied().collect();
        let blocks = keys.flat_map(|key| tree.blocks(key)).copied().collect();
        Self { nodes, blocks, keys: tree.keys(), bounds: tree.bounds() }
    }

    /// Memory of nodes and blocks in bytes.
    pub fn memory_bytes(&self) -> usize {
        size_of_val(&self.nodes[..]) + size_of_val(&self.blocks[..])
    }

    /// Borrows the tree for tracing.
    pub fn view(&self) -> MovingBvhView<'_> {
        MovingBvhView::with_bounds(&self.nodes, &self.blocks, self.keys, self.bounds)
    }
}

/// Whether the same two corners are one point at all keys, and so at all times.
fn never_has_area<'a>(keys: impl Iterator<Item = &'a Triangle> + Clone) -> bool {
    [(0, 1), (1, 2), (2, 0)].iter().any(|&(i, j)| keys.clone().all(|corners| corners[i] == corners[j]))
}

/// Triangles at the first key, in nodes that are made to fit later.
struct FirstKey<'a>(&'a [Triangle]);

impl Contents for FirstKey<'_> {
    type Block = TriangleBlock;
    const EMPTY: TriangleBlock = TriangleBlock::EMPTY;
    const SHAPE: LeafShape = TRIANGLES;

    fn put(&self, block: &mut TriangleBlock, lane: usize, prim_id: u32) {
        block.set(lane, &self.0[prim_id as usize], prim_id);
    }

    fn validate(&self, nodes: &[Node], blocks: &[TriangleBlock]) -> Result<u32, InvalidTree> {
        validate::validate_nodes(nodes, blocks.len(), |_, _| Ok(Aabb::EMPTY))
    }
}
