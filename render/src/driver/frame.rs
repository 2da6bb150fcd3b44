//! Taking samples: from the film through the camera to an integrator, and back to the film.

use std::ops::Range;

use glam::{Vec2, Vec3};
use halfdome_kernel::sampling::{Address, Sampler, fill2};
use halfdome_kernel::{Hit, Ray};

use crate::camera::Camera;
use crate::film::{Features, FilterSample, FilterSampler, Tile};
use crate::integrator::{self, Prepared, RayBatch, Scratch};
use crate::settings::Settings;
use crate::world::World;

/// The set of random numbers that places a sample on the film.
const FILM_SET: u32 = 0;

/// Camera rays that are traced together, and their memory, which the next batch uses again.
#[derive(Default)]
pub(super) struct TileScratch {
    /// Number of the pixel in its tile, and place in the pixel.
    places: Vec<(usize, FilterSample)>,
    samplers: Vec<Sampler>,
    addresses: Vec<Address>,
    /// Numbers for the place in the pixel.
    u_film: Vec<Vec2>,
    /// Points of the film, in pixels.
    points: Vec<Vec2>,
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
        let camera = Camera::new(&world.camera, settings.width, settings.height);
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
        let TileScratch { places, samplers, addresses, u_film, points, rays, hits, radiance, scratch } = scratch;
        let Settings { sampler: pattern, seed, width, .. } = self.settings;
        samplers.clear();
        for sample in samples.clone() {
            samplers.extend(pixels.iter().map(|&(_, (x, y))| Sampler::new(pattern, seed, y * width + x, sample)));
        }
        addresses.clear();
        addresses.extend(samplers.iter().map(Sampler::address));
        u_film.resize(addresses.len(), Vec2::ZERO);
        fill2(world.isa(), pattern, seed, FILM_SET, addresses, u_film);
        places.clear();
        points.clear();
        let pixels = samples.flat_map(|_| pixels);
        for (&(number, (x, y)), u) in pixels.zip(u_film.iter()) {
            let filter = self.filter.sample(u.to_array());
            points.push(Vec2::new(x as f32 + 0.5 + filter.offset[0], y as f32 + 0.5 + filter.offset[1]));
            places.push((number, filter));
        }
        rays.resize(points.len(), Ray::new(Vec3::ZERO, Vec3::ZERO));
        self.camera.rays(world.isa(), points, rays);
        hits.resize(rays.len(), Hit::MISS);
        radiance.resize(rays.len(), Vec3::ZERO);
        world.intersect_side_by_side(rays, hits);
        let camera = RayBatch { rays, hits, samplers, first_set: integrator::FIRST_SET, density: f32::INFINITY };
        let traced = integrator::radiance(world, &self.settings, &self.prepared, &camera, scratch, radiance);
        for (i, (number, filter)) in places.iter().enumerate() {
            tile.add(*number, filter, radiance[i]);
            if self.settings.aov {
                tile.add_features(*number, filter, radiance[i], &features(world, &rays[i], &hits[i]));
            }
        }
        rays.len() as u64 + traced
    }
}

/// What the first surface is.
fn features(world: &World, ray: &Ray, hit: &Hit) -> Features {
    if !hit.is_hit() {
        return Features::default();
    }
    let surface = world.surface_at(hit);
    Features {
        albedo: world.scattering(&mut surface.facing(ray.direction)).albedo(),
        position: surface.position,
        normal: surface.normal,
        shading_normal: surface.shading_normal,
        uv: world.texcoord(hit),
    }
}
