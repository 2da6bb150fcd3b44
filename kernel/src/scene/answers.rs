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
    fn begin(&mut self, number: usize, t_max: f32);

    /// The rest of a search.
    fn search(&self, number: usize, t_max: f32) -> Self::Search;

    /// The result of a search so far, and whether it has ended.
    fn advance(&mut self, number: usize, search: Self::Search) -> bool;

    /// What a hit in an item has to precede, by `t` and `prim_id` alone.
    fn to_precede(&self, number: usize, t_max: f32, common: &SceneHit) -> Hit;

    /// The ray has left an item, with this hit or what it [had to precede](Self::to_precede). Whether its search has
    /// ended.
    fn leave(&mut self, number: usize, hit: Hit, common: &SceneHit) -> bool;

    /// The search is over.
    fn end(&mut self, number: usize);
}

/// The nearest hits.
pub(super) struct Nearest<'a>(pub(super) &'a mut [SceneHit]);

impl Nearest<'_> {
    #[inline(always)]
    fn best(&self, number: usize) -> SceneHit {
        self.0.get(number).copied().unwrap_or(SceneHit::MISS)
    }

    #[inline(always)]
    fn set(&mut self, number: usize, hit: SceneHit) {
        if let Some(place) = self.0.get_mut(number) {
            *place = hit;
        }
    }
}

impl Answers for Nearest<'_> {
    type Search = Closest;
    const ANY: bool = false;

    #[inline(always)]
    fn begin(&mut self, number: usize, t_max: f32) {
        self.set(number, Closest::new(t_max).best);
    }

    #[inline(always)]
    fn search(&self, number: usize, _t_max: f32) -> Closest {
        Closest { best: self.best(number) }
    }

    #[inline(always)]
    fn advance(&mut self, number: usize, search: Closest) -> bool {
        self.set(number, search.best);
        false
    }

    #[inline(always)]
    fn to_precede(&self, number: usize, _t_max: f32, common: &SceneHit) -> Hit {
        Closest { best: self.best(number) }.to_precede(common)
    }

    #[inline(always)]
    fn leave(&mut self, number: usize, hit: Hit, common: &SceneHit) -> bool {
        let mut closest = Closest { best: self.best(number) };
        closest.take(hit, common);
        self.set(number, closest.best);
        false
    }

    #[inline(always)]
    fn end(&mut self, number: usize) {
        if !self.best(number).is_hit() {
            self.set(number, SceneHit::MISS);
        }
    }
}

/// Whether there are hits.
pub(super) struct Occluded<'a>(pub(super) &'a mut [bool]);

impl Occluded<'_> {
    #[inline(always)]
    fn set(&mut self, number: usize, occluded: bool) -> bool {
        if let Some(place) = self.0.get_mut(number) {
            *place = occluded;
        }
        occluded
    }
}

impl Answers for Occluded<'_> {
    type Search = Any;
    const ANY: bool = true;

    #[inline(always)]
    fn begin(&mut self, number: usize, _t_max: f32) {
        self.set(number, false);
    }

    #[inline(always)]
    fn search(&self, _number: usize, t_max: f32) -> Any {
        Any { t_max, found: false }
    }

    #[inline(always)]
    fn advance(&mut self, number: usize, search: Any) -> bool {
        self.set(number, search.found)
    }

    #[inline(always)]
    fn to_precede(&self, _number: usize, t_max: f32, _common: &SceneHit) -> Hit {
        Hit::none_before(t_max)
    }

    #[inline(always)]
    fn leave(&mut self, number: usize, hit: Hit, _common: &SceneHit) -> bool {
        self.set(number, hit.is_hit())
    }

    #[inline(always)]
    fn end(&mut self, _number: usize) {}
}
