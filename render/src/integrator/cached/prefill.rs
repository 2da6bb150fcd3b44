//! The prefill: fills a cache for the surfaces that a camera sees, coarse to fine, or for given points.
//!
//! Where many points have no record yet, a cache of fewer rays a record is filled first, from paths, and the hits of
//! the gathers' rays look up indirect light in it, as paths would add most of the noise. Few points gather from paths
//! directly.
//!
//! With a number of bounces instead of paths each bounce has a cache, and the deepest is filled first: the cache of one
//! reflection gathers direct light alone, each other one direct light and the cache before it. A deeper cache is needed
//! where the gathers' rays end, so its sites are found by rays from the sites above.

use rayon::prelude::*;

use super::clearance::lookup_point;
use super::level::RecordSite;
use super::sites::{camera_sites, deeper_sites, point_passes, point_sites};
use super::to_accuracy::{self, FillTarget};
use super::{FrozenCache, GatherSource, HeldOut, Level, MeanLight, NoLog, RecordLog};
use crate::cache::{Bounds, Cache, Pass, Place};
use crate::estimator::{AdaptiveGatherer, GatherPoint, Gatherer, RayBudget, salts};
use crate::settings::{CachedOptions, Gradients, Metric, Settings};
use crate::watch::Watch;
use crate::world::{Surface, World};

/// The fewest texels of a lightmap, over the error, ...
const LEAST_TEXELS: f32 = 5.0;
/// ... whatever the error is: then each texel may have a record, ...
const LEAST_FOR_ALL: f32 = 0.75;
/// ... and the most.
const MOST_TEXELS: f32 = 40.0;
/// The fewest units that a record reaches, over the error: for sensors ...
const SENSOR_UNITS: f32 = 10.0;
/// ... and for deeper caches, over which the gathers above take means.
const DEEPER_UNITS: f32 = 40.0;
/// From this many sites without a record on gathers use another cache instead of paths ...
pub(crate) const MANY_SITES: usize = 1024;
/// ... whose records have this many times fewer rays, as a gather averages over many of them, ...
const FEWER: u32 = 5;
/// ... and reach this many times as far, ...
const FARTHER: f32 = 2.0;
/// ... but not by more than this error: few records far apart would bias what all gathers see.
const COARSEST: f32 = 0.5;
/// Records that are doubtful get so many times more rays ...
const MORE: u32 = 8;
/// ... but no more than these.
const MOST_RAYS: u32 = 1 << 16;

/// Adds to `cache` the records that a camera needs, and freezes it; returns the rays traced. If the cache's options
/// have an accuracy, it is filled to it.
pub(crate) fn fill_for_camera(
    world: &World,
    settings: &Settings,
    cache: Cache,
    watch: &dyn Watch,
) -> (FrozenCache, u64) {
    let camera = world.camera_on(settings.width, settings.height);
    let error = to_accuracy::made_with(cache.options());
    let (sites, passes, rays) = camera_sites(world, settings, &camera, error);
    let mut aim = FillTarget::Options;
    let held_out;
    if cache.options().accuracy.is_some() {
        let points = (sites.len(), |i: usize| sites[i].point.surface);
        match HeldOut::new(world, cache.options(), points, MeanLight::Total, settings.seed, watch) {
            Some(found) => held_out = found,
            None => return (FrozenCache::new(cache), rays),
        }
        aim = FillTarget::Accuracy(&held_out);
    }
    let prefill = Prefill { world, seed: settings.seed, source: None, aim, log: &NoLog, watch };
    let (frozen, traced) = prefill.fill(cache, &sites, &passes);
    (frozen, rays + traced)
}

/// Adds to `cache` what given points need, and freezes it; gives the rays traced.
pub(crate) fn fill_for_surfaces(
    world: &World,
    seed: u64,
    cache: Cache,
    surfaces: &[Surface],
    aim: FillTarget,
    watch: &dyn Watch,
) -> (FrozenCache, u64) {
    let least_units = SENSOR_UNITS * to_accuracy::made_with(cache.options());
    let sites = point_sites(world, surfaces, 0, least_units, 1);
    let prefill = Prefill { world, seed, source: None, aim, log: &NoLog, watch };
    prefill.fill(cache, &sites, &point_passes(sites.len()))
}

/// Adds to `cache` the records that the texels of a lightmap need, and freezes it; returns the rays traced. Each is a
/// surface with the width of a texel there. Light comes from `source`, unless the cache has a number of bounces.
pub(crate) fn fill_for_texels<'w>(
    world: &'w World,
    seed: u64,
    cache: Cache,
    texels: &[(Surface<'w>, f32)],
    (source, aim): (GatherSource, FillTarget),
    log: &dyn RecordLog,
    watch: &dyn Watch,
) -> (FrozenCache, u64) {
    let least_texels = LEAST_TEXELS * to_accuracy::made_with(cache.options());
    let site = |(number, &(surface, spacing)): (usize, &(Surface<'w>, f32))| RecordSite {
        point: GatherPoint { key: number as u64, surface },
        place: Place { point: lookup_point(world, &surface), spacing },
        bounds: Bounds { lower: least_texels * spacing, upper: MOST_TEXELS * spacing },
        floor: LEAST_FOR_ALL.min(least_texels) * spacing,
    };
    let sites: Vec<RecordSite> = texels.par_iter().enumerate().map(site).collect();
    Prefill { world, seed, source: Some(source), aim, log, watch }.fill(cache, &sites, &point_passes(sites.len()))
}

/// The source of light for caches.
struct Prefill<'a> {
    world: &'a World,
    seed: u64,
    /// The source of light, unless a cache has a number of bounces; by default paths or another cache.
    source: Option<GatherSource<'a>>,
    aim: FillTarget<'a>,
    log: &'a dyn RecordLog,
    watch: &'a dyn Watch,
}

impl Prefill<'_> {
    /// Fills `cache` from the source, or from caches of one, two, three reflections in turn.
    fn fill(&self, mut cache: Cache, sites: &[RecordSite], passes: &[Pass]) -> (FrozenCache, u64) {
        let Self { world, seed, source, .. } = *self;
        let options = *cache.options();
        let mut traced = 0;
        let mut below: Option<FrozenCache> = None;
        let mut paths = source.unwrap_or(GatherSource::Paths(None));
        if let Some(bounces) = options.bounces {
            // Sites from the surface down; the first that are needed are found last.
            let mut deeper: Vec<Vec<RecordSite>> = Vec::new();
            for level in 1..bounces {
                let above = deeper.last().map_or(sites, Vec::as_slice);
                deeper.push(deeper_sites(world, above, seed, level, DEEPER_UNITS * options.error));
            }
            // One reflection of direct light: the surface that the gather sees, and the light.
            paths = GatherSource::Paths(Some(2));
            for (reflections, sites) in (1..).zip(deeper.iter().rev()) {
                let options = CachedOptions { bounces: Some(reflections), accuracy: None, ..options };
                let mut cache = Cache::new(options, world.surroundings_hash()).rough();
                let source = below.as_ref().map_or(paths, GatherSource::Cache);
                traced +=
                    self.level(None, &options, source, &NoLog).fill(&mut cache, sites, &point_passes(sites.len()));
                below = Some(FrozenCache::new(cache));
            }
        } else if source.is_none() {
            let is_open = |site: &&RecordSite| !cache.covers(&site.place.point);
            if sites.par_iter().filter(is_open).count() >= MANY_SITES {
                let options = self::below(&options);
                let sites = deeper_sites(world, sites, seed, 1, SENSOR_UNITS * options.error);
                let mut cache = Cache::new(options, world.surroundings_hash()).rough();
                let level = self.level(None, &options, paths, &NoLog);
                traced += level.fill(&mut cache, &sites, &point_passes(sites.len()));
                below = Some(FrozenCache::new(cache));
            }
        }
        let source = below.as_ref().map_or(paths, GatherSource::Cache);
        let (cache, rays) = match self.aim {
            FillTarget::Accuracy(held_out) => {
                let budget = held_out.ray_budget(world, &options, source, seed, self.watch);
                let Some((budget, rays)) = budget else { return (FrozenCache::new(cache), traced) };
                traced += rays;
                to_accuracy::fill(cache, held_out, self.log, self.watch, |options, cache, log| {
                    self.level(Some(budget), options, source, log).fill(cache, sites, passes)
                })
            }
            FillTarget::Options | FillTarget::Means => {
                let level = self.level(None, &options, source, self.log);
                let rays = Level { careful: self.careful(&options), ..level }.fill(&mut cache, sites, passes);
                (cache, rays)
            }
        };
        (FrozenCache::new(cache), traced + rays)
    }

    /// What fills a cache of these options with light from a source, with as many rays as a budget says, if there is one.
    fn level<'l>(
        &'l self,
        budget: Option<RayBudget>,
        options: &'l CachedOptions,
        source: GatherSource<'l>,
        log: &'l dyn RecordLog,
    ) -> Level<'l> {
        let Self { world, seed, watch, .. } = *self;
        let (layout, with_hessian) = (options.layout, options.metric == Metric::Hessian);
        let gatherer = match budget {
            None => Gatherer::new(layout, options.rays, with_hessian, seed).into(),
            Some(budget) => AdaptiveGatherer::new(budget, layout, with_hessian, seed),
        };
        Level {
            world,
            options,
            source,
            gatherer,
            careful: None,
            made_with: to_accuracy::made_with(options),
            watch,
            log,
        }
    }

    /// The gatherer of outlier records of a cache with these options; none with an accuracy, as each record is then
    /// accurate enough.
    fn careful(&self, options: &CachedOptions) -> Option<AdaptiveGatherer> {
        let rays = (MORE * options.rays).min(MOST_RAYS);
        let with_hessian = options.metric == Metric::Hessian;
        (matches!(self.aim, FillTarget::Options) && rays > options.rays)
            .then(|| Gatherer::new(options.layout, rays, with_hessian, self.seed ^ salts::AGAIN).into())
    }
}

/// The options of the cache from which the records of a cache with `options` are gathered.
fn below(options: &CachedOptions) -> CachedOptions {
    CachedOptions {
        error: options.error.max(COARSEST.min(FARTHER * options.error)),
        rays: (options.rays / FEWER).max(CachedOptions::MIN_RAYS),
        metric: Metric::Hessian,
        gradients: Gradients::Both,
        accuracy: None,
        ..*options
    }
}
