//! Gathers through scenes: rays from one point, or nearly, sorted by direction into packets.

use super::super::{SceneHit, SceneRay, SceneRayPacket, SceneView};
use crate::geometry::Ray;
use crate::simd::{Lanes, Level, Portable, Simd};
use crate::traverse::Width;
use crate::traverse::packet::TracePacket;
use crate::traverse::packet::gather::{Gather, in_packets};

/// Whether packets are faster than [`SceneView::intersect_many`], or with `ANY` than [`SceneView::occluded_many`]: not
/// for rays whose times part them, nor in a search for any hit where sixteen lanes are two registers and there is a
/// stream.
pub(super) fn suits<const ANY: bool>(scene: &SceneView, rays: &[SceneRay]) -> bool {
    let alike = || rays.windows(2).all(|pair| pair[0].time == pair[1].time);
    let is_fast = match scene.isa().level() {
        Level::Scalar => false,
        Level::Avx512 => true,
        _ => !ANY || scene.levels() > 0,
    };
    is_fast && (scene.tree().keys() == 1 || alike())
}

/// Gives `write` the index of each ray and its nearest hit, or with `ANY` one that stands for any, in any order.
pub(super) fn write_all<const ANY: bool>(
    scene: &SceneView,
    rays: &[SceneRay],
    write: impl FnMut(usize, Option<SceneHit>),
) {
    // Sorting needs no lanes; packets choose their own.
    in_packets::<Portable, _>(&mut Through::<ANY, _> { scene, write }, rays);
}

/// A scene, and who takes the hits.
struct Through<'a, const ANY: bool, F> {
    scene: &'a SceneView<'a>,
    write: F,
}

impl<const ANY: bool, F: FnMut(usize, Option<SceneHit>)> Gather for Through<'_, ANY, F> {
    type Ray = SceneRay;

    #[inline(always)]
    fn ray(ray: &SceneRay) -> &Ray {
        &ray.ray
    }

    #[inline(always)]
    fn trace<const N: usize, S: Simd, L: Lanes<N>>(&mut self, rays: &[SceneRay], indices: &[usize])
    where
        Width<N>: TracePacket<N>,
    {
        let packet = SceneRayPacket::<N>::from_rays(rays);
        let mut hits = super::none_before(&packet);
        let found = super::trace::<ANY, N>(self.scene, &packet, &mut hits);
        for (lane, &index) in indices.iter().enumerate().take(N) {
            (self.write)(index, (found >> lane & 1 != 0).then(|| hits.hit(lane)));
        }
    }
}
