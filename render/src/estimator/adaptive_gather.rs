//! Gathers with as many rays as their noise requires.
//!
//! Gathers `i` of `n_i` rays, one of which has a standard deviation of `s_i`, have a mean squared error of
//! `mean(s_i² / n_i)`. For a given error the rays are fewest in total where `n_i` is proportional to `s_i` (the optimal
//! allocation of Neyman 1934): `n_i = s_i mean(s) / error²`. Equal errors everywhere would need `s_i² / error²`, most of
//! them in the brightest places.
//!
//! The standard error of a gather with few rays tells its `s_i`. The gather is repeated with `n_i` rays, rounded up to a
//! power of two times the first number, until it has enough. Rays of earlier gathers are discarded: repeated gathers had
//! found more light than others on average, and would bias the mean upwards.

use super::follow::Follow;
use super::gather::{GatherPoint, Gathered, Gatherer};
use crate::settings::GatherLayout;
use crate::world::World;

/// The most rays of a gather.
const MOST_RAYS: u32 = 1 << 15;
/// The ratio by which the required number of rays may exceed that of a gather which is kept.
const SLACK: f32 = 1.25;

/// The number of rays of gathers.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RayBudget {
    /// Rays of a gather at first.
    pub(crate) first: u32,
    /// Rays over the standard deviation of one of them, in m²/W: `mean(s) / error²`.
    pub(crate) over_deviation: f32,
}

/// Makes gathers of one number of rays, or of as many as they need.
pub(crate) struct AdaptiveGatherer {
    /// Gatherers with twice as many rays each.
    gatherers: Vec<Gatherer>,
    /// Rays over the standard deviation of one of them.
    over_deviation: f32,
}

impl From<Gatherer> for AdaptiveGatherer {
    fn from(gatherer: Gatherer) -> Self {
        Self { gatherers: vec![gatherer], over_deviation: 0.0 }
    }
}

impl AdaptiveGatherer {
    /// Gathers of as many rays as a budget says; with Hessians or without.
    pub(crate) fn new(budget: RayBudget, layout: GatherLayout, with_hessian: bool, seed: u64) -> Self {
        let numbers = (0..).map(|round| budget.first << round).take_while(|&rays| rays <= MOST_RAYS);
        let gatherers = numbers.map(|rays| Gatherer::new(layout, rays, with_hessian, seed)).collect();
        Self { gatherers, over_deviation: budget.over_deviation }
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

    /// The round with enough rays after what another found: the same if that has enough.
    fn next(&self, round: usize, found: &Gathered) -> usize {
        let rays = self.gatherers[round].rays() as f32;
        let deviation = found.gather.standard_error * rays.sqrt();
        let excess = deviation * self.over_deviation / (SLACK * rays);
        // False for NaN too.
        if excess > 1.0 {
            let further = excess.log2().ceil().clamp(1.0, 32.0) as usize;
            (round + further).min(self.gatherers.len() - 1)
        } else {
            round
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;
    use halfdome_kernel::irradiance::Gather;

    use super::*;
    use crate::estimator::occluders::OccluderSectors;

    /// What a gather of `rays` rays finds, one of which has this standard deviation.
    fn found(deviation: f32, rays: u32) -> Gathered {
        let gather = Gather {
            irradiance: Vec3::ONE,
            rotational: [Vec3::ZERO; 3],
            translational: [Vec3::ZERO; 3],
            harmonic_mean_distance: 1.0,
            minimum_distance: 1.0,
            standard_error: deviation / (rays as f32).sqrt(),
        };
        Gathered { gather, hessian: None, occluders: OccluderSectors::OPEN }
    }

    /// For deviations from 0.1 to 10 times their mean the error is what was asked for, in half of the rays that equal
    /// errors take; and a gather with enough rays is not repeated.
    #[test]
    fn rays_are_proportional_to_the_deviation() {
        let deviations: Vec<f32> = (0..200).map(|i| 10f32.powf(0.01 * i as f32 - 1.0)).collect();
        let (error, count) = (0.03f32, deviations.len() as f32);
        let mean = deviations.iter().sum::<f32>() / count;
        let budget = RayBudget { first: 256, over_deviation: mean / (error * error) };
        let gatherer = AdaptiveGatherer::new(budget, GatherLayout::Stratified, false, 1);
        let (mut squares, mut rays, mut rays_for_equal_errors) = (0.0, 0.0, 0.0);
        for &deviation in &deviations {
            let round = gatherer.next(0, &found(deviation, gatherer.gatherers[0].rays() as u32));
            let enough = gatherer.gatherers[round].rays() as f32;
            assert_eq!(gatherer.next(round, &found(deviation, enough as u32)), round, "deviation {deviation}");
            squares += deviation * deviation / enough;
            rays += enough;
            rays_for_equal_errors += (deviation / error).powi(2).max(256.0);
        }
        let reached = (squares / count).sqrt();
        assert!((0.75..1.05).contains(&(reached / error)), "{reached}, not {error}");
        assert!(rays < 0.6 * rays_for_equal_errors, "{rays} of {rays_for_equal_errors}");
    }
}
