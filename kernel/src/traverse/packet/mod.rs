//! Packets of rays, traced together as [`CoherentPacket`]s.
//!
//! Rays are coherent if their directions are in the same octant and have the same fastest axis: then they enter boxes
//! through the same planes and shear triangles along the same axis, and the lanes need no per-ray choices. A packet is
//! traced in as many parts as it has such classes of directions; rays that are alone, or whose `t_min` is negative, are
//! traced one by one.

mod coherent;
pub(crate) mod gather;
mod leaf;

pub(crate) use coherent::{CoherentPacket, PacketTree};
use leaf::Triangles;

use glam::Vec3;

use crate::bvh::BvhView;
use crate::geometry::bundle::Bundle;
use crate::geometry::shaft::Surroundings;
use crate::geometry::{Hit, HitPacket, RayPacket};
use crate::simd::{Isa, Lanes, Mask, Simd, Work, dispatch};
use crate::traverse::single;

/// `N` rays at a time.
pub struct Width<const N: usize>;

/// The widths that packets come in: 4, 8, 16 and 32.
pub trait PacketWidth<const N: usize>: TracePacket<N> {}

impl<const N: usize> PacketWidth<N> for Width<N> where Self: TracePacket<N> {}

/// Runs work on packets of a width.
pub trait TracePacket<const N: usize> {
    /// Runs `work` with the instructions of `isa`, as [`dispatch`] does, and with lanes for `N` rays.
    fn run<W: PacketWork<N>>(isa: Isa, work: W) -> W::Output;
}

/// A kernel for packets.
#[allow(private_bounds, reason = "only this crate has kernels")]
pub trait PacketWork<const N: usize> {
    /// The result.
    type Output;

    /// As [`Work::run`]: it must be `#[inline(always)]`.
    fn run<S: Simd, L: Lanes<N>>(self) -> Self::Output;
}

macro_rules! width {
    ($width:literal, $lanes:ident) => {
        impl TracePacket<$width> for Width<$width> {
            #[inline(always)]
            fn run<W: PacketWork<$width>>(isa: Isa, work: W) -> W::Output {
                struct InLanes<W>(W);
                impl<W: PacketWork<$width>> Work for InLanes<W> {
                    type Output = W::Output;
                    #[inline(always)]
                    fn run<S: Simd>(self) -> W::Output {
                        self.0.run::<S, S::$lanes>()
                    }
                }
                dispatch(isa, InLanes(work))
            }
        }
    };
}

width!(4, F4);
width!(8, F8);
width!(16, F16);
width!(32, F32);

/// A tree, the rays of a packet, and where their hits are written. Gives the active rays that hit something; with `ANY`
/// no hits are written.
pub(super) struct Trace<'a, const ANY: bool, const N: usize> {
    pub(super) tree: &'a BvhView<'a>,
    pub(super) rays: &'a RayPacket<N>,
    pub(super) hits: &'a mut HitPacket<N>,
}

impl<const ANY: bool, const N: usize> PacketWork<N> for Trace<'_, ANY, N> {
    type Output = u32;

    #[inline(always)]
    fn run<S: Simd, L: Lanes<N>>(self) -> u32 {
        trace::<ANY, N, S, L>(self.tree, self.rays, self.hits)
    }
}

/// Gives a bit mask of the active rays that hit something, and writes their nearest hits; with `ANY` it writes nothing.
#[inline(always)]
fn trace<const ANY: bool, const N: usize, S: Simd, L: Lanes<N>>(
    tree: &BvhView,
    packet: &RayPacket<N>,
    hits: &mut HitPacket<N>,
) -> u32 {
    let mut best = HitPacket { t: packet.t_max, ..HitPacket::MISS };
    let found = precede::<ANY, N, S, L>(tree, packet, &mut best);
    if !ANY {
        let (active, found) = (L::Mask::from_bits(packet.active), L::Mask::from_bits(found));
        hits.t = update::<N, L>(active, found, &best.t, Hit::MISS.t, &hits.t);
        hits.u = update::<N, L>(active, found, &best.u, Hit::MISS.u, &hits.u);
        hits.v = update::<N, L>(active, found, &best.v, Hit::MISS.v, &hits.v);
        let (prim_id, none) = (bytemuck::cast_ref(&best.prim_id), f32::from_bits(Hit::NO_PRIM));
        hits.prim_id = bytemuck::cast(update::<N, L>(active, found, prim_id, none, bytemuck::cast_ref(&hits.prim_id)));
    }
    found
}

/// Gives a bit mask of the active rays that have hits which precede the `best` ones, and replaces these; with `ANY` it
/// replaces none. The packet's `t_max` are those of the best hits.
#[inline(always)]
pub(crate) fn precede<const ANY: bool, const N: usize, S: Simd, L: Lanes<N>>(
    tree: &BvhView,
    packet: &RayPacket<N>,
    best: &mut HitPacket<N>,
) -> u32 {
    let surroundings = Surroundings { bounds: tree.bounds(), pad: Vec3::ZERO };
    let bundle = Bundle::<L>::new(packet, &surroundings.bounds);
    let (mut waiting, mut found) = (bundle.live, 0);
    while waiting != 0 {
        let (class, rays) = bundle.take_part(&mut waiting, u32::MAX);
        if rays & rays.wrapping_sub(1) == 0 {
            let lane = rays.trailing_zeros() as usize % N;
            found |= u32::from(precede_alone::<ANY, N, S>(tree, packet, lane, best)) << lane;
        } else {
            let lines = bundle.lines(&class);
            let coherent = CoherentPacket::new(&bundle, class, &lines, rays, &packet.t_max, &surroundings);
            found |= coherent.walk::<ANY, S, _>(&mut Triangles::<ANY, N, L>::new(tree, best, lines), rays);
        }
    }
    found
}

/// The same for the ray of one lane.
#[inline(always)]
fn precede_alone<const ANY: bool, const N: usize, S: Simd>(
    tree: &BvhView,
    packet: &RayPacket<N>,
    lane: usize,
    best: &mut HitPacket<N>,
) -> bool {
    let (ray, before) = (packet.ray(lane), best.hit(lane));
    if ANY {
        return single::occluded::<S>(tree, &ray);
    }
    let hit = single::closest::<S>(tree, &ray, before);
    best.set(lane, hit);
    hit.precedes(&before)
}

/// What was `found`, and `miss` in the other active lanes; those that are not stay as they were.
#[inline(always)]
fn update<const N: usize, L: Lanes<N>>(
    active: L::Mask,
    found: L::Mask,
    best: &[f32; N],
    miss: f32,
    before: &[f32; N],
) -> [f32; N] {
    L::select(active, L::select(found, L::load(best), L::splat(miss)), L::load(before)).store()
}
