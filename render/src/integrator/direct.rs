//! Direct light: emission, and reflection of light straight from its source, with shadows.
//!
//! Each sample takes one light, by its power: `L = L_e + f L_light cos θ / P`, if nothing is in between. Surfaces seen
//! in mirrors and through panes count as seen directly (Whitted 1980): paths continue while their density is infinite,
//! like that of the camera's ray.

use glam::Vec3;
use halfdome_kernel::Ray;

use super::emission::{emission, lights_on_the_way, sky};
use super::shadow_queue::ShadowQueue;
use super::state::Path;
use super::wavefront::{PathVertex, ScalarSteps, VertexStep};
use super::{RayBatch, Wavefront};
use crate::estimator::sample_direct;
use crate::light::SkyPart;
use crate::settings::{DirectOptions, LightSampling};
use crate::world::World;

const LIGHTS: LightSampling = LightSampling::Direct;

/// Writes the radiance along each camera ray; gives the number of further rays.
pub(super) fn radiance(
    world: &World,
    options: &DirectOptions,
    batch: &RayBatch,
    wave: &mut Wavefront,
    radiance: &mut [Vec3],
) -> u64 {
    wave.follow(world, batch, &mut ScalarSteps { world, step: Direct { world, options } }, radiance)
}

struct Direct<'a> {
    world: &'a World,
    options: &'a DirectOptions,
}

impl VertexStep for Direct<'_> {
    fn max_depth(&self) -> u32 {
        self.options.max_depth
    }

    #[inline(always)]
    fn step(
        &mut self,
        path: Path,
        vertex: &PathVertex,
        shadow_queue: &mut ShadowQueue,
        radiance: &mut Vec3,
    ) -> Option<(Path, Ray)> {
        let (world, PathVertex { ray, hit, numbers, .. }) = (self.world, vertex);
        let how = (LIGHTS, SkyPart::All);
        lights_on_the_way(world, how, &path, ray, (hit.t, vertex.time), |_, light| {
            *radiance += path.throughput * light
        });
        if !hit.is_hit() {
            *radiance += path.throughput * sky(world, how, &path, (ray, &world.lights.sky.view(ray.direction)));
            return None;
        }
        let surface = world.surface_at(hit);
        *radiance += path.throughput * emission(world, how, &path, &surface, ray, hit);

        let mut surface = surface.facing(ray.direction);
        let scattering = world.scattering(&mut surface);
        for shadow_ray in sample_direct(world, &surface, &scattering, how, numbers.light()) {
            shadow_queue.push(path.index, path.throughput, shadow_ray);
        }
        path.through(&surface, &scattering, vertex)
    }
}
