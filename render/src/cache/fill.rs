//! Places records in rounds, so that their order does not depend on threads.
//!
//! A round evaluates places in a fixed order against the frozen cache, in parallel; picks among those that no record
//! covers, in the same order, so that no two picks are closer than the round's separation; has them gathered; and
//! commits them by their order. Separations shrink by √2 from round to round, so that the spacing of records adapts to
//! their radii without an initial guess. The last round repeats until every place is covered. Where its records cover
//! little more than their own places, as on many objects no larger than a texel, a separation saves no records and
//! costs rounds: so it halves.

use std::collections::HashMap;

use glam::IVec3;
use rayon::prelude::*;

use super::Cache;
use super::record::{LookupPoint, Record};

/// A point that is to be covered.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Place {
    pub(crate) point: LookupPoint,
    /// The unit of separations here: how wide a pixel is, for example. More than 0.
    pub(crate) spacing: f32,
}

/// A round.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Pass {
    /// It is about the places before this one.
    pub(crate) places: usize,
    /// The least distance of two picks, in units of the later one's spacing.
    pub(crate) separation: f32,
}

/// A round's records cover at least so many places each, or the next round's may be nearer to each other.
const MIN_COVERED: usize = 2;

impl Cache {
    /// Adds records until each of `places` is covered. `gather` makes the records of places by their indices, in that
    /// order, and is told how many places are covered so far; it gives `None` to end the work early, and then so does
    /// this.
    pub(crate) fn fill(
        &mut self,
        places: &[Place],
        passes: &[Pass],
        mut gather: impl FnMut(&[usize], usize) -> Option<Vec<Record>>,
    ) -> Option<()> {
        // A record that does not even cover its own place would be asked for again and again.
        let mut picked = vec![false; places.len()];
        for (number, pass) in passes.iter().enumerate() {
            let last = number + 1 == passes.len();
            let count = pass.places.min(places.len());
            let (mut separation, mut expected) = (pass.separation, usize::MAX);
            loop {
                // All of them, as radii may have been clamped since the last time.
                let is_open = |&i: &usize| !picked[i] && !self.covers(&places[i].point);
                let open: Vec<usize> = (0..count).into_par_iter().filter(is_open).collect();
                if open.len() > expected {
                    separation *= 0.5;
                }
                let picks = pick(places, &open, separation);
                if picks.is_empty() {
                    break;
                }
                expected = open.len().saturating_sub(MIN_COVERED * picks.len());
                picks.iter().for_each(|&i| picked[i] = true);
                self.commit(gather(&picks, count - open.len())?);
                if !last {
                    break;
                }
            }
        }
        Some(())
    }
}

/// The places among `open` that are no closer to those picked before than the separation, in their order.
fn pick(places: &[Place], open: &[usize], separation: f32) -> Vec<usize> {
    let mut picks: Vec<usize> = Vec::new();
    // Cells as wide as the separation, rounded up to a power of two, as separations differ.
    let mut cells: HashMap<(i32, IVec3), Vec<usize>> = HashMap::new();
    for &i in open {
        let Place { point, spacing } = &places[i];
        let distance = separation * spacing;
        let level = distance.log2().ceil();
        let cell = (point.position / level.exp2()).floor().as_ivec3();
        let neighbours = (0..27).map(|k| cell + IVec3::new(k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1));
        let near = |j: &usize| {
            let other = &places[*j].point;
            other.position.distance_squared(point.position) < distance * distance
                && other.normal.dot(point.normal) > 0.5
        };
        let crowded = neighbours
            .into_iter()
            .any(|cell| cells.get(&(level as i32, cell)).is_some_and(|picks| picks.iter().any(near)));
        if !crowded {
            picks.push(i);
            cells.entry((level as i32, cell)).or_default().push(i);
        }
    }
    picks
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    #[test]
    fn picks_keep_their_distance_and_leave_no_hole() {
        let places: Vec<Place> = (0..900)
            .map(|i| {
                let position = Vec3::new((i % 30) as f32, (i / 30) as f32, 0.0);
                let normal = if i % 7 == 0 { Vec3::NEG_Z } else { Vec3::Z };
                Place { point: LookupPoint { position, normal, clearance: None }, spacing: 1.0 }
            })
            .collect();
        let open: Vec<usize> = (0..900).filter(|i| i % 11 != 0).collect();
        for separation in [0.5, 1.0, 3.7, 100.0] {
            let picks = pick(&places, &open, separation);
            let near = |&i: &usize, &j: &usize| {
                let [i, j] = [i, j].map(|number| &places[number].point);
                i.normal == j.normal && i.position.distance(j.position) < separation
            };
            for (n, i) in picks.iter().enumerate() {
                assert!(open.contains(i) && !picks[..n].iter().any(|j| near(i, j)));
            }
            assert!(open.iter().all(|i| picks.iter().any(|j| near(i, j))));
            assert!(picks.is_sorted());
        }
    }
}
