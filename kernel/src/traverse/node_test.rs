//! The node test: eight boxes against a ray, or against eight rays, by the slab test of Kay and Kajiya 1986. Which of a
//! node's planes are near, the signs of the direction say.

use core::hint::select_unpredictable;

use crate::bvh::{BvhView, Child, Node, WIDTH};
use crate::geometry::setup::Slabs;
use crate::geometry::setup_lanes::SetupLanes;
use crate::simd::{Lanes, Simd};

/// Where the ray enters and leaves the eight boxes of a node, within its interval.
#[inline(always)]
pub(super) fn intersect<S: Simd>(node: &Node, ray: &Slabs, t_min: f32, t_max: f32) -> (S::F8, S::F8) {
    let (near_x, far_x) = slab::<S>(node, ray, 0);
    let (near_y, far_y) = slab::<S>(node, ray, 1);
    let (near_z, far_z) = slab::<S>(node, ray, 2);
    let near = near_x.max(near_y).max(near_z.max(S::F8::splat(t_min)));
    let far = far_x.min(far_y).min(far_z.min(S::F8::splat(t_max)));
    (near, far)
}

/// Where the ray enters and leaves the slabs of the eight boxes across one axis.
#[inline(always)]
fn slab<S: Simd>(node: &Node, ray: &Slabs, axis: usize) -> (S::F8, S::F8) {
    let (planes, negative) = (&node.planes[axis], ray.negative[axis]);
    let inverse = S::F8::splat(ray.inverse[axis]);
    let near = S::F8::load(&planes[usize::from(negative)]).mul_sub(inverse, S::F8::splat(ray.near_shift[axis]));
    let far = S::F8::load(&planes[usize::from(!negative)]).mul_sub(inverse, S::F8::splat(ray.far_shift[axis]));
    (near, far)
}

/// Where eight rays enter and leave the boxes of a node: for each ray the eight boxes.
#[inline(always)]
pub(super) fn intersect_children<S: Simd>(
    rays: &SetupLanes<WIDTH, S::F8>,
    node: &Node,
) -> ([S::F8; WIDTH], [S::F8; WIDTH]) {
    let (mut near, mut far) = ([S::F8::splat(0.0); WIDTH], [S::F8::splat(0.0); WIDTH]);
    let [x, y, z] = &node.planes;
    for slot in 0..WIDTH {
        let bounds = [[x[0][slot], x[1][slot]], [y[0][slot], y[1][slot]], [z[0][slot], z[1][slot]]];
        (near[slot], far[slot]) = rays.intersect_box(bounds);
    }
    (S::transpose(near), S::transpose(far))
}

/// The octant in whose order a node's children are visited: the ray's own, from near to far. A search for any hit goes
/// from far to near: what is near the origin is mostly what the ray has just left.
#[inline(always)]
pub(super) fn visit_octant<const ANY: bool>(octant: u8) -> u8 {
    if ANY { octant ^ 7 } else { octant }
}

/// Prefetches a node, or a leaf's first block.
#[inline(always)]
pub(super) fn prefetch<S: Simd>(tree: &BvhView, child: u32) {
    let node = tree.nodes().as_ptr().wrapping_add(child as usize).cast();
    let block = tree.blocks().as_ptr().wrapping_add(Child::first_block(child) as usize).cast();
    S::prefetch::<{ size_of::<Node>() }>(select_unpredictable(Child::is_node(child), node, block));
}
