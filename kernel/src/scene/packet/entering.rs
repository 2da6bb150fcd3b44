//! Rays of a packet that enter an item: in lanes into its space, and if that is a mesh, through its tree.

use super::super::search::Closest;
use super::super::transform::Placement;
use super::super::{SceneHit, SceneHitPacket};
use crate::bvh::BvhView;
use crate::geometry::{HitPacket, RayPacket};
use crate::simd::{Lanes, Simd, lanes_of};
use crate::traverse::packet::{PacketWork, precede};

/// Rays of a packet that enter an item.
pub(super) struct Entering<'a, 's, const N: usize> {
    pub placement: &'a Placement<'a>,
    /// In the space of the scene that has the item.
    pub rays: &'s RayPacket<N>,
    /// Those that enter.
    pub active: u32,
    /// Their time, if the item moves.
    pub time: f32,
    /// In a search for any hit only the rays' `t_max`.
    pub best: &'s mut SceneHitPacket<N>,
}

impl<const N: usize> Entering<'_, '_, N> {
    /// The rays in the item's space; `None` if the item is hidden.
    #[inline(always)]
    pub(super) fn local(&self) -> Option<RayPacket<N>> {
        let RayPacket { t_min, t_max, .. } = *self.rays;
        let nowhere = [[0.0; N]; 3];
        let mut local = RayPacket { origin: nowhere, direction: nowhere, t_min, t_max, active: self.active };
        self.placement.packet_to_local(self.rays, self.time, &mut local).then_some(local)
    }
}

/// Rays that enter an item of triangles. With `ANY` a search for any hit.
pub(super) struct EnterMesh<'a, 's, const ANY: bool, const N: usize> {
    pub tree: &'a BvhView<'a>,
    pub entering: Entering<'a, 's, N>,
    /// What all hits have in common.
    pub common: SceneHit,
}

impl<const ANY: bool, const N: usize> PacketWork<N> for EnterMesh<'_, '_, ANY, N> {
    /// The rays that found a better hit.
    type Output = u32;

    #[inline(always)]
    fn run<S: Simd, L: Lanes<N>>(self) -> u32 {
        let Self { tree, entering, common } = self;
        let Some(mut local) = entering.local() else { return 0 };
        local.t_max = entering.best.hits.t;
        let mut hits = to_precede(entering.best, &common);
        let found = precede::<ANY, N, S, L>(tree, &local, &mut hits);
        if !ANY {
            for lane in lanes_of(found) {
                entering.best.set(lane % N, SceneHit { hit: hits.hit(lane % N), ..common });
            }
        }
        found
    }
}

/// What hits of one item have to precede in each lane.
#[inline(always)]
fn to_precede<const N: usize>(best: &SceneHitPacket<N>, common: &SceneHit) -> HitPacket<N> {
    let mut before = HitPacket { t: best.hits.t, ..HitPacket::MISS };
    for lane in 0..N {
        before.prim_id[lane] = Closest { best: best.hit(lane) }.to_precede(common).prim_id;
    }
    before
}
