//! Tracing rays through a tree: the methods of [`BvhView`], and the scalar [`mod@reference`] that they equal bit for
//! bit.
//!
//! | rays | closest hit | any hit |
//! | --- | --- | --- |
//! | one | [`BvhView::intersect`] | [`BvhView::occluded`] |
//! | 4 to 32 that run alike | [`BvhView::intersect_packet`] | [`BvhView::occluded_packet`] |
//! | a slice | [`BvhView::intersect_many`] | [`BvhView::occluded_many`] |
//! | a slice, of one origin | [`BvhView::intersect_gather`] | [`BvhView::occluded_gather`] |
//! | one, with a filter | [`BvhView::intersect_filtered`] | [`BvhView::occluded_filtered`] |
//! | a slice, with a filter | [`BvhView::intersect_many_filtered`] | [`BvhView::occluded_many_filtered`] |
//! | one, through one-sided triangles | [`BvhView::intersect_facing`] | [`BvhView::occluded_facing`] |
//!
//! | question | method |
//! | --- | --- |
//! | all hits of a ray, in any order | [`BvhView::for_each_hit`] |
//! | all hits of a ray, nearest first | [`BvhView::hits`] |
//! | the nearest few, into a slice | [`BvhView::nearest_hits`] |
//! | the `n`-th | [`BvhView::nth_hit`] |
//! | how many | [`BvhView::count_hits`] |
//! | the closest point of the surface | [`BvhView::closest_point`] |
//! | the triangles that overlap a box | [`BvhView::for_each_overlap`] |
//!
//! Nothing here allocates or panics.

mod collector;
mod leaf_test;
pub(crate) mod node_test;
pub(crate) mod packet;
mod query;
pub mod reference;
pub(crate) mod single;
mod stack;
pub(crate) mod stream;
#[cfg(test)]
pub(crate) mod tests;

use collector::Collector;
use packet::TracePacket;
pub use packet::{PacketWidth, Width};
pub use query::{Facing, Hits, Verdict, Visits};
pub(crate) use stack::TraversalStack;
use stream::leaf_queues;

use core::ops::ControlFlow;

use crate::bvh::BvhView;
use crate::geometry::{Hit, HitPacket, Ray, RayPacket};
use crate::simd::{Level, Simd, Work, dispatch};

impl BvhView<'_> {
    /// The nearest hit of `ray`; among equally near ones that of the lowest `prim_id`.
    pub fn intersect(&self, ray: &Ray) -> Option<Hit> {
        match self.isa().level() {
            Level::Scalar => reference::intersect(self, ray),
            _ => dispatch(self.isa(), One::<false> { tree: self, ray }),
        }
    }

    /// Whether `ray` hits anything: `intersect(ray).is_some()`, but faster.
    pub fn occluded(&self, ray: &Ray) -> bool {
        match self.isa().level() {
            Level::Scalar => reference::occluded(self, ray),
            _ => dispatch(self.isa(), One::<true> { tree: self, ray }).is_some(),
        }
    }

    /// The nearest hit of each active ray of a packet, [`Hit::MISS`] for those that hit nothing. Lanes of inactive rays
    /// are left unchanged.
    ///
    /// Faster for coherent rays, such as camera rays; rays of other packets are traced one by one.
    pub fn intersect_packet<const N: usize>(&self, rays: &RayPacket<N>, hits: &mut HitPacket<N>)
    where
        Width<N>: PacketWidth<N>,
    {
        if self.isa().level() == Level::Scalar {
            for lane in rays.active_lanes() {
                hits.set(lane, reference::intersect(self, &rays.ray(lane)).unwrap_or(Hit::MISS));
            }
        } else {
            Width::<N>::run(self.isa(), packet::Trace::<false, N> { tree: self, rays, hits });
        }
    }

    /// A bit mask of the active rays of a packet that hit anything; bits of inactive lanes are 0.
    pub fn occluded_packet<const N: usize>(&self, rays: &RayPacket<N>) -> u32
    where
        Width<N>: PacketWidth<N>,
    {
        if self.isa().level() == Level::Scalar {
            let occluded = |&lane: &usize| reference::occluded(self, &rays.ray(lane));
            rays.active_lanes().filter(occluded).fold(0, |bits, lane| bits | 1 << lane)
        } else {
            let mut hits = HitPacket::MISS;
            Width::<N>::run(self.isa(), packet::Trace::<true, N> { tree: self, rays, hits: &mut hits })
        }
    }

    /// Writes the nearest hit of each ray, or [`Hit::MISS`]. Elements beyond the end of the shorter slice are left
    /// unchanged.
    ///
    /// The fastest way for many incoherent rays: 64 of them are traced at the same time, as a stream.
    pub fn intersect_many(&self, rays: &[Ray], hits: &mut [Hit]) {
        let rays = &rays[..rays.len().min(hits.len())];
        if self.isa().level() == Level::Scalar {
            for (ray, hit) in rays.iter().zip(hits) {
                *hit = reference::intersect(self, ray).unwrap_or(Hit::MISS);
            }
        } else {
            trace_many::<false>(self, rays, write_hits(hits));
        }
    }

    /// Writes for each ray whether it hits anything. Elements beyond the end of the shorter slice are left unchanged.
    pub fn occluded_many(&self, rays: &[Ray], occluded: &mut [bool]) {
        let rays = &rays[..rays.len().min(occluded.len())];
        if self.isa().level() == Level::Scalar {
            for (ray, occluded) in rays.iter().zip(occluded) {
                *occluded = reference::occluded(self, ray);
            }
        } else {
            trace_many::<true>(self, rays, write_occluded(occluded));
        }
    }

    /// Shows `collector` the hits of `ray`.
    fn collect<C: Collector>(&self, ray: &Ray, collector: &mut C) {
        // The collector itself records whether it was ended early.
        let _ = match self.isa().level() {
            Level::Scalar => reference::walk(self, ray, collector),
            _ => dispatch(self.isa(), Walk { tree: self, ray, collector }),
        };
    }
}

struct Walk<'a, C> {
    tree: &'a BvhView<'a>,
    ray: &'a Ray,
    collector: &'a mut C,
}

impl<C: Collector> Work for Walk<'_, C> {
    type Output = ControlFlow<()>;
    #[inline(always)]
    fn run<S: Simd>(self) -> ControlFlow<()> {
        let mut stack = TraversalStack::new();
        single::walk::<S, C>(self.tree, self.ray, &mut stack, self.collector)
    }
}

impl BvhView<'_> {
    /// Like [`intersect_many`](Self::intersect_many), but faster for rays of one origin with many directions, such as a
    /// hemisphere's strata: 256 at a time are sorted by direction and traced in packets. In a tree of one node they are
    /// the same.
    pub fn intersect_gather(&self, rays: &[Ray], hits: &mut [Hit]) {
        let rays = &rays[..rays.len().min(hits.len())];
        if self.isa().level() == Level::Scalar {
            return self.intersect_many(rays, hits);
        }
        trace_gather::<false>(self, rays, write_hits(hits));
    }

    /// Like [`occluded_many`](Self::occluded_many), but faster for rays of one origin, likewise.
    pub fn occluded_gather(&self, rays: &[Ray], occluded: &mut [bool]) {
        let rays = &rays[..rays.len().min(occluded.len())];
        if self.isa().level() == Level::Scalar {
            return self.occluded_many(rays, occluded);
        }
        trace_gather::<true>(self, rays, write_occluded(occluded));
    }
}

/// Writes the hit of the ray of an index.
fn write_hits(hits: &mut [Hit]) -> impl FnMut(usize, Hit) {
    |ray, hit| {
        if let Some(place) = hits.get_mut(ray) {
            *place = hit;
        }
    }
}

/// Writes whether the ray of an index has a hit.
fn write_occluded(occluded: &mut [bool]) -> impl FnMut(usize, Hit) {
    |ray, hit| {
        if let Some(place) = occluded.get_mut(ray) {
            *place = hit.is_hit();
        }
    }
}

/// Rays of one origin, by the method that suits the tree.
fn trace_gather<const ANY: bool>(tree: &BvhView, rays: &[Ray], write: impl FnMut(usize, Hit)) {
    // Also false where the stack has no room.
    if leaf_queues::suit(tree) && !cfg!(target_os = "none") {
        dispatch(tree.isa(), LeafQueues::<ANY, _> { tree, rays, write });
    } else {
        dispatch(tree.isa(), Packets::<ANY, _> { tree, rays, write });
    }
}

/// Rays of any kind, by the method that suits their number and the tree.
fn trace_many<const ANY: bool>(tree: &BvhView, rays: &[Ray], write: impl FnMut(usize, Hit)) {
    if cfg!(target_os = "none") || rays.len() < stream::MIN_STREAM_RAYS {
        dispatch(tree.isa(), Few::<ANY, _> { tree, rays, write });
    } else if leaf_queues::suit(tree) {
        dispatch(tree.isa(), LeafQueues::<ANY, _> { tree, rays, write });
    } else {
        dispatch(tree.isa(), Stream::<ANY, _> { tree, rays, write });
    }
}

struct One<'a, const ANY: bool> {
    tree: &'a BvhView<'a>,
    ray: &'a Ray,
}

impl<const ANY: bool> Work for One<'_, ANY> {
    type Output = Option<Hit>;
    #[inline(always)]
    fn run<S: Simd>(self) -> Option<Hit> {
        single::trace::<ANY, S>(self.tree, self.ray)
    }
}

/// The methods of tracing a slice of rays, each compiled apart, so that its stack frame is its own.
macro_rules! slices {
    ($($name:ident: $($trace:ident)::+),*) => {$(
        struct $name<'a, const ANY: bool, F> {
            tree: &'a BvhView<'a>,
            rays: &'a [Ray],
            write: F,
        }

        impl<const ANY: bool, F: FnMut(usize, Hit)> Work for $name<'_, ANY, F> {
            type Output = ();
            #[inline(always)]
            fn run<S: Simd>(self) {
                $($trace)::+::<ANY, S>(self.tree, self.rays, self.write);
            }
        }
    )*};
}

slices!(Few: one_by_one, LeafQueues: leaf_queues::trace, Packets: packet::gather::trace, Stream: stream::trace);

#[inline(always)]
fn one_by_one<const ANY: bool, S: Simd>(tree: &BvhView, rays: &[Ray], mut write: impl FnMut(usize, Hit)) {
    for (index, ray) in rays.iter().enumerate() {
        write(index, single::trace::<ANY, S>(tree, ray).unwrap_or(Hit::MISS));
    }
}
