//! Packets of rays that run alike: the boxes of a node against a shaft of all rays first, then what it meets, and each
//! triangle, against the rays, one a lane.
//!
//! Rays run alike if their directions have the same signs and the same fastest axis: then they enter boxes through the
//! same planes and shear triangles along the same axis, and the lanes need no per-ray choices. A packet is traced in as
//! many parts as it has courses; rays that are alone, or whose `t_min` is negative, are traced one by one.

use super::flight::{self, Nearest};
use crate::bvh::{BvhView, Child, MAX_STACK, Node, TriangleBlock, WIDTH};
use crate::geometry::bundle::{Bundle, Course, Shaft, greatest};
use crate::geometry::triangle::{self, LineLanes};
use crate::geometry::{Hit, HitPacket, RayPacket};
use crate::simd::{Children, Lanes, Mask, Simd, Work, dispatch, lanes_of};

/// `N` rays at a time.
pub struct Width<const N: usize>;

/// The widths that packets come in: 4, 8 and 16.
pub trait PacketWidth<const N: usize>: sealed::Sealed {
    #[doc(hidden)]
    fn trace<const ANY: bool>(tree: &BvhView, rays: &RayPacket<N>, hits: &mut HitPacket<N>);
}

mod sealed {
    pub trait Sealed {}
    impl Sealed for super::Width<4> {}
    impl Sealed for super::Width<8> {}
    impl Sealed for super::Width<16> {}
}

macro_rules! width {
    ($width:literal, $lanes:ident) => {
        impl PacketWidth<$width> for Width<$width> {
            fn trace<const ANY: bool>(tree: &BvhView, rays: &RayPacket<$width>, hits: &mut HitPacket<$width>) {
                struct Trace<'a, const ANY: bool>(&'a BvhView<'a>, &'a RayPacket<$width>, &'a mut HitPacket<$width>);
                impl<const ANY: bool> Work for Trace<'_, ANY> {
                    type Output = ();
                    #[inline(always)]
                    fn run<S: Simd>(self) {
                        trace::<ANY, $width, S, S::$lanes>(self.0, self.1, self.2);
                    }
                }
                dispatch(tree.isa(), Trace::<ANY>(tree, rays, hits));
            }
        }
    };
}

width!(4, F4);
width!(8, F8);
width!(16, F16);

/// Writes the hits of the active rays; with `ANY` the first one found of each.
#[inline(always)]
pub(super) fn trace<const ANY: bool, const N: usize, S: Simd, L: Lanes<N>>(
    tree: &BvhView,
    packet: &RayPacket<N>,
    hits: &mut HitPacket<N>,
) {
    let bundle = Bundle::<L>::new(packet, &tree.bounds());
    let mut best = HitPacket { t: packet.t_max, ..HitPacket::MISS };
    let ahead = L::splat(0.0).le(bundle.t_min).bits();
    let mut waiting = bundle.live;
    while waiting != 0 {
        let (course, mut rays) = bundle.course(waiting);
        let first = rays & rays.wrapping_neg();
        rays = if first & ahead == 0 { first } else { rays & ahead };
        waiting &= !rays;
        if rays & rays.wrapping_sub(1) == 0 {
            let lane = rays.trailing_zeros() as usize % N;
            best.set(lane, flight::trace::<ANY, S>(tree, &packet.ray(lane)).unwrap_or(Hit::MISS));
        } else {
            Convoy::<N, L>::new(&bundle, course, rays, &packet.t_max, tree).trace::<ANY, S>(tree, rays, &mut best);
        }
    }
    for lane in packet.active_lanes() {
        let hit = best.hit(lane);
        hits.set(lane, if bundle.live >> lane & 1 != 0 && hit.is_hit() { hit } else { Hit::MISS });
    }
}

/// A subtree to visit, the rays that may meet its box, and which part of the way the first of them has gone by then.
#[derive(Clone, Copy)]
struct Entry {
    child: u32,
    rays: u32,
    near: f32,
}

/// From this visit on, rays of one origin are no longer thought to keep together, and boxes are tested with each.
const COHERENT: u32 = 4;

/// Rays of one course under way together.
struct Convoy<const N: usize, L> {
    course: Course,
    octant: usize,
    shaft: Shaft,
    lines: LineLanes<L>,
    /// The same numbers, for when few rays are left.
    line: LineLanes<[f32; N]>,
    /// For the nodes' boxes, as in [`Slabs`](crate::geometry::setup::Slabs), in the order of the axes.
    inverse: [L; 3],
    near_shift: [L; 3],
    far_shift: [L; 3],
    t_min: L,
    /// Of each ray, one over its length.
    inverse_lengths: L,
}

impl<const N: usize, L: Lanes<N>> Convoy<N, L> {
    #[inline(always)]
    fn new(bundle: &Bundle<L>, course: Course, rays: u32, t_max: &[f32; N], tree: &BvhView) -> Self {
        let scene = &tree.bounds();
        let lines = bundle.lines(&course);
        let lengths = bundle.lengths(&course, &lines, L::load(t_max), scene);
        let shaft = bundle.shaft(&course, lengths, rays, scene);
        let inverse_lengths = L::splat(1.0 + 8.0 * f32::EPSILON) / lengths.max(L::splat(f32::MIN_POSITIVE));
        let [x, y, z] = course.negative.map(usize::from);
        let ([a, b, c], [d, e, f], [g, h]) = (lines.origin, lines.inverse, lines.shear);
        let line = LineLanes {
            origin: [a.store(), b.store(), c.store()],
            inverse: [d.store(), e.store(), f.store()],
            shear: [g.store(), h.store()],
        };
        let (inverse, near_shift, far_shift) = bundle.slabs(&course, &lines, &shaft);
        let t_min = bundle.t_min;
        let octant = x | y << 1 | z << 2;
        Self { course, octant, shaft, lines, line, inverse, near_shift, far_shift, t_min, inverse_lengths }
    }

    /// The part of the way that is left to the ray with the longest one.
    #[inline(always)]
    fn left(&self, rays: u32, best: &HitPacket<N>) -> f32 {
        let left = L::load(&best.t) * self.inverse_lengths;
        greatest(L::select(L::Mask::from_bits(rays), left, L::splat(f32::NEG_INFINITY))).min(2.0)
    }

    /// Finds hits for `rays` that precede the best ones; with `ANY` one each.
    #[inline(always)]
    fn trace<const ANY: bool, S: Simd>(&self, tree: &BvhView, rays: u32, best: &mut HitPacket<N>) {
        let mut live = rays;
        let mut left = self.left(live, best);
        // All zeros, which are written quicker than any other value.
        let mut stack = [Entry { child: 0, rays: 0, near: 0.0 }; MAX_STACK];
        stack[0].rays = rays;
        let mut height = 1;
        let mut visits = if self.shaft.is_pointed { 0 } else { COHERENT };
        while height > 0 {
            height -= 1;
            let Entry { child, rays, near } = stack[height];
            let rays = rays & live;
            // As near is not nearer: there may be a tie to decide.
            if rays == 0 || near > left {
                continue;
            }
            if Child::is_node(child) {
                let Some(node) = tree.nodes().get(child as usize) else { continue };
                let (mut slots, mut near) = ([0; WIDTH], [0.0; WIDTH]);
                let count = self.enter::<S>(node, left, &mut slots, &mut near);
                let loose = visits >= COHERENT;
                visits += 1;
                let t_max = L::load(&best.t);
                for (&slot, &near) in slots.iter().zip(&near).take(count) {
                    let slot = slot as usize % WIDTH;
                    let rays = if loose { rays & self.meet_box(node, slot, t_max) } else { rays };
                    if let Some(entry) = stack.get_mut(height) {
                        *entry = Entry { child: node.children[slot], rays, near };
                        height += usize::from(rays != 0);
                    }
                }
                continue;
            }
            let mut found = 0;
            for block in tree.blocks().get(Child::leaf_blocks(child)).unwrap_or(&[]) {
                let candidates = self.candidates::<S>(block, left);
                found |= if rays.count_ones() < candidates.count_ones() {
                    self.hit_each::<S>(block, rays, best)
                } else {
                    self.hit(block, candidates, rays, best)
                };
            }
            if found != 0 {
                if ANY {
                    live &= !found;
                    if live == 0 {
                        return;
                    }
                }
                left = self.left(live, best);
            }
        }
    }

    /// Writes the slots whose boxes the shaft meets, and where, the nearest one last; gives their number.
    #[inline(always)]
    fn enter<S: Simd>(&self, node: &Node, left: f32, slots: &mut [u32; WIDTH], near: &mut [f32; WIDTH]) -> usize {
        let [x, y, z] = &node.planes;
        let (enter, leave) = self.meet::<S>([bounds::<S>(x), bounds::<S>(y), bounds::<S>(z)], left);
        S::F8::keep(enter, leave, node.order[self.octant & 7], &[0, 1, 2, 3, 4, 5, 6, 7], slots, near)
    }

    /// The rays that meet the box in `slot` within their intervals.
    #[inline(always)]
    fn meet_box(&self, node: &Node, slot: usize, t_max: L) -> u32 {
        let (mut enter, mut leave) = (self.t_min, t_max);
        for k in 0..3 {
            let axis = self.course.axes[k] as usize;
            let negative = self.course.negative[axis];
            let near = L::splat(node.planes[axis][usize::from(negative)][slot]);
            let far = L::splat(node.planes[axis][usize::from(!negative)][slot]);
            enter = enter.max(near.mul_sub(self.inverse[k], self.near_shift[k]));
            leave = leave.min(far.mul_sub(self.inverse[k], self.far_shift[k]));
        }
        enter.le(leave).bits()
    }

    /// The triangles of a block whose boxes the shaft meets.
    #[inline(always)]
    fn candidates<S: Simd>(&self, block: &TriangleBlock, left: f32) -> u32 {
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

    /// Tests triangles of a block in turn against all of `rays`. Gives those that found a better hit.
    #[inline(always)]
    fn hit(&self, block: &TriangleBlock, candidates: u32, rays: u32, best: &mut HitPacket<N>) -> u32 {
        let mut found = 0;
        for triangle in lanes_of(candidates) {
            let triangle = triangle % WIDTH;
            let corners =
                [self.corner(block, 0, triangle), self.corner(block, 1, triangle), self.corner(block, 2, triangle)];
            let Some(crossing) = triangle::cross(&self.lines, corners) else {
                continue;
            };
            let (t_max, prim_id) = (L::load(&best.t), block.prim_id[triangle]);
            let within = self.t_min.le(crossing.t).bits() & crossing.bits & rays;
            let ties = crossing.t.eq(t_max).bits() & within;
            let mut closer = crossing.t.lt(t_max).bits() & within;
            if ties != 0 {
                closer |= earlier(prim_id, ties, &best.prim_id);
            }
            let mask = L::Mask::from_bits(closer);
            best.t = L::select(mask, crossing.t, t_max).store();
            best.u = L::select(mask, crossing.u, L::load(&best.u)).store();
            best.v = L::select(mask, crossing.v, L::load(&best.v)).store();
            let prim_ids = L::load(bytemuck::cast_ref(&best.prim_id));
            best.prim_id = bytemuck::cast(L::select(mask, L::splat(f32::from_bits(prim_id)), prim_ids).store());
            found |= closer;
        }
        found
    }

    /// Tests `rays` in turn against all triangles of a block. Gives those that found a better hit.
    #[inline(always)]
    fn hit_each<S: Simd>(&self, block: &TriangleBlock, rays: u32, best: &mut HitPacket<N>) -> u32 {
        let (t_min, mut found) = (self.t_min.store(), 0);
        for lane in lanes_of(rays) {
            let lane = lane % N;
            let before = best.hit(lane);
            let mut nearest = Nearest::<false> { best: before };
            let line = &self.line;
            let ray = LineLanes::<S::F8> {
                origin: [
                    S::F8::splat(line.origin[0][lane]),
                    S::F8::splat(line.origin[1][lane]),
                    S::F8::splat(line.origin[2][lane]),
                ],
                inverse: [
                    S::F8::splat(line.inverse[0][lane]),
                    S::F8::splat(line.inverse[1][lane]),
                    S::F8::splat(line.inverse[2][lane]),
                ],
                shear: [S::F8::splat(line.shear[0][lane]), S::F8::splat(line.shear[1][lane])],
            };
            // This collector never breaks off.
            let _ = flight::hit_block(block, &ray, self.course.axes, t_min[lane], &mut nearest);
            if nearest.best.precedes(&before) {
                best.set(lane, nearest.best);
                found |= 1 << lane;
            }
        }
        found
    }

    /// A corner of one triangle, in the order of the course's axes.
    #[inline(always)]
    fn corner(&self, block: &TriangleBlock, corner: usize, triangle: usize) -> [L; 3] {
        let [x, y, z] = self.course.axes.map(|axis| axis as usize);
        let axes = &block.corners[corner];
        [L::splat(axes[x][triangle]), L::splat(axes[y][triangle]), L::splat(axes[z][triangle])]
    }
}

/// Those of `lanes` whose triangle comes after `prim_id`.
#[cold]
#[inline(never)]
fn earlier<const N: usize>(prim_id: u32, lanes: u32, prim_ids: &[u32; N]) -> u32 {
    lanes_of(lanes).filter(|&lane| prim_id < prim_ids[lane % N]).fold(0, |bits, lane| bits | 1 << lane)
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
