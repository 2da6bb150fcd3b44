//! Global illumination from an irradiance cache, in two passes: a *prefill* fills the cache, then it is frozen and the
//! picture is computed from it,
//!
//! `L = L_e + ρ/π (E_direct + E_indirect)`,
//!
//! with one sample of direct light at every point and indirect light from the records around. Mirrors and glass are
//! followed to the first surface that scatters light.
//!
//! A point without a valid record does not create one, as the picture would then depend on the order of its points: it
//! falls back on a path, which is unbiased but noisier. These fallbacks are counted.

mod clearance;
mod held_out;
mod irradiance_map;
mod level;
mod lookup;
mod prefill;
mod sites;
mod spacing;
mod to_accuracy;

use std::sync::atomic::{AtomicU64, Ordering};

use glam::Vec3;

use super::{RayBatch, Wavefront, path};
use crate::cache::{Cache, Interpolated, LookupPoint};
use crate::settings::{CachedOptions, PathOptions, Stop, Survival};
use crate::world::{Surface, World};

pub(crate) use clearance::lookup_point;
use clearance::lookup_point_anywhere;
pub(crate) use held_out::{HeldOut, MeanLight};
pub(crate) use irradiance_map::IrradianceMap;
pub(crate) use level::{DirectGatherer, Follower, GatherSource, RecordLog};
use level::{Level, NoLog};
pub(crate) use lookup::CacheMisses;
pub(crate) use prefill::{MANY_SITES, fill_for_camera, fill_for_surfaces, fill_for_texels};
pub(crate) use to_accuracy::{FillTarget, SAMPLED_SHARE};

/// Surfaces after which roulette starts on indirect paths. A gather has many paths, so a few long ones are enough.
const SURE_DEPTH: u32 = 1;
/// Their survival probability: of many paths for one mean, longer ones cost 5% of a bake and gain nothing.
const SURVIVAL: Survival = Survival::THROUGHPUT;

/// A cache that grows no more, and what happened while it was read.
#[derive(Debug)]
pub(crate) struct FrozenCache {
    pub(crate) cache: Cache,
    misses: AtomicU64,
    negative: AtomicU64,
}

/// Counts of lookups in a cache.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct CacheUse {
    /// Records in the cache.
    pub records: u64,
    /// Points without a valid record, for each of which a path was traced.
    pub misses: u64,
    /// Records whose extrapolation had a negative channel, which counted as 0.
    pub negative: u64,
}

impl FrozenCache {
    /// The frozen cache, not read yet.
    pub(crate) fn new(cache: Cache) -> Self {
        Self { cache, misses: AtomicU64::new(0), negative: AtomicU64::new(0) }
    }

    /// Indirect irradiance at a surface's point, on the side of its normal; `None` where no record is valid.
    pub(crate) fn irradiance(&self, world: &World, surface: &Surface) -> Option<Vec3> {
        self.irradiance_at(&lookup_point(world, surface), surface.shading_normal)
    }

    /// The same at a point for the unit normal that a map tilts its own to.
    pub(crate) fn irradiance_at(&self, point: &LookupPoint, tilted: Vec3) -> Option<Vec3> {
        self.count(self.cache.interpolate_tilted(point, tilted))
    }

    /// Like the above, but for pictures and means over many points: occluded regions contribute little, and where a
    /// surface turns within a few pixels, records with other normals are accepted.
    pub(crate) fn irradiance_about(&self, surface: &Surface) -> Option<Vec3> {
        let found = self.count(match self.cache.options().accuracy {
            Some(_) => self.cache.interpolate_tilted(&lookup_point_anywhere(surface), surface.shading_normal),
            None => self.cache.interpolate_wide(&lookup_point_anywhere(surface), surface.shading_normal),
        });
        found.map(|irradiance| irradiance / surface.seen_above())
    }

    fn count(&self, found: Option<Interpolated>) -> Option<Vec3> {
        // Sums of whole numbers do not depend on the order of threads.
        match &found {
            None => _ = self.misses.fetch_add(1, Ordering::Relaxed),
            Some(found) if found.negative > 0 => {
                self.negative.fetch_add(found.negative.into(), Ordering::Relaxed);
            }
            Some(_) => {}
        }
        found.map(|found| found.irradiance)
    }

    /// The counts so far.
    pub(crate) fn usage(&self) -> CacheUse {
        CacheUse {
            records: self.cache.records().len() as u64,
            misses: self.misses.load(Ordering::Relaxed),
            negative: self.negative.load(Ordering::Relaxed),
        }
    }
}

/// Writes the light reflected by surfaces along each ray, and the sky without its sun, by paths of at most `max_depth`
/// surfaces: everything except direct light for the surface that the rays leave, whose `density` is 0. Returns the
/// number of further rays.
pub(super) fn indirect(
    world: &World,
    max_depth: Option<u32>,
    rays: &RayBatch,
    wave: &mut Wavefront,
    radiance: &mut [Vec3],
) -> u64 {
    let defaults = PathOptions::default();
    let stop = Stop::Roulette { after: SURE_DEPTH, survival: SURVIVAL };
    let options = PathOptions { max_depth: max_depth.unwrap_or(defaults.max_depth), stop, ..defaults };
    path::radiance(world, &options, rays, wave, radiance, &mut |_| (), path::PathObservers::default())
}

/// Writes the radiance along each camera ray; gives the number of further rays.
pub(super) fn radiance(
    world: &World,
    frozen: &FrozenCache,
    batch: &RayBatch,
    wave: &mut Wavefront,
    misses: &mut CacheMisses,
    radiance: &mut [Vec3],
) -> u64 {
    let traced = lookup::radiance(world, frozen, batch, wave, misses, radiance);
    traced + misses.follow(world, batch, max_depth(frozen.cache.options()), wave, radiance)
}

/// The most surfaces on a path in place of a record: it has as many reflections as light before a record, and then
/// reaches the source.
pub(crate) fn max_depth(options: &CachedOptions) -> Option<u32> {
    options.bounces.map(|bounces| bounces + 1)
}

#[cfg(test)]
mod tests;
