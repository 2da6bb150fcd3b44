//! Direct light with the directions that it comes from, for texels and probes: from emitters, by samples of the lights and
//! of directions alike, weighted by the power heuristic (Veach 1997), from delta lights, and the sky's sun.
//! The rest of the sky belongs to the gathers.

use std::f32::consts::PI;
use std::ops::Range;

use glam::Vec3;
use halfdome_kernel::sampling::warp::{CosineHemisphere, Warp};
use halfdome_kernel::sampling::{Pattern, Sampler};
use halfdome_kernel::{Ray, Task};

use super::direct::scattered_weight;
use super::light_rays::{LightRays, place_of};
use super::salts;
use crate::light::{Receiver, SkyPart};
use crate::settings::LightSampling;
use crate::world::{Hit, MIDDLE, Surface, World};

/// The set of a direction.
const DIRECTION_SET: u32 = 1;
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
    lights: LightRays,
    samplers: Vec<Sampler>,
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
        const HOW: (LightSampling, SkyPart) = (LightSampling::Mis, SkyPart::Sun);
        let mut traced = 0;
        for first in samples.clone().step_by(BATCH as usize) {
            self.samplers.clear();
            let sampler = |sample| Sampler::new(Pattern::Sobol, seed ^ salts::INCIDENT, number, sample);
            self.samplers.extend((first..samples.end.min(first.saturating_add(BATCH))).map(sampler));
            let found = |direction, irradiance| sink.add_light(direction, share * irradiance);
            traced += self.lights.trace(world, surfaces, HOW, &self.samplers, found);
            if world.lights.has_emitters() {
                world.isa().run(Scatter { surfaces, sampler: self });
                traced += self.collect(world, share, sink);
            }
        }
        traced
    }

    /// Traces the scattered rays, and passes on what they find.
    fn collect(&mut self, world: &World, share: f32, sink: &mut dyn IncidentSink) -> u64 {
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
        self.rays.len() as u64
    }
}

/// A scattered ray for each sample, as a task that is compiled for each instruction set.
struct Scatter<'a> {
    surfaces: &'a [Surface<'a>],
    sampler: &'a mut IncidentSampler,
}

impl Task for Scatter<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let IncidentSampler { samplers, rays, scattered, .. } = self.sampler;
        rays.clear();
        scattered.clear();
        for sampler in &*samplers {
            let surface = &self.surfaces[place_of(sampler, self.surfaces.len())];
            let local = CosineHemisphere.map(sampler.uniform2(DIRECTION_SET));
            let direction = surface.above(surface.frame().to_world(local));
            rays.push(Ray::new(surface.origin_towards(surface.normal), direction));
            scattered.push((surface.lambert(direction), surface.receiver()));
        }
    }
}
