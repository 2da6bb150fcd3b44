//! Collectors: receivers of the hits that a ray finds.

use core::ops::ControlFlow;

use crate::geometry::Hit;

/// Receives the hits that a ray finds.
pub(crate) trait Collector {
    /// Hits with a greater `t` are ignored. It starts at the ray's `t_max` or less, and never grows.
    fn t_max(&self) -> f32;

    /// Sees a hit between the ray's `t_min` and [`t_max`](Self::t_max), and whether it is from the front. `Break` ends
    /// the search.
    fn report(&mut self, hit: Hit, front: bool) -> ControlFlow<()>;
}

/// The nearest hit.
pub(super) struct ClosestHit {
    pub(super) best: Hit,
}

impl Collector for ClosestHit {
    #[inline(always)]
    fn t_max(&self) -> f32 {
        self.best.t
    }

    #[inline(always)]
    fn report(&mut self, hit: Hit, _front: bool) -> ControlFlow<()> {
        if hit.precedes(&self.best) {
            self.best = hit;
        }
        ControlFlow::Continue(())
    }
}
