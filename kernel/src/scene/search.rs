//! The searches of a walk through a scene: the nearest hit, any hit, or hits passed to a callback.

use core::cmp::Ordering;
use core::ops::ControlFlow;

use super::SceneHit;
use crate::bvh::BvhView;
use crate::geometry::{Hit, Ray};
use crate::simd::Simd;
use crate::traverse::TraversalStack;
use crate::traverse::single::{self, Collector};

/// Receives the hits of a ray in a scene.
pub(super) trait Search: Sized {
    /// Hits with a greater `t` are ignored. It starts at the ray's `t_max` or less, and never grows.
    fn t_max(&self) -> f32;

    /// Takes a hit that is not behind [`t_max`](Self::t_max). `Break` ends the search.
    fn report(&mut self, hit: SceneHit) -> ControlFlow<()>;

    /// Looks for hits with triangles that stand still; all have in common what `common` says. `stack` is memory.
    #[inline(always)]
    fn visit_mesh<S: Simd>(
        &mut self,
        tree: &BvhView,
        ray: &Ray,
        common: SceneHit,
        stack: &mut TraversalStack,
    ) -> ControlFlow<()> {
        single::walk::<S, _>(tree, ray, stack, &mut ItemCollector { search: self, common })
    }
}

/// The nearest hit.
pub(super) struct Closest {
    pub best: SceneHit,
}

impl Closest {
    #[inline(always)]
    pub(super) fn new(t_max: f32) -> Self {
        Self { best: SceneHit { hit: Hit::none_before(t_max), ..SceneHit::MISS } }
    }

    /// What a hit of one item has to precede by `t` and `prim_id` alone, to precede the best: of equally near hits the
    /// geometry decides, then the part, then the path.
    #[inline(always)]
    pub(super) fn to_precede(&self, common: &SceneHit) -> Hit {
        let best = &self.best;
        let prim_id = match common.item.cmp(&best.item) {
            Ordering::Less => Hit::NO_PRIM,
            Ordering::Equal => best.hit.prim_id.saturating_add(u32::from(common.path < best.path)),
            Ordering::Greater => 0,
        };
        Hit { t: best.hit.t, prim_id, ..Hit::MISS }
    }

    /// Takes the hit of one item, unless that is what it [had to precede](Self::to_precede).
    #[inline(always)]
    pub(super) fn take(&mut self, hit: Hit, common: &SceneHit) {
        let before = self.to_precede(common);
        if hit.t != before.t || hit.prim_id != before.prim_id {
            self.best = SceneHit { hit, ..*common };
        }
    }
}

impl Search for Closest {
    #[inline(always)]
    fn t_max(&self) -> f32 {
        self.best.hit.t
    }

    #[inline(always)]
    fn report(&mut self, hit: SceneHit) -> ControlFlow<()> {
        if hit.precedes(&self.best) {
            self.best = hit;
        }
        ControlFlow::Continue(())
    }

    #[inline(always)]
    fn visit_mesh<S: Simd>(
        &mut self,
        tree: &BvhView,
        ray: &Ray,
        common: SceneHit,
        _stack: &mut TraversalStack,
    ) -> ControlFlow<()> {
        self.take(single::closest::<S>(tree, ray, self.to_precede(&common)), &common);
        ControlFlow::Continue(())
    }
}

/// Whether there is a hit.
pub(super) struct Any {
    pub t_max: f32,
    pub found: bool,
}

impl Search for Any {
    #[inline(always)]
    fn t_max(&self) -> f32 {
        self.t_max
    }

    #[inline(always)]
    fn report(&mut self, _hit: SceneHit) -> ControlFlow<()> {
        self.found = true;
        ControlFlow::Break(())
    }

    #[inline(always)]
    fn visit_mesh<S: Simd>(
        &mut self,
        tree: &BvhView,
        ray: &Ray,
        _common: SceneHit,
        _stack: &mut TraversalStack,
    ) -> ControlFlow<()> {
        self.found = single::occluded::<S>(tree, ray);
        if self.found { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }
}

/// Passes hits to a callback. Not generic, so that it is compiled once for each instruction set: a filter is called
/// only a few times a ray.
pub(super) struct Judged<'a> {
    pub t_max: f32,
    /// Gives the new [`t_max`](Search::t_max).
    pub judge: &'a mut dyn FnMut(&SceneHit) -> ControlFlow<(), f32>,
}

impl Search for Judged<'_> {
    #[inline(always)]
    fn t_max(&self) -> f32 {
        self.t_max
    }

    #[inline(always)]
    fn report(&mut self, hit: SceneHit) -> ControlFlow<()> {
        self.t_max = (self.judge)(&hit)?;
        ControlFlow::Continue(())
    }
}

/// Passes hits with one item to the search.
pub(super) struct ItemCollector<'s, Q> {
    pub search: &'s mut Q,
    /// The fields that all of them share.
    pub common: SceneHit,
}

impl<Q: Search> Collector for ItemCollector<'_, Q> {
    #[inline(always)]
    fn t_max(&self) -> f32 {
        self.search.t_max()
    }

    #[inline(always)]
    fn report(&mut self, hit: Hit, _front: bool) -> ControlFlow<()> {
        self.search.report(SceneHit { hit, ..self.common })
    }
}
