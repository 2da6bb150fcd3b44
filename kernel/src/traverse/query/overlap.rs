//! The triangles that have a point in common with a box.

use core::ops::ControlFlow;

use crate::bvh::{BvhView, Child, Node, TriangleBlock, WIDTH};
use crate::geometry::{Aabb, overlaps};
use crate::simd::{Lanes, Level, Mask, Simd, Work, dispatch, lanes_of};
use crate::traverse::reference;
use crate::traverse::stack::TraversalStack;

impl BvhView<'_> {
    /// Gives `visit` the `prim_id` of every triangle that [overlaps](overlaps()) `aabb`, each once and in an order that
    /// is the tree's own, the same on every instruction set, until it breaks off; returns whether it did. Touching
    /// counts; the box may be infinite, or a point.
    ///
    /// Never leaves a triangle out; `overlaps` says how exact it is.
    pub fn for_each_overlap(&self, aabb: &Aabb, mut visit: impl FnMut(u32) -> ControlFlow<()>) -> ControlFlow<()> {
        if aabb.is_empty() {
            return ControlFlow::Continue(());
        }
        match self.isa().level() {
            Level::Scalar => reference::for_each_overlap(self, aabb, &mut visit),
            _ => dispatch(self.isa(), Overlap { tree: self, aabb, visit }),
        }
    }
}

struct Overlap<'a, F> {
    tree: &'a BvhView<'a>,
    aabb: &'a Aabb,
    visit: F,
}

impl<F: FnMut(u32) -> ControlFlow<()>> Work for Overlap<'_, F> {
    type Output = ControlFlow<()>;

    #[inline(always)]
    fn run<S: Simd>(mut self) -> ControlFlow<()> {
        let query = BoxLanes::<S::F8>::splat(self.aabb);
        let mut stack = TraversalStack::new();
        stack.reset_to_root();
        loop {
            let Some((child, _)) = stack.pop() else { return ControlFlow::Continue(()) };
            if Child::is_node(child) {
                if let Some(node) = self.tree.nodes().get(child as usize) {
                    stack.push_first_last::<S>(node, query.gap(node), S::F8::splat(0.0));
                }
                continue;
            }
            for block in self.tree.blocks().get(Child::leaf_blocks(child)).unwrap_or(&[]) {
                for lane in lanes_of(query.near(block)) {
                    if overlaps(&block.triangle(lane), self.aabb) {
                        (self.visit)(block.prim_id[lane])?;
                    }
                }
            }
        }
    }
}

/// A box in all lanes.
struct BoxLanes<L> {
    min: [L; 3],
    max: [L; 3],
}

impl<L: Lanes<WIDTH>> BoxLanes<L> {
    #[inline(always)]
    fn splat(aabb: &Aabb) -> Self {
        // Differences with infinity would be NaN in empty slots.
        let (min, max) = (aabb.min.max(glam::Vec3::MIN), aabb.max.min(glam::Vec3::MAX));
        Self {
            min: [L::splat(min.x), L::splat(min.y), L::splat(min.z)],
            max: [L::splat(max.x), L::splat(max.y), L::splat(max.z)],
        }
    }

    /// The greatest gap to each of a node's boxes along an axis; none is positive if they overlap, as the sign of a
    /// difference is exact.
    #[inline(always)]
    fn gap(&self, node: &Node) -> L {
        self.gap_along(node, 0).max(self.gap_along(node, 1)).max(self.gap_along(node, 2))
    }

    #[inline(always)]
    fn gap_along(&self, node: &Node, axis: usize) -> L {
        let [lower, upper] = &node.planes[axis];
        (L::load(lower) - self.max[axis]).max(self.min[axis] - L::load(upper))
    }

    /// The triangles whose own boxes overlap this one.
    #[inline(always)]
    fn near(&self, block: &TriangleBlock) -> u32 {
        self.near_along(block, 0) & self.near_along(block, 1) & self.near_along(block, 2)
    }

    #[inline(always)]
    fn near_along(&self, block: &TriangleBlock, axis: usize) -> u32 {
        let [a, b, c] = &block.corners;
        let (a, b, c) = (L::load(&a[axis]), L::load(&b[axis]), L::load(&c[axis]));
        (a.min(b).min(c).le(self.max[axis]) & self.min[axis].le(a.max(b).max(c))).bits()
    }
}
