//! Single rays through a tree of points or curves; in a [scene](crate::scene) all queries of scenes work.

use core::ops::ControlFlow;

use crate::bvh::RoundBvhView;
use crate::geometry::{Hit, Ray};
use crate::simd::{Level, Simd, Work, dispatch};
use crate::traverse::collector::{ClosestHit, Collector};
use crate::traverse::single::round;
use crate::traverse::{TraversalStack, reference};

impl RoundBvhView<'_> {
    /// The nearest hit of `ray`; among equally near ones that of the lowest `prim_id`. Which crossings with a primitive
    /// count, [`round`](crate::geometry::round) says.
    pub fn intersect(&self, ray: &Ray) -> Option<Hit> {
        self.trace(ray, ClosestHit { best: Hit::none_before(ray.t_max) }).best.found()
    }

    /// Whether `ray` hits anything: `intersect(ray).is_some()`, but faster.
    pub fn occluded(&self, ray: &Ray) -> bool {
        self.trace(ray, AnyHit { t_max: ray.t_max, found: false }).found
    }

    /// Writes the nearest hit of each ray, or [`Hit::MISS`]. Elements beyond the end of the shorter slice are left
    /// unchanged.
    pub fn intersect_many(&self, rays: &[Ray], hits: &mut [Hit]) {
        for (ray, hit) in rays.iter().zip(hits) {
            *hit = self.intersect(ray).unwrap_or(Hit::MISS);
        }
    }

    /// Writes for each ray whether it hits anything. Elements beyond the end of the shorter slice are left unchanged.
    pub fn occluded_many(&self, rays: &[Ray], occluded: &mut [bool]) {
        for (ray, occluded) in rays.iter().zip(occluded) {
            *occluded = self.occluded(ray);
        }
    }

    fn trace<C: Collector>(&self, ray: &Ray, collector: C) -> C {
        match self.isa().level() {
            Level::Scalar => {
                let mut collector = collector;
                // The collector itself records whether it was ended early.
                let _ = reference::walk_round(self, ray, &mut collector);
                collector
            }
            _ => dispatch(self.isa(), Walk { tree: self, ray, collector }),
        }
    }
}

struct Walk<'a, C> {
    tree: &'a RoundBvhView<'a>,
    ray: &'a Ray,
    collector: C,
}

impl<C: Collector> Work for Walk<'_, C> {
    type Output = C;
    #[inline(always)]
    fn run<S: Simd>(mut self) -> C {
        let _ =
            round::walk::<S, C>(self.tree, self.tree.isa(), self.ray, &mut TraversalStack::new(), &mut self.collector);
        self.collector
    }
}

/// Whether there is a hit.
struct AnyHit {
    t_max: f32,
    found: bool,
}

impl Collector for AnyHit {
    #[inline(always)]
    fn t_max(&self) -> f32 {
        self.t_max
    }

    #[inline(always)]
    fn report(&mut self, _hit: Hit, _front: bool) -> ControlFlow<()> {
        self.found = true;
        ControlFlow::Break(())
    }
}
