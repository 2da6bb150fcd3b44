//! Reference irradiance at points held out from a cache, by gathers that no record uses.
//!
//! Two independent gathers at a point, by paths, have irradiance `a` and `b`, each without bias. For a cache's value
//! `x`, the expectation of `(x - a)(x - b)` is the square of its error, whatever the noise of both, and its mean over
//! all points is the mean squared error, with noise of records, interpolation and bias of their source.
//!
//! Their mean, with direct light, is also what errors are relative to.

use glam::{DVec3, Vec3};
use halfdome_kernel::sampling::Stream;
use rayon::prelude::*;

use super::GatherSource;
use super::clearance::lookup_point;
use super::level::{DirectGatherer, Follower};
use crate::cache::{Cache, LookupPoint};
use crate::estimator::{GATHER_FIRST_SET, GatherPoint, Gatherer, IncidentSampler, IncidentSink, RayBudget, salts};
use crate::settings::CachedOptions;
use crate::watch::Watch;
use crate::world::{Surface, World};

/// One point in this many is held out, ...
const ONE_OF: usize = 64;
/// ... but at least so many, if there are as many, ...
const LEAST: usize = 256;
/// ... and at most so many.
const MOST: usize = 1024;
/// Rays of a gather at first ...
const FIRST_RAYS: u32 = 512;
/// ... and at most.
const MOST_RAYS: u32 = 1 << 14;
/// The relative standard error of a mean squared error that is small enough.
const KNOWN_TO: f64 = 0.25;
/// Samples of direct light, of which a mean over all points is taken.
const LIGHT_SAMPLES: u32 = 32;
/// Points that a thread takes at once.
const CHUNK: usize = 4;
/// What the root mean square of the records' standard errors may be, as a part of the error that was asked for.
const NOISE: f64 = 0.7;
/// The fewest and the most rays of records at first.
const RAYS_OF_RECORDS: [f64; 2] = [256.0, 2048.0];
/// Records get this part of the mean number of rays at first: many need fewer.
const FIRST_PART: f64 = 0.25;

/// The light of a mean.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum MeanLight {
    /// All of it.
    Total,
    /// The results of gathers.
    Indirect,
    /// The rest, for which no gathers are made.
    Direct,
}

/// Independent knowledge of some points.
#[derive(Debug)]
pub(crate) struct HeldOut<'w> {
    surfaces: Vec<Surface<'w>>,
    /// Each, as it asks for records.
    points: Vec<LookupPoint>,
    /// Irradiance at each, twice.
    gathered: Vec<[Vec3; 2]>,
    /// Rays of each of these gathers.
    rays: u32,
    light: f64,
    /// The requested accuracy.
    accuracy: f64,
    /// Rays traced for all this.
    pub(crate) traced: u64,
}

/// A sum of direct light.
struct Sum(DVec3);

impl IncidentSink for Sum {
    fn add_light(&mut self, _: Vec3, irradiance: Vec3) {
        self.0 += irradiance.as_dvec3();
    }
}

impl<'w> HeldOut<'w> {
    /// Gathers at some of `count` points, of which `surface` gives each; `None` if the watcher stops.
    pub(crate) fn new(
        world: &World,
        options: &CachedOptions,
        (count, surface): (usize, impl Fn(usize) -> Surface<'w>),
        light: MeanLight,
        seed: u64,
        watch: &dyn Watch,
    ) -> Option<Self> {
        let accuracy = f64::from(options.accuracy.unwrap_or(CachedOptions::MAX_ACCURACY));
        let some = (count / ONE_OF).clamp(LEAST, MOST).min(count);
        // One of each part of the list.
        let chosen = (0..some).map(|part| {
            let [first, end] = [part, part + 1].map(|part| part * count / some);
            let place = Stream::new(seed ^ salts::HELD_OUT[0], part as u32, 0).uniform2(0).x;
            (first + (place * (end - first) as f32) as usize).min(end - 1)
        });
        let surfaces: Vec<Surface> = chosen.map(surface).collect();
        let points = surfaces.iter().map(|surface| lookup_point(world, surface)).collect();
        let gathered = Vec::new();
        let mut found = Self { gathered, surfaces, points, rays: FIRST_RAYS, light: 0.0, accuracy, traced: 0 };
        if light != MeanLight::Direct {
            found.gather(world, options, seed, watch)?;
        }
        let direct = match light {
            MeanLight::Total | MeanLight::Direct => found.direct(world, seed),
            MeanLight::Indirect => 0.0,
        };
        let sum: f64 = found.gathered.iter().flatten().map(|value| f64::from(value.element_sum())).sum();
        found.light = direct + sum / (6 * some.max(1)) as f64;
        // The variance of the mean of (x - a)(x - b) is about that of a and b, multiplied, over the number of points.
        let needed = found.variance() / (found.allowed_error().powi(2) * KNOWN_TO * (some as f64).sqrt());
        if needed > 1.0 {
            let rays = FIRST_RAYS as f64 * needed.log2().ceil().exp2();
            found.rays = rays.min(f64::from(MOST_RAYS)) as u32;
            found.gather(world, options, seed, watch)?;
        }
        Some(found)
    }

    /// The mean of light at the points, over all channels, in W/m².
    pub(crate) fn light(&self) -> f32 {
        self.light as f32
    }

    /// The requested root mean square error, in W/m².
    pub(crate) fn allowed_error(&self) -> f64 {
        self.accuracy * self.light
    }

    /// The root mean square error that a mean variance is, in W²/m⁴, relative to the mean.
    pub(crate) fn relative(&self, variance: f64) -> f32 {
        if self.light > 0.0 { (variance.sqrt() / self.light) as f32 } else { 0.0 }
    }

    /// Rays with which records that are gathered from `source` have their part of the requested error as the root mean
    /// square of their standard errors, and the rays that were traced to find that number; `None` if the watcher stops.
    pub(super) fn ray_budget(
        &self,
        world: &World,
        options: &CachedOptions,
        source: GatherSource,
        seed: u64,
        watch: &dyn Watch,
    ) -> Option<(RayBudget, u64)> {
        let gatherer = Gatherer::new(options.layout, FIRST_RAYS, false, seed ^ salts::HELD_OUT[0]);
        let points = self.gather_points();
        let gathers = points.par_chunks(CHUNK).map(|points| {
            if watch.stop() {
                return None;
            }
            let (found, rays) = gatherer.gather(world, points, &mut Follower::new(world, source, GATHER_FIRST_SET));
            watch.advance(0, rays);
            Some((found.iter().map(|found| f64::from(found.gather.standard_error)).sum::<f64>(), rays))
        });
        let gathers = gathers.collect::<Vec<_>>().into_iter().collect::<Option<Vec<(f64, u64)>>>()?;
        let (sum, traced) = gathers.iter().fold((0.0, 0), |(sum, all), (errors, rays)| (sum + errors, all + rays));
        let deviation = sum / points.len().max(1) as f64 * (gatherer.rays() as f64).sqrt();
        let allowed = (NOISE * self.allowed_error()).powi(2);
        // Without any light both are 0.
        let over_deviation = if deviation > 0.0 { deviation / allowed } else { 0.0 };
        let [fewest, most] = RAYS_OF_RECORDS;
        let first = (FIRST_PART * over_deviation * deviation).clamp(fewest, most).log2().round().exp2() as u32;
        Some((RayBudget { first, over_deviation: over_deviation as f32 }, traced))
    }

    /// The points as gathers take them.
    fn gather_points(&self) -> Vec<GatherPoint<'w>> {
        (0..).zip(&self.surfaces).map(|(key, &surface)| GatherPoint { key, surface }).collect()
    }

    /// The mean squared error of a cache's irradiance over points and channels, in W²/m⁴; 0 if noise alone makes it less.
    pub(crate) fn squared_error(&self, cache: &Cache) -> f64 {
        let square = |((surface, point), pair): ((&Surface, &LookupPoint), &[Vec3; 2])| {
            // Where there is no record, or none that sees what the point sees, a path is traced or a gather made.
            let found = cache.interpolate_tilted(point, surface.shading_normal)?.irradiance;
            let [a, b] = pair.map(|gathered| (found - gathered).as_dvec3());
            Some((a * b).element_sum() / 3.0)
        };
        let squares: Vec<f64> = self.surfaces.iter().zip(&self.points).zip(&self.gathered).filter_map(square).collect();
        (squares.iter().sum::<f64>() / squares.len().max(1) as f64).max(0.0)
    }

    /// The mean variance of a gather.
    fn variance(&self) -> f64 {
        self.gathered.iter().map(half_squared_difference).sum::<f64>() / self.gathered.len().max(1) as f64
    }

    fn gather(&mut self, world: &World, options: &CachedOptions, seed: u64, watch: &dyn Watch) -> Option<()> {
        let options = CachedOptions { rays: self.rays, ..*options };
        let points = self.gather_points();
        let gathers = points.par_chunks(CHUNK).map(|points| {
            if watch.stop() {
                return None;
            }
            let [(a, first), (b, second)] = salts::HELD_OUT.map(|salt| {
                DirectGatherer::new(world, &options, GatherSource::paths(&options), seed ^ salt).irradiance(points)
            });
            watch.advance(0, first + second);
            Some((a.into_iter().zip(b).map(|(a, b)| [a, b]).collect::<Vec<_>>(), first + second))
        });
        let gathers = gathers.collect::<Vec<_>>().into_iter().collect::<Option<Vec<_>>>()?;
        self.traced += gathers.iter().map(|(_, rays)| rays).sum::<u64>();
        self.gathered = gathers.into_iter().flat_map(|(pairs, _)| pairs).collect();
        Some(())
    }

    /// The mean of direct light.
    fn direct(&mut self, world: &World, seed: u64) -> f64 {
        let sample = |incident: &mut IncidentSampler, (number, surface): (u32, &Surface)| {
            let mut sum = Sum(DVec3::ZERO);
            let samples = (0..LIGHT_SAMPLES, 1.0 / LIGHT_SAMPLES as f32);
            let rays = incident.sample(world, &[*surface], (seed ^ salts::HELD_OUT[1], number), samples, &mut sum);
            (sum.0.element_sum() / 3.0, rays)
        };
        let numbered: Vec<(u32, &Surface)> = (0..).zip(&self.surfaces).collect();
        let found: Vec<(f64, u64)> = numbered.into_par_iter().map_init(IncidentSampler::default, sample).collect();
        self.traced += found.iter().map(|(_, rays)| rays).sum::<u64>();
        found.iter().map(|(light, _)| light).sum::<f64>() / found.len().max(1) as f64
    }
}

/// Half of the squared difference, as a mean over the channels: the variance of one of the two.
fn half_squared_difference([a, b]: &[Vec3; 2]) -> f64 {
    f64::from((*a - *b).length_squared()) / 6.0
}
