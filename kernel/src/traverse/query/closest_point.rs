//! The point of the surface that is closest to a point.

use glam::Vec3;

use crate::bvh::{BvhView, Child, Node, TriangleBlock, WIDTH};
use crate::geometry::SurfacePoint;
use crate::geometry::closest::{ClosestCandidate, closest_points};
use crate::simd::{Lanes, Level, Mask, Simd, Work, dispatch, lanes_of};
use crate::traverse::reference;
use crate::traverse::stack::TraversalStack;

impl BvhView<'_> {
    /// The point of the triangles that is closest to `point`, if it is not farther than `radius`; of equally close ones
    /// that of the lowest `prim_id`. `None` too if `point` is out of the [numeric limits](crate#numeric-limits), or
    /// `radius` is negative or NaN; it may be infinite.
    ///
    /// Distances are compared by their squares in `f32`. As with hits, the tree does not matter: it is what a loop over
    /// all triangles gives.
    pub fn closest_point(&self, point: Vec3, radius: f32) -> Option<SurfacePoint> {
        let nothing = ClosestCandidate::none_within(point, radius)?;
        let best = match self.isa().level() {
            Level::Scalar => reference::closest_point(self, point, nothing),
            _ => dispatch(self.isa(), Closest { tree: self, point, best: nothing }),
        };
        best.found(point)
    }
}

struct Closest<'a> {
    tree: &'a BvhView<'a>,
    point: Vec3,
    best: ClosestCandidate,
}

impl Work for Closest<'_> {
    type Output = ClosestCandidate;

    #[inline(always)]
    fn run<S: Simd>(mut self) -> ClosestCandidate {
        let from = [S::F8::splat(self.point.x), S::F8::splat(self.point.y), S::F8::splat(self.point.z)];
        let mut stack = TraversalStack::new();
        stack.reset_to_root();
        loop {
            let Some((child, near)) = stack.pop() else { return self.best };
            // As close is not closer: there may be a tie to decide.
            if near > self.best.distance2 {
                continue;
            }
            if Child::is_node(child) {
                if let Some(node) = self.tree.nodes().get(child as usize) {
                    // Empty slots are infinitely far away.
                    let far = S::F8::splat(self.best.distance2.min(f32::MAX));
                    stack.push_nearest_last::<S>(node, distance2(node, &from), far);
                }
            } else {
                for block in self.tree.blocks().get(Child::leaf_blocks(child)).unwrap_or(&[]) {
                    self.visit_block(block, &from);
                }
            }
        }
    }
}

impl Closest<'_> {
    /// Replaces the best by the block's closest triangle, if that precedes it.
    #[inline(always)]
    fn visit_block<L: Lanes<WIDTH>>(&mut self, block: &TriangleBlock, from: &[L; 3]) {
        let [a, b, c] = &block.corners;
        let feet = closest_points([relative(a, from), relative(b, from), relative(c, from)]);
        let bits = feet.distance2.le(L::splat(self.best.distance2)).bits();
        if bits == 0 {
            return;
        }
        let ([x, y, z], distance2) = (feet.offset, feet.distance2.store());
        let (x, y, z, u, v) = (x.store(), y.store(), z.store(), feet.u.store(), feet.v.store());
        for lane in lanes_of(bits) {
            let foot = ClosestCandidate {
                offset: [x[lane], y[lane], z[lane]],
                distance2: distance2[lane],
                u: u[lane],
                v: v[lane],
                prim_id: block.prim_id[lane],
            };
            if foot.precedes(&self.best) {
                self.best = foot;
            }
        }
    }
}

#[inline(always)]
fn relative<L: Lanes<WIDTH>>(corner: &[[f32; WIDTH]; 3], from: &[L; 3]) -> [L; 3] {
    [L::load(&corner[0]) - from[0], L::load(&corner[1]) - from[1], L::load(&corner[2]) - from[2]]
}

/// The distances of a node's boxes, squared: computed like those of triangles, and never greater than of one inside.
#[inline(always)]
fn distance2<L: Lanes<WIDTH>>(node: &Node, from: &[L; 3]) -> L {
    let (x, y, z) = (gap(node, from, 0), gap(node, from, 1), gap(node, from, 2));
    x * x + y * y + z * z
}

/// How far the boxes are along one axis; zero inside.
#[inline(always)]
fn gap<L: Lanes<WIDTH>>(node: &Node, from: &[L; 3], axis: usize) -> L {
    let [lower, upper] = &node.planes[axis];
    let (before, behind) = (L::load(lower) - from[axis], from[axis] - L::load(upper));
    before.max(behind).max(L::splat(0.0))
}
