//! Packets of rays through scenes, and gathers, which are sorted into packets.
//!
//! A packet goes through the scene's own tree as through one of triangles, in parts of coherent rays. At an item all
//! rays that meet its box are transformed together, and are a packet in the tree of the item, or in the nested scene,
//! with what is coherent there. So an item costs a transform, a setup and the test of the nodes that they meet for the
//! packet, not for each ray. Points, curves, custom shapes and meshes between two keys are tested ray by ray, and so
//! are rays that are few.

mod entering;
mod gather;
mod items;
mod parts;
mod visit;

use entering::Entering;
use gather::write_all;
use visit::{EnterScene, PacketVisit, Traced};

use super::transform::Placement;
use super::{SceneHit, SceneHitPacket, SceneRay, SceneRayPacket, SceneView, reference};
use crate::geometry::HitPacket;
use crate::simd::Level;
use crate::traverse::packet::TracePacket;
use crate::traverse::{PacketWidth, Width};

/// Wider packets are traced in halves: their stack frames would be too large.
const WIDEST: usize = 16;

impl SceneView<'_> {
    /// The nearest hit of each active ray of a packet, [`SceneHit::MISS`] for those that hit nothing. Lanes of inactive
    /// rays are left unchanged.
    ///
    /// The fastest way for coherent rays, such as camera rays: best sixteen at a time, and through nested scenes too. A
    /// packet of more than eight is traced ray by ray below the first nested scene, and rays whose times differ in a
    /// scene with motion, or that do not run alike, one by one.
    pub fn intersect_packet<const N: usize>(&self, rays: &SceneRayPacket<N>, hits: &mut SceneHitPacket<N>)
    where
        Width<N>: PacketWidth<N>,
    {
        if self.isa().level() == Level::Scalar {
            for lane in rays.rays.active_lanes() {
                hits.set(lane, reference::intersect(self, &rays.ray(lane)).unwrap_or(SceneHit::MISS));
            }
            return;
        }
        if N > WIDEST {
            for first in (0..N).step_by(WIDEST) {
                let mut half = hits.part(first);
                self.intersect_packet::<WIDEST>(&rays.part(first), &mut half);
                (first..N).zip(0..WIDEST).for_each(|(lane, from)| hits.set(lane, half.hit(from)));
            }
            return;
        }
        let mut best = none_before(rays);
        let found = trace::<false, N>(self, rays, &mut best);
        for lane in rays.rays.active_lanes() {
            hits.set(lane, if found >> lane & 1 != 0 { best.hit(lane) } else { SceneHit::MISS });
        }
    }

    /// A bit mask of the active rays of a packet that hit anything; bits of inactive lanes are 0.
    ///
    /// For rays towards a light through many instances [`occluded_many`](Self::occluded_many) is faster: among 10,000 it
    /// is about 1.6 times as fast as single rays, packets of sixteen 1.5 times.
    pub fn occluded_packet<const N: usize>(&self, rays: &SceneRayPacket<N>) -> u32
    where
        Width<N>: PacketWidth<N>,
    {
        if self.isa().level() == Level::Scalar {
            let occluded = |&lane: &usize| reference::intersect(self, &rays.ray(lane)).is_some();
            return rays.rays.active_lanes().filter(occluded).fold(0, |bits, lane| bits | 1 << lane);
        }
        if N > WIDEST {
            let half = |first: usize| self.occluded_packet::<WIDEST>(&rays.part(first)) << first;
            return (0..N).step_by(WIDEST).fold(0, |bits, first| bits | half(first));
        }
        trace::<true, N>(self, rays, &mut none_before(rays))
    }

    /// Like [`intersect_many`](Self::intersect_many), but faster for rays of one origin with many directions, such as a
    /// hemisphere's strata: 256 at a time are sorted by direction and traced in packets. If the scene has motion and
    /// the rays' times differ, they are the same.
    pub fn intersect_gather(&self, rays: &[SceneRay], hits: &mut [SceneHit]) {
        let rays = &rays[..rays.len().min(hits.len())];
        if !gather::suits::<false>(self, rays) {
            return self.intersect_many(rays, hits);
        }
        write_all::<false>(self, rays, |ray, hit| {
            if let Some(place) = hits.get_mut(ray) {
                *place = hit.unwrap_or(SceneHit::MISS);
            }
        });
    }

    /// Like [`occluded_many`](Self::occluded_many), but faster for rays of one origin, likewise. Without AVX-512 it is the
    /// same in scenes without nested ones.
    pub fn occluded_gather(&self, rays: &[SceneRay], occluded: &mut [bool]) {
        let rays = &rays[..rays.len().min(occluded.len())];
        if !gather::suits::<true>(self, rays) {
            return self.occluded_many(rays, occluded);
        }
        write_all::<true>(self, rays, |ray, hit| {
            if let Some(place) = occluded.get_mut(ray) {
                *place = hit.is_some();
            }
        });
    }
}

/// What any hit precedes.
fn none_before<const N: usize>(rays: &SceneRayPacket<N>) -> SceneHitPacket<N> {
    SceneHitPacket { hits: HitPacket { t: rays.rays.t_max, ..HitPacket::MISS }, ..SceneHitPacket::MISS }
}

/// A bit mask of the active rays that hit something. Their nearest hits replace those before; with `ANY` none does.
fn trace<const ANY: bool, const N: usize>(
    scene: &SceneView,
    SceneRayPacket { rays, time, mask }: &SceneRayPacket<N>,
    best: &mut SceneHitPacket<N>,
) -> u32
where
    Width<N>: TracePacket<N>,
{
    let (isa, first_path, depth) = (scene.isa(), 0, 0);
    let entering = Entering { placement: &Placement::AsItIs, rays, active: rays.active, time: 0.0, best: &mut *best };
    let enter = EnterScene::<ANY, N> { scene, isa, entering, time, mask, first_path, depth };
    let Traced { found, left } = Width::<N>::run(isa, enter);
    let mut visit = PacketVisit::<ANY, N> { scene, isa, rays, time, mask, first_path, depth, best };
    found | visit.one_by_one(left, None)
}
