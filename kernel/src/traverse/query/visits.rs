//! The cost of a ray: the nodes and blocks that it visits, front to back, up to its nearest hit.
//!
//! It is counted by a walk of its own, one box at a time, so that it is the same number on every machine. A batch
//! visits the same subtrees, save those whose boxes the ray only grazes: each backend widens boxes by its own rounding.

use crate::bvh::{BvhView, Child, MAX_STACK, WIDTH};
use crate::geometry::setup::RaySetup;
use crate::geometry::{Hit, Ray, intersect_triangle};
use crate::traverse::reference::{entry, nearer};

/// Steps of a traversal.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Visits {
    /// Nodes whose eight boxes were tested.
    pub nodes: u32,
    /// Blocks whose eight triangles were tested.
    pub blocks: u32,
}

impl Visits {
    /// Nodes and blocks.
    pub fn total(&self) -> u64 {
        u64::from(self.nodes) + u64::from(self.blocks)
    }
}

impl BvhView<'_> {
    /// The visits of [`intersect`](Self::intersect). Slow: for pictures of the cost, not for tracing.
    pub fn intersect_visits(&self, ray: &Ray) -> Visits {
        walk(self, ray, false).0
    }

    /// The visits of [`occluded`](Self::occluded), likewise.
    pub fn occluded_visits(&self, ray: &Ray) -> Visits {
        walk(self, ray, true).0
    }
}

/// The visits of `ray`, and its nearest hit; with `any` the first one found.
fn walk(tree: &BvhView, ray: &Ray, any: bool) -> (Visits, Option<Hit>) {
    let mut visits = Visits::default();
    let mut best: Option<Hit> = None;
    let Some(setup) = RaySetup::new(ray, &tree.bounds()) else {
        return (visits, best);
    };
    // A subtree, and where the ray enters its box.
    let mut stack = [(0u32, 0.0f64); MAX_STACK];
    let mut height = 1;
    while height > 0 && !(any && best.is_some()) {
        height -= 1;
        let (child, near) = stack[height];
        if best.is_some_and(|best| near > f64::from(best.t)) {
            continue;
        }
        match Child::unpack(child) {
            Child::Empty => {}
            Child::Node(index) => {
                visits.nodes += 1;
                let node = &tree.nodes()[index as usize];
                // From the farthest child to the nearest, which is then on top.
                for place in 0..WIDTH {
                    let slot = (node.order[usize::from(setup.slabs.octant())] >> (3 * place) & 7) as usize;
                    if let Some(near) = entry(&node.aabb(slot), ray, &tree.bounds()) {
                        stack[height] = (node.children[slot], near);
                        height += 1;
                    }
                }
            }
            Child::Leaf { first, count } => {
                for block in &tree.blocks()[first as usize..][..count as usize] {
                    visits.blocks += 1;
                    for lane in 0..WIDTH {
                        let hit = intersect_triangle(ray, &block.triangle(lane));
                        best = nearer(best, hit.map(|hit| Hit { prim_id: block.prim_id[lane], ..hit }));
                    }
                    if any && best.is_some() {
                        break;
                    }
                }
            }
        }
    }
    (visits, best)
}

#[cfg(test)]
mod tests {
    use alloc::vec::Vec;

    use glam::{Vec3, vec3};

    use super::*;
    use crate::{BuildOptions, Bvh, Triangle};

    /// Squares of two triangles across the z axis, at z = 0, 1, 2 …
    fn sheets(count: usize) -> Vec<Triangle> {
        let sheet = |z: usize| {
            let [a, b, c, d] = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(|(x, y)| vec3(x, y, z as f32));
            [[a, b, c], [a, c, d]]
        };
        (0..count).flat_map(sheet).collect()
    }

    #[test]
    fn one_node_and_one_block_hold_two_triangles() {
        let (bvh, _) = Bvh::build(&sheets(1), &BuildOptions::default()).unwrap();
        let visits = |origin: Vec3| bvh.view().intersect_visits(&Ray::new(origin, Vec3::Z));
        assert_eq!(visits(vec3(0.3, 0.2, -1.0)), Visits { nodes: 1, blocks: 1 });
        assert_eq!(visits(vec3(5.0, 0.2, -1.0)), Visits { nodes: 1, blocks: 0 });
        assert_eq!(visits(Vec3::NAN), Visits::default());
    }

    #[test]
    fn what_is_hidden_costs_nothing() {
        let (bvh, _) = Bvh::build(&sheets(1000), &BuildOptions::default()).unwrap();
        let tree = bvh.view();
        let along = Ray::new(vec3(0.3, 0.2, -1.0), Vec3::Z);
        let through = Ray::new(vec3(5.0, 0.2, -1.0), vec3(-1.0, 0.0, 200.0));
        let all = tree.nodes().len() as u64 + tree.blocks().len() as u64;
        let (first, slanted) = (tree.intersect_visits(&along).total(), tree.intersect_visits(&through).total());
        assert!(first > 1 && first * 10 < all, "{first} of {all}");
        assert!(tree.occluded_visits(&along).total() <= first);
        assert!(slanted >= 1 && slanted * 10 < all, "{slanted} of {all}");
    }

    #[test]
    fn the_walk_finds_what_all_others_find() {
        let triangles = sheets(300);
        let (bvh, _) = Bvh::build(&triangles, &BuildOptions::default()).unwrap();
        for i in 0..500 {
            let (sin, cos) = (libm::sinf, libm::cosf);
            let a = i as f32;
            let origin = vec3(3.0 * sin(a), 3.0 * cos(a), a * 0.6);
            let ray = Ray::new(origin, vec3(-sin(a * 1.1), -cos(a * 0.9), sin(a * 0.37)));
            let (_, hit) = walk(&bvh.view(), &ray, false);
            assert_eq!(hit, crate::traverse::reference::intersect_all(&triangles, &ray), "{ray:?}");
            assert_eq!(walk(&bvh.view(), &ray, true).1.is_some(), hit.is_some());
        }
    }
}
