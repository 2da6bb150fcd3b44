//! A ray of a stream: what it needs at a visit, in whole cache lines, and its own short stack.

use super::NONE;
use crate::bvh::{Child, Node, SLOTS_IN_ORDER, TriangleBlock, WIDTH};
use crate::geometry::Hit;
use crate::geometry::setup_rows::{FORWARD, SetupRows};
use crate::geometry::triangle::{self, LineLanes};
use crate::simd::{CompressChildren, Lanes, Simd};
use crate::traverse::collector::ClosestHit;
use crate::traverse::leaf_test::{corners, intersect_block};
use crate::traverse::node_test::{self, visit_octant};

/// Entries of a ray's stack: enough for nearly all rays. One that needs more is traced by the single-ray intersector.
const ROOM: usize = 32;

/// An active ray: a cache line for the node test, one for the leaf test, and the stack, with [`NONE`] at its bottom.
#[derive(Clone, Copy)]
#[repr(C, align(64))]
pub(crate) struct ActiveRay {
    /// [`Slabs::inverse`](crate::geometry::setup::Slabs::inverse) and `near_shift`, then the ray's interval.
    slabs: [f32; 8],
    far_shift: [f32; 3],
    /// The node's rows that hold near planes.
    near_rows: [u8; 3],
    /// [`visit_octant`].
    octant: u8,
    pub(crate) best: Hit,
    /// [`Line::numbers`](crate::geometry::setup::Line::numbers).
    pub(super) line: [f32; 8],
    /// Of a block's rows, those of the first corners' coordinates, in the order of the line's axes, times eight.
    pub(super) corners: [u8; 3],
    height: u8,
    /// Of the ray in its batch.
    pub(crate) index: usize,
    children: Entries<u32>,
    near: Entries<f32>,
}

/// Aligned to whole cache lines.
#[derive(Clone, Copy)]
#[repr(align(64))]
struct Entries<T>([T; ROOM]);

const _: () = assert!(size_of::<ActiveRay>() == 384 && core::mem::offset_of!(ActiveRay, line) == 64);

impl ActiveRay {
    /// All zeros, which is fastest to write.
    pub(super) const EMPTY: Self = Self {
        slabs: [0.0; 8],
        far_shift: [0.0; 3],
        near_rows: [0; 3],
        octant: 0,
        best: Hit { t: 0.0, u: 0.0, v: 0.0, prim_id: 0 },
        line: [0.0; 8],
        corners: [0; 3],
        height: 0,
        index: 0,
        children: Entries([0; ROOM]),
        near: Entries([0.0; ROOM]),
    };

    /// Becomes the ray of a lane, and enters those children of the root for which `near <= far`. Returns the first
    /// visit.
    #[inline(always)]
    pub(super) fn start<const ANY: bool, S: Simd>(
        &mut self,
        setups: &SetupRows,
        lane: usize,
        index: usize,
        root: &Node,
        (near, far): (S::F8, S::F8),
    ) -> u32 {
        self.set_up(setups, lane, ANY);
        self.best = Hit::none_before(self.slabs[7]);
        self.index = index;
        (self.children.0[0], self.near.0[0]) = (NONE, f32::NEG_INFINITY);
        self.height = 1;
        let _ = self.push_children::<S>(root, near, far, root.order[usize::from(self.octant & 7)]);
        self.pop()
    }

    /// Becomes the ray of a lane, and keeps its index, its best hit and its stack.
    #[inline(always)]
    pub(crate) fn set_up(&mut self, setups: &SetupRows, lane: usize, any: bool) {
        self.slabs = setups.slabs[lane];
        self.far_shift = setups.far_shift(lane);
        self.near_rows = setups.classes.near_rows(lane);
        self.octant = visit_octant(setups.classes.octant(lane), any);
        self.line = setups.lines[lane];
        self.corners = setups.classes.corner_offsets(lane);
    }

    #[inline(always)]
    pub(super) fn t_min(&self) -> f32 {
        self.slabs[6]
    }

    /// Visits a node: pushes the children that the ray meets. Returns whether there was room.
    #[inline(always)]
    #[must_use]
    pub(crate) fn visit_node<S: Simd>(&mut self, node: &Node) -> bool {
        let [ix, iy, iz, nx, ny, nz, t_min, _] = self.slabs;
        let [fx, fy, fz] = self.far_shift;
        let rows: &[[f32; WIDTH]; 8] = bytemuck::cast_ref(node);
        let [x, y, z] = self.near_rows.map(|row| usize::from(row & 7));
        let (near_x, far_x) = slabs::<S::F8>(rows, x, ix, nx, fx);
        let (near_y, far_y) = slabs::<S::F8>(rows, y, iy, ny, fy);
        let (near_z, far_z) = slabs::<S::F8>(rows, z, iz, nz, fz);
        let near = near_x.max(near_y).max(near_z.max(S::F8::splat(t_min)));
        let far = far_x.min(far_y).min(far_z.min(S::F8::splat(self.best.t)));
        self.push_children::<S>(node, near, far, node.order[usize::from(self.octant & 7)])
    }

    #[inline(always)]
    fn push_children<S: Simd>(&mut self, node: &Node, near: S::F8, far: S::F8, order: u32) -> bool {
        let from = usize::from(self.height);
        let (Some(children), Some(distances)) =
            (self.children.0.get_mut(from..from + WIDTH), self.near.0.get_mut(from..from + WIDTH))
        else {
            return false;
        };
        if let (Some(children), Some(distances)) = (children.first_chunk_mut(), distances.first_chunk_mut()) {
            self.height += S::F8::compress(near, far, order, &node.children, children, distances) as u8;
        }
        true
    }

    /// Pops the stack: [`NONE`] if nothing is left.
    #[inline(always)]
    pub(crate) fn pop(&mut self) -> u32 {
        self.height = self.height.wrapping_sub(1);
        self.children.0[usize::from(self.height) % ROOM]
    }

    /// Takes a hit if it precedes the best one, and drops subtrees behind it.
    #[inline(always)]
    pub(crate) fn accept<S: Simd>(&mut self, hit: Hit) {
        if hit.precedes(&self.best) {
            self.best = hit;
            self.cull::<S>(hit.t);
        }
    }

    /// Drops subtrees that begin behind `t_max`. Equal distances are kept: ties are decided by `prim_id`.
    #[inline(always)]
    pub(crate) fn cull<S: Simd>(&mut self, t_max: f32) {
        let height = self.height;
        let t_max = S::F8::splat(t_max.min(f32::MAX));
        let (mut from, mut left) = (0u8, 0u8);
        // Once at least, without a branch on whether there is anything.
        loop {
            let first = usize::from(from) % ROOM;
            let (Some(children), Some(near)) =
                (self.children.0[first..].first_chunk::<WIDTH>(), self.near.0[first..].first_chunk::<WIDTH>())
            else {
                return;
            };
            let (children, near) = (*children, S::F8::load(near));
            // Slots above the height are not entries.
            let is_entry = S::F8::load(&[0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0])
                .lt(S::F8::splat(height.saturating_sub(from).into()));
            let near = S::F8::select(is_entry, near, S::F8::splat(f32::INFINITY));
            let to = usize::from(left) % ROOM;
            if let (Some(kept), Some(distances)) =
                (self.children.0[to..].first_chunk_mut(), self.near.0[to..].first_chunk_mut())
            {
                left += S::F8::compress(near, t_max, SLOTS_IN_ORDER, &children, kept, distances) as u8;
            }
            from = from.saturating_add(WIDTH as u8);
            if from >= height {
                self.height = left;
                return;
            }
        }
    }

    /// Tests the triangles of a block.
    #[inline(always)]
    pub(crate) fn visit_block<const ANY: bool, S: Simd>(&mut self, block: &TriangleBlock) {
        let line = LineLanes::<S::F8>::splat(&self.line);
        let axes = FORWARD[usize::from(self.corners[2] / WIDTH as u8) % 3];
        if ANY {
            let interval = [S::F8::splat(self.t_min()), S::F8::splat(self.best.t)];
            if triangle::occludes(&line, corners(block, axes), interval) != 0 {
                self.end_with_any();
            }
        } else {
            let mut closest = ClosestHit { best: self.best };
            // This collector never ends the search.
            let _ = intersect_block(block, &line, axes, self.t_min(), &mut closest);
            self.accept::<S>(closest.best);
        }
    }

    /// The ray's visit after the first block of a leaf: the rest of the leaf, or the top of the stack.
    #[inline(always)]
    pub(crate) fn after_block<const ANY: bool>(&mut self, leaf: u32) -> u32 {
        let has_ended = ANY && self.best.is_hit();
        if Child::has_more_blocks(leaf) && !has_ended { Child::without_first_block(leaf) } else { self.pop() }
    }

    /// Any hit will do, and has been found.
    #[inline(always)]
    pub(crate) fn end_with_any(&mut self) {
        self.best = Hit::any_if(true);
        self.height = 1;
    }

    /// Pushes a subtree that no hit culls. Returns whether there was room.
    #[inline(always)]
    #[must_use]
    pub(crate) fn push(&mut self, child: u32) -> bool {
        let top = usize::from(self.height);
        let (Some(children), Some(near)) = (self.children.0.get_mut(top), self.near.0.get_mut(top)) else {
            return false;
        };
        (*children, *near) = (child, f32::NEG_INFINITY);
        self.height += 1;
        true
    }
}

/// Where a ray crosses a node's near and far planes across one axis.
#[inline(always)]
fn slabs<L: Lanes<WIDTH>>(rows: &[[f32; WIDTH]; 8], row: usize, inverse: f32, near: f32, far: f32) -> (L, L) {
    let inverse = L::splat(inverse);
    (node_test::slab(rows, row, inverse, L::splat(near)), node_test::slab(rows, row ^ 1, inverse, L::splat(far)))
}
