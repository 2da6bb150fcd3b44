//! Gathers with as many rays as their standard error requires.
//!
//! The standard error of a gather with few rays tells how many rays would be enough, as the variance of a mean falls
//! with their number. The gather is repeated with that many, a power of two times the first number, until its error is
//! small enough. Rays of earlier gathers are discarded: repeated gathers had found more light than others on average,
//! and would bias the mean upwards.

use super::follow::Follow;
use super::gather::{GatherPoint, Gathered, Gatherer};
use crate::settings::GatherLayout;
use crate::world::World;

/// The most rays of a gather.
const MOST_RAYS: u32 = 1 << 15;
/// The ratio by which a variance may exceed the requested one.
const SLACK: f32 = 1.25;

/// Makes gathers of one number of rays, or of as many as they need.
pub(crate) struct AdaptiveGatherer {
    /// Gatherers with twice as many rays each.
    gatherers: Vec<Gatherer>,
    /// The standard error that is small enough, in W/m².
    tolerance: f32,
}

impl From<Gatherer> for AdaptiveGatherer {
    fn from(gatherer: Gatherer) -> Self {
        Self { gatherers: vec![gatherer], tolerance: f32::INFINITY }
    }
}

impl AdaptiveGatherer {
    /// Gathers of `rays` rays or more, until their standard error is at most `tolerance`; with Hessians or without.
    pub(crate) fn new((rays, tolerance): (u32, f32), layout: GatherLayout, with_hessian: bool, seed: u64) -> Self {
        let numbers = (0..).map(|round| rays << round).take_while(|&rays| rays <= MOST_RAYS);
        let gatherers = numbers.map(|rays| Gatherer::new(layout, rays, with_hessian, seed)).collect();
        Self { gatherers, tolerance }
    }

    /// Gathers at `points`; gives what each found, in their order, and the number of all rays.
    pub(crate) fn gather(
        &self,
        world: &World,
        points: &[GatherPoint],
        follow: &mut dyn Follow,
    ) -> (Vec<Gathered>, u64) {
        let (mut found, mut rays) = self.gatherers[0].gather(world, points, follow);
        let mut rounds: Vec<usize> = found.iter().map(|found| self.next(0, found)).collect();
        for (round, gatherer) in self.gatherers.iter().enumerate().skip(1) {
            let again: Vec<usize> = (0..points.len()).filter(|&i| rounds[i] == round).collect();
            if again.is_empty() {
                continue;
            }
            let points: Vec<GatherPoint> = again.iter().map(|&i| points[i]).collect();
            let (gathered, traced) = gatherer.gather(world, &points, follow);
            rays += traced;
            for (i, gathered) in again.into_iter().zip(gathered) {
                rounds[i] = self.next(round, &gathered);
                found[i] = gathered;
            }
        }
        (found, rays)
    }

    /// The round that should be right enough after what another found: the same if that is.
    fn next(&self, round: usize, found: &Gathered) -> usize {
        let excess = (found.gather.standard_error / self.tolerance).powi(2) / SLACK;
        // False for NaN too.
        if excess > 1.0 {
            let further = excess.log2().ceil().clamp(1.0, 32.0) as usize;
            (round + further).min(self.gatherers.len() - 1)
        } else {
            round
        }
    }
}
