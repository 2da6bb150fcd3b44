//! Taking samples: from the film through the camera to an integrator, and back to the film.

use std::ops::Range;

use glam::{Vec2, Vec3};
use halfdome_kernel::Ray;
use halfdome_kernel::sampling::{SampleId, Sampler, fill2};

use super::features;
use super::mattes::MatteIds;
use super::motion_vectors::MotionVectors;
use crate::camera::{Camera, FilmPoint, FilmSample, MovingCamera};
use crate::film::{FilterSample, FilterSampler, FirstHit, Tile};
use crate::integrator::{self, FILM_SET, LENS_SET, LightPaths, Prepared, RayBatch, Scratch, TIME_SET};
use crate::lpe::Event;
use crate::settings::{MatteKind, Settings};
use crate::world::{Hit, World};

/// Camera rays that are traced together, and their memory, which the next batch uses again.
#[derive(Default)]
pub(super) struct TileScratch {
    /// Index of the pixel in its tile, index of the sample, and place in the pixel.
    places: Vec<(usize, u32, FilterSample)>,
    samplers: Vec<Sampler>,
    addresses: Vec<SampleId>,
    /// Numbers for the place in the pixel.
    u_film: Vec<Vec2>,
    /// Numbers for the place on the lens; empty without one.
    u_lens: Vec<Vec2>,
    /// When each is taken; empty if nothing moves.
    times: Vec<f32>,
    film: Vec<FilmSample>,
    rays: Vec<Ray>,
    hits: Vec<Hit>,
    radiance: Vec<Vec3>,
    /// The AOVs by light path expressions of each ray.
    light: Vec<Vec3>,
    scratch: Scratch,
}

/// The inputs of a sample besides the world.
pub(super) struct FrameRender {
    pub(super) settings: Settings,
    pub(super) prepared: Prepared,
    /// If there are AOVs by light path expressions.
    light_paths: Option<LightPaths>,
    pub(super) camera: Camera,
    /// If it moves.
    moving_camera: Option<MovingCamera>,
    filter: FilterSampler,
    /// The ids of each Cryptomatte layer.
    mattes: Vec<MatteIds>,
    /// If anything moves.
    motion: Option<MotionVectors>,
}

impl FrameRender {
    /// A picture of `world` as its camera sees it.
    pub(super) fn new(world: &World, settings: Settings, prepared: Prepared, light_paths: Option<LightPaths>) -> Self {
        let camera = world.camera_on(settings.width, settings.height);
        let moving_camera = MovingCamera::new(world.cameras_on(settings.width, settings.height));
        let filter = FilterSampler::new(&settings.filter);
        let mattes = settings.cryptomatte.kinds.iter().map(|&kind| MatteIds::new(world, kind)).collect();
        let motion = MotionVectors::new(world, &settings, &camera);
        Self { settings, prepared, light_paths, camera, moving_camera, filter, mattes, motion }
    }

    /// The paths that have found light since they were last taken, if they are [listed](LightPaths::listing).
    pub(super) fn take_paths(&self) -> Vec<(Vec<Event>, Vec3)> {
        self.light_paths.as_ref().map(LightPaths::take_paths).unwrap_or_default()
    }

    /// What the camera ray of a sample of the row `y` has hit.
    fn first_hit(&self, world: &World, (y, sample): (u32, u32), ray: &Ray, hit: &Hit) -> FirstHit {
        let motion = self.motion.as_ref().map_or([0.0; 2], |motion| motion.at(world, y, ray, hit));
        if !hit.is_hit() {
            return FirstHit { sample, motion, ..FirstHit::NONE };
        }
        let [object, material] = MatteKind::ALL.map(|kind| world.number_of(kind, hit) as u32 + 1);
        let ids = [object, material, world.triangle_number(hit) + 1, hit.instance];
        FirstHit { sample, depth: self.camera.depth(ray, hit.t), ids, motion }
    }

    /// Adds samples to pixels of the tile, which come with their indices; gives the number of rays traced.
    pub(super) fn sample(
        &self,
        world: &World,
        scratch: &mut TileScratch,
        tile: &mut Tile,
        pixels: &[(usize, (u32, u32))],
        samples: Range<u32>,
    ) -> u64 {
        let TileScratch {
            places,
            samplers,
            addresses,
            u_film,
            u_lens,
            times,
            film,
            rays,
            hits,
            radiance,
            light,
            scratch,
        } = scratch;
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
        times.clear();
        if let Some(motion) = world.motion() {
            let mut u_time = vec![Vec2::ZERO; addresses.len()];
            fill2(world.isa(), pattern, seed, TIME_SET, addresses, &mut u_time);
            times.extend(u_time.iter().map(|u| motion.time(u.x)));
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
                    tile.add_uncovered(number, sample, &filter);
                    continue;
                }
                // Samples that hit something move up.
                samplers[film.len()] = samplers[i];
                if !times.is_empty() {
                    times[film.len()] = times[i];
                }
            }
            film.push(FilmSample { film: point, lens: if has_lens { u_lens[i] } else { Vec2::ZERO } });
            places.push((number, sample, filter));
        }
        samplers.truncate(film.len());
        times.truncate(film.len());
        rays.resize(film.len(), Ray::new(Vec3::ZERO, Vec3::ZERO));
        match (&self.moving_camera, world.motion()) {
            (Some(camera), Some(motion)) => camera.rays(world.isa(), film, |i| motion.camera_moment(times[i]), rays),
            _ => self.camera.rays(world.isa(), film, rays),
        }
        hits.resize(rays.len(), Hit::MISS);
        radiance.resize(rays.len(), Vec3::ZERO);
        world.intersect_side_by_side(rays, times, hits);
        let camera = RayBatch { rays, hits, samplers, times, first_set: integrator::FIRST_SET, density: f32::INFINITY };
        let aovs = self.light_paths.as_ref().map_or(0, LightPaths::count);
        light.resize(rays.len() * aovs, Vec3::ZERO);
        let recorded = self.light_paths.as_ref().map(|paths| (paths, light.as_mut_slice()));
        let traced = integrator::radiance(world, &self.settings, &self.prepared, &camera, scratch, radiance, recorded);
        for (i, (number, sample, filter)) in places.iter().enumerate() {
            tile.add(*number, *sample, filter, radiance[i]);
            if aovs > 0 {
                tile.add_light(*number, filter, radiance[i], &light[i * aovs..][..aovs]);
            }
            for (layer, ids) in self.mattes.iter().enumerate() {
                tile.add_name(layer, *number, filter, ids.of(world, &hits[i]));
            }
            if self.settings.aov {
                let features = if self.settings.aov_through { features::through } else { features::first };
                if tile.is_first(*number, *sample) {
                    tile.add_hit(*number, self.first_hit(world, (film[i].film.pixel.1, *sample), &rays[i], &hits[i]));
                }
                tile.add_features(*number, filter, radiance[i], &features(world, &rays[i], &hits[i]));
            }
        }
        rays.len() as u64 + traced
    }
}
