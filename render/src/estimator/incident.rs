//! Direct light with the directions that it comes from, for texels and probes: from emitters, by samples of the lights and
//! of directions alike, weighted by the power heuristic (Veach 1997), from delta lights, and the sky's sun.
//! The rest of the sky belongs to the gathers.

use std::f32::consts::PI;
use std::ops::Range;

use glam::{Vec2, Vec3};
use halfdome_kernel::Ray;
use halfdome_kernel::sampling::warp::{CosineHemisphere, Warp};
use halfdome_kernel::sampling::{Pattern, Sampler, unit_double};

use super::direct::{sample_direct, scattered_weight};
use super::salts;
use crate::light::{Receiver, SkyPart};
use crate::settings::LightSampling;
use crate::world::{Hit, MIDDLE, Surface, World};

/// The set of random numbers that chooses the light and a point on it.
const LIGHT_SET: u32 = 0;
/// The set of a direction.
const DIRECTION_SET: u32 = 1;
/// The set that says at which of the surfaces.
const PLACE_SET: u32 = 2;
/// Samples that are traced together, about.
const BATCH: u32 = 2048;

/// Incident light at a point: a unit vector, and irradiance on a surface that faces it.
pub(crate) trait IncidentSink {
    /// Light from a direction in world space, as irradiance on the surface and over the cosine there.
    fn add_light(&mut self, direction: Vec3, irradiance: Vec3);
}

/// Samples of direct light, and their memory.
#[derive(Default)]
pub(crate) struct IncidentSampler {
    shadows: Vec<Ray>,
    /// Unit vectors to what they are sent to.
    directions: Vec<Vec3>,
    occluded: Vec<bool>,
    values: Vec<Vec3>,
    rays: Vec<Ray>,
    hits: Vec<Hit>,
    /// The densities of the scattered rays, and the surfaces that they leave.
    scattered: Vec<(f32, Receiver)>,
}

impl IncidentSampler {
    /// Gives to `sink` the irradiance of the samples of these numbers, `share` of each, each at one of `surfaces`, at least
    /// one; gives the number of rays. `number` selects the random numbers.
    pub(crate) fn sample(
        &mut self,
        world: &World,
        surfaces: &[Surface],
        (seed, number): (u64, u32),
        (samples, share): (Range<u32>, f32),
        sink: &mut dyn IncidentSink,
    ) -> u64 {
        let mut traced = 0;
        for first in samples.clone().step_by(BATCH as usize) {
            self.shadows.clear();
            self.directions.clear();
            self.values.clear();
            self.rays.clear();
            self.scattered.clear();
            for sample in first..samples.end.min(first.saturating_add(BATCH)) {
                let sampler = Sampler::new(Pattern::Sobol, seed ^ salts::INCIDENT, number, sample);
                let place = sampler.uniform2(PLACE_SET).x * surfaces.len() as f32;
                self.push_sample(world, &surfaces[(place as usize).min(surfaces.len() - 1)], &sampler);
            }
            traced += self.collect(world, share, sink);
        }
        traced
    }

    /// Makes the two rays of a sample.
    fn push_sample(&mut self, world: &World, surface: &Surface, sampler: &Sampler) {
        let [x, y, finer, _] = sampler.uniform4(LIGHT_SET);
        let numbers = (unit_double(Vec2::new(x, finer)), y);
        for light in sample_direct(world, surface, &surface.white(), (LightSampling::Mis, SkyPart::Sun), numbers) {
            self.shadows.push(light.ray);
            self.directions.push(light.direction);
            self.values.push(light.radiance * PI);
        }
        if world.lights.has_emitters() {
            let local = CosineHemisphere.map(sampler.uniform2(DIRECTION_SET));
            let direction = surface.above(surface.frame().to_world(local));
            self.rays.push(Ray::new(surface.origin_towards(surface.normal), direction));
            self.scattered.push((surface.lambert(direction), surface.receiver()));
        }
    }

    /// Traces the rays, and passes on what they find.
    fn collect(&mut self, world: &World, share: f32, sink: &mut dyn IncidentSink) -> u64 {
        self.occluded.resize(self.shadows.len(), false);
        world.occluded_many(&self.shadows, &mut self.occluded);
        for ((direction, value), occluded) in self.directions.iter().zip(&self.values).zip(&self.occluded) {
            if !occluded {
                sink.add_light(*direction, share * *value);
            }
        }
        self.hits.resize(self.rays.len(), Hit::MISS);
        world.intersect_many(&self.rays, &mut self.hits);
        for ((ray, hit), (density, receiver)) in self.rays.iter().zip(&self.hits).zip(&self.scattered) {
            let (hit, transmittance) = world.behind_panes(ray, hit, MIDDLE);
            if hit.is_hit() {
                let emitter = world.surface_at(&hit);
                let emitted = emitter.emitted(ray.direction);
                if emitted != Vec3::ZERO {
                    let weight = scattered_weight(world, receiver, *density, &emitter, ray, &hit);
                    // Cosine over density is π.
                    sink.add_light(ray.direction, share * PI * weight * emitted * transmittance);
                }
            }
        }
        (self.shadows.len() + self.rays.len()) as u64
    }
}
