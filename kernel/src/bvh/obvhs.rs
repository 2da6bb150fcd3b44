//! Conversion of binary trees built by [obvhs](https://docs.rs/obvhs) to eight children a node.
//!
//! Only the grouping of triangles is taken from the other tree: boxes are computed anew around whole triangles, and the
//! collapse, the order of children and all checks are those of every build. So hits equal those of any tree over the
//! same triangles, bit for bit.
//!
//! PLOC is built from the leaves up, in time that hardly depends on the triangles; `Bvh2` also inserts, removes and
//! reinserts. Leaves of one primitive are best, as the collapse then decides what shares a block.

use alloc::vec;
use alloc::vec::Vec;

use ::obvhs::bvh2::Bvh2;

use super::MAX_STACK;
use super::binary::{BinaryNode, BinaryTree, MAX_DEPTH};
use super::build::{BuildReport, Bvh, check_count, is_usable, usable};
use super::collapse::{Collapsed, collapse};
use super::contents::{Contents, Faces};
use super::executor::{Executor, Serial};
use super::node::WIDTH;
use super::primitive::Primitive;
use crate::error::{Error, InvalidTree, RefitError};
use crate::geometry::{Aabb, Triangle};
use crate::mesh::Mesh;

impl Bvh {
    /// Makes a tree of `tree`, which was built over `triangles` or their boxes: its `primitive_indices` are indices
    /// into them.
    ///
    /// Triangles that no ray can hit are left out and counted. Where spatial splits have put one into several leaves,
    /// the first of them counts.
    ///
    /// # Errors
    /// - [`InvalidTree::BadChild`] if `tree` is not a tree: a node does not exist, or has two parents.
    /// - [`InvalidTree::TooDeep`]; obvhs' reinsertion may cause it with long chains of triangles.
    /// - [`RefitError::Missing`] if it names a triangle that is not among `triangles`.
    /// - [`RefitError::Appeared`] if it leaves out triangles that can be hit.
    pub fn from_obvhs(tree: &Bvh2, triangles: &[Triangle]) -> Result<(Self, BuildReport), Error> {
        Self::from_obvhs_on(&Serial, tree, triangles)
    }

    /// Like [`from_obvhs`](Self::from_obvhs), over triangles in any layout, on the threads of `executor`.
    ///
    /// # Errors
    /// The errors of [`from_obvhs`](Self::from_obvhs).
    pub fn from_obvhs_on<E: Executor, M: Mesh + ?Sized>(
        executor: &E,
        tree: &Bvh2,
        mesh: &M,
    ) -> Result<(Self, BuildReport), Error> {
        check_count(mesh.len())?;
        let mut report = BuildReport::default();
        let kept = usable(mesh, &mut report).len();
        let mut reader =
            Reader { tree, mesh, seen: vec![false; mesh.len()], visits: 0, prims: Vec::new(), parts: Vec::new() };
        let root = if tree.nodes.is_empty() { None } else { reader.read(0, 1)? };
        if reader.prims.len() < kept {
            return Err(RefitError::Appeared { count: kept - reader.prims.len() }.into());
        }
        let Some(root) = root else {
            return Self::build_mesh_on(executor, mesh, &super::BuildOptions::default());
        };
        let rejected_builds = InvalidTree::TooDeep { needed: MAX_DEPTH as u32, allowed: MAX_STACK as u32 };
        let binary = BinaryTree { nodes: side_by_side(&reader.parts, root), prims: reader.prims }
            .in_order()
            .ok_or(rejected_builds)?;
        let Collapsed { nodes, blocks, cost } = collapse(executor, &binary, &Faces(mesh), 1.0)?;
        let stack = Faces(mesh).validate(&nodes, &blocks)?;
        let bounds = nodes[0].bounds();
        Ok((Self { nodes, blocks, bounds, cost, built_cost: cost, stack }, report))
    }
}

/// A part of the tree that has been read.
struct Part {
    aabb: Aabb,
    contents: Contained,
}

#[derive(Clone, Copy)]
enum Contained {
    Prims {
        first: u32,
        count: u16,
    },
    /// Numbers of parts.
    Parts([u32; 2]),
}

/// Reads a tree from the leaves up.
struct Reader<'a, M: ?Sized> {
    tree: &'a Bvh2,
    mesh: &'a M,
    /// Whether each triangle has been visited.
    seen: Vec<bool>,
    /// The number of visited nodes: at most the number of nodes, if it is a tree.
    visits: usize,
    prims: Vec<Primitive>,
    parts: Vec<Part>,
}

impl<M: Mesh + ?Sized> Reader<'_, M> {
    /// Reads what is below a node; `None` if that is nothing that can be hit.
    fn read(&mut self, node: usize, level: usize) -> Result<Option<u32>, Error> {
        let bad_child = InvalidTree::BadChild { node: node as u32, slot: 0 };
        let Some(&contents) = self.tree.nodes.get(node) else {
            return Err(bad_child.into());
        };
        self.visits += 1;
        if self.visits > self.tree.nodes.len() {
            return Err(bad_child.into());
        }
        if level == MAX_DEPTH {
            return Err(InvalidTree::TooDeep { needed: MAX_DEPTH as u32, allowed: MAX_STACK as u32 }.into());
        }
        let first = contents.first_index as usize;
        if contents.prim_count > 0 {
            let places = first..first.saturating_add(contents.prim_count as usize);
            let ids = self.tree.primitive_indices.get(places).ok_or(bad_child)?;
            let begin = self.prims.len();
            for &id in ids {
                let count = self.mesh.len();
                let seen = self.seen.get_mut(id as usize).ok_or(RefitError::Missing { prim_id: id, count })?;
                let triangle = self.mesh.triangle(id as usize);
                if !core::mem::replace(seen, true) && is_usable(&triangle) {
                    self.prims.push(Primitive::new(&Aabb::around(&triangle), id));
                }
            }
            return Ok(self.leaves(begin, self.prims.len()));
        }
        let [left, right] = [self.read(first, level + 1)?, self.read(first + 1, level + 1)?];
        Ok(match (left, right) {
            (Some(left), Some(right)) => Some(self.join(left, right)),
            (one, other) => one.or(other),
        })
    }

    /// A part for a range of primitives: several if they do not fit into a block.
    fn leaves(&mut self, begin: usize, end: usize) -> Option<u32> {
        if end - begin > WIDTH {
            let middle = begin.midpoint(end);
            let (left, right) = (self.leaves(begin, middle)?, self.leaves(middle, end)?);
            return Some(self.join(left, right));
        }
        let mut boxes = self.prims[begin..end].iter().map(|prim| prim.bounds());
        let mut bounds = boxes.next()?;
        boxes.for_each(|other| bounds.grow(&other));
        let contents = Contained::Prims { first: begin as u32, count: (end - begin) as u16 };
        self.parts.push(Part { aabb: bounds.to_aabb(), contents });
        Some(self.parts.len() as u32 - 1)
    }

    fn join(&mut self, left: u32, right: u32) -> u32 {
        let aabb = self.parts[left as usize].aabb.union(&self.parts[right as usize].aabb);
        self.parts.push(Part { aabb, contents: Contained::Parts([left, right]) });
        self.parts.len() as u32 - 1
    }
}

/// The nodes of a binary tree, the root first and siblings side by side.
fn side_by_side(parts: &[Part], root: u32) -> Vec<BinaryNode> {
    let node = |part: u32| {
        let Part { aabb, contents } = parts[part as usize];
        let (first, count) = if let Contained::Prims { first, count } = contents { (first, count) } else { (0, 0) };
        BinaryNode { aabb, first, count, middle: 0 }
    };
    let mut nodes = Vec::with_capacity(parts.len());
    nodes.push(node(root));
    let mut todo = Vec::from([(root, 0)]);
    while let Some((part, index)) = todo.pop() {
        if let Contained::Parts(children) = parts[part as usize].contents {
            let first = nodes.len();
            nodes[index].first = first as u32;
            nodes.extend(children.map(node));
            todo.extend([(children[1], first + 1), (children[0], first)]);
        }
    }
    nodes
}

// Miri would take hours.
#[cfg(all(test, not(miri)))]
mod tests {
    use ::obvhs::bvh2::node::Bvh2Node;
    use ::obvhs::bvh2::reinsertion::ReinsertionOptimizer;
    use ::obvhs::ploc::{PlocBuilder, PlocSearchDistance, SortPrecision};
    use glam::{Vec3, Vec3A};

    use super::*;
    use crate::BvhView;
    use crate::simd::isas;
    use crate::traverse::reference;
    use crate::traverse::tests::{Random, rays_at, soup};

    fn boxes(triangles: &[Triangle]) -> Vec<::obvhs::aabb::Aabb> {
        let aabb = |corners: &Triangle| {
            let aabb = Aabb::around(corners);
            ::obvhs::aabb::Aabb::new(Vec3A::from(aabb.min), Vec3A::from(aabb.max))
        };
        triangles.iter().map(aabb).collect()
    }

    fn ploc(triangles: &[Triangle]) -> Bvh2 {
        let indices = (0..triangles.len() as u32).collect();
        let boxes = boxes(triangles);
        PlocBuilder::new().build(PlocSearchDistance::Medium, &boxes, indices, SortPrecision::U64, 0)
    }

    #[test]
    fn a_tree_from_obvhs_has_the_hits_of_any_other() {
        let mut random = Random(71);
        for (count, size) in [(1, 1.0), (2, 0.5), (9, 0.7), (300, 0.4), (3000, 0.1)] {
            let mut triangles = soup(&mut random, count, size);
            if count > 100 {
                triangles[7] = [Vec3::ONE; 3];
            }
            let mut tree = ploc(&triangles);
            for improved in [false, true] {
                if improved {
                    ReinsertionOptimizer::default().run(&mut tree, 0.15, None);
                }
                let (bvh, report) = Bvh::from_obvhs(&tree, &triangles).unwrap();
                let (ours, other) = Bvh::build(&triangles, &crate::BuildOptions::default()).unwrap();
                assert_eq!(report, BuildReport { rejected_builds: 0, ..other });
                let view = bvh.view();
                assert!(BvhView::new(view.nodes(), view.blocks()).is_ok());
                assert!(bvh.statistics().triangles == report.kept && bvh.statistics().cost > 0.0);
                for ray in rays_at(&triangles, &mut random, 30) {
                    let expected = reference::intersect_all(&triangles, &ray);
                    assert_eq!(ours.view().intersect(&ray), expected);
                    for isa in isas() {
                        assert_eq!(view.with_isa(isa).intersect(&ray), expected);
                        assert_eq!(view.with_isa(isa).occluded(&ray), expected.is_some());
                    }
                }
            }
        }
    }

    #[test]
    fn leaves_of_many_and_triangles_in_several_are_taken() {
        let mut random = Random(72);
        let triangles = soup(&mut random, 70, 0.5);
        let aabb = boxes(&triangles)[0];
        // Two leaves of 40, which share ten.
        let tree = Bvh2 {
            nodes: vec![Bvh2Node::new(aabb, 0, 1), Bvh2Node::new(aabb, 40, 0), Bvh2Node::new(aabb, 40, 40)],
            primitive_indices: (0..40).chain(30..70).collect(),
            ..Bvh2::default()
        };
        let (bvh, report) = Bvh::from_obvhs(&tree, &triangles).unwrap();
        assert_eq!((report.kept, bvh.statistics().triangles), (70, 70));
        for ray in rays_at(&triangles, &mut random, 60) {
            assert_eq!(bvh.view().intersect(&ray), reference::intersect_all(&triangles, &ray));
        }
    }

    #[test]
    fn what_is_no_tree_is_refused() {
        let mut random = Random(73);
        let triangles = soup(&mut random, 20, 0.5);
        let check = |change: &dyn Fn(&mut Bvh2)| {
            let mut tree = ploc(&triangles);
            change(&mut tree);
            Bvh::from_obvhs(&tree, &triangles).err()
        };
        assert_eq!(check(&|_| {}), None);
        let inner = |tree: &Bvh2| tree.nodes.iter().rposition(|node| node.prim_count == 0).unwrap();
        let is_bad_child = |error| matches!(error, Some(Error::InvalidTree(InvalidTree::BadChild { .. })));
        // A cycle, a node that is not there; then primitives that are not there.
        for child in [0, u32::MAX] {
            let bad = check(&|tree| {
                let node = inner(tree);
                tree.nodes[node].first_index = child;
            });
            assert!(is_bad_child(bad));
        }
        assert!(is_bad_child(check(&|tree| tree.primitive_indices.truncate(3))));
        let missing = check(&|tree| tree.primitive_indices[3] = 20);
        assert_eq!(missing, Some(RefitError::Missing { prim_id: 20, count: 20 }.into()));
        let forgotten = check(&|tree| tree.primitive_indices[3] = tree.primitive_indices[4]);
        assert_eq!(forgotten, Some(RefitError::Appeared { count: 1 }.into()));
        assert_eq!(check(&|tree| tree.nodes.clear()), Some(RefitError::Appeared { count: 20 }.into()));
        // A chain that is too deep.
        let many = soup(&mut random, 400, 0.5);
        let chain = |i: u32| {
            let aabb = boxes(&many)[0];
            [
                Bvh2Node::new(aabb, 1, i),
                Bvh2Node::new(aabb, if i == 398 { 1 } else { 0 }, if i == 398 { 399 } else { 2 * i + 3 }),
            ]
        };
        let mut nodes = vec![Bvh2Node::new(boxes(&many)[0], 0, 1)];
        (0..399).for_each(|i| nodes.extend(chain(i)));
        let tree = Bvh2 { nodes, primitive_indices: (0..400).collect(), ..Bvh2::default() };
        let deep = Bvh::from_obvhs(&tree, &many).err();
        assert!(matches!(deep, Some(Error::InvalidTree(InvalidTree::TooDeep { .. }))), "{deep:?}");
        assert_eq!(Bvh::from_obvhs(&Bvh2::default(), &[]).unwrap().1.kept, 0);
    }
}
