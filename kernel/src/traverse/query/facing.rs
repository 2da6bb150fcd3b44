//! Searches that pass through triangles from one of their sides: back-face culling.
//!
//! The side is that of the edge functions' sum, whose sign is exact and decides the hit itself
//! ([`geometry`](crate::geometry)). So it is exact and equal on every target, however the ray grazes the triangle.

use core::ops::ControlFlow;

use crate::bvh::BvhView;
use crate::geometry::{Hit, Ray};
use crate::traverse::collector::Collector;

/// The sides of triangles from which they can be hit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Facing {
    /// Both.
    #[default]
    Both,
    /// The side from which the corners run counter-clockwise.
    Front,
    /// The other side.
    Back,
}

impl BvhView<'_> {
    /// The nearest hit of `ray` with a triangle that shows it one of these sides; among equally near ones that of the
    /// lowest `prim_id`.
    pub fn intersect_facing(&self, ray: &Ray, facing: Facing) -> Option<Hit> {
        let mut nearest = OneSided { best: Hit::none_before(ray.t_max), facing, any: false };
        self.collect(ray, &mut nearest);
        nearest.best.found()
    }

    /// Whether `ray` hits any triangle that shows it one of these sides.
    pub fn occluded_facing(&self, ray: &Ray, facing: Facing) -> bool {
        let mut first = OneSided { best: Hit::none_before(ray.t_max), facing, any: true };
        self.collect(ray, &mut first);
        first.best.is_hit()
    }
}

/// The nearest hit on one side, or with `any` the first one found.
struct OneSided {
    best: Hit,
    facing: Facing,
    any: bool,
}

impl Collector for OneSided {
    #[inline(always)]
    fn t_max(&self) -> f32 {
        self.best.t
    }

    #[inline(always)]
    fn report(&mut self, hit: Hit, front: bool) -> ControlFlow<()> {
        let counts = match self.facing {
            Facing::Both => true,
            Facing::Front => front,
            Facing::Back => !front,
        };
        if !counts || !hit.precedes(&self.best) {
            return ControlFlow::Continue(());
        }
        self.best = hit;
        if self.any { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }
}
