//! Radiance along a gather's rays from irradiance that is known where they end, as by the texels of a lightmap: `L = ρ/π E`.
//!
//! Nothing but the choice of the rays is left to chance then, so that a gather has a fraction of the noise, and of the rays,
//! of one that follows paths. Where nothing is known, as on backs and behind mirrors and glass, a path finds the light.

use std::f32::consts::PI;

use glam::Vec3;
use halfdome_kernel::sampling::Sampler;
use halfdome_kernel::{Hit, Ray};

use super::indirect;
use crate::integrator::{CameraRays, Wavefront};
use crate::scene::Specular;
use crate::world::World;

/// Somebody who knows irradiance.
pub(crate) trait Known: Sync {
    /// All irradiance at a hit on the front of a triangle, direct light included; `None` where it is not known.
    fn irradiance(&self, hit: &Hit) -> Option<Vec3>;
}

/// The rays that paths go on from.
#[derive(Default)]
pub(super) struct Unknown {
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
    known: &dyn Known,
    camera: &CameraRays,
    wave: &mut Wavefront,
    unknown: &mut Unknown,
    radiance: &mut [Vec3],
) -> u64 {
    unknown.clear();
    for (i, (ray, hit)) in camera.rays.iter().zip(camera.hits).enumerate() {
        radiance[i] = Vec3::ZERO;
        if !hit.is_hit() {
            continue;
        }
        let surface = world.surface_at(hit);
        let is_plain = surface.normal.dot(ray.direction) < 0.0 && surface.material.specular == Specular::None;
        match is_plain.then(|| known.irradiance(hit)).flatten() {
            Some(irradiance) => radiance[i] = surface.diffuse * irradiance * (1.0 / PI),
            None => unknown.push(i, *ray, *hit, camera.samplers[i]),
        }
    }
    unknown.follow(world, camera, wave, radiance)
}

impl Unknown {
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
    fn follow(&mut self, world: &World, camera: &CameraRays, wave: &mut Wavefront, radiance: &mut [Vec3]) -> u64 {
        if self.of.is_empty() {
            return 0;
        }
        self.radiance.resize(self.of.len(), Vec3::ZERO);
        let rays = CameraRays { rays: &self.rays, hits: &self.hits, samplers: &self.samplers, ..*camera };
        let traced = indirect(world, None, &rays, wave, &mut self.radiance);
        for (&number, found) in self.of.iter().zip(&self.radiance) {
            radiance[number] = *found;
        }
        traced
    }
}
