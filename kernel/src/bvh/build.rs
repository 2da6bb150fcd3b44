//! Builds a tree and owns it.

use alloc::vec;
use alloc::vec::Vec;
use core::fmt;

use super::binary::MAX_DEPTH;
use super::collapse::{self, Collapsed};
use super::contents::{Contents, Faces};
use super::executor::{Executor, Serial};
use super::node::{Child, Node, TriangleBlock, WIDTH};
use super::options::{BuildOptions, Effort, Quality};
use super::primitive::Primitive;
use super::{BvhView, MAX_STACK, reinsertion, top_down};
use crate::error::{Error, InvalidTree};
#[cfg(doc)]
use crate::geometry::round::RoundPrimitive;
use crate::geometry::{Aabb, Hit, MAX_COORDINATE, PrimitiveFault, Triangle};
use crate::mesh::Mesh;

/// A tree that owns its memory.
#[derive(Clone, Debug)]
pub struct Bvh {
    pub(super) nodes: Vec<Node>,
    pub(super) blocks: Vec<TriangleBlock>,
    /// The box around all triangles.
    pub(super) bounds: Aabb,
    pub(super) cost: f32,
    /// The cost before any triangle was moved.
    pub(super) built_cost: f32,
    /// Entries that the stack of a traversal needs.
    pub(super) stack: u32,
}

/// What a build left out, and why.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct BuildReport {
    /// Primitives in the tree.
    pub kept: usize,
    /// Primitives that no ray hits: triangles with two equal corners, points and curves whose radii are all zero or one
    /// less than zero, discs without a normal, empty boxes.
    pub degenerate: usize,
    /// Primitives with a coordinate or radius that is NaN or infinite.
    pub not_finite: usize,
    /// Primitives that reach beyond [`MAX_COORDINATE`].
    pub out_of_range: usize,
    /// The first primitive that was left out; of points and curves [`RoundPrimitive::fault`] says why.
    pub first_dropped: Option<u32>,
    /// How many trees were built and rejected as too deep, before one with less regard for cost was accepted.
    pub rejected_builds: u32,
}

/// A tree in figures.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TreeStatistics {
    /// Nodes.
    pub nodes: usize,
    /// Leaves.
    pub leaves: usize,
    /// Blocks of triangles.
    pub blocks: usize,
    /// Triangles.
    pub triangles: usize,
    /// Nodes on the longest path from the root to a leaf.
    pub depth: usize,
    /// Expected cost of a random ray that meets the scene's box (surface area heuristic): 1 a node visited, 0.6 a
    /// block.
    pub cost: f32,
    /// Memory of nodes and blocks in bytes.
    pub memory_bytes: usize,
    /// Entries that the stack of a traversal needs, of [`MAX_STACK`].
    pub stack: u32,
}

impl BuildReport {
    /// Primitives that are not in the tree, for any reason.
    pub fn dropped(&self) -> usize {
        self.degenerate + self.not_finite + self.out_of_range
    }

    /// Counts a primitive that is left out; they come in their order.
    pub(super) fn drop(&mut self, prim_id: u32, fault: PrimitiveFault) {
        self.first_dropped.get_or_insert(prim_id);
        match fault {
            PrimitiveFault::NotFinite => self.not_finite += 1,
            PrimitiveFault::OutOfRange => self.out_of_range += 1,
            PrimitiveFault::Degenerate => self.degenerate += 1,
        }
    }
}

impl fmt::Display for BuildReport {
    /// Prints for example `12 primitives kept, 3 dropped, the first of them 4: 2 degenerate, 1 not finite`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let plural = if self.kept == 1 { "" } else { "s" };
        write!(f, "{} primitive{plural} kept, {} dropped", self.kept, self.dropped())?;
        if let Some(first) = self.first_dropped {
            write!(f, ", the first of them {first}")?;
        }
        let mut separator = ": ";
        let reasons =
            [(self.degenerate, "degenerate"), (self.not_finite, "not finite"), (self.out_of_range, "too far away")];
        for (count, reason) in reasons.into_iter().filter(|&(count, _)| count > 0) {
            write!(f, "{separator}{count} {reason}")?;
            separator = ", ";
        }
        Ok(())
    }
}

impl Bvh {
    /// The most triangles that a tree can hold: 2²⁹ - 1, if all blocks but the last are full.
    pub const MAX_TRIANGLES: usize = Child::MAX_INDEX as usize * WIDTH - 1;

    /// Builds a tree over `triangles` on this thread; a hit's `prim_id` is an index into them.
    ///
    /// Triangles that no ray can hit are left out and counted. The tree depends on the triangles and options alone.
    ///
    /// # Errors
    /// [`Error::TooManyPrimitives`] beyond [`MAX_TRIANGLES`](Self::MAX_TRIANGLES), and [`InvalidTree::TooLarge`] if
    /// fewer do not fit, as blocks are not full.
    pub fn build(triangles: &[Triangle], options: &BuildOptions) -> Result<(Self, BuildReport), Error> {
        Self::build_on(&Serial, triangles, options)
    }

    /// Like [`build`](Self::build), on the threads of `executor`, which also receives the progress. The tree does not
    /// depend on it.
    ///
    /// # Errors
    /// The errors of [`build`](Self::build).
    pub fn build_on<E: Executor>(
        executor: &E,
        triangles: &[Triangle],
        options: &BuildOptions,
    ) -> Result<(Self, BuildReport), Error> {
        Self::build_mesh_on(executor, triangles, options)
    }

    /// Like [`build`](Self::build), over triangles in another layout, such as an
    /// [`IndexedMesh`](crate::mesh::IndexedMesh). The tree is that over the same triangles in a slice.
    ///
    /// # Errors
    /// The errors of [`build`](Self::build).
    pub fn build_mesh<M: Mesh + ?Sized>(mesh: &M, options: &BuildOptions) -> Result<(Self, BuildReport), Error> {
        Self::build_mesh_on(&Serial, mesh, options)
    }

    /// Like [`build_mesh`](Self::build_mesh), on the threads of `executor`.
    ///
    /// # Errors
    /// The errors of [`build`](Self::build).
    pub fn build_mesh_on<E: Executor, M: Mesh + ?Sized>(
        executor: &E,
        mesh: &M,
        options: &BuildOptions,
    ) -> Result<(Self, BuildReport), Error> {
        check_count(mesh.len())?;
        let mut report = BuildReport::default();
        let prims = || usable(mesh, &mut report);
        let tree = build_tree(executor, &Faces(mesh), prims, options.quality)?;
        report.rejected_builds = tree.rejected_builds;
        let Collapsed { nodes, blocks, cost } = tree.collapsed;
        let bounds = nodes[0].bounds();
        Ok((Self { nodes, blocks, bounds, cost, built_cost: cost, stack: tree.stack }, report))
    }

    /// Borrows the tree for tracing.
    pub fn view(&self) -> BvhView<'_> {
        BvhView::with_bounds(&self.nodes, &self.blocks, self.bounds)
    }

    /// The tree in figures.
    pub fn statistics(&self) -> TreeStatistics {
        let (mut leaves, mut depth) = (0, 0);
        let mut todo = vec![(0usize, 1usize)];
        while let Some((index, level)) = todo.pop() {
            depth = depth.max(level);
            for &child in &self.nodes[index].children {
                match Child::unpack(child) {
                    Child::Empty => {}
                    Child::Node(index) => todo.push((index as usize, level + 1)),
                    Child::Leaf { .. } => leaves += 1,
                }
            }
        }
        let used = self.blocks.iter().flat_map(|block| block.prim_id).filter(|&id| id != Hit::NO_PRIM);
        TreeStatistics {
            nodes: self.nodes.len(),
            leaves,
            blocks: self.blocks.len(),
            triangles: used.count(),
            depth,
            cost: self.cost,
            memory_bytes: size_of_val(&self.nodes[..]) + size_of_val(&self.blocks[..]),
            stack: self.stack,
        }
    }
}

/// A tree, the entries that the stack of a traversal needs, and how many trees before it were too deep.
pub(super) struct Built<B> {
    pub collapsed: Collapsed<B>,
    pub stack: u32,
    pub rejected_builds: u32,
}

/// Builds a tree over those of `contents` that `prims` gives, and gives anew if a tree is too deep.
pub(super) fn build_tree<E: Executor, C: Contents + ?Sized>(
    executor: &E,
    contents: &C,
    mut prims: impl FnMut() -> Vec<Primitive>,
    quality: Quality,
) -> Result<Built<C::Block>, InvalidTree> {
    let mut rejected_builds = 0;
    // Moving subtrees has no regard for depth, splitting by cost hardly any, and splitting in the middle all.
    for effort in [quality.effort(), Effort::SPLIT_ONLY, Effort::MEDIAN] {
        let prims = prims();
        if prims.is_empty() {
            break;
        }
        executor.advance(0.05);
        match attempt(executor, contents, prims, effort) {
            Err(InvalidTree::TooDeep { .. }) => rejected_builds += 1,
            result => return result.map(|(collapsed, stack)| Built { collapsed, stack, rejected_builds }),
        }
    }
    let collapsed = Collapsed { nodes: vec![Node::EMPTY], blocks: Vec::new(), cost: 0.0 };
    Ok(Built { collapsed, stack: 1, rejected_builds })
}

fn attempt<E: Executor, C: Contents + ?Sized>(
    executor: &E,
    contents: &C,
    prims: Vec<Primitive>,
    effort: Effort,
) -> Result<(Collapsed<C::Block>, u32), InvalidTree> {
    let mut tree = top_down::build(executor, prims, effort.splitting, C::SHAPE.lanes as usize, 0.45);
    reinsertion::optimize(executor, &mut tree, effort.patience, 0.3);
    let tree = tree.in_order().ok_or(InvalidTree::TooDeep { needed: MAX_DEPTH as u32, allowed: MAX_STACK as u32 })?;
    let collapsed = collapse::collapse(executor, &tree, contents, 0.2)?;
    let stack = contents.validate(&collapsed.nodes, &collapsed.blocks)?;
    Ok((collapsed, stack))
}

pub(super) fn check_count(count: usize) -> Result<(), Error> {
    let limit = Bvh::MAX_TRIANGLES;
    if count > limit { Err(Error::TooManyPrimitives { count, limit }) } else { Ok(()) }
}

/// The triangles that a ray can hit; counts them and the others.
pub(super) fn usable<M: Mesh + ?Sized>(mesh: &M, report: &mut BuildReport) -> Vec<Primitive> {
    *report = BuildReport { rejected_builds: report.rejected_builds, ..BuildReport::default() };
    let mut prims = Vec::with_capacity(mesh.len());
    for prim_id in 0..mesh.len() {
        let triangle = &mesh.triangle(prim_id);
        if !triangle.iter().all(|p| p.is_finite()) {
            report.drop(prim_id as u32, PrimitiveFault::NotFinite);
        } else if !in_range(triangle) {
            report.drop(prim_id as u32, PrimitiveFault::OutOfRange);
        } else if is_degenerate(triangle) {
            report.drop(prim_id as u32, PrimitiveFault::Degenerate);
        } else {
            prims.push(Primitive::new(&Aabb::around(triangle), prim_id as u32));
        }
    }
    report.kept = prims.len();
    prims
}

/// Whether a ray can hit the triangle.
pub(super) fn is_usable(triangle: &Triangle) -> bool {
    in_range(triangle) && !is_degenerate(triangle)
}

pub(super) fn in_range(triangle: &Triangle) -> bool {
    triangle.iter().all(|p| p.abs().cmple(glam::Vec3::splat(MAX_COORDINATE)).all())
}

/// Whether two corners coincide: then an edge function is zero, the other two cancel, and no ray can hit. Triangles
/// with collinear corners are kept, as rounding may give them an area, and meshes close cracks with them.
fn is_degenerate([a, b, c]: &Triangle) -> bool {
    a == b || b == c || c == a
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;

    #[test]
    fn what_is_dropped_is_told_by_reason() {
        let with = |corner: Vec3| [Vec3::X, Vec3::Y, corner];
        let next = |x: f32| f32::from_bits(x.to_bits() + 1);
        let triangles = [
            with(Vec3::Z),
            with(Vec3::Z * MAX_COORDINATE),
            with(-Vec3::Z * MAX_COORDINATE),
            with(-Vec3::Z * next(MAX_COORDINATE)),
            with(Vec3::Z * f32::MAX),
            with(Vec3::X),
            with(Vec3::Z * f32::INFINITY),
            with(Vec3::NAN),
            with(Vec3::new(0.0, f32::NEG_INFINITY, f32::MAX)),
        ];
        let (bvh, report) = Bvh::build(&triangles, &BuildOptions::default()).unwrap();
        let first_dropped = Some(3);
        let expected =
            BuildReport { kept: 3, degenerate: 1, not_finite: 3, out_of_range: 2, first_dropped, rejected_builds: 0 };
        assert_eq!((report, report.dropped(), bvh.statistics().triangles), (expected, 6, 3));
        assert_eq!(
            alloc::format!("{report}"),
            "3 primitives kept, 6 dropped, the first of them 3: 1 degenerate, 3 not finite, 2 too far away"
        );
        let one = BuildReport { kept: 1, not_finite: 2, ..BuildReport::default() };
        assert_eq!(alloc::format!("{one}"), "1 primitive kept, 2 dropped: 2 not finite");
        assert_eq!(alloc::format!("{}", BuildReport::default()), "0 primitives kept, 0 dropped");
    }

    #[test]
    fn one_triangle_too_many_is_refused() {
        assert_eq!(Bvh::MAX_TRIANGLES, (1 << 29) - 1);
        assert_eq!(check_count(Bvh::MAX_TRIANGLES), Ok(()));
        let error = check_count(Bvh::MAX_TRIANGLES + 1).unwrap_err();
        assert_eq!(error, Error::TooManyPrimitives { count: 1 << 29, limit: (1 << 29) - 1 });
        assert_eq!(alloc::format!("{error}"), "536870912 primitives are too many: a tree holds 536870911 at most");
    }
}
