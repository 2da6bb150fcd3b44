//! Tracing rays through a tree: the methods of [`BvhView`], and the scalar [`reference`] that they equal bit for bit.
//!
//! | rays | closest hit | any hit |
//! | --- | --- | --- |
//! | one | [`BvhView::intersect`] | [`BvhView::occluded`] |
//! | 4 or 8 that run alike | [`BvhView::intersect_packet`] | [`BvhView::occluded_packet`] |
//! | a slice | [`BvhView::intersect_many`] | [`BvhView::occluded_many`] |
//!
//! Nothing here allocates or panics.

mod packet;
pub mod reference;
mod single;
mod stack;
#[cfg(test)]
mod tests;

pub use packet::{PacketWidth, Width};

use crate::bvh::BvhView;
use crate::geometry::{Hit, HitPacket, Ray, RayPacket};

impl BvhView<'_> {
    /// The nearest hit of `ray`; among equally near ones that of the lowest `prim_id`.
    pub fn intersect(&self, ray: &Ray) -> Option<Hit> {
        single::trace::<false, wide::f32x8>(self, ray).found()
    }

    /// Whether `ray` hits anything: `intersect(ray).is_some()`, but quicker.
    pub fn occluded(&self, ray: &Ray) -> bool {
        single::trace::<true, wide::f32x8>(self, ray).is_hit()
    }

    /// The nearest hit of each active ray of a packet, [`Hit::MISS`] for those that hit nothing. Lanes of inactive rays
    /// are left as they are.
    ///
    /// Pays where rays run side by side, as camera rays do; those of other packets are traced one by one.
    pub fn intersect_packet<const N: usize>(&self, rays: &RayPacket<N>, hits: &mut HitPacket<N>)
    where
        Width<N>: PacketWidth<N>,
    {
        Width::<N>::trace::<false>(self, rays, hits);
    }

    /// A bit mask of the active rays of a packet that hit anything.
    pub fn occluded_packet<const N: usize>(&self, rays: &RayPacket<N>) -> u32
    where
        Width<N>: PacketWidth<N>,
    {
        let mut hits = HitPacket::MISS;
        Width::<N>::trace::<true>(self, rays, &mut hits);
        (0..N).filter(|&lane| hits.hit(lane).is_hit()).fold(0, |bits, lane| bits | 1 << lane)
    }

    /// Writes the nearest hit of each ray, or [`Hit::MISS`]. Of slices of unequal length the ends are left alone.
    pub fn intersect_many(&self, rays: &[Ray], hits: &mut [Hit]) {
        for (ray, hit) in rays.iter().zip(hits) {
            *hit = self.intersect(ray).unwrap_or(Hit::MISS);
        }
    }

    /// Writes for each ray whether it hits anything. Of slices of unequal length the ends are left alone.
    pub fn occluded_many(&self, rays: &[Ray], occluded: &mut [bool]) {
        for (ray, occluded) in rays.iter().zip(occluded) {
            *occluded = self.occluded(ray);
        }
    }
}
