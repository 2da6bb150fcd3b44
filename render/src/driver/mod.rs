//! Runs an integrator over the tiles of a picture on all threads, and keeps whoever watches informed.
//!
//! Samples are taken in waves over the whole picture: first one a pixel, which cannot be stopped, then as many as there
//! are already, so that a render which is stopped leaves a picture without holes. The first wave can be watched from
//! coarse to fine. A pixel's samples are summed in their own order, whatever the tiles, waves and threads.

mod frame;
mod levels;
mod worker;

use std::time::{Duration, Instant};

use rayon::prelude::*;

use crate::cache::Cache;
use crate::film::{Metadata, Picture, Tile, channels, tiles};
use crate::integrator::{self, Prepared};
use crate::settings::Settings;
use crate::world::World;
use frame::{FrameRender, TileScratch};

pub use crate::integrator::CacheUse;
pub use crate::watch::{MAX_PREVIEW_SIDE, Watch};
pub use worker::{Step, TileWorker};

/// What a render gives.
#[derive(Clone, Debug)]
pub struct Render {
    /// The picture, complete or as far as it went.
    pub picture: Picture,
    /// Whether every sample was taken.
    pub finished: bool,
    /// Rays traced: camera, bounce and shadow rays.
    pub rays: u64,
    /// Wall-clock time.
    pub elapsed: Duration,
    /// How the irradiance cache was used, if there was one.
    pub cache: Option<CacheUse>,
}

/// The most samples a pixel that one wave takes, and so the most by which tiles differ after an interruption.
const MAX_WAVE: u32 = 16;
/// Camera rays of a tile that are traced together, about: enough to fill batches, few enough to stay in the cache.
const BATCH: usize = 4096;

/// Renders on the threads of the current rayon pool. The picture depends on `world` and `settings` alone.
pub fn render(world: &World, settings: &Settings, watch: &dyn Watch) -> Render {
    render_with(world, settings, None, watch)
}

/// Like [`render`], but the `cached` integrator adds to `cache`, which must be of this world and of its options.
pub fn render_with(world: &World, settings: &Settings, cache: Option<Cache>, watch: &dyn Watch) -> Render {
    let start = Instant::now();
    let (prepared, prefill_rays) = integrator::prepare(world, settings, cache, watch);
    let renderer = Renderer { world, frame: FrameRender::new(world, settings.clone(), prepared), watch };
    let mut tiles = tiles(settings.width, settings.height, settings.aov);
    let mut rays = prefill_rays + renderer.first_wave(&mut tiles, start);
    let mut done = 1;
    while done < settings.spp && !watch.stop() {
        let wave = done.min(MAX_WAVE).min(settings.spp - done);
        rays += tiles
            .par_iter_mut()
            .map_init(TileScratch::default, |scratch, tile| renderer.sample(scratch, tile, done + wave))
            .sum::<u64>();
        done += wave;
    }
    let picture = renderer.picture(&tiles, start);
    let finished = picture.metadata.samples_per_pixel == settings.spp;
    let cache = match &renderer.frame.prepared {
        Prepared::Cache(frozen) => Some(frozen.usage()),
        Prepared::Nothing => None,
    };
    Render { picture, finished, rays, elapsed: start.elapsed(), cache }
}

/// `cache` with the records that a picture with these settings needs. It must be of this world.
pub fn fill_cache(world: &World, settings: &Settings, cache: Cache, watch: &dyn Watch) -> Cache {
    integrator::fill_for_camera(world, settings, cache, watch).0.cache
}

/// What all tiles share.
struct Renderer<'a> {
    world: &'a World,
    frame: FrameRender,
    watch: &'a dyn Watch,
}

impl Renderer<'_> {
    /// Takes the first sample of every pixel, which cannot be stopped, level by level; gives the rays traced.
    fn first_wave(&self, tiles: &mut [Tile], start: Instant) -> u64 {
        let coarsest = levels::sides(self.watch.coarsest()).next().unwrap_or(1);
        let mut rays = 0;
        for side in levels::sides(coarsest) {
            let sample = |scratch: &mut TileScratch, tile: &mut Tile| {
                let pixels = tile.pixels().enumerate().filter(|&(_, (x, y))| levels::is_new(x, y, side, coarsest));
                let pixels: Vec<_> = pixels.collect();
                let rays = self.frame.sample(self.world, scratch, tile, &pixels, 0..1);
                self.watch.advance(pixels.len() as u64, rays);
                tile.samples = u32::from(side == 1);
                rays
            };
            rays += tiles.par_iter_mut().map_init(TileScratch::default, sample).sum::<u64>();
            if coarsest > 1 {
                let mut picture = self.picture(tiles, start);
                levels::fill_squares(&mut picture, side);
                self.watch.level(side, &picture);
            }
        }
        rays
    }

    /// The picture of the samples so far.
    fn picture(&self, tiles: &[Tile], start: Instant) -> Picture {
        let Settings { width, height, seed, ref integrator, .. } = self.frame.settings;
        let metadata = Metadata {
            samples_per_pixel: tiles.iter().map(|tile| tile.samples).min().unwrap_or(0),
            render_time_seconds: Metadata::stored_seconds(start.elapsed()),
            world_to_camera: self.frame.camera.world_to_camera(),
            seed,
            scene_hash: self.world.hash(),
            integrator: integrator.name().to_owned(),
        };
        Picture { width, height, channels: channels(tiles, width, height, self.frame.camera.has_border()), metadata }
    }

    /// Takes a tile's samples up to `target` a pixel, or fewer if the watcher says stop; gives the rays traced.
    fn sample(&self, scratch: &mut TileScratch, tile: &mut Tile, target: u32) -> u64 {
        let pixels: Vec<_> = tile.pixels().enumerate().collect();
        let mut traced = 0;
        while tile.samples < target && !self.watch.stop() {
            let samples = (BATCH / pixels.len()).max(1) as u32;
            let end = target.min(tile.samples + samples);
            let rays = self.frame.sample(self.world, scratch, tile, &pixels, tile.samples..end);
            self.watch.advance(u64::from(end - tile.samples) * pixels.len() as u64, rays);
            tile.samples = end;
            traced += rays;
        }
        traced
    }
}
