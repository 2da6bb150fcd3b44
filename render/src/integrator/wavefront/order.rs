//! The order in which paths take their steps: by the kind of closure that they have hit.

use super::Wavefront;
use crate::material::Kind;
use crate::world::{Hit, World};

impl Wavefront {
    /// Sorts the paths by the kind of closure that they have hit, and otherwise leaves them in their order. Gives where
    /// each kind ends in [`order`](Self::order); behind the last one are the paths that hit nothing.
    pub(in crate::integrator) fn sort_by_kind(&mut self, world: &World) -> [usize; Kind::COUNT] {
        self.order.resize(self.hits.len(), 0);
        if !world.has_closures() {
            return [self.hits_first(); Kind::COUNT];
        }
        let kind = |hit: &Hit| if hit.is_hit() { world.kind(hit.prim_id) as usize } else { Kind::COUNT };
        let mut counts = [0; Kind::COUNT + 1];
        for hit in &self.hits {
            counts[kind(hit)] += 1;
        }
        let mut places = [0; Kind::COUNT + 1];
        for i in 1..places.len() {
            places[i] = places[i - 1] + counts[i - 1];
        }
        for (number, hit) in (0..).zip(&self.hits) {
            let place = &mut places[kind(hit)];
            self.order[*place] = number;
            *place += 1;
        }
        std::array::from_fn(|i| places[i])
    }

    /// Puts the paths that hit something first, where they are all of one kind; gives their number.
    fn hits_first(&mut self) -> usize {
        let Self { hits, order, .. } = self;
        let mut end = 0;
        // Written in any case, as a branch would be unpredictable.
        for (number, hit) in (0..).zip(hits.iter()) {
            order[end] = number;
            end += usize::from(hit.is_hit());
        }
        let misses = (0..).zip(hits.iter()).filter(|(_, hit)| !hit.is_hit());
        for (place, (number, _)) in order[end..].iter_mut().zip(misses) {
            *place = number;
        }
        end
    }
}
