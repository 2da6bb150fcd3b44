//! The ways to trace that trees and scenes have in common.

use std::fmt::Debug;

use bytemuck::Pod;
use halfdome_kernel::traverse::{PacketWidth, Width};
use halfdome_kernel::{
    BvhView, Hit, HitPacket, Isa, Ray, RayPacket, SceneHit, SceneHitPacket, SceneRay, SceneRayPacket, SceneView,
};

/// What rays are traced through.
pub trait Ways {
    /// A ray.
    type Ray: Copy + Debug;
    /// A hit.
    type Hit: Pod + Debug;
    /// What batches and packets say of a ray that hits nothing.
    const MISS: Self::Hit;
    /// What nothing hits: stands where nothing is to be written.
    const UNTOUCHED: Self::Hit;

    /// The instruction set in use.
    fn isa(&self) -> Isa;
    /// The nearest hit of a ray.
    fn one(&self, ray: &Self::Ray) -> Option<Self::Hit>;
    /// Whether a ray hits anything.
    fn one_occluded(&self, ray: &Self::Ray) -> bool;
    /// A batch.
    fn many(&self, rays: &[Self::Ray], hits: &mut [Self::Hit], occluded: &mut [bool]);
    /// A gather.
    fn gather(&self, rays: &[Self::Ray], hits: &mut [Self::Hit], occluded: &mut [bool]);
    /// A packet of up to `N` rays, of which those in `mask` are active. `hits` is what it writes hits over; the result
    /// says which lanes hit anything.
    fn packet<const N: usize>(&self, rays: &[Self::Ray], mask: u32, hits: &mut [Self::Hit; N]) -> u32
    where
        Width<N>: PacketWidth<N>;
}

/// Whether there is a hit in both or in neither, with the same bits: zeros of different signs differ.
pub fn same<H: Pod>(a: Option<H>, b: Option<H>) -> bool {
    match (a, b) {
        (Some(a), Some(b)) => bytemuck::bytes_of(&a) == bytemuck::bytes_of(&b),
        (a, b) => a.is_none() && b.is_none(),
    }
}

/// A view's methods, which have the same names for trees and for scenes.
macro_rules! ways {
    ($view:ident, $ray:ident, $hit:ident, $packet:ident, $hits:ident, $untouched:expr, |$rays:ident| $active:expr) => {
        impl Ways for $view<'_> {
            type Ray = $ray;
            type Hit = $hit;
            const MISS: $hit = $hit::MISS;
            const UNTOUCHED: $hit = $untouched;

            fn isa(&self) -> Isa {
                self.isa()
            }

            fn one(&self, ray: &$ray) -> Option<$hit> {
                self.intersect(ray)
            }

            fn one_occluded(&self, ray: &$ray) -> bool {
                self.occluded(ray)
            }

            fn many(&self, rays: &[$ray], hits: &mut [$hit], occluded: &mut [bool]) {
                self.intersect_many(rays, hits);
                self.occluded_many(rays, occluded);
            }

            fn gather(&self, rays: &[$ray], hits: &mut [$hit], occluded: &mut [bool]) {
                self.intersect_gather(rays, hits);
                self.occluded_gather(rays, occluded);
            }

            fn packet<const N: usize>(&self, rays: &[$ray], mask: u32, hits: &mut [$hit; N]) -> u32
            where
                Width<N>: PacketWidth<N>,
            {
                let mut $rays = $packet::<N>::from_rays(rays);
                $active &= mask;
                let mut found = $hits::MISS;
                (0..N).for_each(|lane| found.set(lane, hits[lane]));
                self.intersect_packet(&$rays, &mut found);
                (0..N).for_each(|lane| hits[lane] = found.hit(lane));
                self.occluded_packet(&$rays)
            }
        }
    };
}

const UNTOUCHED: Hit = Hit { t: -7.25, u: 3.0, v: -1.0, prim_id: 4321 };

ways!(BvhView, Ray, Hit, RayPacket, HitPacket, UNTOUCHED, |packet| packet.active);
ways!(
    SceneView,
    SceneRay,
    SceneHit,
    SceneRayPacket,
    SceneHitPacket,
    SceneHit { hit: UNTOUCHED, item: 17, depth: 3, path: 1 << 40 },
    |packet| packet.rays.active
);
