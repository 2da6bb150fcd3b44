//! Taking samples: from the film through the camera to an integrator, and back to the film.

use std::ops::Range;

use glam::{Vec2, Vec3};
use halfdome_kernel::sampling::{Address, Sampler, fill2};
use halfdome_kernel::{Hit, Ray};

use super::features;
use crate::camera::{Camera, FilmPoint, FilmSample};
use crate::film::{FilterSample, FilterSampler, Tile};
use crate::integrator::{self, Prepared, RayBatch, Scratch};
use crate::settings::Settings;
use crate::world::World;

/// The set of random numbers that places a sample on the film.
const FILM_SET: u32 = 0;
/// The set that places it on the lens: one that no integrator comes to, so that a lens changes no other number.
const LENS_SET: u32 = u32::MAX;

/// Camera rays that are traced together, and their memory, which the next batch uses again.
#[derive(Default)]
pub(super) struct TileScratch {
    /// Number of the pixel in its tile, number of the sample, and place in the pixel.
    places: Vec<(usize, u32, FilterSample)>,
    samplers: Vec<Sampler>,
    addresses: Vec<Address>,
    /// Numbers for the place in the pixel.
    u_film: Vec<Vec2>,
    /// Numbers for the place on the lens; empty without one.
    u_lens: Vec<Vec2>,
    film: Vec<FilmSample>,
    rays: Vec<Ray>,
    hits: Vec<Hit>,
    radiance: Vec<Vec3>,
    scratch: Scratch,
}

/// What a sample depends on besides the world.
pub(super) struct FrameRender {
    pub(super) settings: Settings,
    pub(super) prepared: Prepared,
    pub(super) camera: Camera,
    filter: FilterSampler,
}

impl FrameRender {
    /// A picture of `world` as its camera sees it.
    pub(super) fn new(world: &World, settings: Settings, prepared: Prepared) -> Self {
        let camera = world.camera_on(settings.width, settings.height);
        let filter = FilterSampler::new(&settings.filter);
        Self { settings, prepared, camera, filter }
    }

    /// Adds samples to pixels of the tile, which come with their numbers; gives the number of rays traced.
    pub(super) fn sample(
        &self,
        world: &World,
        scratch: &mut TileScratch,
        tile: &mut Tile,
        pixels: &[(usize, (u32, u32))],
        samples: Range<u32>,
    ) -> u64 {
        let TileScratch { places, samplers, addresses, u_film, u_lens, film, rays, hits, radiance, scratch } = scratch;
        let Settings { sampler: pattern, seed, width, .. } = self.settings;
        samplers.clear();
        for sample in samples.clone() {
            samplers.extend(pixels.iter().map(|&(_, (x, y))| Sampler::new(pattern, seed, y * width + x, sample)));
        }
        addresses.clear();
        addresses.extend(samplers.iter().map(Sampler::address));
        u_film.resize(addresses.len(), Vec2::ZERO);
        fill2(world.isa(), pattern, seed, FILM_SET, addresses, u_film);
        let (has_lens, has_border) = (self.camera.has_lens(), self.camera.has_border());
        if has_lens {
            u_lens.resize(addresses.len(), Vec2::ZERO);
            fill2(world.isa(), pattern, seed, LENS_SET, addresses, u_lens);
        }
        places.clear();
        film.clear();
        let pixels = samples.flat_map(|sample| pixels.iter().map(move |&pixel| (sample, pixel)));
        for (i, ((sample, (number, (x, y))), u)) in pixels.zip(u_film.iter()).enumerate() {
            let filter = self.filter.sample(u.to_array());
            let point = Vec2::new(x as f32 + 0.5 + filter.offset[0], y as f32 + 0.5 + filter.offset[1]);
            let point = FilmPoint { pixel: (x, y), point };
            if has_border {
                if !self.camera.covers(&point) {
                    tile.add_blind(number, sample, &filter);
                    continue;
                }
                // Those that see something move up.
                samplers[film.len()] = samplers[i];
            }
            film.push(FilmSample { film: point, lens: if has_lens { u_lens[i] } else { Vec2::ZERO } });
            places.push((number, sample, filter));
        }
        samplers.truncate(film.len());
        rays.resize(film.len(), Ray::new(Vec3::ZERO, Vec3::ZERO));
        self.camera.rays(world.isa(), film, rays);
        hits.resize(rays.len(), Hit::MISS);
        radiance.resize(rays.len(), Vec3::ZERO);
        world.intersect_side_by_side(rays, hits);
        let camera = RayBatch { rays, hits, samplers, first_set: integrator::FIRST_SET, density: f32::INFINITY };
        let traced = integrator::radiance(world, &self.settings, &self.prepared, &camera, scratch, radiance);
        for (i, (number, sample, filter)) in places.iter().enumerate() {
            tile.add(*number, *sample, filter, radiance[i]);
            if self.settings.aov {
                let features = if self.settings.aov_through { features::through } else { features::first };
                tile.add_features(*number, filter, radiance[i], &features(world, &rays[i], &hits[i]));
            }
        }
        rays.len() as u64 + traced
    }
}
