//! Runs an integrator over the tiles of a picture on all threads, and keeps whoever watches informed.
//!
//! Samples are taken in waves over the whole picture: first one a pixel, which cannot be stopped, then as many as there
//! are already, so that a render which is stopped leaves a picture without holes. A pixel's samples are summed in their own order, whatever
//! the tiles, waves and threads.

use std::time::{Duration, Instant};

use glam::Vec3;
use halfdome_kernel::sampling::Sampler;
use halfdome_kernel::{Hit, Ray};
use rayon::prelude::*;

use crate::cache::Cache;
use crate::camera::Camera;
use crate::film::{Features, FilterSample, FilterSampler, Metadata, Picture, Tile, channels, tiles};
use crate::integrator::{self, CameraRays, Memory, Prepared};

pub use crate::integrator::CacheUse;

use crate::settings::Settings;
use crate::world::World;

/// Watches a render and may stop it. Called from all threads.
pub trait Watch: Sync {
    /// `samples` camera samples and `rays` rays more are done.
    fn advance(&self, samples: u64, rays: u64);
    /// Whether to stop; asked often. The samples so far still make a picture.
    fn stop(&self) -> bool;
}

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
const BATCH: usize = 2048;
/// The set of random numbers that places a sample on the film.
const FILM_SET: u32 = 0;

/// Renders on the threads of the current rayon pool. The picture depends on `world` and `settings` alone.
pub fn render(world: &World, settings: &Settings, watch: &dyn Watch) -> Render {
    render_with(world, settings, None, watch)
}

/// Like [`render`], but the `cached` integrator adds to `cache`, which must be of this world and of its options.
pub fn render_with(world: &World, settings: &Settings, cache: Option<Cache>, watch: &dyn Watch) -> Render {
    let start = Instant::now();
    let (prepared, overture) = integrator::prepare(world, settings, cache, watch);
    let job = Job {
        world,
        settings,
        prepared: &prepared,
        watch,
        camera: Camera::new(&world.camera, settings.width, settings.height),
        filter: FilterSampler::new(&settings.filter),
    };
    let mut tiles = tiles(settings.width, settings.height, settings.aov);
    let mut rays = overture;
    let mut done = 0;
    while done < settings.spp && (done == 0 || !watch.stop()) {
        let wave = done.clamp(1, MAX_WAVE).min(settings.spp - done);
        rays += tiles
            .par_iter_mut()
            .map_init(Batch::default, |batch, tile| job.sample(batch, tile, done + wave))
            .sum::<u64>();
        done += wave;
    }
    let samples = tiles.iter().map(|tile| tile.samples).min().unwrap_or(0);
    let metadata = Metadata {
        samples_per_pixel: samples,
        render_time_seconds: Metadata::stored_seconds(start.elapsed()),
        world_to_camera: job.camera.world_to_camera(),
        seed: settings.seed,
        scene_hash: world.hash(),
        integrator: settings.integrator.name().to_owned(),
    };
    let channels = channels(&tiles, settings.width, settings.height);
    let cache = match &prepared {
        Prepared::Cache(frozen) => Some(frozen.usage()),
        Prepared::Nothing => None,
    };
    let picture = Picture { width: settings.width, height: settings.height, channels, metadata };
    Render { picture, finished: samples == settings.spp, rays, elapsed: start.elapsed(), cache }
}

/// `cache` with the records that a picture with these settings needs. It must be of this world.
pub fn fill_cache(world: &World, settings: &Settings, cache: Cache, watch: &dyn Watch) -> Cache {
    integrator::fill_for_camera(world, settings, cache, watch).0.cache
}

/// Camera rays that are traced together, and their memory, which the next batch uses again.
#[derive(Default)]
struct Batch {
    /// Number of the pixel in its tile, and place in the pixel.
    places: Vec<(usize, FilterSample)>,
    samplers: Vec<Sampler>,
    rays: Vec<Ray>,
    hits: Vec<Hit>,
    radiance: Vec<Vec3>,
    memory: Memory,
}

/// What all tiles share.
struct Job<'a> {
    world: &'a World,
    settings: &'a Settings,
    prepared: &'a Prepared,
    watch: &'a dyn Watch,
    camera: Camera,
    filter: FilterSampler,
}

impl Job<'_> {
    /// Takes a tile's samples up to `target` a pixel, or fewer if the watcher says stop; gives the rays traced.
    fn sample(&self, batch: &mut Batch, tile: &mut Tile, target: u32) -> u64 {
        let pixels: Vec<(u32, u32)> = tile.pixels().collect();
        let mut traced = 0;
        while tile.samples < target && (tile.samples == 0 || !self.watch.stop()) {
            let samples = (BATCH / pixels.len()).max(1) as u32;
            let end = target.min(tile.samples + samples);
            let rays = self.sample_batch(batch, tile, &pixels, end);
            self.watch.advance(u64::from(end - tile.samples) * pixels.len() as u64, rays);
            tile.samples = end;
            traced += rays;
        }
        traced
    }

    /// Adds the samples from the tile's number up to `end` to all its pixels.
    fn sample_batch(&self, batch: &mut Batch, tile: &mut Tile, pixels: &[(u32, u32)], end: u32) -> u64 {
        let Batch { places, samplers, rays, hits, radiance, memory } = batch;
        places.clear();
        samplers.clear();
        rays.clear();
        for sample in tile.samples..end {
            for (number, &(x, y)) in pixels.iter().enumerate() {
                let sampler =
                    Sampler::new(self.settings.sampler, self.settings.seed, y * self.settings.width + x, sample);
                let filter = self.filter.sample(sampler.uniform2(FILM_SET).into());
                rays.push(self.camera.ray(x as f32 + 0.5 + filter.offset[0], y as f32 + 0.5 + filter.offset[1]));
                places.push((number, filter));
                samplers.push(sampler);
            }
        }
        hits.resize(rays.len(), Hit::MISS);
        radiance.resize(rays.len(), Vec3::ZERO);
        self.world.tree().intersect_many(rays, hits);
        let camera = CameraRays { rays, hits, samplers, first_set: integrator::FIRST_SET, density: f32::INFINITY };
        let traced = integrator::radiance(self.world, self.settings, self.prepared, &camera, memory, radiance);
        for (i, (number, filter)) in places.iter().enumerate() {
            tile.add(*number, filter, radiance[i]);
            if self.settings.aov {
                tile.add_features(*number, filter, &self.features(&hits[i]));
            }
        }
        rays.len() as u64 + traced
    }

    /// What the first surface is.
    fn features(&self, hit: &Hit) -> Features {
        if !hit.is_hit() {
            return Features::default();
        }
        let surface = self.world.surface_at(hit);
        Features {
            albedo: surface.material.diffuse,
            position: surface.position,
            normal: surface.normal,
            shading_normal: surface.shading_normal,
            uv: surface.uv,
        }
    }
}
