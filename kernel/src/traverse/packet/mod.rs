//! Packets of rays, traced together as [`CoherentPacket`]s.
//!
//! Rays are coherent if their directions are in the same octant and have the same fastest axis: then they enter boxes
//! through the same planes and shear triangles along the same axis, and the lanes need no per-ray choices. A packet is
//! traced in as many parts as it has such classes of directions; rays that are alone, or whose `t_min` is negative, are
//! traced one by one.

mod coherent;
pub(super) mod gather;
mod leaf;

use coherent::CoherentPacket;

use crate::bvh::BvhView;
use crate::geometry::bundle::Bundle;
use crate::geometry::{Hit, HitPacket, RayPacket};
use crate::simd::{Lanes, Mask, Simd, Work, dispatch};
use crate::traverse::single;

/// `N` rays at a time.
pub struct Width<const N: usize>;

/// The widths that packets come in: 4, 8, 16 and 32.
pub trait PacketWidth<const N: usize>: TracePacket<N> {}

impl<const N: usize> PacketWidth<N> for Width<N> where Self: TracePacket<N> {}

/// Traces packets of a width.
pub trait TracePacket<const N: usize> {
    /// A bit mask of the active rays that hit something; writes their nearest hits, or with `ANY` nothing.
    fn trace<const ANY: bool>(tree: &BvhView, rays: &RayPacket<N>, hits: &mut HitPacket<N>) -> u32;
}

macro_rules! width {
    ($width:literal, $lanes:ident) => {
        impl TracePacket<$width> for Width<$width> {
            fn trace<const ANY: bool>(tree: &BvhView, rays: &RayPacket<$width>, hits: &mut HitPacket<$width>) -> u32 {
                struct Trace<'a, const ANY: bool>(&'a BvhView<'a>, &'a RayPacket<$width>, &'a mut HitPacket<$width>);
                impl<const ANY: bool> Work for Trace<'_, ANY> {
                    type Output = u32;
                    #[inline(always)]
                    fn run<S: Simd>(self) -> u32 {
                        trace::<ANY, $width, S, S::$lanes>(self.0, self.1, self.2)
                    }
                }
                dispatch(tree.isa(), Trace::<ANY>(tree, rays, hits))
            }
        }
    };
}

width!(4, F4);
width!(8, F8);
width!(16, F16);
width!(32, F32);

/// Gives a bit mask of the active rays that hit something, and writes their nearest hits; with `ANY` it writes nothing.
#[inline(always)]
pub(super) fn trace<const ANY: bool, const N: usize, S: Simd, L: Lanes<N>>(
    tree: &BvhView,
    packet: &RayPacket<N>,
    hits: &mut HitPacket<N>,
) -> u32 {
    let bundle = Bundle::<L>::new(packet, &tree.bounds());
    let mut best = HitPacket { t: packet.t_max, ..HitPacket::MISS };
    let ahead = L::splat(0.0).le(bundle.t_min).bits();
    let (mut waiting, mut found) = (bundle.live, 0);
    while waiting != 0 {
        let (class, mut rays) = bundle.class(waiting);
        let first = rays & rays.wrapping_neg();
        rays = if first & ahead == 0 { first } else { rays & ahead };
        waiting &= !rays;
        if rays & rays.wrapping_sub(1) == 0 {
            let lane = rays.trailing_zeros() as usize % N;
            if let Some(hit) = single::trace::<ANY, S>(tree, &packet.ray(lane)) {
                best.set(lane, hit);
                found |= rays;
            }
        } else {
            let coherent = CoherentPacket::<N, L>::new(&bundle, class, rays, &packet.t_max, tree);
            found |= coherent.trace::<ANY, S>(tree, rays, &mut best);
        }
    }
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
