//! Moves a tree's triangles without a rebuild: boxes are fitted from the bottom up, and children are ordered again. The
//! triangles of each leaf stay the same, so a tree whose triangles move apart gets worse; the expected cost measures by
//! how much.

use super::build::{Bvh, is_usable};
use super::contents::TRIANGLES;
use super::executor::{Executor, Serial, for_each};
use super::fit;
use super::node::{Child, Node, TriangleBlock};
use super::plan::NODE;
use crate::error::{Error, RefitError};
use crate::geometry::{Aabb, Triangle};
use crate::mesh::Mesh;

/// Blocks that are one task.
const TASK: usize = 1 << 10;

/// The result of a refit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Refit {
    /// The expected cost of a ray, as in [`TreeStatistics::cost`](super::TreeStatistics::cost).
    pub cost: f32,
    /// That cost as a multiple of what it was when the tree was built or loaded: about 1 if nothing has moved.
    pub cost_ratio: f32,
}

impl Refit {
    /// The [`cost_ratio`](Self::cost_ratio) from which on a rebuild usually pays. Where sheets and clouds of triangles
    /// twist or drift so far, rays visit 1.1 to 1.7 times as much as in a new tree, and a build takes as long as two or
    /// three rays a triangle.
    pub const REBUILD_COST_RATIO: f32 = 1.5;

    /// Whether a rebuild is advisable.
    pub fn should_rebuild(&self) -> bool {
        self.cost_ratio > Self::REBUILD_COST_RATIO
    }
}

impl Bvh {
    /// Moves the tree's triangles to where they are in `triangles` now, indexed as when the tree was built. Hits then
    /// equal those of a new tree bit for bit, but tracing may be slower.
    ///
    /// # Errors
    /// [`Error::Refit`] if the triangles that can be hit are not just those in the tree: one of them is missing, is now
    /// out of limits or has two equal corners, or one that was left out when the tree was built could be hit now. The
    /// tree is then unchanged.
    pub fn refit(&mut self, triangles: &[Triangle]) -> Result<Refit, Error> {
        self.refit_on(&Serial, triangles)
    }

    /// Like [`refit`](Self::refit), on the threads of `executor`. The tree does not depend on it.
    ///
    /// # Errors
    /// The errors of [`refit`](Self::refit).
    pub fn refit_on<E: Executor>(&mut self, executor: &E, triangles: &[Triangle]) -> Result<Refit, Error> {
        self.refit_mesh_on(executor, triangles)
    }

    /// Like [`refit`](Self::refit), to triangles in another layout, such as an
    /// [`IndexedMesh`](crate::mesh::IndexedMesh).
    ///
    /// # Errors
    /// The errors of [`refit`](Self::refit).
    pub fn refit_mesh<M: Mesh + ?Sized>(&mut self, mesh: &M) -> Result<Refit, Error> {
        self.refit_mesh_on(&Serial, mesh)
    }

    /// Like [`refit_mesh`](Self::refit_mesh), on the threads of `executor`.
    ///
    /// # Errors
    /// The errors of [`refit`](Self::refit).
    pub fn refit_mesh_on<E: Executor, M: Mesh + ?Sized>(&mut self, executor: &E, mesh: &M) -> Result<Refit, Error> {
        self.check_refit(mesh)?;
        for_each(executor, TASK, 0, &mut self.blocks, &|_, block| block.place(mesh));
        let blocks = &self.blocks;
        fit::fit_on(executor, &mut self.nodes, &|leaf| TriangleBlock::bounds_of(&blocks[leaf]));
        self.bounds = self.nodes[0].bounds();
        self.cost = expected_cost(&self.nodes);
        let cost_ratio = if self.built_cost > 0.0 { self.cost / self.built_cost } else { 1.0 };
        Ok(Refit { cost: self.cost, cost_ratio })
    }

    fn check_refit<M: Mesh + ?Sized>(&self, mesh: &M) -> Result<(), RefitError> {
        let mut kept = 0;
        for (_, prim_id) in self.blocks.iter().flat_map(TriangleBlock::used_lanes) {
            if prim_id as usize >= mesh.len() {
                return Err(RefitError::Missing { prim_id, count: mesh.len() });
            }
            if !is_usable(&mesh.triangle(prim_id as usize)) {
                return Err(RefitError::Vanished { prim_id });
            }
            kept += 1;
        }
        let usable = (0..mesh.len()).filter(|&prim_id| is_usable(&mesh.triangle(prim_id))).count();
        if usable > kept { Err(RefitError::Appeared { count: usable - kept }) } else { Ok(()) }
    }
}

/// The expected cost of a ray that meets the root's box: each node and block by the area of the box that it is in.
pub(super) fn expected_cost(nodes: &[Node]) -> f32 {
    let area = |aabb: Aabb| f64::from(aabb.half_area());
    let whole = area(nodes[0].bounds());
    let mut cost = f64::from(NODE) * whole;
    for node in nodes {
        for (slot, &child) in node.children.iter().enumerate() {
            cost += match Child::unpack(child) {
                Child::Empty => 0.0,
                Child::Node(_) => f64::from(NODE) * area(node.aabb(slot)),
                Child::Leaf { count, .. } => f64::from(TRIANGLES.cost) * f64::from(count) * area(node.aabb(slot)),
            };
        }
    }
    if whole > 0.0 { (cost / whole) as f32 } else { 0.0 }
}

// Miri would take hours.
#[cfg(all(test, not(miri)))]
mod tests {
    use alloc::vec::Vec;

    use glam::{Vec3, vec3};

    use super::*;
    use crate::traverse::reference;
    use crate::{BvhView, Quality, Ray};

    /// A grid of `n` by `n` squares of two triangles over the unit square, with `height` above it.
    fn sheet(n: usize, height: impl Fn(f32, f32) -> f32) -> Vec<Triangle> {
        let at = |i: usize, j: usize| {
            let (x, y) = (i as f32 / n as f32, j as f32 / n as f32);
            vec3(x, y, height(x, y))
        };
        let square = |i: usize, j: usize| {
            [[at(i, j), at(i + 1, j), at(i + 1, j + 1)], [at(i, j), at(i + 1, j + 1), at(i, j + 1)]]
        };
        (0..n * n).flat_map(|k| square(k / n, k % n)).collect()
    }

    fn rays() -> impl Iterator<Item = Ray> {
        (0..400).map(|i| {
            let [x, y, a] = [0.754_877_7, 0.569_840_3, 0.438_579_3].map(|step| (i as f32 * step) % 1.0);
            Ray::new(vec3(x, y, 2.0), vec3(y - x, a - 0.5, -1.0 - x))
        })
    }

    /// Bits, as NaN of unused lanes are not equal.
    fn bits(bvh: &Bvh) -> (Vec<u32>, Vec<u32>) {
        let tree = bvh.view();
        (bytemuck::cast_slice(tree.nodes()).to_vec(), bytemuck::cast_slice(tree.blocks()).to_vec())
    }

    #[test]
    fn nothing_moved_is_the_same_tree() {
        for quality in Quality::ALL {
            let triangles = sheet(40, |x, y| x * y);
            let (mut bvh, _) = Bvh::build(&triangles, &quality.into()).unwrap();
            let (before, cost) = (bits(&bvh), bvh.statistics().cost);
            let refit = bvh.refit(&triangles).unwrap();
            assert!(bits(&bvh) == before);
            assert!((refit.cost_ratio - 1.0).abs() < 1e-4 && (refit.cost - cost).abs() < 1e-4 * cost, "{refit:?}");
            assert!(!refit.should_rebuild());
        }
    }

    #[test]
    fn refitted_equals_rebuilt() {
        for quality in Quality::ALL {
            let (mut bvh, _) = Bvh::build(&sheet(30, |_, _| 0.0), &quality.into()).unwrap();
            for step in 1..5 {
                let moved = sheet(30, |x, y| libm::sinf(9.0 * step as f32 * x) * libm::cosf(7.0 * y));
                let refit = bvh.refit(&moved).unwrap();
                assert_eq!(bvh.statistics().cost, refit.cost);
                let tree = bvh.view();
                assert_eq!(BvhView::new(tree.nodes(), tree.blocks()).err(), None);
                let (rebuilt, _) = Bvh::build(&moved, &quality.into()).unwrap();
                let mut hits = 0;
                for ray in rays() {
                    let hit = tree.intersect(&ray);
                    hits += usize::from(hit.is_some());
                    assert_eq!(hit, rebuilt.view().intersect(&ray));
                    assert_eq!(hit, reference::intersect_all(&moved, &ray));
                    assert_eq!(tree.closest_point(ray.origin, 5.0), rebuilt.view().closest_point(ray.origin, 5.0));
                    assert!(tree.hits(&ray).eq(rebuilt.view().hits(&ray)));
                }
                assert!(hits > 100);
            }
        }
    }

    #[test]
    fn triangles_that_change_places_make_the_tree_decay() {
        let triangles = sheet(40, |_, _| 0.0);
        let (mut bvh, _) = Bvh::build(&triangles, &Quality::High.into()).unwrap();
        let scattered: Vec<_> = (0..triangles.len()).map(|i| triangles[i * 1009 % triangles.len()]).collect();
        let (fresh, _) = Bvh::build(&scattered, &Quality::High.into()).unwrap();
        let refit = bvh.refit(&scattered).unwrap();
        assert!(refit.should_rebuild() && refit.cost_ratio > 10.0, "{refit:?}");
        let visits = |bvh: &Bvh| rays().map(|ray| bvh.view().intersect_visits(&ray).total()).sum::<u64>();
        assert!(visits(&bvh) > 3 * visits(&fresh));
        // Back in their places, all is well.
        assert!((bvh.refit(&triangles).unwrap().cost_ratio - 1.0).abs() < 1e-4);
    }

    #[test]
    fn what_does_not_fit_leaves_the_tree_as_it_was() {
        let mut triangles = sheet(10, |x, y| x - y);
        triangles[7] = [Vec3::ONE; 3];
        triangles[9][1].x = f32::NAN;
        let (mut bvh, report) = Bvh::build(&triangles, &Quality::High.into()).unwrap();
        assert_eq!(report.kept, 198);
        let before = bits(&bvh);
        let mut refuse = |change: &dyn Fn(&mut Vec<Triangle>), expected: RefitError| {
            let mut moved = triangles.iter().map(|triangle| triangle.map(|p| p * 2.0)).collect();
            change(&mut moved);
            assert_eq!(bvh.refit(&moved), Err(Error::Refit(expected)));
            assert!(bits(&bvh) == before);
        };
        refuse(&|moved| moved.truncate(199), RefitError::Missing { prim_id: 199, count: 199 });
        refuse(&|moved| moved[5][0].y = f32::INFINITY, RefitError::Vanished { prim_id: 5 });
        refuse(&|moved| moved[5][0].y = 5e12, RefitError::Vanished { prim_id: 5 });
        refuse(&|moved| moved[198][2] = moved[198][0], RefitError::Vanished { prim_id: 198 });
        refuse(&|moved| moved[7] = moved[8], RefitError::Appeared { count: 1 });
        refuse(&|moved| moved.extend_from_within(..3), RefitError::Appeared { count: 3 });
        // What stays unusable, and what is added so, does not matter.
        triangles.push([Vec3::NAN; 3]);
        assert!(bvh.refit(&triangles).is_ok());
    }

    #[test]
    fn trees_of_nothing_and_of_one() {
        let (mut none, _) = Bvh::build(&[], &Quality::Fast.into()).unwrap();
        assert_eq!(none.refit(&[]), Ok(Refit { cost: 0.0, cost_ratio: 1.0 }));
        assert!(none.refit(&sheet(1, |_, _| 0.0)).is_err());
        let triangle = [Vec3::ZERO, Vec3::X, Vec3::Y];
        let (mut one, _) = Bvh::build(&[triangle], &Quality::Fast.into()).unwrap();
        one.refit(&[triangle.map(|p| p + Vec3::Z)]).unwrap();
        let hit = one.view().intersect(&Ray::new(vec3(0.25, 0.25, 3.0), Vec3::NEG_Z)).unwrap();
        assert_eq!((hit.t, hit.prim_id), (2.0, 0));
    }
}
