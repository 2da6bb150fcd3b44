//! Fills one cache: gathers at the places of its records, with a given source of radiance at hits.

use std::collections::{HashMap, HashSet};

use halfdome_kernel::Ray;
use halfdome_kernel::sampling::Sampler;

use glam::Vec3;
use rayon::prelude::*;

use super::clearance::clearance;
use super::irradiance_map::{IrradianceMap, UnmappedHits};
use super::{CacheMisses, FrozenCache, indirect, irradiance_map, max_depth};
use crate::cache::{Bounds, Cache, Pass, Place, Record, bound};
use crate::estimator::{AdaptiveGatherer, Follow, GATHER_FIRST_SET, GatherPoint, Gathered, Gatherer};
use crate::integrator::{RayBatch, Wavefront};
use crate::settings::CachedOptions;
use crate::watch::Watch;
use crate::world::{Hit, World};

/// The source of light beyond the first surface.
#[derive(Clone, Copy)]
pub(crate) enum GatherSource<'a> {
    /// Paths, of at most this many surfaces or as many as chance lets them have.
    Paths(Option<u32>),
    /// A cache of light with one reflection less.
    Cache(&'a FrozenCache),
    /// A source of all light on surfaces.
    Map(&'a dyn IrradianceMap),
}

/// A cache that is being filled.
pub(super) struct Level<'a> {
    pub(crate) world: &'a World,
    pub(crate) options: &'a CachedOptions,
    pub(crate) source: GatherSource<'a>,
    pub(crate) gatherer: AdaptiveGatherer,
    /// The gatherer of outlier records, if any.
    pub(crate) careful: Option<AdaptiveGatherer>,
    /// The error that records are made with; they reach as far as by that of the options.
    pub(crate) made_with: f32,
    pub(crate) watch: &'a dyn Watch,
    pub(crate) log: &'a dyn RecordLog,
}

/// Keeps records that are made while a cache is filled, so that interrupted work can resume. As the places of records
/// follow from earlier records, refilling a cache with known records instead of gathers gives the same cache.
pub(crate) trait RecordLog: Sync {
    /// The record with this key, if it was made before, with its radii as they were not bounded yet.
    fn get(&self, key: u64) -> Option<Record>;
    /// Takes note of a new record. Called from all threads.
    fn put(&self, record: &Record);
}

/// Knows nothing, and keeps nothing.
pub(super) struct NoLog;

impl RecordLog for NoLog {
    fn get(&self, _: u64) -> Option<Record> {
        None
    }

    fn put(&self, _: &Record) {}
}

/// Gathers for points that have no cache.
pub(crate) struct DirectGatherer<'a> {
    world: &'a World,
    gatherer: Gatherer,
    source: GatherSource<'a>,
}

impl<'a> DirectGatherer<'a> {
    /// Gathers as records of a cache with these options are made.
    pub(crate) fn new(world: &'a World, options: &CachedOptions, source: GatherSource<'a>, seed: u64) -> Self {
        Self { world, gatherer: Gatherer::new(options.layout, options.rays, false, seed), source }
    }

    /// Irradiance at points, in their order, and the number of rays.
    pub(crate) fn irradiance(&self, points: &[GatherPoint]) -> (Vec<Vec3>, u64) {
        let mut follower = Follower::new(self.world, self.source, GATHER_FIRST_SET);
        let (found, rays) = self.gatherer.gather(self.world, points, &mut follower);
        (found.into_iter().map(|found| found.gather.irradiance).collect(), rays)
    }
}

impl GatherSource<'_> {
    /// The paths of a cache with these options: they include the gather's hit and the light.
    pub(crate) fn paths(options: &CachedOptions) -> Self {
        Self::Paths(max_depth(options))
    }
}

/// A point that may get a record.
#[derive(Clone, Copy, Debug)]
pub(super) struct RecordSite<'w> {
    pub(crate) point: GatherPoint<'w>,
    pub(crate) place: Place,
    /// The bounds of radii for the error of records.
    pub(crate) bounds: Bounds,
    /// No lower bound is less, whatever the error.
    pub(crate) floor: f32,
}

/// The side of the square in which an error of 1 may be, as a part of the scene's diagonal. It makes the Hessian's radii
/// in the Cornell box about as good as those of the other metrics with the same error.
const HESSIAN_EXTENT: f32 = 0.02;
/// Mean distances of what a record sees within which the scene matters.
const SURROUNDINGS: f32 = 16.0;
/// The number of passes over outlier records.
const ROUNDS_AGAIN: usize = 3;
/// Gathers that a thread takes at once.
const GATHERS: usize = 2;

impl Level<'_> {
    /// Adds records to `cache` until each site is covered, and gathers outliers again, or until the watcher stops;
    /// returns the rays traced.
    pub(crate) fn fill(&self, cache: &mut Cache, sites: &[RecordSite], passes: &[Pass]) -> u64 {
        let mut traced = self.cover(cache, sites, passes);
        let Some(gatherer) = &self.careful else { return traced };
        let by_key: HashMap<u64, usize> = (0..).zip(sites).map(|(i, site)| (site.point.key, i)).collect();
        let mut again = HashSet::new();
        for _ in 0..ROUNDS_AGAIN {
            let doubtful = cache.doubtful(&again);
            again.extend(&doubtful);
            // Others were in the cache before, for other sites.
            let picks: Vec<usize> = doubtful.iter().filter_map(|key| by_key.get(key).copied()).collect();
            if picks.is_empty() {
                break;
            }
            // The log has them as they were at first, as what doubts them follows from that.
            let Some((records, rays)) = self.gather(gatherer, sites, &picks, &NoLog) else { return traced };
            traced += rays;
            cache.replace(records);
        }
        // The new records may reach less far.
        if again.is_empty() { traced } else { traced + self.cover(cache, sites, &passes[passes.len() - 1..]) }
    }

    /// Adds records until each site is covered.
    fn cover(&self, cache: &mut Cache, sites: &[RecordSite], passes: &[Pass]) -> u64 {
        let places: Vec<Place> = sites.iter().map(|site| site.place).collect();
        let mut traced = 0;
        cache.fill(&places, passes, |picks, covered| {
            self.watch.covered(covered as u64);
            let known = |&i: &usize| Some(self.fit(self.log.get(sites[i].point.key)?, &sites[i]));
            let mut records: Vec<Option<Record>> = picks.iter().map(known).collect();
            let new: Vec<(usize, usize)> =
                (0..).zip(picks).filter(|&(place, _)| records[place].is_none()).map(|(place, &i)| (place, i)).collect();
            let picks: Vec<usize> = new.iter().map(|&(_, i)| i).collect();
            // A round counts as a whole, or where it ended would show.
            let (made, rays) = self.gather(&self.gatherer, sites, &picks, self.log)?;
            traced += rays;
            new.iter().zip(made).for_each(|(&(place, _), record)| records[place] = Some(record));
            records.into_iter().collect()
        });
        traced
    }

    /// The records of sites by their numbers, and the rays traced; `None` if the watcher stops.
    fn gather(
        &self,
        gatherer: &AdaptiveGatherer,
        sites: &[RecordSite],
        picks: &[usize],
        log: &dyn RecordLog,
    ) -> Option<(Vec<Record>, u64)> {
        let gathers = picks.par_chunks(GATHERS).map(|picks| {
            if self.watch.stop() {
                return None;
            }
            let points: Vec<GatherPoint> = picks.iter().map(|&i| sites[i].point.smooth()).collect();
            let mut follower = Follower::new(self.world, self.source, GATHER_FIRST_SET);
            let (found, rays) = gatherer.gather(self.world, &points, &mut follower);
            let records = picks.iter().zip(found).map(|(&i, found)| {
                let record = self.record(&sites[i], &found);
                log.put(&record);
                self.fit(record, &sites[i])
            });
            let records: Vec<Record> = records.collect();
            self.watch.advance(0, rays);
            self.watch.gathered(records.len() as u64);
            Some((records, rays))
        });
        let gathers = gathers.collect::<Vec<_>>().into_iter().collect::<Option<Vec<_>>>()?;
        let rays = gathers.iter().map(|(_, rays)| rays).sum();
        Some((gathers.into_iter().flat_map(|(records, _)| records).collect(), rays))
    }

    /// The allowed relative error of an ellipse, times its area (Jarosz et al. bound the error that is integrated over
    /// it). The fourth power makes radii proportional to the error, as those of the other metrics are; the scene's
    /// extent makes them scale with the scene, as far as the record sees much of it.
    fn area_error(&self, mean_distance: f32) -> f32 {
        let scale = self.world.diagonal().min(SURROUNDINGS * mean_distance);
        let extent = HESSIAN_EXTENT * self.made_with * self.made_with * scale;
        extent * extent
    }

    /// The record of what a gather found, whose radii have no bounds yet.
    fn record(&self, site: &RecordSite, found: &Gathered) -> Record {
        let Gathered { gather, hessian, occluders } = found;
        let surface = &site.point.surface.smooth();
        // A point that sees nothing, or only distant surfaces, has a radius of the scene's extent.
        let mean_distance = gather.harmonic_mean_distance.min(occluders.clearance).min(self.world.diagonal());
        // Rays meet surfaces, but not where these are nearest; the planes of occluders do.
        let occluders = occluders.occluders();
        let min_distance = occluders.into_iter().fold(gather.minimum_distance.min(mean_distance), f32::min);
        let mut record = Record {
            key: site.point.key,
            position: surface.position,
            normal: surface.shading_normal,
            // Differences to a map may be negative.
            irradiance: gather.irradiance.max(Vec3::ZERO),
            standard_error: gather.standard_error,
            rotational: gather.rotational,
            translational: gather.translational,
            mean_distance,
            min_distance,
            radii: [self.made_with * mean_distance; 2],
            axis: surface.frame().tangent,
            occluders,
            clearance: site.place.point.clearance.unwrap_or_else(|| clearance(self.world, surface)),
        };
        if let Some(hessian) = hessian {
            let ellipse = hessian.radii(self.area_error(mean_distance)).to_world(&surface.frame());
            (record.axis, record.radii) = (ellipse.axes[0], ellipse.radii);
        }
        record
    }

    /// A record with the radii that it has in a cache with these options.
    fn fit(&self, mut record: Record, site: &RecordSite) -> Record {
        // Exactly 1 unless an accuracy is asked for.
        let scale = self.options.error / self.made_with;
        record.radii = record.radii.map(|radius| scale * radius);
        let lower = (scale * site.bounds.lower).max(site.floor);
        bound(&mut record, self.options, Bounds { lower, ..site.bounds });
        record
    }
}

/// Follows rays that were sent or aimed from points.
pub(crate) struct Follower<'a> {
    world: &'a World,
    source: GatherSource<'a>,
    first_set: u32,
    scratch: (Wavefront, CacheMisses, UnmappedHits),
}

impl<'a> Follower<'a> {
    /// By what a source knows of their light, with the sets of random numbers from this one on.
    pub(crate) fn new(world: &'a World, source: GatherSource<'a>, first_set: u32) -> Self {
        Self { world, source, first_set, scratch: Default::default() }
    }
}

impl Follow for Follower<'_> {
    fn follow(&mut self, rays: &[Ray], hits: &[Hit], samplers: &[Sampler], radiance: &mut [Vec3]) -> u64 {
        let batch = RayBatch { rays, hits, samplers, times: &[], first_set: self.first_set, density: 0.0 };
        let (wave, misses, unmapped) = &mut self.scratch;
        match self.source {
            GatherSource::Paths(max_depth) => indirect(self.world, max_depth, &batch, wave, radiance),
            GatherSource::Cache(frozen) => super::radiance(self.world, frozen, &batch, wave, misses, radiance),
            GatherSource::Map(map) => irradiance_map::radiance(self.world, map, &batch, wave, unmapped, radiance),
        }
    }
}
