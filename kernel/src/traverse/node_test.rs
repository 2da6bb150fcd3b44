//! The node test: eight boxes against a ray, or against eight rays, by the slab test of Kay and Kajiya 1986. The signs
//! of the direction determine which of a node's planes are near.

use core::hint::select_unpredictable;

use crate::bvh::{BvhView, Child, Node, TriangleBlock, WIDTH};
use crate::geometry::setup::Slabs;
use crate::geometry::setup_lanes::SetupLanes;
use crate::simd::{Lanes, Simd};

/// A ray's values for the node test, each in all lanes.
pub(super) struct NodeTest<L> {
    inverse: [L; 3],
    near_shift: [L; 3],
    far_shift: [L; 3],
    t_min: L,
    /// The rows of near planes along each axis; far planes are in the rows beside them.
    near_rows: [usize; 3],
}

impl<L: Lanes<WIDTH>> NodeTest<L> {
    #[inline(always)]
    pub(super) fn new(ray: &Slabs, t_min: f32) -> Self {
        let [ix, iy, iz] = ray.inverse;
        let [nx, ny, nz] = ray.near_shift;
        let [fx, fy, fz] = ray.far_shift;
        let [x, y, z] = ray.negative.map(usize::from);
        Self {
            inverse: [L::splat(ix), L::splat(iy), L::splat(iz)],
            near_shift: [L::splat(nx), L::splat(ny), L::splat(nz)],
            far_shift: [L::splat(fx), L::splat(fy), L::splat(fz)],
            t_min: L::splat(t_min),
            near_rows: [x, 2 + y, 4 + z],
        }
    }

    /// Where the ray enters and leaves the eight boxes of a node, within its interval.
    #[inline(always)]
    pub(super) fn intersect(&self, node: &Node, t_max: f32) -> (L, L) {
        // Eight rows of eight: the planes, and two more, so that three bits are an index.
        let rows: &[[f32; WIDTH]; 8] = bytemuck::cast_ref(node);
        let (near_x, far_x) = self.slabs(rows, 0);
        let (near_y, far_y) = self.slabs(rows, 1);
        let (near_z, far_z) = self.slabs(rows, 2);
        let near = near_x.max(near_y).max(near_z.max(self.t_min));
        let far = far_x.min(far_y).min(far_z.min(L::splat(t_max)));
        (near, far)
    }

    /// Where the ray enters and leaves the slabs of the eight boxes across one axis.
    #[inline(always)]
    fn slabs(&self, rows: &[[f32; WIDTH]; 8], axis: usize) -> (L, L) {
        let (row, inverse) = (self.near_rows[axis] & 7, self.inverse[axis]);
        (slab(rows, row, inverse, self.near_shift[axis]), slab(rows, row ^ 1, inverse, self.far_shift[axis]))
    }
}

/// Where a ray crosses a row of planes.
#[inline(always)]
pub(super) fn slab<L: Lanes<WIDTH>>(rows: &[[f32; WIDTH]; 8], row: usize, inverse: L, shift: L) -> L {
    L::load(&rows[row & 7]).mul_sub(inverse, shift)
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
/// from far to near: triangles near the origin mostly belong to the surface that the ray has just left.
#[inline(always)]
pub(super) fn visit_octant(octant: u8, any: bool) -> u8 {
    if any { octant ^ 7 } else { octant }
}

/// Prefetches a node, or a leaf's first block, whole.
#[inline(always)]
pub(super) fn prefetch<S: Simd>(tree: &BvhView, child: u32) {
    prefetch_of::<S>(tree.nodes(), tree.blocks(), child);
}

/// Prefetches a node, or a leaf's first block, of these nodes and blocks.
#[inline(always)]
pub(crate) fn prefetch_of<S: Simd>(nodes: &[Node], blocks: &[TriangleBlock], child: u32) {
    let node = nodes.as_ptr().wrapping_add(child as usize).cast();
    let block = blocks.as_ptr().wrapping_add(Child::first_block(child) as usize).cast();
    S::prefetch::<{ size_of::<Node>() }>(select_unpredictable(Child::is_node(child), node, block));
}
