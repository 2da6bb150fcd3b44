//! A coherent packet, whose rays share octant and fastest axis: the boxes of a node, and those of a block's triangles,
//! against a shaft of all rays first, then those that the shaft hits against the rays, one a lane.

use crate::bvh::{Child, MAX_STACK, Node, TriangleBlock, WIDTH};
use crate::geometry::bundle::{Bundle, DirectionClass, greatest};
use crate::geometry::shaft::{Shaft, Surroundings};
use crate::geometry::triangle::LineLanes;
use crate::simd::{CompressChildren, Lanes, Mask, Simd};
use crate::traverse::node_test::visit_octant;

/// A subtree to visit, the rays that may meet its box, and the entry distance of the first of them, as a fraction of
/// its length.
#[derive(Clone, Copy)]
struct Entry {
    child: u32,
    rays: u32,
    near: f32,
}

/// From this visit on, rays of one origin no longer count as coherent, and boxes are tested with each ray.
const COHERENT: u32 = 4;

/// A tree that a packet goes through.
pub(crate) trait PacketTree<const N: usize, L> {
    /// Whether what is in a leaf costs so much that no ray should come there in vain.
    const IS_EXPENSIVE: bool;

    /// The node of this index, if there is one; `room` is memory for it.
    fn node<'n, S: Simd>(&'n self, index: u32, room: &'n mut Node) -> Option<&'n Node>;

    /// Prefetches a child.
    fn prefetch<S: Simd>(&self, child: u32);

    /// What the rays' hits may be at most as far away as.
    fn t_max(&self) -> &[f32; N];

    /// Tests what is in a leaf, up to the fraction `left` of the rays' lengths. Gives those of `rays` that found a
    /// better hit.
    fn visit_leaf<S: Simd>(&mut self, packet: &CoherentPacket<N, L>, leaf: u32, rays: u32, left: f32) -> u32;
}

/// Rays whose directions are of one class.
pub(crate) struct CoherentPacket<const N: usize, L> {
    pub(super) class: DirectionClass,
    octant: u8,
    shaft: Shaft,
    /// For the nodes' boxes, as in [`Slabs`](crate::geometry::setup::Slabs), in the order of the axes.
    inverse: [L; 3],
    near_shift: [L; 3],
    far_shift: [L; 3],
    pub(super) t_min: L,
    /// Of each ray, one over its length.
    inverse_lengths: L,
}

impl<const N: usize, L: Lanes<N>> CoherentPacket<N, L> {
    #[inline(always)]
    pub(crate) fn new(
        bundle: &Bundle<L>,
        class: DirectionClass,
        lines: &LineLanes<L>,
        rays: u32,
        t_max: &[f32; N],
        surroundings: &Surroundings,
    ) -> Self {
        let lengths = bundle.lengths(&class, lines, L::load(t_max), surroundings);
        let shaft = bundle.shaft(&class, lengths, rays, surroundings);
        let inverse_lengths = L::splat(1.0 + 8.0 * f32::EPSILON) / lengths.max(L::splat(f32::MIN_POSITIVE));
        let [x, y, z] = class.negative.map(u8::from);
        let (inverse, near_shift, far_shift) = bundle.slabs(&class, lines, &shaft);
        let t_min = bundle.t_min;
        let octant = x | y << 1 | z << 2;
        Self { class, octant, shaft, inverse, near_shift, far_shift, t_min, inverse_lengths }
    }

    /// The greatest remaining fraction of a ray's length.
    #[inline(always)]
    fn left(&self, rays: u32, t_max: &[f32; N]) -> f32 {
        let left = L::load(t_max) * self.inverse_lengths;
        greatest(L::select(L::Mask::from_bits(rays), left, L::splat(f32::NEG_INFINITY))).min(2.0)
    }

    /// Takes `rays` through a tree, roughly from near to far, and gives those that found a better hit. With `ANY` a ray
    /// that has found one goes no farther.
    #[inline(always)]
    pub(crate) fn walk<const ANY: bool, S: Simd, T: PacketTree<N, L>>(&self, tree: &mut T, rays: u32) -> u32 {
        let (mut live, mut all_found) = (rays, 0);
        let mut left = self.left(live, tree.t_max());
        let mut room = Node::EMPTY;
        // All zeros, which is fastest to write.
        let mut stack = [Entry { child: 0, rays: 0, near: 0.0 }; MAX_STACK];
        stack[0].rays = rays;
        let mut height = 1;
        let mut visits = if self.shaft.is_pointed && !T::IS_EXPENSIVE { 0 } else { COHERENT };
        while height > 0 {
            height -= 1;
            let Entry { child, rays, near } = stack[height];
            let rays = rays & live;
            // Equal distances are kept: ties are decided by `prim_id`.
            if rays == 0 || near > left {
                continue;
            }
            if Child::is_node(child) {
                let Some(node) = tree.node::<S>(child, &mut room) else { continue };
                let (mut slots, mut near) = ([0; WIDTH], [0.0; WIDTH]);
                let count = self.enter::<ANY, S>(node, left, &mut slots, &mut near);
                let loose = visits >= COHERENT;
                visits += 1;
                let t_max = L::load(tree.t_max());
                for (&slot, &near) in slots.iter().zip(&near).take(count) {
                    let slot = slot as usize % WIDTH;
                    let rays = if loose { rays & self.meet_box(node, slot, t_max) } else { rays };
                    tree.prefetch::<S>(node.children[slot]);
                    if let Some(entry) = stack.get_mut(height) {
                        *entry = Entry { child: node.children[slot], rays, near };
                        height += usize::from(rays != 0);
                    }
                }
                continue;
            }
            let rays = if T::IS_EXPENSIVE { rays & self.reaching(near, tree.t_max()) } else { rays };
            let found = tree.visit_leaf::<S>(self, child, rays, left);
            all_found |= found;
            if ANY {
                live &= !found;
                if live == 0 {
                    break;
                }
            } else if found != 0 {
                left = self.left(live, tree.t_max());
            }
        }
        all_found
    }

    /// Writes the slots whose boxes the shaft meets, and where, the [first](visit_octant) one last; gives their number.
    #[inline(always)]
    fn enter<const ANY: bool, S: Simd>(
        &self,
        node: &Node,
        left: f32,
        slots: &mut [u32; WIDTH],
        near: &mut [f32; WIDTH],
    ) -> usize {
        let [x, y, z] = &node.planes;
        let (enter, leave) = self.meet::<S>([bounds::<S>(x), bounds::<S>(y), bounds::<S>(z)], left);
        S::F8::compress(
            enter,
            leave,
            node.order[usize::from(visit_octant(self.octant, ANY) & 7)],
            &[0, 1, 2, 3, 4, 5, 6, 7],
            slots,
            near,
        )
    }

    /// The rays that meet the box in `slot` within their intervals.
    #[inline(always)]
    fn meet_box(&self, node: &Node, slot: usize, t_max: L) -> u32 {
        let (mut enter, mut leave) = (self.t_min, t_max);
        for k in 0..3 {
            let axis = self.class.axes[k] as usize;
            let negative = self.class.negative[axis];
            let near = L::splat(node.planes[axis][usize::from(negative)][slot]);
            let far = L::splat(node.planes[axis][usize::from(!negative)][slot]);
            enter = enter.max(near.mul_sub(self.inverse[k], self.near_shift[k]));
            leave = leave.min(far.mul_sub(self.inverse[k], self.far_shift[k]));
        }
        enter.le(leave).bits()
    }

    /// The rays that go as far as this fraction of their lengths.
    #[inline(always)]
    fn reaching(&self, near: f32, t_max: &[f32; N]) -> u32 {
        L::splat(near).le(L::load(t_max) * self.inverse_lengths).bits()
    }

    /// The triangles of a block whose boxes the shaft meets.
    #[inline(always)]
    pub(super) fn candidates<S: Simd>(&self, block: &TriangleBlock, left: f32) -> u32 {
        let (enter, leave) =
            self.meet::<S>([extent::<S>(block, 0), extent::<S>(block, 1), extent::<S>(block, 2)], left);
        enter.le(leave).bits()
    }

    /// Where the shaft enters and leaves eight boxes, of which the lower and upper bounds are given.
    #[inline(always)]
    fn meet<S: Simd>(&self, boxes: [[S::F8; 2]; 3], left: f32) -> (S::F8, S::F8) {
        let (mut enter, mut leave) = (S::F8::splat(0.0), S::F8::splat(left));
        let Shaft { inverse, shift, rises, .. } = &self.shaft;
        for axis in 0..3 {
            // The upper side has to be above the lower bounds, the lower side below the upper ones.
            let [lower, upper] = boxes[axis];
            let above = lower.mul_sub(S::F8::splat(inverse[0][axis]), S::F8::splat(shift[0][axis]));
            let below = upper.mul_sub(S::F8::splat(inverse[1][axis]), S::F8::splat(shift[1][axis]));
            if rises[0][axis] {
                enter = enter.max(above);
            } else {
                leave = leave.min(above);
            }
            if rises[1][axis] {
                leave = leave.min(below);
            } else {
                enter = enter.max(below);
            }
        }
        (enter, leave)
    }
}

/// The lower and upper bounds of eight boxes along an axis.
#[inline(always)]
fn bounds<S: Simd>(planes: &[[f32; WIDTH]; 2]) -> [S::F8; 2] {
    [S::F8::load(&planes[0]), S::F8::load(&planes[1])]
}

/// The lower and upper bounds of a block's triangles along an axis.
#[inline(always)]
fn extent<S: Simd>(block: &TriangleBlock, axis: usize) -> [S::F8; 2] {
    let [a, b, c] = &block.corners;
    let (a, b, c) = (S::F8::load(&a[axis]), S::F8::load(&b[axis]), S::F8::load(&c[axis]));
    [a.min(b).min(c), a.max(b).max(c)]
}
