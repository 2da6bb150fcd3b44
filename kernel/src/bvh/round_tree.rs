//! Builds a tree over points or curves and owns it.

use alloc::vec::Vec;

use super::build::{BuildReport, build_tree, check_count};
use super::contents::{Contents, LeafShape};
use super::executor::{Executor, Serial};
use super::node::{Node, WIDTH};
use super::options::BuildOptions;
use super::primitive::Primitive;
use super::round_block::{CubicCurveBlock, DiscBlock, LinearCurveBlock, RoundBlock, SphereBlock, leaf_bounds};
use super::{RoundBlocks, RoundBvhView, validate};
use crate::error::{Error, InvalidTree};
use crate::geometry::round::RoundPrimitive;
use crate::geometry::{Aabb, CubicCurve, Disc, LinearCurve, Sphere};

/// A tree over spheres, discs or round curves that owns its memory.
#[derive(Clone, Debug)]
pub struct RoundBvh {
    nodes: Vec<Node>,
    blocks: Blocks,
    bounds: Aabb,
}

#[derive(Clone, Debug)]
pub enum Blocks {
    Spheres(Vec<SphereBlock>),
    Discs(Vec<DiscBlock>),
    LinearCurves(Vec<LinearCurveBlock>),
    CubicCurves(Vec<CubicCurveBlock>),
}

/// The primitives that a [`RoundBvh`] can be built over: [`Sphere`], [`Disc`], [`LinearCurve`], [`CubicCurve`].
pub trait RoundBuild: InBlocks {}

impl<P: InBlocks> RoundBuild for P {}

/// A primitive that is stored in blocks.
pub trait InBlocks: RoundPrimitive {
    type Block: RoundBlock<Primitive = Self>;
    /// The cost of a block's test, in units of that of a node.
    const BLOCK_COST: f32;
    fn keep(blocks: Vec<Self::Block>) -> Blocks;
}

macro_rules! build {
    ($($primitive:ident: $block:ident, $kind:ident, $cost:literal;)*) => {$(
        impl InBlocks for $primitive {
            type Block = $block;
            const BLOCK_COST: f32 = $cost;
            fn keep(blocks: Vec<$block>) -> Blocks {
                Blocks::$kind(blocks)
            }
        }
    )*};
}

build! {
    Sphere: SphereBlock, Spheres, 0.6;
    Disc: DiscBlock, Discs, 0.6;
    LinearCurve: LinearCurveBlock, LinearCurves, 0.8;
    CubicCurve: CubicCurveBlock, CubicCurves, 2.0;
}

impl RoundBvh {
    /// Builds a tree over `primitives` on this thread; a hit's `prim_id` is an index into them.
    ///
    /// Primitives that no ray can hit are left out and counted. The tree depends on the primitives and options alone,
    /// and holds a copy of the primitives: with 100,000 of them about 32 bytes for each sphere, 50 for each disc, 54
    /// for each linear and 115 for each cubic curve, nodes included.
    ///
    /// # Errors
    /// [`Error::TooManyPrimitives`] beyond [`MAX_TRIANGLES`](super::Bvh::MAX_TRIANGLES), and [`InvalidTree::TooLarge`]
    /// if fewer do not fit, as blocks are not full.
    pub fn build<P: RoundBuild>(primitives: &[P], options: &BuildOptions) -> Result<(Self, BuildReport), Error> {
        Self::build_on(&Serial, primitives, options)
    }

    /// Like [`build`](Self::build), on the threads of `executor`, which also receives the progress. The tree does not
    /// depend on it.
    ///
    /// # Errors
    /// The errors of [`build`](Self::build).
    pub fn build_on<E: Executor, P: RoundBuild>(
        executor: &E,
        primitives: &[P],
        options: &BuildOptions,
    ) -> Result<(Self, BuildReport), Error> {
        check_count(primitives.len())?;
        let mut report = BuildReport::default();
        let prims = || usable(primitives, &mut report);
        let tree = build_tree(executor, &Rounds(primitives), prims, options.quality)?;
        report.rejected_builds = tree.rejected_builds;
        let (nodes, blocks) = (tree.collapsed.nodes, tree.collapsed.blocks);
        let bounds = nodes[0].bounds();
        Ok((Self { nodes, blocks: P::keep(blocks), bounds }, report))
    }

    /// A copy of a tree.
    pub(crate) fn copy_of(tree: &RoundBvhView) -> Self {
        let blocks = match tree.blocks() {
            RoundBlocks::Spheres(blocks) => Blocks::Spheres(blocks.to_vec()),
            RoundBlocks::Discs(blocks) => Blocks::Discs(blocks.to_vec()),
            RoundBlocks::LinearCurves(blocks) => Blocks::LinearCurves(blocks.to_vec()),
            RoundBlocks::CubicCurves(blocks) => Blocks::CubicCurves(blocks.to_vec()),
        };
        Self { nodes: tree.nodes().to_vec(), blocks, bounds: tree.bounds() }
    }

    /// Borrows the tree for tracing.
    pub fn view(&self) -> RoundBvhView<'_> {
        let blocks = match &self.blocks {
            Blocks::Spheres(blocks) => RoundBlocks::Spheres(blocks),
            Blocks::Discs(blocks) => RoundBlocks::Discs(blocks),
            Blocks::LinearCurves(blocks) => RoundBlocks::LinearCurves(blocks),
            Blocks::CubicCurves(blocks) => RoundBlocks::CubicCurves(blocks),
        };
        RoundBvhView::with_bounds(&self.nodes, blocks, self.bounds)
    }

    /// Memory of nodes and blocks in bytes.
    pub fn memory_bytes(&self) -> usize {
        let blocks = match &self.blocks {
            Blocks::Spheres(blocks) => size_of_val(&blocks[..]),
            Blocks::Discs(blocks) => size_of_val(&blocks[..]),
            Blocks::LinearCurves(blocks) => size_of_val(&blocks[..]),
            Blocks::CubicCurves(blocks) => size_of_val(&blocks[..]),
        };
        size_of_val(&self.nodes[..]) + blocks
    }
}

/// The primitives that a ray can hit; counts them and the others.
fn usable<P: RoundPrimitive>(primitives: &[P], report: &mut BuildReport) -> Vec<Primitive> {
    *report = BuildReport { rejected_builds: report.rejected_builds, ..BuildReport::default() };
    let mut prims = Vec::with_capacity(primitives.len());
    for (prim_id, primitive) in (0..).zip(primitives) {
        match primitive.fault() {
            Some(fault) => report.drop(prim_id, fault),
            None => prims.push(Primitive::new(&primitive.bounds(), prim_id)),
        }
    }
    report.kept = prims.len();
    prims
}

/// Primitives in blocks of eight.
struct Rounds<'a, P>(&'a [P]);

impl<P: RoundBuild> Contents for Rounds<'_, P> {
    type Block = P::Block;
    const EMPTY: P::Block = P::Block::EMPTY;
    const SHAPE: LeafShape = LeafShape { lanes: WIDTH as u32, blocks: 2, cost: P::BLOCK_COST };

    fn put(&self, block: &mut P::Block, lane: usize, prim_id: u32) {
        block.set(lane, &self.0[prim_id as usize], prim_id);
    }

    fn validate(&self, nodes: &[Node], blocks: &[P::Block]) -> Result<u32, InvalidTree> {
        validate::validate_nodes(nodes, blocks.len(), |first, end| leaf_bounds(&blocks[first..end], first as u32))
    }
}
