//! Radiance along a gather's rays from irradiance that is known where they end, as by the texels of a lightmap: `L = ρ/π E`.
//!
//! Then only the directions of the rays are random, so that a gather needs a fraction of the rays of one that follows
//! paths. Where the map has no value, as on backs and behind mirrors and glass, a path finds the light.
//!
//! Rough gloss reflects lamps and the sun as wide patches that one sees on the walls. There a light sample adds what
//! the closure `f` reflects of direct light beyond that, `∫ (f - ρ/π) L_direct cos θ dω`, which may be negative.
//!
//! Deviation: rough gloss reflects indirect light as diffuse surfaces do.

use std::f32::consts::PI;

use glam::{Vec2, Vec3};
use halfdome_kernel::Ray;
use halfdome_kernel::sampling::{Sampler, unit_double};

use super::indirect;
use crate::estimator::sample_direct_by;
use crate::integrator::{RayBatch, Wavefront};
use crate::light::SkyPart;
use crate::material::Kind;
use crate::settings::LightSampling;
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
        let is_known = surface.normal.dot(ray.direction) < 0.0 && world.is_nearly_diffuse(hit.prim_id);
        let Some(irradiance) = is_known.then(|| map.irradiance(hit)).flatten() else {
            unmapped.push(i, *ray, *hit, batch.samplers[i]);
            continue;
        };
        let mut surface = surface.facing(ray.direction);
        let scattering = world.scattering(&mut surface);
        let diffuse = scattering.albedo() * (1.0 / PI);
        radiance[i] = diffuse * irradiance;
        if world.kind(hit.prim_id) != Kind::Matte {
            let beyond_diffuse = |direction: Vec3| {
                let (scattered, density) = scattering.eval(direction);
                (scattered - diffuse * surface.shading_normal.dot(direction).max(0.0), density)
            };
            let [a, b, v, _] = batch.samplers[i].uniform4(batch.first_set);
            let (how, numbers) = ((LightSampling::Direct, SkyPart::Sun), (unit_double(Vec2::new(a, b)), v));
            for shadow_ray in sample_direct_by(world, &surface, beyond_diffuse, how, numbers) {
                wave.shadow_queue.push(i as u32, Vec3::ONE, shadow_ray);
            }
        }
    }
    let shadow_rays = wave.shadow_queue.resolve(world, batch.times, radiance);
    shadow_rays + unmapped.follow(world, batch, wave, radiance)
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

#[cfg(test)]
mod tests {
    use glam::vec3;
    use halfdome_kernel::sampling::{Pattern, Stream};

    use super::*;
    use crate::fixtures::{square, sun};
    use crate::material::Inputs;
    use crate::scene::{CameraPose, Material, Scene};

    /// The same irradiance everywhere.
    struct Constant(f32);

    impl IrradianceMap for Constant {
        fn irradiance(&self, _: &Hit) -> Option<Vec3> {
            Some(Vec3::splat(self.0))
        }
    }

    /// A floor of this roughness under a low sun.
    fn floor(roughness: f32, to_sun: Vec3) -> World {
        let inputs = Inputs {
            base_color: vec3(0.5, 0.3, 0.2),
            specular_weight: 1.0,
            specular_roughness: roughness,
            ..Inputs::default()
        };
        World::new(Scene {
            meshes: vec![square(0.0, true, 0)],
            materials: vec![Material { inputs, ..Material::default() }],
            lights: vec![sun(to_sun)],
            camera: Some(CameraPose { eye: Vec3::Z, target: Vec3::ZERO, up: Vec3::Y, vfov: 40.0 }),
            ..Scene::default()
        })
        .unwrap()
    }

    /// The closure's direct light, and its albedo's share of the rest.
    #[test]
    fn gloss_reflects_the_sun_as_its_closure_does() {
        let to_sun = vec3(-0.9, 0.1, 0.3).normalize();
        for roughness in [0.25, 0.5, 0.8] {
            let world = floor(roughness, to_sun);
            let rays: Vec<Ray> = (0..200)
                .map(|i| {
                    let [x, y, z, _] = Stream::new(3, i, 0).uniform4(0);
                    let from = vec3(2.0 * x - 0.5, y - 0.5, 0.05 + z);
                    Ray::new(2.0 * from, -from.normalize())
                })
                .collect();
            let mut hits = vec![Hit::MISS; rays.len()];
            world.intersect_many_at(&rays, &[], &mut hits);
            let samplers: Vec<Sampler> = (0..200).map(|i| Sampler::new(Pattern::Random, 1, i, 0)).collect();
            let batch =
                RayBatch { rays: &rays, hits: &hits, samplers: &samplers, times: &[], first_set: 0, density: 0.0 };
            let map = Constant(to_sun.z + 0.4);
            let mut found = vec![Vec3::ZERO; rays.len()];
            let (mut wave, mut unmapped) = (Wavefront::default(), UnmappedHits::default());
            radiance(&world, &map, &batch, &mut wave, &mut unmapped, &mut found);
            let mut most = 0.0_f32;
            for ((ray, hit), found) in rays.iter().zip(&hits).zip(&found) {
                let scattering = world.scattering(&mut world.surface_at(hit).facing(ray.direction));
                let rest = scattering.albedo() * 0.4 / PI;
                let expected = scattering.eval(to_sun).0 + rest;
                assert!((*found - expected).abs().max_element() < 1e-5 * expected.max_element(), "{found} {expected}");
                most = most.max((expected.x - rest.x) / (scattering.albedo().x * to_sun.z / PI));
            }
            assert!(most > 1.3, "a diffuse surface would do as well: {most}");
        }
    }
}
