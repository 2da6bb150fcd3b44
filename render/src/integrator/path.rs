//! Path tracing (Kajiya 1986): `L = L_e + ∫ f L cos θ dω`, one sample of the integral a surface.
//!
//! Shirley's first program is `LightSampling::Naive`: a ray hits a surface, adds what it emits, and goes on by the
//! cosine. `Direct` samples a light at every surface as well, and leaves out what the next bounce would find again;
//! `Mis` weights both by the power heuristic (Veach 1997). The module [`bsdf`](crate::bsdf) says why mirrors and the
//! first surface need no rule of their own.
//!
//! Each surface reflects a part of the light, and a path may stop when little is left ([`Stop`]): where the product of
//! all reflectances falls below a threshold, with the scene's mean radiance in place of what is left out or without, or
//! by Russian roulette, where a path that survives with the probability `p` counts for `1/p`.

use glam::Vec3;
use halfdome_kernel::Ray;

use super::wavefront::{Arrival, Connections, Path, Walk};
use super::{CameraRays, Wavefront};
use crate::estimator::{connect, emitted_density, sky_density};
use crate::settings::{LightSampling, PathOptions, Stop, Survival};
use crate::world::{Surface, World};

/// Writes the radiance along each camera ray; gives the number of further rays.
///
/// `watch` sees the rays that are to be traced before they are: the shadow rays of each bounce, and the paths'.
pub(super) fn radiance(
    world: &World,
    options: &PathOptions,
    camera: &CameraRays,
    wave: &mut Wavefront,
    radiance: &mut [Vec3],
    watch: &mut dyn FnMut(&Wavefront),
) -> u64 {
    wave.follow(world, camera, &mut PathTracer { world, options, watch }, radiance)
}

struct PathTracer<'a> {
    world: &'a World,
    options: &'a PathOptions,
    watch: &'a mut dyn FnMut(&Wavefront),
}

impl Walk for PathTracer<'_> {
    fn max_depth(&self) -> u32 {
        self.options.max_depth
    }

    fn takes_chances(&self, depth: u32) -> bool {
        matches!(self.options.stop, Stop::Roulette { after, .. } if depth > after)
    }

    /// Collects light, samples a light, and bounces.
    #[inline(always)]
    fn step(
        &mut self,
        path: Path,
        &Arrival { depth, ray, hit, ref numbers }: &Arrival,
        connections: &mut Connections,
        radiance: &mut Vec3,
    ) -> Option<(Path, Ray)> {
        let (world, &PathOptions { max_depth, lights, stop }) = (self.world, self.options);
        if !hit.is_hit() {
            *radiance += path.throughput * sky(world, lights, &path, ray.direction);
            return None;
        }
        let surface = world.surface_at(hit);
        *radiance += path.throughput * emission(world, lights, &path, &surface, ray, hit.t);
        if depth == max_depth {
            return None;
        }

        let surface = surface.facing(ray.direction);
        let reflected = path.throughput * surface.reflectance();
        if let Stop::Threshold { cutoff, add_back } = stop
            && reflected.max_element() < cutoff
        {
            if add_back {
                *radiance += reflected * world.lights.mean_radiance();
            }
            return None;
        }
        if let Some(connection) = connect(world, &surface, lights, numbers.light()) {
            connections.push(path.index, path.throughput, connection);
        }
        let mut throughput = path.throughput;
        if let Stop::Roulette { after, survival } = stop
            && depth > after
        {
            let survival = survive(survival, reflected);
            if numbers.chance >= survival {
                return None;
            }
            throughput /= survival;
        }
        let bounce = surface.sample_with(ray.direction, numbers.onwards, numbers.cosine)?;
        let next = Path {
            index: path.index,
            throughput: throughput * bounce.weight,
            density: bounce.density,
            sky_density: sky_density(world, &surface, bounce.direction),
        };
        Some((next, Ray::new(surface.origin_towards(bounce.direction), bounce.direction)))
    }

    fn watch(&mut self, wave: &Wavefront) {
        (self.watch)(wave);
    }
}

/// The probability with which roulette lets a path go on of whose light `reflected` is left.
pub(super) fn survive(survival: Survival, reflected: Vec3) -> f32 {
    match survival {
        Survival::Constant(probability) => probability,
        Survival::Throughput { max } => reflected.max_element().min(max),
    }
}

/// What a path sees of the sky in its direction, weighted against the light sample that might have looked there.
pub(super) fn sky(world: &World, lights: LightSampling, path: &Path, direction: Vec3) -> Vec3 {
    world.sky.radiance(direction) * lights.of_bounce(path.density, path.sky_density)
}

/// What the surface emits along the path, weighted against the light sample that might have found it.
#[inline(always)]
pub(super) fn emission(
    world: &World,
    lights: LightSampling,
    path: &Path,
    surface: &Surface,
    ray: &Ray,
    t: f32,
) -> Vec3 {
    // Most surfaces emit nothing.
    if surface.emission == Vec3::ZERO || !surface.emits_towards(ray.direction) {
        return Vec3::ZERO;
    }
    surface.emission * lights.of_bounce(path.density, emitted_density(world, surface, ray.direction, t))
}
