//! Irradiance at given points, as sensors in a room would measure it.
//!
//! A sensor is a small white surface. Direct light, with the sun of a sky picture, is sampled `spp` times at each;
//! light reflected by surfaces, and the rest of the sky, comes from an irradiance cache that is filled for the sensors,
//! or from `spp` paths at each.
//!
//! Lit triangles are sampled as secondary lights, as in gathers of records.
//!
//! If the cache asks for an accuracy, `to_accuracy` chooses between a cache and paths at each sensor.
//!
//! Area lights are sampled. A scattered ray counts their emission too where it begins a path, and near lights, as in
//! lookups of the camera; both are weighted by the power heuristic (Veach 1997).

mod part;
mod points;
mod sample;
mod to_accuracy;

use std::ops::Range;

use glam::{DVec3, Vec3};
use rayon::prelude::*;

use crate::cache::Cache;
use crate::estimator::{RoundsMean, mean_in_rounds, mean_of_halves};
use crate::integrator::CacheUse;
use crate::integrator::{FillTarget, FrozenCache, fill_for_surfaces, max_depth};
use crate::settings::Shard;
use crate::watch::Watch;
use crate::world::{Surface, World};

pub use part::{SensorPart, join, key, lines};
pub use points::{PointsError, Sensor, read_points, read_positions};
use sample::{Samples, SensorScratch};

/// The part of the light that counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// All of it.
    Total,
    /// Light reflected by surfaces, and the sky without the sun of its picture.
    Indirect,
}

/// The estimator of irradiance.
#[derive(Clone, Copy, Debug)]
pub struct Request {
    /// Samples of direct light at each sensor, and without a cache paths, at least 1; as many as it takes instead where the
    /// options of a cache ask for an accuracy.
    pub spp: u32,
    /// Selects the random numbers.
    pub seed: u64,
    /// The part of the light that counts.
    pub part: Part,
}

/// Irradiance at sensors, in their order, and what it took.
#[derive(Clone, Debug)]
pub struct Irradiance {
    /// In W/m², linear sRGB; unspecified at sensors of other shards; 0 at sensors that were not reached before the
    /// watcher stopped.
    pub values: Vec<Vec3>,
    /// Whether all sensors were reached.
    pub finished: bool,
    /// Rays traced.
    pub rays: u64,
    /// The cache, with the records that were added for the sensors, and how it was used; `None` without one, also where an
    /// accuracy was requested that took fewer rays without one.
    pub cache: Option<(Cache, CacheUse)>,
    /// An estimate of the root mean square error, relative to the mean, if the cache's options ask for an accuracy.
    pub error: Option<f32>,
}

/// How many samples a component gets.
#[derive(Clone, Copy, Debug)]
enum Effort {
    /// So many.
    Samples(u32),
    /// So many in two independent halves, whose difference tells the noise.
    Halves(u32),
    /// Until the standard error is this, in W/m².
    Noise(f64),
}

/// The samples at a sensor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Component {
    /// Direct light.
    Direct,
    /// All but that, by paths of at most this many surfaces or as many as chance lets them have.
    Indirect(Option<u32>),
    /// Both, by such paths.
    All(Option<u32>),
}

/// Samples that are traced together, about.
const BATCH: usize = 2048;

/// Irradiance by paths alone.
pub fn by_paths(world: &World, sensors: &[Sensor], request: &Request, watch: &dyn Watch) -> Irradiance {
    shard_by_paths(world, sensors, Shard::ALL, request, watch)
}

/// Irradiance by paths alone at those of the sensors that are in a shard.
pub fn shard_by_paths(
    world: &World,
    sensors: &[Sensor],
    shard: Shard,
    request: &Request,
    watch: &dyn Watch,
) -> Irradiance {
    let component = match request.part {
        Part::Total => Component::All(None),
        Part::Indirect => Component::Indirect(None),
    };
    let mut found = Irradiance::black(sensors);
    let effort = Effort::Samples(request.spp.max(1));
    found.add(world, sensors, &own(sensors, shard), (component, effort), request.seed, watch);
    found
}

/// Irradiance with the indirect part from `cache`, to which records are added where the sensors need them. It must be
/// of this world. Records go by the order of the sensors: in another order they may lie elsewhere.
pub fn by_cache(world: &World, sensors: &[Sensor], cache: Cache, request: &Request, watch: &dyn Watch) -> Irradiance {
    shard_by_cache(world, sensors, Shard::ALL, cache, request, watch)
}

/// The same at those of the sensors that are in a shard. The cache is filled for all of them, so that values do not depend
/// on shards.
pub fn shard_by_cache(
    world: &World,
    sensors: &[Sensor],
    shard: Shard,
    cache: Cache,
    request: &Request,
    watch: &dyn Watch,
) -> Irradiance {
    if cache.options().accuracy.is_some() {
        return to_accuracy::shard(world, (sensors, shard), cache, request, watch);
    }
    let surfaces: Vec<Surface> = sensors.iter().map(|sensor| sensor.surface(world)).collect();
    let (frozen, filled) = fill_for_surfaces(world, request.seed, cache, &surfaces, FillTarget::Options, watch);
    let effort = Effort::Samples(request.spp.max(1));
    let (mut found, _) = look_up(world, (sensors, &own(sensors, shard)), &frozen, (request, effort), watch);
    found.rays += filled;
    found.set_cache(frozen);
    found
}

/// Irradiance at some of the sensors with the indirect part from a frozen cache; by paths, of as many surfaces as those to a
/// record, where it has no record. Gives the mean variance of what was sampled too.
fn look_up(
    world: &World,
    (sensors, own): (&[Sensor], &[usize]),
    frozen: &FrozenCache,
    (request, effort): (&Request, Effort),
    watch: &dyn Watch,
) -> (Irradiance, f64) {
    let indirect: Vec<Option<Vec3>> =
        own.par_iter().map(|&i| frozen.irradiance(world, &sensors[i].surface(world))).collect();
    let mut found = Irradiance::black(sensors);
    own.iter().zip(&indirect).for_each(|(&i, indirect)| found.values[i] = indirect.unwrap_or_default());
    let lost: Vec<usize> = own.iter().zip(&indirect).filter(|(_, it)| it.is_none()).map(|(&i, _)| i).collect();
    let mut variance = 0.0;
    if request.part == Part::Total {
        variance += found.add(world, sensors, own, (Component::Direct, effort), request.seed, watch);
    }
    let max_depth = max_depth(frozen.cache.options());
    variance += found.add(world, sensors, &lost, (Component::Indirect(max_depth), effort), request.seed, watch);
    (found, variance / own.len().max(1) as f64)
}

/// The numbers of the sensors of a shard.
fn own(sensors: &[Sensor], shard: Shard) -> Vec<usize> {
    (0..sensors.len()).filter(|&sensor| shard.has(sensor)).collect()
}

impl Irradiance {
    /// No light at these sensors yet.
    fn black(sensors: &[Sensor]) -> Self {
        Self { values: vec![Vec3::ZERO; sensors.len()], finished: true, rays: 0, cache: None, error: None }
    }

    /// Keeps the cache that was read.
    fn set_cache(&mut self, frozen: FrozenCache) {
        let usage = frozen.usage();
        self.cache = Some((frozen.cache, usage));
    }

    /// Adds the means of the samples of a component at the sensors of these numbers; gives the sum of their variances, as far
    /// as they are known.
    fn add(
        &mut self,
        world: &World,
        sensors: &[Sensor],
        numbers: &[usize],
        (component, effort): (Component, Effort),
        seed: u64,
        watch: &dyn Watch,
    ) -> f64 {
        let known = |found: RoundsMean| (found.mean, found.variance);
        let sample = |batch: &mut SensorScratch, &number: &usize| {
            let surface = sensors[number].surface(world);
            let (mut rays, mut stopped) = (0, false);
            let mut sum = |seed, numbers: Range<u32>| {
                let mut sum = DVec3::ZERO;
                for first in numbers.clone().step_by(BATCH) {
                    stopped = stopped || watch.stop();
                    if stopped {
                        break;
                    }
                    let end = numbers.end.min(first.saturating_add(BATCH as u32));
                    let samples = Samples { seed, sensor: number as u32, first };
                    batch.samplers.clear();
                    batch.samplers.extend((0..end - first).map(|i| samples.sampler(seed, i)));
                    let traced = batch.sample(world, &surface, component, &samples, &mut sum);
                    watch.advance(batch.samplers.len() as u64, traced);
                    rays += traced;
                }
                sum
            };
            let (mean, variance) = match effort {
                Effort::Samples(count) => (sum(seed, 0..count) / f64::from(count), 0.0),
                Effort::Halves(count) => known(mean_of_halves(seed, count, sum)),
                Effort::Noise(tolerance) => known(mean_in_rounds(seed, |_| tolerance, sum)),
            };
            ((!stopped).then_some((mean.as_vec3(), variance)), rays)
        };
        let means: Vec<(Option<(Vec3, f64)>, u64)> =
            numbers.par_iter().map_init(SensorScratch::default, sample).collect();
        let mut variances = 0.0;
        for (&number, (found, rays)) in numbers.iter().zip(means) {
            self.rays += rays;
            self.finished &= found.is_some();
            let (mean, variance) = found.unwrap_or_default();
            self.values[number] += mean;
            variances += variance;
        }
        variances
    }
}

#[cfg(test)]
mod tests;
