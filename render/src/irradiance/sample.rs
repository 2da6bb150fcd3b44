//! Samples of the irradiance at a sensor: light samples, and paths that go on from there.

use std::f32::consts::PI;

use glam::{DVec3, Vec3};
use halfdome_kernel::Ray;
use halfdome_kernel::sampling::warp::{CosineHemisphere, Warp};
use halfdome_kernel::sampling::{Pattern, Sampler};

use super::Component;
use crate::estimator::{AimedFrom, AimedRays, Follow, LightRays, scattered_weight};
use crate::integrator::{Follower, GatherSource};
use crate::light::SkyPart;
use crate::settings::LightSampling;
use crate::world::{Hit, MIDDLE, Surface, World};

/// The set of a path's direction; later sets are for the path.
const DIRECTION_SET: u32 = 1;

/// The random numbers of samples that are traced together.
pub(super) struct Samples {
    pub(super) seed: u64,
    pub(super) sensor: u32,
    pub(super) first: u32,
}

impl Samples {
    pub(super) fn sampler(&self, seed: u64, i: u32) -> Sampler {
        Sampler::new(Pattern::Sobol, seed, self.sensor, self.first + i)
    }
}

/// Samples of one sensor that are traced together, and their memory.
#[derive(Default)]
pub(super) struct SensorScratch {
    pub(super) samplers: Vec<Sampler>,
    lights: LightRays,
    rays: Vec<Ray>,
    hits: Vec<Hit>,
    values: Vec<Vec3>,
    aimed: AimedRays,
}

impl SensorScratch {
    /// Adds a sample of a component for each sampler; gives the number of rays.
    pub(super) fn sample(
        &mut self,
        world: &World,
        surface: &Surface,
        component: Component,
        samples: &Samples,
        sum: &mut DVec3,
    ) -> u64 {
        let lights = match component {
            Component::Indirect(_) => None,
            Component::Direct => Some(world.lights.techniques_at(surface.position)),
            // The ray is there in any case.
            Component::All(_) => Some(LightSampling::Mis),
        };
        let mut rays = lights.map_or(0, |lights| self.sample_lights(world, surface, lights, sum));
        if component == Component::Direct && lights == Some(LightSampling::Direct) {
            return rays;
        }
        rays += self.scatter(world, surface);
        if lights.is_some() {
            self.add_emission(world, surface, sum);
        }
        match component {
            Component::Direct => rays,
            Component::Indirect(max_depth) | Component::All(max_depth) => {
                rays + self.follow(world, surface, max_depth, samples, sum)
            }
        }
    }

    /// Adds samples of lights.
    fn sample_lights(&mut self, world: &World, surface: &Surface, lights: LightSampling, sum: &mut DVec3) -> u64 {
        let (surfaces, how) = (std::slice::from_ref(surface), (lights, SkyPart::Sun));
        let mut lit = DVec3::ZERO;
        let found = |_, irradiance: Vec3| lit += irradiance.as_dvec3();
        let rays = self.lights.trace(world, surfaces, how, &self.samplers, found);
        *sum += lit;
        rays
    }

    /// Traces rays that follow the cosine.
    fn scatter(&mut self, world: &World, surface: &Surface) -> u64 {
        let frame = surface.frame();
        self.rays.clear();
        self.rays.extend(self.samplers.iter().map(|sampler| {
            let direction = frame.to_world(CosineHemisphere.map(sampler.uniform2(DIRECTION_SET)));
            Ray::new(surface.origin_towards(surface.normal), direction)
        }));
        self.hits.resize(self.rays.len(), Hit::MISS);
        world.intersect_many(&self.rays, &mut self.hits);
        self.rays.len() as u64
    }

    /// Adds what lights send along the scattered rays: a cosine over its density is π.
    fn add_emission(&self, world: &World, surface: &Surface, sum: &mut DVec3) {
        for (ray, hit) in self.rays.iter().zip(&self.hits) {
            let (hit, transmittance) = world.behind_panes(ray, hit, MIDDLE);
            if !hit.is_hit() {
                continue;
            }
            let emitter = world.surface_at(&hit);
            let emitted = emitter.emitted(ray.direction);
            if emitted != Vec3::ZERO {
                let density = surface.normal.dot(ray.direction) / PI;
                let weight = scattered_weight(world, &surface.receiver(), density, &emitter, ray, &hit);
                *sum += (PI * weight * emitted * transmittance).as_dvec3();
            }
        }
    }

    /// Adds what paths find along the scattered rays, `E = π` times the mean of their radiance, and along those that
    /// are aimed at secondary lights.
    fn follow(
        &mut self,
        world: &World,
        surface: &Surface,
        max_depth: Option<u32>,
        samples: &Samples,
        sum: &mut DVec3,
    ) -> u64 {
        let mut follower = Follower::new(world, GatherSource::Paths(max_depth), DIRECTION_SET + 1);
        self.values.resize(self.rays.len(), Vec3::ZERO);
        let mut traced = follower.follow(&self.rays, &self.hits, &self.samplers, &mut self.values);
        let count = self.rays.len();
        let from = AimedFrom::new(world, surface, count);
        let others = |direction: Vec3| surface.lambert(direction) * count as f32;
        for ((ray, hit), radiance) in self.rays.iter().zip(&self.hits).zip(&self.values) {
            let kept = if hit.is_hit() { from.kept(world, ray, hit, others(ray.direction)) } else { 1.0 };
            *sum += (*radiance * (PI * kept)).as_dvec3();
        }
        self.aimed.clear();
        self.aimed.push(world, (surface, &from), (0, samples.seed), |seed, i| samples.sampler(seed, i), others);
        traced += self.aimed.trace(world, &mut follower);
        for lit in self.aimed.found(world, 0) {
            // The caller takes the mean.
            *sum += (lit.flux * (count as f32 * PI * surface.lambert(lit.direction))).as_dvec3();
        }
        traced
    }
}
