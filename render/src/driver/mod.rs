//! Runs an integrator over the tiles of a picture on all threads, and reports to a watcher.
//!
//! Samples are taken in waves over the whole picture: first one a pixel, which cannot be stopped unless the watcher
//! gives up the picture, then as many as there are already, so that a stopped render leaves a picture without holes.
//! The first wave can be watched from coarse to fine. The film's sums do not depend on the order of the samples, so the
//! picture does not depend on tiles, waves, threads, shares or interruptions.

mod features;
mod frame;
mod history;
mod levels;
mod mattes;
mod motion_vectors;
mod option_names;
mod plan;
mod worker;

use std::time::{Duration, Instant};

use rayon::prelude::*;

use crate::cache::Cache;
use crate::film::{Film, FilmError, Picture, Tile};
use crate::integrator::{self, FrozenCache, LightPaths, Prepared};
use crate::settings::Settings;
use crate::world::{RayCounts, World};
use frame::{FrameRender, TileScratch};

pub use crate::integrator::CacheUse;
pub use crate::watch::{MAX_PREVIEW_SIDE, Watch};
pub use history::{LightPath, SampleHistory, pixel_history};
pub use plan::{Plan, film_header};
pub use worker::{Step, TileWorker};

/// The result of a render.
#[derive(Clone, Debug)]
pub struct Render {
    /// The picture, complete or as far as it went.
    pub picture: Picture,
    /// The sums that the picture is made of.
    pub film: Film,
    /// Whether it ran to its end.
    pub finished: bool,
    /// Whether the requested error is reached in the whole picture; true if none was requested.
    pub is_precise: bool,
    /// Rays traced.
    pub rays: u64,
    /// The same by their kinds.
    pub rays_by_kind: RaysByKind,
    /// Wall-clock time.
    pub elapsed: Duration,
    /// The use of the irradiance cache, if there was one.
    pub cache: Option<CacheUse>,
    /// An estimate of the cache's root mean square error, relative to the mean irradiance, if an accuracy was
    /// requested.
    pub cache_error: Option<f32>,
}

/// How many rays of each kind were traced; they sum to all.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RaysByKind {
    /// Before the first sample: those that fill an irradiance cache, or train a guide.
    pub preparation: u64,
    /// Camera rays.
    pub camera: u64,
    /// Rays from surfaces to the nearest hit.
    pub bounce: u64,
    /// Occlusion rays from surfaces: to lights, and those of ambient occlusion.
    pub shadow: u64,
}

impl RaysByKind {
    fn of(all: u64, preparation: u64, sampled: RayCounts) -> Self {
        let RayCounts { side_by_side: camera, occlusion: shadow } = sampled;
        Self { preparation, camera, bounce: all.saturating_sub(preparation + camera + shadow), shadow }
    }
}

/// Approximate number of a tile's camera rays that are traced together: enough to fill batches, few enough to stay in
/// the cache.
const BATCH: usize = 4096;

/// Renders on the threads of the current rayon pool. The picture depends on `world` and `settings` alone.
///
/// # Panics
/// If the settings' light path expressions are too complex, which [`render_plan`] tells.
pub fn render(world: &World, settings: &Settings, watch: &dyn Watch) -> Render {
    match render_plan(world, settings, Plan::default(), watch) {
        Ok(render) => render,
        Err(error) => panic!("there is no film to be wrong: {error}"),
    }
}

/// Like [`render`], but only the plan's part of the picture.
///
/// # Errors
/// If the plan's film is not of this picture, or has other samples than the plan's; if these begin at the end; if the
/// light path expressions are too complex.
pub fn render_plan(world: &World, settings: &Settings, mut plan: Plan, watch: &dyn Watch) -> Result<Render, FilmError> {
    let start = Instant::now();
    let header = film_header(world, settings, plan.cache.as_ref());
    let mut film = plan.begin(header, settings.spp)?;
    let light_paths = LightPaths::new(world, &integrator::aovs(world, settings)).map_err(FilmError::from)?;
    let (prepared, prefill_rays) = integrator::prepare(world, settings, plan.cache.take(), watch);
    let renderer =
        Renderer { world, frame: FrameRender::new(world, settings.clone(), prepared, light_paths), plan: &plan, watch };
    let before = film.seconds;
    let counts_before = world.ray_counts();
    let mut rays = prefill_rays;
    if !film.has_first_samples(|number| plan.shard.has(number)) {
        rays += renderer.first_wave(&mut film, start);
    }
    let level = film.header.level;
    let mut is_done: Vec<bool> = film.tiles.iter().map(|tile| plan.is_enough(tile, level, settings.spp)).collect();
    loop {
        let is_open = |tile: &(usize, &Tile)| plan.shard.has(tile.0) && !is_done[tile.0];
        let open = film.tiles.iter().enumerate().filter(is_open);
        let Some(least) = open.map(|(_, tile)| tile.samples.len() as u32).min() else { break };
        if watch.stop() {
            break;
        }
        let target = plan::next_wave(least);
        let tiles = film.tiles.par_iter_mut().zip(&mut is_done).enumerate();
        let open = tiles.filter(|(number, (_, is_done))| plan.shard.has(*number) && !**is_done);
        let sample = |scratch: &mut TileScratch, (_, (tile, is_done)): (usize, (&mut Tile, &mut bool))| {
            let rays = renderer.sample(scratch, tile, plan.first_sample.saturating_add(target));
            *is_done = plan.is_enough(tile, level, settings.spp);
            rays
        };
        rays += open.map_init(TileScratch::default, sample).sum::<u64>();
        film.seconds = before + start.elapsed().as_secs_f64();
        watch.wave(&film);
        if watch.wants_film() {
            watch.film(&film);
        }
    }
    film.seconds = before + start.elapsed().as_secs_f64();
    let is_precise = |(number, tile): (usize, &Tile)| !plan.shard.has(number) || plan.is_precise(tile, level);
    let frozen = match &renderer.frame.prepared {
        Prepared::Cache(frozen) => Some(frozen),
        Prepared::Guide(_) | Prepared::Nothing => None,
    };
    let cache_error = frozen.and_then(|frozen| Some(frozen.cache.estimate()?.root_mean_square));
    let cache = frozen.map(FrozenCache::usage);
    Ok(Render {
        picture: film.picture(),
        finished: (0..film.tiles.len()).all(|number| !plan.shard.has(number) || is_done[number]),
        is_precise: film.tiles.iter().enumerate().all(is_precise),
        film,
        rays,
        rays_by_kind: RaysByKind::of(rays, prefill_rays, world.ray_counts() - counts_before),
        elapsed: start.elapsed(),
        cache,
        cache_error,
    })
}

/// `cache` with the records that a picture with these settings needs. It must be of this world.
pub fn fill_cache(world: &World, settings: &Settings, cache: Cache, watch: &dyn Watch) -> Cache {
    integrator::fill_for_camera(world, settings, cache, watch).0.cache
}

/// The shared data of all tiles.
struct Renderer<'a> {
    world: &'a World,
    frame: FrameRender,
    plan: &'a Plan,
    watch: &'a dyn Watch,
}

impl Renderer<'_> {
    /// Takes the first sample of every pixel that has none, which cannot be stopped, level by level; gives the rays
    /// traced.
    fn first_wave(&self, film: &mut Film, start: Instant) -> u64 {
        let coarsest = levels::sides(self.watch.coarsest()).next().unwrap_or(1);
        let first = self.plan.first_sample;
        // Errors are compared with all of the picture.
        let is_for_all = film.header.halves && first == 0;
        let is_new: Vec<bool> = (film.tiles.iter().enumerate())
            .map(|(number, tile)| tile.samples.is_empty() && (is_for_all || self.plan.shard.has(number)))
            .collect();
        let mut rays = 0;
        for side in levels::sides(coarsest) {
            let sample = |scratch: &mut TileScratch, (tile, _): (&mut Tile, &bool)| {
                if self.watch.gives_up() {
                    return 0;
                }
                let pixels = tile.pixels().enumerate().filter(|&(_, (x, y))| levels::is_new(x, y, side, coarsest));
                let pixels: Vec<_> = pixels.collect();
                let rays = self.frame.sample(self.world, scratch, tile, &pixels, first..first + 1);
                self.watch.advance(pixels.len() as u64, rays);
                tile.samples = first..first + u32::from(side == 1);
                rays
            };
            let tiles = film.tiles.par_iter_mut().zip(&is_new).filter(|(_, is_new)| **is_new);
            rays += tiles.map_init(TileScratch::default, sample).sum::<u64>();
            film.seconds = start.elapsed().as_secs_f64();
            if self.watch.gives_up() {
                return rays;
            }
            if coarsest > 1 {
                let mut picture = film.picture_of(|name| self.watch.wants_channel(name));
                levels::fill_squares(&mut picture, side);
                self.watch.level(side, &picture);
            }
        }
        if is_for_all && film.header.level.is_none() {
            film.header.level = film.level();
            film.keep(|number| self.plan.shard.has(number));
        }
        rays
    }

    /// Takes a tile's samples up to `target`, or fewer if the watcher stops; gives the rays traced.
    fn sample(&self, scratch: &mut TileScratch, tile: &mut Tile, target: u32) -> u64 {
        let pixels: Vec<_> = tile.pixels().enumerate().collect();
        let mut traced = 0;
        let target = target.min(self.frame.settings.spp);
        while tile.samples.end < target && !self.watch.stop() && !self.watch.wants_film() {
            let count = (BATCH / pixels.len()).max(1) as u32;
            let next = tile.samples.end..target.min(tile.samples.end.saturating_add(count));
            let rays = self.frame.sample(self.world, scratch, tile, &pixels, next.clone());
            self.watch.advance(next.len() as u64 * pixels.len() as u64, rays);
            tile.samples.end = next.end;
            traced += rays;
        }
        traced
    }
}
