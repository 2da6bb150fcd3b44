//! A packet in a scene, and the rays of it that go alone.

use core::ops::ControlFlow;

use super::super::object::Target;
use super::super::search::{Any, Closest, Search};
use super::super::walk::{self, MeetItem, Visit};
use super::super::{SceneHitPacket, SceneRay, SceneView};
use super::entering::Entering;
use crate::geometry::RayPacket;
use crate::simd::{Isa, dispatch, lanes_of};
use crate::traverse::TraversalStack;

/// Rays that enter a scene. With `ANY` a search for any hit.
pub(super) struct EnterScene<'a, 's, const ANY: bool, const N: usize> {
    pub scene: &'a SceneView<'a>,
    pub isa: Isa,
    pub entering: Entering<'a, 's, N>,
    pub time: &'s [f32; N],
    pub mask: &'s [u32; N],
    /// The first of the paths through the scene, in the outermost.
    pub first_path: u64,
    pub depth: u32,
}

/// What has become of the rays of a packet.
#[derive(Clone, Copy)]
pub(super) struct Traced {
    /// Those that found a better hit.
    pub found: u32,
    /// Those that are alone and still have to be traced: where this packet's stack frame is gone.
    pub left: u32,
}

/// A packet in a scene; fields as in [`EnterScene`].
pub(super) struct PacketVisit<'a, 's, const ANY: bool, const N: usize> {
    pub scene: &'a SceneView<'a>,
    pub isa: Isa,
    /// In the scene's space, with the `t_max` of the outermost rays: a round primitive's hit may depend on it.
    pub rays: &'s RayPacket<N>,
    pub time: &'s [f32; N],
    pub mask: &'s [u32; N],
    pub first_path: u64,
    pub depth: u32,
    pub best: &'s mut SceneHitPacket<N>,
}

impl<const ANY: bool, const N: usize> PacketVisit<'_, '_, ANY, N> {
    /// Takes rays through the scene, or through the entry with the box of this index, like single rays. Gives those that
    /// found a better hit.
    #[inline(always)]
    pub(super) fn one_by_one(&mut self, rays: u32, index: Option<u32>) -> u32 {
        lanes_of(rays).fold(0, |found, lane| found | u32::from(self.alone(lane % N, index)) << lane)
    }

    /// Takes the ray of a lane through the scene, or through the entry with the box of this index, like a single ray.
    /// Whether it found a better hit. Not inlined, so that its stack frame exists only while it runs.
    #[inline(never)]
    fn alone(&mut self, lane: usize, index: Option<u32>) -> bool {
        if ANY {
            let mut search = Any { t_max: self.best.hits.t[lane], found: false };
            self.search(lane, index, &mut search);
            return search.found;
        }
        let before = self.best.hit(lane);
        let mut search = Closest { best: before };
        self.search(lane, index, &mut search);
        self.best.set(lane, search.best);
        search.best.precedes(&before)
    }

    #[inline(always)]
    fn search<Q: Search>(&self, lane: usize, index: Option<u32>, search: &mut Q) {
        let Self { scene, isa, first_path, depth, .. } = *self;
        let ray = SceneRay { ray: self.rays.ray(lane), time: self.time[lane], mask: self.mask[lane] };
        let triangles = &mut TraversalStack::new();
        let visit = Visit { scene, isa, ray, first_path, depth, search, triangles };
        // The search itself records whether it was ended early.
        let _ = match index {
            None => walk::enter(visit),
            Some(index) => meet(visit, index),
        };
    }
}

/// Takes a ray through the entry with the box of this index. A nested scene is entered at once: on the way through
/// [`MeetItem`] there would be one stack frame more.
#[inline(always)]
fn meet<Q: Search>(mut visit: Visit<Q>, index: u32) -> ControlFlow<()> {
    if let Some((_, item)) = visit.scene.item_of(index)
        && let Target::Scene(inner) = item.object.target()
    {
        return match item.placement.to_local(&visit.ray.ray, visit.ray.time) {
            Some(ray) => walk::enter(visit.nested(&inner, item, ray)),
            None => ControlFlow::Continue(()),
        };
    }
    dispatch(visit.isa, MeetItem { visit, index });
    ControlFlow::Continue(())
}
