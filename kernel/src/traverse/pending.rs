//! The subtrees that a ray has still to visit, and the visit of a node, which puts the node's children there.
//!
//! Children are not sorted by distance but taken in an order that the tree keeps for each octant of directions, which
//! needs no branch.

use core::hint::select_unpredictable;

use crate::bvh::{BvhView, Child, MAX_STACK, Node, TriangleBlock, WIDTH};
use crate::geometry::setup::{Axis, Slabs};
use crate::geometry::setup_lanes::SetupLanes;
use crate::simd::{Children, Lanes, Simd};

/// Whatever a height is, an entry is there, and room for the eight that a node writes, whether it keeps them or not; and
/// so many that distances begin with a cache line.
const ROOM: usize = 256 + WIDTH + 7;
const _: () = assert!(MAX_STACK + 1 + WIDTH <= 256);

/// The order of the slots themselves.
const AS_THEY_ARE: u32 = 0o76543210;
/// The last slot first.
const BACKWARDS: u32 = 0o01234567;

/// A stack of subtrees. At its bottom lies [`Pending::NONE`], which is never taken. What is used of a low one lies in two
/// cache lines.
#[repr(C, align(64))]
pub(crate) struct Pending {
    height: u8,
    /// The next one last.
    children: [u32; ROOM],
    /// Where the ray enters their boxes.
    near: [f32; ROOM],
}

impl Pending {
    /// What is on top when nothing is left. No node keeps it: it stands for a box that is inside out.
    pub(super) const NONE: u32 = u32::MAX;
    /// Nothing left to visit.
    pub(crate) const EMPTY: Self = Self { height: 1, children: [Self::NONE; ROOM], near: [f32::INFINITY; ROOM] };

    /// Leaves the root alone to visit.
    #[inline(always)]
    pub(super) fn start(&mut self) {
        (self.children[1], self.near[1]) = (Child::Node(0).pack(), f32::NEG_INFINITY);
        self.height = 2;
    }

    /// Leaves those children of the root alone to visit for which `near <= far`.
    #[inline(always)]
    pub(super) fn start_below<S: Simd>(&mut self, root: &Node, near: S::F8, far: S::F8, octant: u8) {
        self.push::<S>(1, near, far, root.order[usize::from(octant & 7)], &root.children);
    }

    /// Forgets everything.
    #[inline(always)]
    pub(super) fn clear(&mut self) {
        self.height = 1;
    }

    /// What is next.
    #[inline(always)]
    pub(super) fn top(&self) -> u32 {
        self.children[usize::from(self.height.wrapping_sub(1))]
    }

    /// Takes what is next, and where its box begins. Not if it is [`Pending::NONE`].
    #[inline(always)]
    pub(super) fn take(&mut self) -> (u32, f32) {
        self.height = self.height.wrapping_sub(1);
        let top = usize::from(self.height);
        (self.children[top], self.near[top])
    }

    /// Takes the leaf that is next, but for its first block.
    #[inline(always)]
    pub(super) fn take_block(&mut self) -> u32 {
        let height = self.height.wrapping_sub(1);
        let place = &mut self.children[usize::from(height)];
        let leaf = *place;
        *place = Child::without_first_block(leaf);
        self.height = height + u8::from(Child::has_more_blocks(leaf));
        Child::first_block(leaf)
    }

    /// Puts the children whose boxes the ray meets within its interval on top, the nearest one last.
    #[inline(always)]
    pub(crate) fn enter<S: Simd>(&mut self, node: &Node, ray: &Slabs, octant: u8, t_min: f32, t_max: f32) {
        let (near_x, far_x) = slab::<S>(node, ray, 0);
        let (near_y, far_y) = slab::<S>(node, ray, 1);
        let (near_z, far_z) = slab::<S>(node, ray, 2);
        let near = near_x.max(near_y).max(near_z.max(S::F8::splat(t_min)));
        let far = far_x.min(far_y).min(far_z.min(S::F8::splat(t_max)));
        self.push::<S>(self.height, near, far, node.order[usize::from(octant & 7)], &node.children);
    }

    /// Forgets subtrees that begin behind `t_max`. As near is not nearer: there may be a tie to decide.
    #[inline(always)]
    pub(super) fn cull<S: Simd>(&mut self, t_max: f32) {
        let (mut from, height) = (1, self.height);
        self.height = 1;
        // Once at least, without a branch on whether there is anything.
        loop {
            let (children, near) = (*eight(&self.children, from), *eight(&self.near, from));
            // What lies above the height is no entry.
            let is_entry = S::F8::load(&[0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0])
                .lt(S::F8::splat(height.saturating_sub(from).into()));
            let near = S::F8::select(is_entry, S::F8::load(&near), S::F8::splat(f32::INFINITY));
            let t_max = S::F8::splat(t_max.min(f32::MAX));
            self.push::<S>(self.height, near, t_max, AS_THEY_ARE, &children);
            from = from.saturating_add(WIDTH as u8);
            if from >= height {
                return;
            }
        }
    }

    /// Puts those children on top for which `near <= far`, the one with the least `near` last.
    #[inline(always)]
    pub(super) fn enter_nearest_last<S: Simd>(&mut self, node: &Node, near: S::F8, far: S::F8) {
        let below = usize::from(self.height);
        self.push::<S>(self.height, near, far, AS_THEY_ARE, &node.children);
        for end in below + 1..usize::from(self.height) {
            let mut place = end;
            while place > below && self.near[place - 1] < self.near[place] {
                self.near.swap(place - 1, place);
                self.children.swap(place - 1, place);
                place -= 1;
            }
        }
    }

    /// Puts those children on top for which `near <= far`, the first slot last.
    #[inline(always)]
    pub(super) fn enter_first_last<S: Simd>(&mut self, node: &Node, near: S::F8, far: S::F8) {
        self.push::<S>(self.height, near, far, BACKWARDS, &node.children);
    }

    /// Writes those of eight subtrees for which `near <= far` to the places from `height` on.
    #[inline(always)]
    fn push<S: Simd>(&mut self, height: u8, near: S::F8, far: S::F8, order: u32, children: &[u32; WIDTH]) {
        let (kept, distances) = (eight_mut(&mut self.children, height), eight_mut(&mut self.near, height));
        self.height = height.wrapping_add(S::F8::keep(near, far, order, children, kept, distances) as u8);
    }
}

/// The eight entries from a height on.
#[inline(always)]
fn eight<T>(entries: &[T; ROOM], height: u8) -> &[T; WIDTH] {
    entries[usize::from(height)..].first_chunk().expect("there is room above every height")
}

#[inline(always)]
fn eight_mut<T>(entries: &mut [T; ROOM], height: u8) -> &mut [T; WIDTH] {
    entries[usize::from(height)..].first_chunk_mut().expect("there is room above every height")
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
pub(super) fn meet_children<S: Simd>(rays: &SetupLanes<WIDTH, S::F8>, node: &Node) -> ([S::F8; WIDTH], [S::F8; WIDTH]) {
    let (mut near, mut far) = ([S::F8::splat(0.0); WIDTH], [S::F8::splat(0.0); WIDTH]);
    let [x, y, z] = &node.planes;
    for slot in 0..WIDTH {
        let bounds = [[x[0][slot], x[1][slot]], [y[0][slot], y[1][slot]], [z[0][slot], z[1][slot]]];
        (near[slot], far[slot]) = rays.meet(bounds);
    }
    (S::transpose(near), S::transpose(far))
}

/// The octant in whose order a node's children are visited: the ray's own, from near to far. A search for any hit goes
/// from far to near: what is near the origin is mostly what the ray has just left.
#[inline(always)]
pub(super) fn first_octant<const ANY: bool>(octant: u8) -> u8 {
    if ANY { octant ^ 7 } else { octant }
}

/// Fetches a node, or a leaf's first block.
#[inline(always)]
pub(super) fn fetch<S: Simd>(tree: &BvhView, child: u32) {
    let node = tree.nodes().as_ptr().wrapping_add(child as usize).cast();
    let block = tree.blocks().as_ptr().wrapping_add(Child::first_block(child) as usize).cast();
    S::prefetch::<{ size_of::<Node>() }>(select_unpredictable(Child::is_node(child), node, block));
}

/// The corners of a block's eight triangles, in the order of `axes`.
#[inline(always)]
pub(super) fn corners<L: Lanes<WIDTH>>(block: &TriangleBlock, axes: [Axis; 3]) -> [[L; 3]; 3] {
    [corner(block, 0, axes), corner(block, 1, axes), corner(block, 2, axes)]
}

#[inline(always)]
fn corner<L: Lanes<WIDTH>>(block: &TriangleBlock, corner: usize, [x, y, z]: [Axis; 3]) -> [L; 3] {
    let axes = &block.corners[corner];
    [L::load(&axes[x as usize]), L::load(&axes[y as usize]), L::load(&axes[z as usize])]
}
