//! The traversal stack: the subtrees that a ray has still to visit.
//!
//! Children are not sorted by distance but taken in an order that the tree keeps for each octant of directions, which
//! needs no branch.

use super::node_test;
use crate::bvh::{Child, MAX_STACK, Node, WIDTH};
use crate::geometry::setup::Slabs;
use crate::simd::{CompressChildren, Lanes, Simd};

/// Whatever a height is, an entry is there, and room for the eight that a node writes, whether it keeps them or not; and
/// so many that distances begin with a cache line.
const ROOM: usize = 256 + WIDTH + 7;
const _: () = assert!(MAX_STACK + 1 + WIDTH <= 256);

/// The order of the slots themselves.
const AS_THEY_ARE: u32 = 0o76543210;
/// The last slot first.
const BACKWARDS: u32 = 0o01234567;

/// A stack of subtrees. At its bottom lies [`TraversalStack::NONE`], which is never taken. What is used of a low one lies in two
/// cache lines.
#[repr(C, align(64))]
pub(crate) struct TraversalStack {
    height: u8,
    /// The next one last.
    children: [u32; ROOM],
    /// Where the ray enters their boxes.
    near: [f32; ROOM],
}

impl TraversalStack {
    /// What is on top when nothing is left. No node keeps it: it stands for a box that is inside out.
    pub(super) const NONE: u32 = u32::MAX;
    /// Nothing left to visit.
    pub(crate) const EMPTY: Self = Self { height: 1, children: [Self::NONE; ROOM], near: [f32::INFINITY; ROOM] };

    /// Leaves the root alone to visit.
    #[inline(always)]
    pub(super) fn reset_to_root(&mut self) {
        (self.children[1], self.near[1]) = (Child::Node(0).pack(), f32::NEG_INFINITY);
        self.height = 2;
    }

    /// Leaves those children of the root alone to visit for which `near <= far`.
    #[inline(always)]
    pub(super) fn reset_to_children<S: Simd>(&mut self, root: &Node, near: S::F8, far: S::F8, octant: u8) {
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

    /// Takes what is next, and where its box begins. Not if it is [`TraversalStack::NONE`].
    #[inline(always)]
    pub(super) fn pop(&mut self) -> (u32, f32) {
        self.height = self.height.wrapping_sub(1);
        let top = usize::from(self.height);
        (self.children[top], self.near[top])
    }

    /// Takes the leaf that is next, but for its first block.
    #[inline(always)]
    pub(super) fn pop_block(&mut self) -> u32 {
        let height = self.height.wrapping_sub(1);
        let place = &mut self.children[usize::from(height)];
        let leaf = *place;
        *place = Child::without_first_block(leaf);
        self.height = height + u8::from(Child::has_more_blocks(leaf));
        Child::first_block(leaf)
    }

    /// Puts the children whose boxes the ray meets within its interval on top, the nearest one last.
    #[inline(always)]
    pub(crate) fn push_children<S: Simd>(&mut self, node: &Node, ray: &Slabs, octant: u8, t_min: f32, t_max: f32) {
        let (near, far) = node_test::intersect::<S>(node, ray, t_min, t_max);
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
    pub(super) fn push_nearest_last<S: Simd>(&mut self, node: &Node, near: S::F8, far: S::F8) {
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
    pub(super) fn push_first_last<S: Simd>(&mut self, node: &Node, near: S::F8, far: S::F8) {
        self.push::<S>(self.height, near, far, BACKWARDS, &node.children);
    }

    /// Writes those of eight subtrees for which `near <= far` to the places from `height` on.
    #[inline(always)]
    fn push<S: Simd>(&mut self, height: u8, near: S::F8, far: S::F8, order: u32, children: &[u32; WIDTH]) {
        let (kept, distances) = (eight_mut(&mut self.children, height), eight_mut(&mut self.near, height));
        self.height = height.wrapping_add(S::F8::compress(near, far, order, children, kept, distances) as u8);
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
