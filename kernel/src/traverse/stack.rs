//! The traversal stack: the subtrees that a ray has still to visit. Walks whose order others see use this one: children
//! come in the order that the tree keeps for each octant of directions, not in that of their distances.

use super::node_test::NodeTest;
use crate::bvh::{Child, MAX_STACK, Node, SLOTS_IN_ORDER, WIDTH};
use crate::geometry::setup::Slabs;
use crate::simd::{CompressChildren, Simd, UninitStack};

const _: () = assert!(MAX_STACK + WIDTH < 256, "more than a stack with an index of eight bits holds");

/// The slots, the last one first.
const BACKWARDS: u32 = 0o01234567;

/// A stack of subtrees, and where the ray enters their boxes.
pub(crate) struct TraversalStack {
    children: UninitStack<u32>,
    near: UninitStack<f32>,
}

impl TraversalStack {
    /// An empty stack.
    #[inline(always)]
    pub(crate) fn new() -> Self {
        Self { children: UninitStack::new(), near: UninitStack::new() }
    }

    /// Leaves the root alone to visit.
    #[inline(always)]
    pub(super) fn reset_to_root(&mut self) {
        self.children.clear();
        self.near.clear();
        self.children.push(Child::Node(0).pack());
        self.near.push(f32::NEG_INFINITY);
    }

    /// Pops the next subtree, and where its box begins.
    #[inline(always)]
    pub(super) fn pop(&mut self) -> Option<(u32, f32)> {
        self.children.pop().zip(self.near.pop())
    }

    /// Pushes the children whose boxes the ray meets within its interval, the nearest one last.
    #[inline(always)]
    pub(crate) fn push_children<S: Simd>(&mut self, node: &Node, ray: &Slabs, octant: u8, t_min: f32, t_max: f32) {
        let (near, far) = NodeTest::<S::F8>::new(ray, t_min).intersect(node, t_max);
        let (mut children, mut distances) = ([0; WIDTH], [0.0; WIDTH]);
        let order = node.order[usize::from(octant & 7)];
        let count = S::F8::compress(near, far, order, &node.children, &mut children, &mut distances);
        self.push(children, distances, count);
    }

    /// Pushes the children of the node of this index, if there is one.
    #[inline(always)]
    pub(crate) fn push_children_of<S: Simd>(
        &mut self,
        nodes: &[Node],
        node: u32,
        ray: &Slabs,
        octant: u8,
        (t_min, t_max): (f32, f32),
    ) {
        if let Some(node) = nodes.get(node as usize) {
            self.push_children::<S>(node, ray, octant, t_min, t_max);
        }
    }

    /// Pushes the children for which `near <= far`, the one with the least `near` last.
    #[inline(always)]
    pub(super) fn push_nearest_last<S: Simd>(&mut self, node: &Node, near: S::F8, far: S::F8) {
        let (mut children, mut distances) = ([0; WIDTH], [0.0; WIDTH]);
        let count = S::F8::compress(near, far, SLOTS_IN_ORDER, &node.children, &mut children, &mut distances);
        for end in 1..count.min(WIDTH) {
            let mut place = end;
            while place > 0 && distances[place - 1] < distances[place] {
                distances.swap(place - 1, place);
                children.swap(place - 1, place);
                place -= 1;
            }
        }
        self.push(children, distances, count);
    }

    /// Pushes the children for which `near <= far`, the first slot last.
    #[inline(always)]
    pub(super) fn push_first_last<S: Simd>(&mut self, node: &Node, near: S::F8, far: S::F8) {
        let (mut children, mut distances) = ([0; WIDTH], [0.0; WIDTH]);
        let count = S::F8::compress(near, far, BACKWARDS, &node.children, &mut children, &mut distances);
        self.push(children, distances, count);
    }

    #[inline(always)]
    fn push(&mut self, children: [u32; WIDTH], near: [f32; WIDTH], count: usize) {
        self.children.push_first(children, count);
        self.near.push_first(near, count);
    }
}
