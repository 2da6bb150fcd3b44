//! Path tracing (Kajiya 1986): `L = L_e + ∫ ρ/π L cos θ dω`, one sample of the integral a surface, with direct light
//! sampled as well at every surface.
//!
//! Light that both ways can find, from emissive triangles, is weighted by the power heuristic (Veach 1997); light that
//! one alone can find, from the sky or from points, counts in full. Bounces follow the cosine, so `ρ` is all that the
//! throughput is multiplied by. Russian roulette ends paths from the fourth surface on, with a survival of the largest
//! throughput, 0.95 at most.

use std::f32::consts::PI;

use glam::{Vec2, Vec3};
use halfdome_kernel::sampling::power;
use halfdome_kernel::sampling::warp::{CosineHemisphere, Warp};
use halfdome_kernel::{Hit, Ray};

use super::CameraRays;
use crate::estimator::{emitted_density, sample_light};
use crate::world::{Surface, World};

/// Sets of random numbers that a bounce uses: which light and whether to go on, where on the light, the next direction.
const SETS_PER_BOUNCE: u32 = 3;
/// Surfaces on a path before roulette begins.
const SURE_DEPTH: u32 = 3;
/// The most surfaces on a path that only chance ends.
pub(crate) const MAX_DEPTH: u32 = 1024;
/// The greatest probability of going on.
const MAX_SURVIVAL: f32 = 0.95;

/// A path that is under way.
struct Path {
    /// Its camera ray.
    index: usize,
    throughput: Vec3,
    /// Density per solid angle of its last bounce; infinite for the camera's ray, which no light sample competes with.
    density: f32,
}

/// Light that arrives if its shadow ray is free.
struct Pending {
    index: usize,
    radiance: Vec3,
}

/// All paths of a batch, side by side: element `i` of each list belongs to the same path, and finished ones are gone.
#[derive(Default)]
pub(crate) struct Wavefront {
    paths: Vec<Path>,
    rays: Vec<Ray>,
    hits: Vec<Hit>,
    shadows: Vec<Ray>,
    pending: Vec<Pending>,
    occluded: Vec<bool>,
}

/// Writes the radiance along each camera ray; gives the number of further rays.
pub(super) fn radiance(
    world: &World,
    max_depth: u32,
    camera: &CameraRays,
    wave: &mut Wavefront,
    radiance: &mut [Vec3],
) -> u64 {
    radiance.fill(Vec3::ZERO);
    wave.start(camera);
    let mut traced = 0;
    for depth in 1..=max_depth {
        wave.shade(world, camera, depth, max_depth, radiance);
        traced += wave.connect(world, radiance);
        if wave.paths.is_empty() {
            break;
        }
        traced += wave.trace(world);
    }
    traced
}

impl Wavefront {
    /// Starts a path with each camera ray, in the memory of the paths before.
    fn start(&mut self, camera: &CameraRays) {
        let path = |index| Path { index, throughput: Vec3::ONE, density: camera.density };
        self.paths.clear();
        self.paths.extend((0..camera.rays.len()).map(path));
        self.rays.clear();
        self.rays.extend_from_slice(camera.rays);
        self.hits.clear();
        self.hits.extend_from_slice(camera.hits);
    }

    /// Collects light at the paths' hits, samples lights there, and turns the paths to their next direction.
    fn shade(&mut self, world: &World, camera: &CameraRays, depth: u32, max_depth: u32, radiance: &mut [Vec3]) {
        let mut kept = 0;
        for i in 0..self.paths.len() {
            let (ray, hit, Path { index, throughput, density }) = (self.rays[i], self.hits[i], &self.paths[i]);
            let (index, throughput) = (*index, *throughput);
            if !hit.is_hit() {
                radiance[index] += throughput * world.sky.radiance;
                continue;
            }
            let surface = world.surface_at(&hit);
            radiance[index] += throughput * emission(world, &surface, &ray, hit.t, *density);
            if depth == max_depth {
                continue;
            }

            let surface = surface.facing(ray.direction);
            let albedo = surface.material.diffuse;
            let set = camera.first_set + (depth - 1) * SETS_PER_BOUNCE;
            let sampler = &camera.samplers[index];
            let Vec2 { x: choice, y: survival } = sampler.uniform2(set);
            if let Some(light) = sample_light(world, &surface, choice, sampler.uniform2(set + 1)) {
                let bounce_density = surface.shading_normal.dot(light.shadow.direction.normalize()).max(0.0) / PI;
                let radiance = throughput * light.reflected(albedo) * power(light.density, bounce_density);
                self.pending.push(Pending { index, radiance });
                self.shadows.push(light.shadow);
            }

            let mut throughput = throughput * albedo;
            if depth > SURE_DEPTH {
                let go_on = throughput.max_element().min(MAX_SURVIVAL);
                if survival >= go_on {
                    continue;
                }
                throughput /= go_on;
            }
            let local = CosineHemisphere.map(sampler.uniform2(set + 2));
            let direction = surface.frame().to_world(local);
            // A shading normal may send light through the surface: none comes from there.
            if surface.normal.dot(direction) <= 0.0 || throughput == Vec3::ZERO {
                continue;
            }
            self.paths[kept] = Path { index, throughput, density: local.z / PI };
            self.rays[kept] = Ray::new(surface.origin_towards(direction), direction);
            kept += 1;
        }
        self.paths.truncate(kept);
        self.rays.truncate(kept);
        self.hits.truncate(kept);
    }

    /// Adds the light whose shadow rays are free.
    fn connect(&mut self, world: &World, radiance: &mut [Vec3]) -> u64 {
        self.occluded.resize(self.shadows.len(), false);
        world.tree().occluded_many(&self.shadows, &mut self.occluded);
        for (light, occluded) in self.pending.iter().zip(&self.occluded) {
            if !occluded {
                radiance[light.index] += light.radiance;
            }
        }
        let traced = self.shadows.len() as u64;
        self.pending.clear();
        self.shadows.clear();
        traced
    }

    /// Finds the paths' next hits.
    fn trace(&mut self, world: &World) -> u64 {
        world.tree().intersect_many(&self.rays, &mut self.hits);
        self.rays.len() as u64
    }
}

/// What the surface emits along the path, weighted against the light sample that might have found it.
fn emission(world: &World, surface: &Surface, ray: &Ray, t: f32, bounce_density: f32) -> Vec3 {
    let emitted = surface.emitted(ray.direction);
    if emitted == Vec3::ZERO {
        return emitted;
    }
    emitted * power(bounce_density, emitted_density(world, surface, ray.direction, t))
}
