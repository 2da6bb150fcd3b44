//! Packets of rays that run alike: the boxes of a node against a shaft of all rays first, then what it meets, and each
//! triangle, against the rays, one a lane.
//!
//! Rays run alike if their directions have the same signs and the same fastest axis: then they enter boxes through the
//! same planes and shear triangles along the same axis, and the lanes need no per-ray choices. A packet is traced in as
//! many parts as it has courses; rays that are alone, or whose `t_min` is negative, are traced one by one.

use super::flight;
use crate::bvh::{BvhView, Child, MAX_STACK, Node, TriangleBlock, WIDTH};
use crate::geometry::bundle::{Bundle, Course, Shaft, greatest};
use crate::geometry::triangle::{self, LineLanes};
use crate::geometry::{Aabb, Hit, HitPacket, RayPacket};
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
    let mut best = Best::none(L::load(&packet.t_max));
    let ahead = L::splat(0.0).le(bundle.t_min).bits();
    let mut waiting = bundle.live;
    while waiting != 0 {
        let (course, mut rays) = bundle.course(packet, waiting);
        rays &= ahead | rays & rays.wrapping_neg();
        waiting &= !rays;
        if rays & rays.wrapping_sub(1) == 0 {
            let lane = rays.trailing_zeros() as usize % N;
            if let Some(hit) = flight::trace::<ANY, S>(tree, &packet.ray(lane)) {
                best.take(L::Mask::from_bits(rays), &Best::splat(&hit));
            }
        } else {
            Convoy::new(&bundle, course, rays, best.t, &tree.bounds()).trace::<ANY, N, S>(tree, rays, &mut best);
        }
    }
    best.write(bundle.live, packet.active, hits);
}

/// The best hits so far, a ray a lane; `prim_id` by its bits.
struct Best<L> {
    t: L,
    u: L,
    v: L,
    prim_id: L,
}

impl<L: Copy> Best<L> {
    /// None up to `t_max`.
    #[inline(always)]
    fn none<const N: usize>(t_max: L) -> Self
    where
        L: Lanes<N>,
    {
        let zero = L::splat(0.0);
        Self { t: t_max, u: zero, v: zero, prim_id: L::splat(f32::from_bits(Hit::NO_PRIM)) }
    }

    /// The same hit in all lanes.
    #[inline(always)]
    fn splat<const N: usize>(hit: &Hit) -> Self
    where
        L: Lanes<N>,
    {
        let prim_id = L::splat(f32::from_bits(hit.prim_id));
        Self { t: L::splat(hit.t), u: L::splat(hit.u), v: L::splat(hit.v), prim_id }
    }

    /// Takes other hits in the lanes of `mask`.
    #[inline(always)]
    fn take<const N: usize>(&mut self, mask: L::Mask, other: &Self)
    where
        L: Lanes<N>,
    {
        self.t = L::select(mask, other.t, self.t);
        self.u = L::select(mask, other.u, self.u);
        self.v = L::select(mask, other.v, self.v);
        self.prim_id = L::select(mask, other.prim_id, self.prim_id);
    }

    /// Of `lanes`, in which a hit is as near as the best one, those whose best one is of a triangle after `prim_id`.
    #[cold]
    #[inline(never)]
    fn after<const N: usize>(&self, prim_id: u32, lanes: u32) -> u32
    where
        L: Lanes<N>,
    {
        let best = self.prim_id.store();
        lanes_of(lanes).filter(|&lane| prim_id < best[lane].to_bits()).fold(0, |bits, lane| bits | 1 << lane)
    }

    /// Writes the lanes of `active`: those of `live` that found something, and misses.
    #[inline(always)]
    fn write<const N: usize>(&self, live: u32, active: u32, hits: &mut HitPacket<N>)
    where
        L: Lanes<N>,
    {
        let (t, u, v, prim_id) = (self.t.store(), self.u.store(), self.v.store(), self.prim_id.store());
        for lane in 0..N {
            let prim_id = prim_id[lane].to_bits();
            if active >> lane & 1 != 0 {
                let found = live >> lane & 1 != 0 && prim_id != Hit::NO_PRIM;
                hits.set(lane, if found { Hit { t: t[lane], u: u[lane], v: v[lane], prim_id } } else { Hit::MISS });
            }
        }
    }
}

/// What validation allows, and room for the eight that a node writes, whether it keeps them or not.
const ROOM: usize = MAX_STACK + WIDTH;

/// Rays of one course under way together.
struct Convoy<L> {
    course: Course,
    octant: usize,
    shaft: Shaft,
    lines: LineLanes<L>,
    t_min: L,
    /// Of each ray, one over its length.
    inverse_lengths: L,
}

impl<L: Copy> Convoy<L> {
    #[inline(always)]
    fn new<const N: usize>(bundle: &Bundle<L>, course: Course, rays: u32, t_max: L, scene: &Aabb) -> Self
    where
        L: Lanes<N>,
    {
        let lines = bundle.lines(&course);
        let lengths = bundle.lengths(&course, &lines, t_max, scene);
        let shaft = bundle.shaft(&course, lengths, rays, scene);
        let inverse_lengths = L::splat(1.0 + 8.0 * f32::EPSILON) / lengths.max(L::splat(f32::MIN_POSITIVE));
        let [x, y, z] = course.negative.map(usize::from);
        Self { course, octant: x | y << 1 | z << 2, shaft, lines, t_min: bundle.t_min, inverse_lengths }
    }

    /// The part of the way that is left to the ray with the longest one.
    #[inline(always)]
    fn left<const N: usize>(&self, rays: u32, best: &Best<L>) -> f32
    where
        L: Lanes<N>,
    {
        let left = best.t * self.inverse_lengths;
        greatest(L::select(L::Mask::from_bits(rays), left, L::splat(f32::NEG_INFINITY))).min(2.0)
    }

    /// Finds hits for `rays` that precede the best ones; with `ANY` one each.
    #[inline(always)]
    fn trace<const ANY: bool, const N: usize, S: Simd>(&self, tree: &BvhView, rays: u32, best: &mut Best<L>)
    where
        L: Lanes<N>,
    {
        let mut live = rays;
        let mut left = self.left(live, best);
        let mut children = [0u32; ROOM];
        let mut near = [f32::NEG_INFINITY; ROOM];
        let mut height = 1;
        while height > 0 {
            height -= 1;
            let (child, entry) = (children[height], near[height]);
            // As near is not nearer: there may be a tie to decide.
            if entry > left {
                continue;
            }
            if Child::is_node(child) {
                let children = children.get_mut(height..).and_then(<[_]>::first_chunk_mut);
                let near = near.get_mut(height..).and_then(<[_]>::first_chunk_mut);
                if let (Some(node), Some(children), Some(near)) = (tree.nodes().get(child as usize), children, near) {
                    height += self.enter::<S>(node, left, children, near);
                }
                continue;
            }
            let mut found = 0;
            for block in tree.blocks().get(Child::leaf_blocks(child)).unwrap_or(&[]) {
                let candidates = self.candidates::<S>(block, left);
                found |= self.hit(block, candidates, live, best);
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

    /// Writes the children whose boxes the shaft meets, and where, the nearest one last; gives their number.
    #[inline(always)]
    fn enter<S: Simd>(&self, node: &Node, left: f32, children: &mut [u32; WIDTH], near: &mut [f32; WIDTH]) -> usize {
        let [x, y, z] = &node.planes;
        let (enter, leave) = self.meet::<S>([bounds::<S>(x), bounds::<S>(y), bounds::<S>(z)], left);
        S::F8::keep(enter, leave, node.order[self.octant & 7], &node.children, children, near)
    }

    /// The triangles of a block whose boxes the shaft meets.
    #[inline(always)]
    fn candidates<S: Simd>(&self, block: &TriangleBlock, left: f32) -> u32 {
        let (enter, leave) = self.meet::<S>([extent::<S>(block, 0), extent::<S>(block, 1), extent::<S>(block, 2)], left);
        enter.le(leave).bits()
    }

    /// Where the shaft enters and leaves eight boxes, of which the lower and upper bounds are given.
    #[inline(always)]
    fn meet<S: Simd>(&self, boxes: [[S::F8; 2]; 3], left: f32) -> (S::F8, S::F8) {
        let (mut enter, mut leave) = (S::F8::splat(0.0), S::F8::splat(left));
        let Shaft { inverse, shift, rises } = &self.shaft;
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

    /// Tests triangles of a block in turn against `rays`. Gives those that found a better hit.
    #[inline(always)]
    fn hit<const N: usize>(&self, block: &TriangleBlock, candidates: u32, rays: u32, best: &mut Best<L>) -> u32
    where
        L: Lanes<N>,
    {
        let mut found = 0;
        for triangle in lanes_of(candidates) {
            let triangle = triangle % WIDTH;
            let corners =
                [self.corner(block, 0, triangle), self.corner(block, 1, triangle), self.corner(block, 2, triangle)];
            let Some(crossing) = triangle::cross(&self.lines, corners) else {
                continue;
            };
            let within = (self.t_min.le(crossing.t) & crossing.t.le(best.t)).bits() & crossing.bits & rays;
            if within == 0 {
                continue;
            }
            let prim_id = block.prim_id[triangle];
            let ties = crossing.t.eq(best.t).bits() & within;
            let closer = if ties == 0 { within } else { within & !ties | best.after(prim_id, ties) };
            let prim_id = L::splat(f32::from_bits(prim_id));
            best.take(L::Mask::from_bits(closer), &Best { t: crossing.t, u: crossing.u, v: crossing.v, prim_id });
            found |= closer;
        }
        found
    }

    /// A corner of one triangle, in the order of the course's axes.
    #[inline(always)]
    fn corner<const N: usize>(&self, block: &TriangleBlock, corner: usize, triangle: usize) -> [L; 3]
    where
        L: Lanes<N>,
    {
        let [x, y, z] = self.course.axes.map(|axis| axis as usize);
        let axes = &block.corners[corner];
        [L::splat(axes[x][triangle]), L::splat(axes[y][triangle]), L::splat(axes[z][triangle])]
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
