//! Whether one ray hits anything. Children are visited from far to near, in the order that the tree keeps for octants:
//! triangles near the origin mostly belong to the surface that the ray has just left. No distances are kept, as no hit
//! shortens the ray.

use crate::bvh::{BvhView, Child};
use crate::geometry::Ray;
use crate::geometry::setup::RaySetup;
use crate::geometry::triangle::{self, LineLanes};
use crate::simd::{CompressChildren, Lanes, Simd, UninitStack};
use crate::traverse::leaf_test::corners;
use crate::traverse::node_test::{NodeTest, visit_octant};

/// Whether `ray` hits anything.
#[inline(always)]
pub(in crate::traverse) fn trace<S: Simd>(tree: &BvhView, ray: &Ray) -> bool {
    let Some(RaySetup { slabs, line }) = RaySetup::new(ray, &tree.bounds()) else {
        return false;
    };
    let test = NodeTest::<S::F8>::new(&slabs, ray.t_min);
    let lines = LineLanes::<S::F8>::splat(&line.numbers);
    let interval = [S::F8::splat(ray.t_min), S::F8::splat(ray.t_max)];
    let order = usize::from(visit_octant(slabs.octant(), true) & 7);
    let mut stack = UninitStack::new();
    let mut child = Child::Node(0).pack();
    loop {
        if Child::is_node(child) {
            if let Some(node) = tree.nodes().get(child as usize) {
                let (near, far) = test.intersect(node, ray.t_max);
                let mut hit = [0; 8];
                let count = S::F8::compress(near, far, node.order[order], &node.children, &mut hit, &mut [0.0; 8]);
                if count != 0 {
                    child = hit[(count - 1) & 7];
                    stack.push_first(hit, count - 1);
                    continue;
                }
            }
        } else {
            for block in tree.blocks().get(Child::leaf_blocks(child)).unwrap_or(&[]) {
                if triangle::occludes(&lines, corners(block, line.axes), interval) != 0 {
                    return true;
                }
            }
        }
        match stack.pop() {
            Some(next) => child = next,
            None => return false,
        }
    }
}
