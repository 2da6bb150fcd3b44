//! Radiance along a gather's rays from irradiance that is known where they end, as by the texels of a lightmap: `L = ρ/π E`.
//!
//! Then only the directions of the rays are random, so that a gather needs a fraction of the rays of one that follows
//! paths. Where the map has no value, as on backs and behind mirrors and glass, a path finds the light.

use std::f32::consts::PI;

use glam::Vec3;
use halfdome_kernel::Ray;
use halfdome_kernel::sampling::Sampler;

use super::indirect;
use crate::integrator::{RayBatch, Wavefront};
use crate::world::{Hit, World};

/// A source of irradiance.
pub(crate) trait IrradianceMap: Sync {
    /// All irradiance at a hit on the front of a triangle, direct light included; `None` where it is not known.
    fn irradiance(&self, hit: &Hit) -> Option<Vec3>;
}

/// The rays that paths continue.
#[derive(Default)]
pub(super) struct UnmappedHits {
    /// Their numbers.
    of: Vec<usize>,
    rays: Vec<Ray>,
    hits: Vec<Hit>,
    samplers: Vec<Sampler>,
    radiance: Vec<Vec3>,
}

/// Writes what surfaces reflect along each ray that hits one; gives the number of further rays.
pub(super) fn radiance(
    world: &World,
    map: &dyn IrradianceMap,
    batch: &RayBatch,
    wave: &mut Wavefront,
    unmapped: &mut UnmappedHits,
    radiance: &mut [Vec3],
) -> u64 {
    unmapped.clear();
    for (i, (ray, hit)) in batch.rays.iter().zip(batch.hits).enumerate() {
        radiance[i] = Vec3::ZERO;
        if !hit.is_hit() {
            continue;
        }
        let surface = world.surface_at(hit);
        let is_known = surface.normal.dot(ray.direction) < 0.0 && world.is_nearly_diffuse_to_lights(hit.prim_id);
        match is_known.then(|| map.irradiance(hit)).flatten() {
            Some(irradiance) => {
                let albedo = world.scattering(&mut surface.facing(ray.direction)).albedo();
                radiance[i] = albedo * irradiance * (1.0 / PI);
            }
            None => unmapped.push(i, *ray, *hit, batch.samplers[i]),
        }
    }
    unmapped.follow(world, batch, wave, radiance)
}

impl UnmappedHits {
    fn clear(&mut self) {
        self.of.clear();
        self.rays.clear();
        self.hits.clear();
        self.samplers.clear();
    }

    fn push(&mut self, number: usize, ray: Ray, hit: Hit, sampler: Sampler) {
        self.of.push(number);
        self.rays.push(ray);
        self.hits.push(hit);
        self.samplers.push(sampler);
    }

    /// Writes what paths find; gives the number of rays.
    fn follow(&mut self, world: &World, batch: &RayBatch, wave: &mut Wavefront, radiance: &mut [Vec3]) -> u64 {
        if self.of.is_empty() {
            return 0;
        }
        self.radiance.resize(self.of.len(), Vec3::ZERO);
        let rays = RayBatch { rays: &self.rays, hits: &self.hits, samplers: &self.samplers, times: &[], ..*batch };
        let traced = indirect(world, None, &rays, wave, &mut self.radiance);
        for (&number, found) in self.of.iter().zip(&self.radiance) {
            radiance[number] = *found;
        }
        traced
    }
}
