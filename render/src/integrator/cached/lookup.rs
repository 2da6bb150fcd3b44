//! The second pass: radiance along rays from a frozen cache.
//!
//! On a surface that is not matte, records give the light reflected by its diffuse albedo. For the rest of its closure
//! a ray is sampled from the closure, and its weight is reduced by the part that records cover; for a glossy surface
//! the lobe remains, as if the diffuse light below were Lambert's (deviation: under uneven light this is off by the
//! part that the reflection takes from grazing light). At the hit of such a ray at most one further ray is traced:
//! where no record is valid it stands for all scattering, as in path tracing, with Russian roulette.
//!
//! Area lights are sampled. Near them the contribution of a light sample is unbounded, as it falls with the square of
//! the distance; there a ray sampled from the closure counts emission too, and both are weighted (Veach 1997).

use std::f32::consts::PI;

use glam::Vec3;
use halfdome_kernel::Ray;
use halfdome_kernel::sampling::Sampler;

use super::super::emission::{emission, lights_on_the_way, sky_after_delta};
use super::super::shadow_queue::ShadowQueue;
use super::super::state::Path;
use super::super::wavefront::{PathVertex, SETS_PER_SURFACE, ScalarSteps, VertexStep};
use super::super::{RayBatch, Wavefront};
use super::{FrozenCache, indirect};
use crate::estimator::{sample_direct, scattered_weight};
use crate::light::SkyPart;
use crate::material::Kind;
use crate::settings::LightSampling;
use crate::world::{Hit, Surface, World};

/// The most surfaces on a path that mirrors and glass prolong.
const MAX_SURFACES: u32 = 32;

/// The least probability of a ray for the light that records do not cover: the same ray finds emission.
const LEAST_REST: f32 = 0.25;

/// Points without a record, and the rays from there.
#[derive(Default)]
pub(crate) struct CacheMisses {
    /// Which camera ray saw them, and what the light that arrives by the ray is multiplied by.
    seen: Vec<(u32, Vec3)>,
    rays: Vec<Ray>,
    hits: Vec<Hit>,
    samplers: Vec<Sampler>,
    radiance: Vec<Vec3>,
    /// The throughput of each ray's path, scattered last by a density, for all light except emission, minus the part covered
    /// by records; 1 for a path that has not been scattered yet.
    indirect: Vec<Vec3>,
}

/// Writes the radiance along each ray, and adds points without records to `misses`; returns the number of further rays.
pub(super) fn radiance(
    world: &World,
    frozen: &FrozenCache,
    batch: &RayBatch,
    wave: &mut Wavefront,
    misses: &mut CacheMisses,
    radiance: &mut [Vec3],
) -> u64 {
    misses.clear();
    misses.indirect.clear();
    misses.indirect.resize(batch.rays.len(), Vec3::ONE);
    wave.follow(world, batch, &mut ScalarSteps { world, step: Lookup { world, frozen, batch, misses } }, radiance)
}

struct Lookup<'a> {
    world: &'a World,
    frozen: &'a FrozenCache,
    batch: &'a RayBatch<'a>,
    misses: &'a mut CacheMisses,
}

impl VertexStep for Lookup<'_> {
    fn max_depth(&self) -> u32 {
        MAX_SURFACES
    }

    #[inline(always)]
    fn step(
        &mut self,
        mut path: Path,
        vertex: &PathVertex,
        shadow_queue: &mut ShadowQueue,
        radiance: &mut Vec3,
    ) -> Option<(Path, Ray)> {
        let (world, PathVertex { ray, hit, numbers, .. }, index) = (self.world, vertex, path.index);
        let is_scattered = path.density > 0.0 && path.density < f32::INFINITY;
        if vertex.is_mirrored {
            // Records cover their part of what panes reflect.
            path.throughput = self.misses.indirect[index as usize] * vertex.transmittance;
        }
        let how = (LightSampling::Direct, SkyPart::Sun);
        lights_on_the_way(world, how, &path, ray, (hit.t, vertex.time), |_, light| {
            *radiance += path.throughput * light
        });
        if !hit.is_hit() {
            let (sky, view) = (&world.lights.sky, world.lights.sky.view(ray.direction));
            // Of the sky a gather sees what light samples do not.
            if is_scattered {
                *radiance += self.misses.indirect[index as usize] * vertex.transmittance * sky.ambient(&view);
            } else if path.density == 0.0 {
                *radiance += path.throughput * sky.ambient(&view);
            } else {
                *radiance += path.throughput * sky_after_delta(world, &path, &view);
            }
            return None;
        }
        let surface = world.surface_at(hit);
        let mut throughput = path.throughput;
        if is_scattered {
            *radiance += throughput * self.scattered_emission(&path, &surface, ray, hit);
            throughput = self.misses.indirect[index as usize] * vertex.transmittance;
            if throughput == Vec3::ZERO {
                return None;
            }
        } else {
            *radiance += throughput * emission(world, how, &path, &surface, ray, hit);
        }

        let mut surface = surface.facing(ray.direction);
        let scattering = world.scattering(&mut surface);
        // A gather's ray is one of many of which the mean is taken.
        let is_gathered = self.batch.density == 0.0 && world.is_nearly_diffuse(hit.prim_id);
        let is_matte = is_gathered || world.kind(hit.prim_id) == Kind::Matte;
        let albedo = if is_matte { scattering.albedo() } else { surface.diffuse };
        let lights = if is_matte { world.lights.techniques_at(surface.position) } else { LightSampling::Mis };
        if albedo != Vec3::ZERO || !is_matte {
            let how = (lights, SkyPart::Sun);
            for shadow_ray in sample_direct(world, &surface, &scattering, how, numbers.light()) {
                shadow_queue.push(index, throughput, shadow_ray);
            }
        }
        let is_first = path.is_first() && self.batch.density != 0.0;
        let may_split = is_first || is_matte || self.frozen.cache.options().bounces.is_some();
        let mut known = albedo;
        if albedo != Vec3::ZERO {
            match self.frozen.irradiance_about(&surface) {
                Some(irradiance) => *radiance += throughput * albedo * irradiance * (1.0 / PI),
                None if !may_split => known = Vec3::ZERO,
                None => {
                    let direction = surface.above(surface.frame().to_world(numbers.cosine));
                    let ray = Ray::new(surface.origin_towards(direction), direction);
                    self.misses.push(index, throughput * albedo, ray, self.batch.samplers[index as usize]);
                }
            }
        }
        if is_matte && lights == LightSampling::Direct {
            return None;
        }
        let mut u = numbers.u_direction;
        if !may_split {
            let survival = scattering.albedo().max_element().min(1.0);
            // NaN survives, and shows.
            if u.x >= survival {
                return None;
            }
            u.x /= survival;
            throughput /= survival;
        }
        let bounce = scattering.sample(u)?;
        let direction = bounce.direction;
        let mut next = Path { throughput: throughput * bounce.weight, density: bounce.density, ..path };
        if bounce.density == f32::INFINITY {
            next.normal = path.normal_mirrored();
        } else {
            next.normal = surface.receiver().packed();
            let mut indirect = Vec3::ZERO;
            if !is_matte {
                // Records cover diffuse scattering. Where that is nearly everything, few rays are sent, for emission
                // alone.
                let rest = if world.kind(hit.prim_id) == Kind::Glossy && known != Vec3::ZERO && !surface.transmits {
                    scattering.glossy(direction) / bounce.density
                } else {
                    bounce.weight - known * (surface.lambert(direction) / bounce.density)
                };
                let all = bounce.weight.max_element();
                if all <= 0.0 {
                    return None;
                }
                let survival = (rest.abs().max_element() / all).clamp(LEAST_REST, 1.0);
                if numbers.light().1 >= survival {
                    return None;
                }
                indirect = throughput * rest / survival;
                next.throughput /= survival;
            }
            self.misses.indirect[index as usize] = indirect;
        }
        Some((next, Ray::new(surface.origin_towards(direction), direction)))
    }
}

impl Lookup<'_> {
    /// What a surface emits along a ray that was scattered near area lights.
    #[inline(always)]
    fn scattered_emission(&self, path: &Path, surface: &Surface, ray: &Ray, hit: &Hit) -> Vec3 {
        let receiver = path.receiver(ray.origin);
        surface.emitted(ray.direction) * scattered_weight(self.world, &receiver, path.density, surface, ray, hit)
    }
}

impl CacheMisses {
    /// Adds the light of paths with at most `max_depth` surfaces in place of missing records; returns the number of
    /// rays.
    pub(super) fn follow(
        &mut self,
        world: &World,
        batch: &RayBatch,
        max_depth: Option<u32>,
        wave: &mut Wavefront,
        radiance: &mut [Vec3],
    ) -> u64 {
        if self.seen.is_empty() {
            return 0;
        }
        self.hits.resize(self.rays.len(), Hit::MISS);
        self.radiance.resize(self.rays.len(), Vec3::ZERO);
        world.intersect_many(&self.rays, &mut self.hits);
        // Behind the sets of all surfaces before.
        let first_set = batch.first_set + MAX_SURFACES * SETS_PER_SURFACE;
        let (rays, hits, samplers) = (&self.rays, &self.hits, &self.samplers);
        // What records say is of the middle of the shutter's time, too.
        let rays = RayBatch { rays, hits, samplers, times: &[], first_set, density: 0.0 };
        let further = indirect(world, max_depth, &rays, wave, &mut self.radiance);
        for (&(index, throughput), found) in self.seen.iter().zip(&self.radiance) {
            radiance[index as usize] += throughput * *found;
        }
        self.rays.len() as u64 + further
    }

    fn push(&mut self, index: u32, throughput: Vec3, ray: Ray, sampler: Sampler) {
        self.seen.push((index, throughput));
        self.rays.push(ray);
        self.samplers.push(sampler);
    }

    fn clear(&mut self) {
        self.seen.clear();
        self.rays.clear();
        self.samplers.clear();
    }
}
