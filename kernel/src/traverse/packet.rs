//! Packets of rays that run alike: one box, or one triangle, against all rays at a time.
//!
//! Rays run alike if their directions have the same signs and the same fastest axis: then they enter boxes through the
//! same planes and shear triangles along the same axis, and the lanes need no per-ray choices. Packets of other rays
//! are traced one by one, which is quicker for rays that go different ways anyhow.

use super::flight;
use super::stack::Stack;
use crate::bvh::{BvhView, Child, Node, TriangleBlock, WIDTH};
use crate::geometry::setup::{Axis, RaySetup};
use crate::geometry::triangle::{self, LineLanes};
use crate::geometry::{Hit, HitPacket, RayPacket};
use crate::simd::{Lanes, Mask, Simd, Work, dispatch, lanes_of};

/// `N` rays at a time.
pub struct Width<const N: usize>;

/// The widths that packets come in: 4 and 8.
pub trait PacketWidth<const N: usize>: sealed::Sealed {
    #[doc(hidden)]
    fn trace<const ANY: bool>(tree: &BvhView, rays: &RayPacket<N>, hits: &mut HitPacket<N>);
}

mod sealed {
    pub trait Sealed {}
    impl Sealed for super::Width<4> {}
    impl Sealed for super::Width<8> {}
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

/// A subtree to visit, the rays that meet its box, and where the first of them enters it.
#[derive(Clone, Copy)]
struct Entry {
    child: u32,
    rays: u32,
    near: f32,
}

/// Writes the hits of the active rays; with `ANY` the first one found of each.
#[inline(always)]
fn trace<const ANY: bool, const N: usize, S: Simd, L: Lanes<N>>(
    tree: &BvhView,
    packet: &RayPacket<N>,
    hits: &mut HitPacket<N>,
) {
    // Rays that can hit nothing are done with at once.
    let mut setups = [None; N];
    let mut live = 0;
    for lane in packet.active_lanes() {
        setups[lane] = RaySetup::new(&packet.ray(lane), &tree.bounds());
        live |= (setups[lane].is_some() as u32) << lane;
        hits.set(lane, Hit::MISS);
    }
    let Some(first) = setups.iter().flatten().next().copied() else {
        return;
    };
    if setups.iter().flatten().any(|setup| setup.course() != first.course()) {
        for lane in lanes_of(live) {
            let ray = packet.ray(lane);
            hits.set(lane, flight::trace::<ANY, S>(tree, &ray).unwrap_or(Hit::MISS));
        }
        return;
    }
    // Idle lanes compute something; nobody looks at it.
    let traversal = Traversal::<L>::new(&setups.map(|setup| setup.unwrap_or(first)), &packet.t_min);
    let mut best: [Hit; N] = core::array::from_fn(|lane| Hit::none_before(packet.t_max[lane]));
    let mut stack = Stack::new(Entry { child: 0, rays: 0, near: 0.0 });
    let mut next = Some(Entry { child: 0, rays: live, near: f32::NEG_INFINITY });
    while let Some(entry) = next {
        let rays = entry.rays & live;
        if lanes_of(rays).any(|lane| entry.near <= best[lane].t) {
            match Child::unpack(entry.child) {
                Child::Empty => {}
                Child::Node(index) => {
                    if let Some(node) = tree.nodes().get(index as usize) {
                        let t_max = L::load(&best.map(|hit| hit.t));
                        let since = stack.height();
                        for slot in 0..WIDTH {
                            let (bits, near) = traversal.enter(node, slot, t_max);
                            if bits & rays != 0 {
                                let near =
                                    lanes_of(bits & rays).fold(f32::INFINITY, |least, lane| least.min(near[lane]));
                                let entry = Entry { child: node.children[slot], rays: bits & rays, near };
                                stack.insert(entry, since, |other| !ANY && other.near < near);
                            }
                        }
                    }
                }
                Child::Leaf { first, count } => {
                    let range = first as usize..first as usize + count as usize;
                    for block in tree.blocks().get(range).unwrap_or(&[]) {
                        traversal.hit_block(block, rays, &mut best);
                    }
                    if ANY {
                        live =
                            lanes_of(live).filter(|&lane| !best[lane].is_hit()).fold(0, |live, lane| live | 1 << lane);
                    }
                }
            }
        }
        next = stack.pop();
    }
    for (lane, setup) in setups.iter().enumerate() {
        if setup.is_some() {
            hits.set(lane, best[lane].found().unwrap_or(Hit::MISS));
        }
    }
}

/// What stays the same while a packet is traced: a ray a lane, all on one course.
struct Traversal<L> {
    axes: [Axis; 3],
    negative: [bool; 3],
    inverse: [L; 3],
    near_shift: [L; 3],
    far_shift: [L; 3],
    lines: LineLanes<L>,
    t_min: L,
}

impl<L: Copy> Traversal<L> {
    #[inline(always)]
    fn new<const N: usize>(rays: &[RaySetup; N], t_min: &[f32; N]) -> Self
    where
        L: Lanes<N>,
    {
        Self {
            axes: rays[0].line.axes,
            negative: rays[0].slabs.negative,
            inverse: gather(rays, |ray| ray.slabs.inverse),
            near_shift: gather(rays, |ray| ray.slabs.near_shift),
            far_shift: gather(rays, |ray| ray.slabs.far_shift),
            lines: LineLanes {
                origin: gather(rays, |ray| ray.line.origin),
                inverse: gather(rays, |ray| ray.line.inverse),
                shear: gather(rays, |ray| ray.line.shear),
            },
            t_min: L::load(t_min),
        }
    }

    /// The rays that meet the box in `slot` within their intervals, and where.
    #[inline(always)]
    fn enter<const N: usize>(&self, node: &Node, slot: usize, t_max: L) -> (u32, [f32; N])
    where
        L: Lanes<N>,
    {
        let (mut enter, mut leave) = (self.t_min, t_max);
        for axis in 0..3 {
            let negative = self.negative[axis];
            let near = L::splat(node.planes[axis][usize::from(negative)][slot]);
            let far = L::splat(node.planes[axis][usize::from(!negative)][slot]);
            enter = enter.max(near.mul_sub(self.inverse[axis], self.near_shift[axis]));
            leave = leave.min(far.mul_sub(self.inverse[axis], self.far_shift[axis]));
        }
        (enter.le(leave).bits(), enter.store())
    }

    /// A corner of one triangle, in the order of the course's axes.
    #[inline(always)]
    fn corner<const N: usize>(&self, block: &TriangleBlock, corner: usize, triangle: usize) -> [L; 3]
    where
        L: Lanes<N>,
    {
        let [x, y, z] = self.axes.map(|axis| axis as usize);
        let axes = &block.corners[corner];
        [L::splat(axes[x][triangle]), L::splat(axes[y][triangle]), L::splat(axes[z][triangle])]
    }

    /// Tests the block's triangles in turn against `rays`.
    #[inline(always)]
    fn hit_block<const N: usize>(&self, block: &TriangleBlock, rays: u32, best: &mut [Hit; N])
    where
        L: Lanes<N>,
    {
        for (triangle, &prim_id) in block.prim_id.iter().enumerate().filter(|&(_, &id)| id != Hit::NO_PRIM) {
            let corners =
                [self.corner(block, 0, triangle), self.corner(block, 1, triangle), self.corner(block, 2, triangle)];
            let Some(crossing) = triangle::cross(&self.lines, corners) else {
                continue;
            };
            let within = self.t_min.le(crossing.t).bits() & crossing.bits & rays;
            if within == 0 {
                continue;
            }
            let (t, u, v) = (crossing.t.store(), crossing.u.store(), crossing.v.store());
            for lane in lanes_of(within) {
                let hit = Hit { t: t[lane], u: u[lane], v: v[lane], prim_id };
                if hit.precedes(&best[lane]) {
                    best[lane] = hit;
                }
            }
        }
    }
}

/// The same part of all rays, turned into lanes.
#[inline(always)]
fn gather<const N: usize, const M: usize, L: Lanes<N>>(
    rays: &[RaySetup; N],
    part: impl Fn(&RaySetup) -> [f32; M],
) -> [L; M] {
    let mut lanes = [L::splat(0.0); M];
    for (k, lanes) in lanes.iter_mut().enumerate() {
        let mut values = [0.0; N];
        for (value, ray) in values.iter_mut().zip(rays) {
            *value = part(ray)[k];
        }
        *lanes = L::load(&values);
    }
    lanes
}
