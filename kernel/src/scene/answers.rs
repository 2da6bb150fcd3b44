//! Results of the rays of a stream: their nearest hits, or whether they have any.

use super::SceneHit;
use super::search::{Any, Closest, Search};
use crate::geometry::Hit;

/// The results of rays by their indices in the batch.
pub(super) trait Answers {
    /// The state of a ray's search.
    type Search: Search;
    /// Whether any hit is as good as another.
    const ANY: bool;

    /// Nothing has been found up to `t_max`.
    fn begin(&mut self, ray: usize, t_max: f32);

    /// The rest of a search.
    fn search(&self, ray: usize, t_max: f32) -> Self::Search;

    /// The result of a search so far, and whether it has ended.
    fn advance(&mut self, ray: usize, search: Self::Search) -> bool;

    /// What a hit in an item has to precede, by `t` and `prim_id` alone.
    fn to_precede(&self, ray: usize, t_max: f32, common: &SceneHit) -> Hit;

    /// The ray has left an item, with this hit or what it [had to precede](Self::to_precede). Whether its search has
    /// ended.
    fn leave(&mut self, ray: usize, hit: Hit, common: &SceneHit) -> bool;

    /// The search is over.
    fn end(&mut self, ray: usize);
}

/// The nearest hits.
pub(super) struct Nearest<'a>(pub(super) &'a mut [SceneHit]);

impl Nearest<'_> {
    #[inline(always)]
    fn best(&self, ray: usize) -> SceneHit {
        self.0.get(ray).copied().unwrap_or(SceneHit::MISS)
    }

    #[inline(always)]
    fn set(&mut self, ray: usize, hit: SceneHit) {
        if let Some(place) = self.0.get_mut(ray) {
            *place = hit;
        }
    }
}

impl Answers for Nearest<'_> {
    type Search = Closest;
    const ANY: bool = false;

    #[inline(always)]
    fn begin(&mut self, ray: usize, t_max: f32) {
        self.set(ray, Closest::new(t_max).best);
    }

    #[inline(always)]
    fn search(&self, ray: usize, _t_max: f32) -> Closest {
        Closest { best: self.best(ray) }
    }

    #[inline(always)]
    fn advance(&mut self, ray: usize, search: Closest) -> bool {
        self.set(ray, search.best);
        false
    }

    #[inline(always)]
    fn to_precede(&self, ray: usize, _t_max: f32, common: &SceneHit) -> Hit {
        Closest { best: self.best(ray) }.to_precede(common)
    }

    #[inline(always)]
    fn leave(&mut self, ray: usize, hit: Hit, common: &SceneHit) -> bool {
        let mut closest = Closest { best: self.best(ray) };
        closest.take(hit, common);
        self.set(ray, closest.best);
        false
    }

    #[inline(always)]
    fn end(&mut self, ray: usize) {
        if !self.best(ray).is_hit() {
            self.set(ray, SceneHit::MISS);
        }
    }
}

/// Whether there are hits.
pub(super) struct Occluded<'a>(pub(super) &'a mut [bool]);

impl Occluded<'_> {
    #[inline(always)]
    fn set(&mut self, ray: usize, occluded: bool) -> bool {
        if let Some(place) = self.0.get_mut(ray) {
            *place = occluded;
        }
        occluded
    }
}

impl Answers for Occluded<'_> {
    type Search = Any;
    const ANY: bool = true;

    #[inline(always)]
    fn begin(&mut self, ray: usize, _t_max: f32) {
        self.set(ray, false);
    }

    #[inline(always)]
    fn search(&self, _ray: usize, t_max: f32) -> Any {
        Any { t_max, found: false }
    }

    #[inline(always)]
    fn advance(&mut self, ray: usize, search: Any) -> bool {
        self.set(ray, search.found)
    }

    #[inline(always)]
    fn to_precede(&self, _ray: usize, t_max: f32, _common: &SceneHit) -> Hit {
        Hit::none_before(t_max)
    }

    #[inline(always)]
    fn leave(&mut self, ray: usize, hit: Hit, _common: &SceneHit) -> bool {
        self.set(ray, hit.is_hit())
    }

    #[inline(always)]
    fn end(&mut self, _ray: usize) {}
}
