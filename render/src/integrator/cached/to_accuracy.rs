//! Fills a cache so that its irradiance has the requested error.
//!
//! An error has two parts. Noise is controlled per record: each is gathered with as many rays as its own standard error
//! requires ([`AdaptiveGatherer`](crate::estimator::AdaptiveGatherer)). Radii are found by trial: a cache of few records
//! is filled, and held-out points estimate its error ([`HeldOut`]); while that is too large, the next cache has smaller
//! radii. As radii are proportional to one number, records of earlier caches are reused where their points are picked
//! again.
//!
//! Caches over whose records gathers take means have a fixed number of rays a record: rays by their noise would bias what
//! all gathers see, as records that have missed the light look as if they had little noise.
//!
//! Errors at single points, away from all held-out points, are not detected.

use std::collections::BTreeMap;
use std::sync::{Mutex, MutexGuard, PoisonError};

use super::{HeldOut, RecordLog};
use crate::cache::{Cache, ErrorEstimate, Record};
use crate::settings::CachedOptions;
use crate::watch::Watch;

/// The error of the options with which the first cache is filled for 1%; for other accuracies it scales with their
/// root. Few held-out points are where interpolation is worst, so the first cache must be good enough.
const FIRST_ERROR: f32 = 0.3;
/// The least and the greatest error of a first cache.
const FIRST_ERRORS: [f32; 2] = [0.15, 0.6];
/// The part of the mean squared error that light may have which is sampled at each point; the rest is for the cache's.
pub(crate) const SAMPLED_SHARE: f64 = 0.3;
/// The most caches that are tried, ...
const MOST_CACHES: u32 = 6;
/// ... and the part of its squared error that a cache must have lost if another is to be tried.
const LEAST_GAIN: f64 = 0.1;
/// The factors by which records may come to reach less far at once.
const FACTORS: [f64; 2] = [0.5, 0.85];

/// The accuracy of records.
#[derive(Clone, Copy, Debug)]
pub(crate) enum FillTarget<'a> {
    /// As their options make them, the doubtful ones with more rays.
    Options,
    /// As their options make them.
    Means,
    /// So that the cache has the accuracy of its options at the points that were held out.
    Accuracy(&'a HeldOut<'a>),
}

/// The error of the records of a cache with these options. Their radii are smaller if the cache's are.
pub(super) fn made_with(options: &CachedOptions) -> f32 {
    match options.accuracy {
        Some(accuracy) => (FIRST_ERROR * (100.0 * accuracy).sqrt()).clamp(FIRST_ERRORS[0], FIRST_ERRORS[1]),
        None => options.error,
    }
}

/// Fills caches like `cache`, which is empty or is added to, by `fill_one`, until one is accurate enough; returns the
/// last of them, with its estimated error, and the rays traced.
pub(super) fn fill(
    mut cache: Cache,
    held_out: &HeldOut,
    log: &dyn RecordLog,
    watch: &dyn Watch,
    fill_one: impl Fn(&CachedOptions, &mut Cache, &dyn RecordLog) -> u64,
) -> (Cache, u64) {
    let is_begun = !cache.records().is_empty();
    let log = Memory { log, records: Mutex::default() };
    let light = held_out.light();
    let asked = (1.0 - SAMPLED_SHARE) * held_out.allowed_error().powi(2);
    let (mut error, mut traced, mut before) = (made_with(cache.options()), 0, f64::INFINITY);
    for number in 1.. {
        if !is_begun {
            cache = cache.with_error(error, ErrorEstimate { light, root_mean_square: 0.0 });
        }
        let options = *cache.options();
        traced += fill_one(&options, &mut cache, &log);
        if watch.stop() {
            break;
        }
        let squared = held_out.squared_error(&cache);
        let root_mean_square = if light > 0.0 { squared.sqrt() as f32 / light } else { 0.0 };
        cache.set_estimate(ErrorEstimate { light, root_mean_square });
        let is_stuck = squared > (1.0 - LEAST_GAIN) * before;
        if is_begun || squared <= asked || is_stuck || number == MOST_CACHES {
            break;
        }
        before = squared;
        error *= (asked / squared).sqrt().clamp(FACTORS[0], FACTORS[1]) as f32;
    }
    (cache, traced)
}

/// Remembers records, besides what another log does.
struct Memory<'a> {
    log: &'a dyn RecordLog,
    records: Mutex<BTreeMap<u64, Record>>,
}

impl Memory<'_> {
    fn records(&self) -> MutexGuard<'_, BTreeMap<u64, Record>> {
        // Records are put in whole, whatever happened to a thread.
        self.records.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl RecordLog for Memory<'_> {
    fn get(&self, key: u64) -> Option<Record> {
        let known = self.records().get(&key).copied();
        known.or_else(|| self.log.get(key))
    }

    fn put(&self, record: &Record) {
        self.records().insert(record.key, *record);
        self.log.put(record);
    }
}
