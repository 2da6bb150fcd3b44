//! Irradiance at given points, as sensors in a room would measure it.
//!
//! A sensor is a small white surface. Direct light is sampled `spp` times at each, and with it the sun of a sky's picture;
//! what surfaces reflect, and the rest of the sky, comes from an irradiance cache that is filled for the sensors, or from `spp` paths at each.

mod points;

use std::f32::consts::PI;

use glam::{DVec3, Vec2, Vec3};
use halfdome_kernel::sampling::{Pattern, Sampler, unit_double};
use halfdome_kernel::{Hit, Ray};
use rayon::prelude::*;

use crate::cache::Cache;
use crate::driver::{CacheUse, Watch};
use crate::estimator::connect_lamp;
use crate::integrator::{CameraRays, Wavefront, fill_for_surfaces, indirect};
use crate::settings::LightSampling;
use crate::world::{Surface, World};

pub use points::{PointsError, Sensor, read_points, read_positions};

/// What of the light counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// All of it.
    Total,
    /// What surfaces reflect, and the sky without the sun of its picture.
    Indirect,
}

/// How irradiance is estimated.
#[derive(Clone, Copy, Debug)]
pub struct Request {
    /// Samples of direct light at each sensor, and without a cache paths, at least 1.
    pub spp: u32,
    /// Selects the random numbers.
    pub seed: u64,
    /// What counts.
    pub part: Part,
}

/// Irradiance at sensors, in their order, and what it took.
#[derive(Clone, Debug)]
pub struct Irradiance {
    /// In W/m², linear sRGB.
    pub values: Vec<Vec3>,
    /// Rays traced.
    pub rays: u64,
    /// The cache, with the records that were added for the sensors, and how it was used.
    pub cache: Option<(Cache, CacheUse)>,
}

/// The set of random numbers that says which light is sampled, and where on it.
const LIGHT_SET: u32 = 0;
/// The set of a path's direction; those after it are the path's.
const DIRECTION_SET: u32 = 1;
/// Samples that are traced together, about.
const BATCH: usize = 2048;

/// Irradiance by paths alone.
pub fn by_paths(world: &World, sensors: &[Sensor], request: &Request, watch: &dyn Watch) -> Irradiance {
    let found = sample(world, sensors, request, true, watch);
    Irradiance { values: found.iter().map(|(value, _)| *value).collect(), rays: sum_rays(&found), cache: None }
}

/// Irradiance with the indirect part from `cache`, to which records are added where the sensors need them. It must be
/// of this world.
pub fn by_cache(world: &World, sensors: &[Sensor], cache: Cache, request: &Request, watch: &dyn Watch) -> Irradiance {
    let surfaces: Vec<Surface> = sensors.iter().map(|sensor| sensor.surface(world)).collect();
    let (frozen, mut rays) = fill_for_surfaces(world, request.seed, cache, &surfaces, watch);
    let indirect: Vec<Option<Vec3>> = surfaces.par_iter().map(|surface| frozen.irradiance(surface)).collect();
    let mut values = vec![Vec3::ZERO; sensors.len()];
    if request.part == Part::Total {
        let direct = sample(world, sensors, request, false, watch);
        rays += sum_rays(&direct);
        values.iter_mut().zip(direct).for_each(|(value, (direct, _))| *value = direct);
    }
    let mut missing: Vec<usize> = Vec::new();
    for (i, found) in indirect.into_iter().enumerate() {
        match found {
            Some(irradiance) => values[i] += irradiance,
            None => missing.push(i),
        }
    }
    // Only where filling was interrupted.
    let lost: Vec<Sensor> = missing.iter().map(|&i| sensors[i]).collect();
    let found = sample(world, &lost, &Request { part: Part::Indirect, ..*request }, true, watch);
    rays += sum_rays(&found);
    missing.iter().zip(found).for_each(|(&i, (value, _))| values[i] += value);
    let usage = frozen.usage();
    Irradiance { values, rays, cache: Some((frozen.cache, usage)) }
}

fn sum_rays(found: &[(Vec3, u64)]) -> u64 {
    found.iter().map(|(_, rays)| rays).sum()
}

/// The mean of each sensor's samples, of direct light if that counts, and with `paths` of the rest; and its rays.
fn sample(world: &World, sensors: &[Sensor], request: &Request, paths: bool, watch: &dyn Watch) -> Vec<(Vec3, u64)> {
    let sample = |batch: &mut Batch, (number, sensor): (usize, &Sensor)| {
        let surface = sensor.surface(world);
        let (mut sum, mut rays) = (DVec3::ZERO, 0);
        for first in (0..request.spp).step_by(BATCH) {
            let samples = first..request.spp.min(first.saturating_add(BATCH as u32));
            batch.samplers.clear();
            batch.samplers.extend(samples.map(|i| Sampler::new(Pattern::Sobol, request.seed, number as u32, i)));
            if request.part == Part::Total {
                rays += batch.direct(world, &surface, &mut sum);
            }
            if paths {
                rays += batch.indirect(world, &surface, &mut sum);
            }
        }
        watch.advance(u64::from(request.spp), rays);
        ((sum / f64::from(request.spp)).as_vec3(), rays)
    };
    sensors.par_iter().enumerate().map_init(Batch::default, sample).collect()
}

/// Samples of one sensor that are traced together, and their memory.
#[derive(Default)]
struct Batch {
    samplers: Vec<Sampler>,
    rays: Vec<Ray>,
    hits: Vec<Hit>,
    occluded: Vec<bool>,
    values: Vec<Vec3>,
    wave: Wavefront,
}

impl Batch {
    /// Adds samples of direct light.
    fn direct(&mut self, world: &World, surface: &Surface, sum: &mut DVec3) -> u64 {
        self.rays.clear();
        self.values.clear();
        for sampler in &self.samplers {
            let [x, y, finer, _] = sampler.uniform4(LIGHT_SET);
            let numbers = (unit_double(Vec2::new(x, finer)), y);
            if let Some(light) = connect_lamp(world, surface, LightSampling::Direct, numbers) {
                self.rays.push(light.shadow);
                self.values.push(light.radiance * PI);
            }
        }
        self.occluded.resize(self.rays.len(), false);
        world.occluded_many(&self.rays, &mut self.occluded);
        let free = self.values.iter().zip(&self.occluded).filter(|(_, occluded)| !**occluded);
        *sum += free.map(|(value, _)| value.as_dvec3()).sum::<DVec3>();
        self.rays.len() as u64
    }

    /// Adds what paths find that follow the cosine: `E = π` times the mean of their radiance.
    fn indirect(&mut self, world: &World, surface: &Surface, sum: &mut DVec3) -> u64 {
        use halfdome_kernel::sampling::warp::{CosineHemisphere, Warp};
        let frame = surface.frame();
        self.rays.clear();
        self.rays.extend(self.samplers.iter().map(|sampler| {
            let direction = frame.to_world(CosineHemisphere.map(sampler.uniform2(DIRECTION_SET)));
            Ray::new(surface.origin_towards(surface.normal), direction)
        }));
        self.hits.resize(self.rays.len(), Hit::MISS);
        self.values.resize(self.rays.len(), Vec3::ZERO);
        world.intersect_many(&self.rays, &mut self.hits);
        let rays = CameraRays {
            rays: &self.rays,
            hits: &self.hits,
            samplers: &self.samplers,
            first_set: DIRECTION_SET + 1,
            density: 0.0,
        };
        let further = indirect(world, None, &rays, &mut self.wave, &mut self.values);
        *sum += self.values.iter().map(|radiance| (*radiance * PI).as_dvec3()).sum::<DVec3>();
        self.rays.len() as u64 + further
    }
}
