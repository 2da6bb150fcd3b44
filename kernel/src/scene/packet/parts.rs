//! The parts of a packet: rays that are coherent in the scene's space go through its tree together.

use glam::Vec3;

use super::super::SceneView;
use super::entering::Entering;
use super::items::Items;
use super::visit::{EnterScene, PacketVisit, Traced};
use crate::geometry::Aabb;
use crate::geometry::bundle::Bundle;
use crate::geometry::moment::Moment;
use crate::geometry::setup::NODE_ORIGIN_PAD;
use crate::geometry::shaft::Surroundings;
use crate::simd::{Lanes, Mask, Simd};
use crate::traverse::Width;
use crate::traverse::packet::{CoherentPacket, PacketWork, TracePacket};

impl<const ANY: bool, const N: usize> PacketWork<N> for EnterScene<'_, '_, ANY, N>
where
    Width<N>: TracePacket<N>,
{
    type Output = Traced;

    #[inline(always)]
    fn run<S: Simd, L: Lanes<N>>(self) -> Traced {
        let Self { scene, isa, entering, time, mask, first_path, depth } = self;
        let mut traced = Traced { found: 0, left: 0 };
        let Some(rays) = entering.local() else { return traced };
        let Entering { best, .. } = entering;
        let mut visit = PacketVisit::<ANY, N> { scene, isa, rays: &rays, time, mask, first_path, depth, best };

        let mut surroundings = Surroundings { bounds: scene.reach(), pad: Vec3::ZERO };
        let bundle = Bundle::<L>::new(&rays, &surroundings.bounds);
        let times = L::load(time);
        let mut waiting = bundle.live & times.eq(times).bits();
        while waiting != 0 {
            let first = waiting.trailing_zeros() as usize % N;
            let alike = if scene.tree().keys() > 1 { times.eq(L::splat(time[first])).bits() } else { u32::MAX };
            let (class, part) = bundle.take_part(&mut waiting, alike);
            if part & part.wrapping_sub(1) == 0 {
                traced.left |= part;
                continue;
            }
            let Some(moment) = Moment::new(time[first], scene.tree().keys()) else { continue };
            let (origins, _) = bundle.origins(part);
            surroundings.pad = widening(scene, &origins, surroundings.reach(&origins));
            let lines = bundle.lines(&class);
            let coherent = CoherentPacket::new(&bundle, class, &lines, part, &visit.best.hits.t, &surroundings);
            traced.found |= coherent.walk::<ANY, S, _>(&mut Items::new(&mut visit, time[first], moment), part);
        }
        traced
    }
}

/// How much boxes are widened for rays with these origins and this reach; for the pads see `walk.rs`.
#[inline(always)]
fn widening(scene: &SceneView, origins: &Aabb, reach: Vec3) -> Vec3 {
    scene.widening().of_ray(reach.max_element()) + origins.min.abs().max(origins.max.abs()) * NODE_ORIGIN_PAD
}
