//! Integrators: the radiance of camera rays.
//!
//! All rays of a tile advance together. The driver traces the camera rays; an integrator gets their hits, and traces
//! what it needs further in batches.

mod ao;
mod cached;
mod direct;
mod emission;
mod flat;
mod heat;
mod heat_lights;
mod light_paths;
mod media;
mod montecarlo;
mod panes;
mod path;
mod path_block;
mod path_tree;
mod shadow_queue;
mod state;
mod training;
mod unmatched_labels;
mod wavefront;

use glam::Vec3;
use halfdome_kernel::Ray;
use halfdome_kernel::sampling::Sampler;

use crate::cache::Cache;
use crate::guide::Guide;
use crate::settings::{Integrator, PathOptions, Settings};
use crate::watch::Watch;
use crate::world::{Hit, World};

pub use cached::CacheUse;
pub(crate) use cached::{
    DirectGatherer, FillTarget, Follower, FrozenCache, GatherSource, HeldOut, IrradianceMap, MANY_SITES, MeanLight,
    RecordLog, SAMPLED_SHARE, fill_for_camera, fill_for_surfaces, fill_for_texels, lookup_point, max_depth,
};
pub(crate) use light_paths::{LightPaths, aovs, labels_hash};
pub(crate) use unmatched_labels::unmatched_labels;
pub(crate) use wavefront::Wavefront;

/// Camera rays that are traced together, with unit directions, and their hits.
pub(crate) struct RayBatch<'a> {
    pub rays: &'a [Ray],
    pub hits: &'a [Hit],
    /// The numbers of each ray's sample, all of one pattern and seed; sets from [`first_set`](Self::first_set) on are the
    /// integrator's.
    pub samplers: &'a [Sampler],
    /// When each ray is sent, if anything moves.
    pub times: &'a [f32],
    pub first_set: u32,
    /// The density per solid angle with which the rays' directions were chosen: infinite for the camera's, which no
    /// light sample competes with; 0 for rays whose own light counts elsewhere.
    pub density: f32,
}

/// Memory that an integrator reuses between batches.
#[derive(Default)]
pub(crate) struct Scratch {
    wave: Wavefront,
    recorded: path::RecorderMemory,
    generations: [montecarlo::Generation; 2],
    ao_rays: ao::AoRays,
    misses: cached::CacheMisses,
}

/// Data that an integrator prepares once, before the first sample.
pub(crate) enum Prepared {
    /// Nothing.
    Nothing,
    /// A frozen irradiance cache.
    Cache(FrozenCache),
    /// The guide of paths.
    Guide(Guide),
}

impl Prepared {
    /// A cache that is to be read as it is.
    pub(crate) fn frozen(cache: Cache) -> Self {
        Self::Cache(FrozenCache::new(cache))
    }
}

/// The first set of random numbers of integrators.
pub(crate) const FIRST_SET: u32 = 1;
/// The sets that place a sample on the film, on the lens and in the time that the shutter is open: no integrator uses them, so
/// that a lens changes no other number.
pub(crate) const FILM_SET: u32 = 0;
pub(crate) const LENS_SET: u32 = u32::MAX;
pub(crate) const TIME_SET: u32 = u32::MAX - 1;

/// Makes what the integrator needs before the first sample; a cache from before goes into it. Gives the rays traced.
pub(crate) fn prepare(world: &World, settings: &Settings, cache: Option<Cache>, watch: &dyn Watch) -> (Prepared, u64) {
    match &settings.integrator {
        Integrator::Cached(options) => {
            let cache = cache.unwrap_or_else(|| Cache::new(*options, world.surroundings_hash()));
            let (frozen, rays) = fill_for_camera(world, settings, cache, watch);
            (Prepared::Cache(frozen), rays)
        }
        Integrator::Path(options) => match options.guide {
            Some(paths) => {
                let (guide, rays) = training::train(world, settings, options, paths);
                (guide.map_or(Prepared::Nothing, Prepared::Guide), rays)
            }
            None => (Prepared::Nothing, 0),
        },
        _ => (Prepared::Nothing, 0),
    }
}

/// Writes the radiance along each ray, found by paths; gives the number of further rays traced.
pub(crate) fn radiance_by_paths(
    world: &World,
    options: &PathOptions,
    rays: &RayBatch,
    wave: &mut Wavefront,
    radiance: &mut [Vec3],
) -> u64 {
    path::radiance(world, options, rays, wave, radiance, &mut |_| (), path::PathObservers::default())
}

/// Writes the radiance that each camera ray sees, and the AOVs of these light paths, side by side for each ray; gives the
/// number of further rays traced.
pub(crate) fn radiance(
    world: &World,
    settings: &Settings,
    prepared: &Prepared,
    batch: &RayBatch,
    scratch: &mut Scratch,
    radiance: &mut [Vec3],
    light: Option<(&LightPaths, &mut [Vec3])>,
) -> u64 {
    let Scratch { wave, recorded, generations, ao_rays, misses } = scratch;
    if let Prepared::Cache(frozen) = prepared {
        return cached::radiance(world, frozen, batch, wave, misses, radiance);
    }
    match &settings.integrator {
        Integrator::Path(options) => {
            let count = batch.rays.len();
            let recorder = light.map(|(paths, aovs)| path::Recorder::new(paths, recorded, count, aovs));
            let guide = if let Prepared::Guide(guide) = prepared { Some(guide) } else { None };
            let companions = path::PathObservers { recorder, guide, trainer: None };
            path::radiance(world, options, batch, wave, radiance, &mut |_| (), companions)
        }
        Integrator::Cached(_) => unreachable!("its cache is prepared"),
        Integrator::MonteCarlo(options) => montecarlo::radiance(world, options, batch, generations, radiance),
        Integrator::Direct(options) => direct::radiance(world, options, batch, wave, radiance),
        Integrator::Ao(options) => ao::radiance(world, options, batch, ao_rays, radiance),
        Integrator::Flat => flat::colors(world, batch, radiance),
        Integrator::Heat(options) => heat::visits(world, options, batch, wave, radiance),
        Integrator::HeatLights => heat_lights::colors(world, batch, wave, radiance),
        Integrator::Normals => flat::normals(world, batch, radiance),
        Integrator::Albedo => flat::albedo(world, batch, radiance),
    }
}
