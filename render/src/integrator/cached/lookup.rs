//! The second pass: radiance along rays from a frozen cache.

use std::f32::consts::PI;

use glam::{Vec2, Vec3};
use halfdome_kernel::sampling::Sampler;
use halfdome_kernel::sampling::warp::{CosineHemisphere, Warp};
use halfdome_kernel::{Hit, Ray};

use super::super::{CameraRays, path};
use super::{Frozen, indirect};
use crate::estimator::sample_light;
use crate::world::World;

/// Sets of random numbers that a surface uses: which light, where on it, and the direction in which a miss is followed.
const SETS_PER_SURFACE: u32 = 3;
/// The sets of a path that follows a miss begin this many later, behind those of all surfaces before it.
const MISS_SETS: u32 = 3 * 64;

/// All rays of a batch, and what is left to do for them.
#[derive(Default)]
pub(crate) struct Wavefront {
    shadows: Vec<Ray>,
    /// Light that arrives if the shadow ray is free: of which camera ray, how much.
    pending: Vec<(usize, Vec3)>,
    occluded: Vec<bool>,
    /// Directions to follow by paths: of which camera ray, with what throughput.
    misses: Vec<(usize, Vec3)>,
    rays: Vec<Ray>,
    hits: Vec<Hit>,
    samplers: Vec<Sampler>,
    radiance: Vec<Vec3>,
}

impl Wavefront {
    /// Writes the radiance along each ray, but for points without records, which [`follow_misses`](Self::follow_misses)
    /// sees to; gives the number of further rays.
    pub(super) fn radiance(
        &mut self,
        world: &World,
        frozen: &Frozen,
        camera: &CameraRays,
        radiance: &mut [Vec3],
    ) -> u64 {
        self.clear();
        for (index, (ray, hit)) in camera.rays.iter().zip(camera.hits).enumerate() {
            radiance[index] = if hit.is_hit() { Vec3::ZERO } else { world.sky.radiance };
            if !hit.is_hit() {
                continue;
            }
            let surface = world.surface_at(hit);
            // Light that a gather's ray meets is direct, and so not the gather's: its density is 0.
            if camera.density == f32::INFINITY {
                radiance[index] += surface.emitted(ray.direction);
            }
            let surface = surface.facing(ray.direction);
            let albedo = surface.material.diffuse;
            if albedo == Vec3::ZERO {
                continue;
            }
            let sampler = &camera.samplers[index];
            let Vec2 { x: choice, .. } = sampler.uniform2(camera.first_set);
            if let Some(light) = sample_light(world, &surface, choice, sampler.uniform2(camera.first_set + 1)) {
                self.pending.push((index, light.reflected(albedo)));
                self.shadows.push(light.shadow);
            }
            match frozen.irradiance(&surface) {
                Some(irradiance) => radiance[index] += albedo * irradiance * (1.0 / PI),
                None => {
                    let local = CosineHemisphere.map(sampler.uniform2(camera.first_set + 2));
                    let direction = surface.frame().to_world(local);
                    if surface.normal.dot(direction) > 0.0 {
                        self.misses.push((index, albedo));
                        self.rays.push(Ray::new(surface.origin_towards(direction), direction));
                        self.samplers.push(*sampler);
                    }
                }
            }
        }
        self.connect(world, radiance)
    }

    /// Adds what paths find in the places of missing records; gives the number of rays.
    pub(super) fn follow_misses(
        &mut self,
        world: &World,
        camera: &CameraRays,
        max_depth: u32,
        paths: &mut path::Wavefront,
        radiance: &mut [Vec3],
    ) -> u64 {
        if self.misses.is_empty() {
            return 0;
        }
        self.hits.resize(self.rays.len(), Hit::MISS);
        self.radiance.resize(self.rays.len(), Vec3::ZERO);
        world.tree().intersect_many(&self.rays, &mut self.hits);
        let first_set = camera.first_set + SETS_PER_SURFACE + MISS_SETS;
        let misses =
            CameraRays { rays: &self.rays, hits: &self.hits, samplers: &self.samplers, first_set, density: 0.0 };
        let traced = indirect(world, max_depth, &misses, paths, &mut self.radiance);
        for (&(index, throughput), found) in self.misses.iter().zip(&self.radiance) {
            radiance[index] += throughput * *found;
        }
        self.rays.len() as u64 + traced
    }

    /// Adds the light whose shadow rays are free.
    fn connect(&mut self, world: &World, radiance: &mut [Vec3]) -> u64 {
        self.occluded.resize(self.shadows.len(), false);
        world.tree().occluded_many(&self.shadows, &mut self.occluded);
        for (&(index, light), occluded) in self.pending.iter().zip(&self.occluded) {
            if !occluded {
                radiance[index] += light;
            }
        }
        self.shadows.len() as u64
    }

    fn clear(&mut self) {
        self.shadows.clear();
        self.pending.clear();
        self.misses.clear();
        self.rays.clear();
        self.hits.clear();
        self.samplers.clear();
    }
}
