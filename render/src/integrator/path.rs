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

use glam::{Vec2, Vec3};
use halfdome_kernel::sampling::unit_double;
use halfdome_kernel::{Hit, Ray};

use super::wavefront::{Connections, Path};
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
    mut watch: impl FnMut(&Wavefront),
) -> u64 {
    radiance.fill(Vec3::ZERO);
    wave.start(camera);
    let mut traced = 0;
    for depth in 1..=options.max_depth {
        let bounce = Step { world, options, depth };
        wave.advance(world, camera, depth, |path, ray, hit, numbers, connections| {
            bounce.take(path, ray, hit, numbers, connections, &mut radiance[path.index])
        });
        watch(wave);
        traced += wave.connect(world, radiance);
        if wave.is_empty() {
            break;
        }
        traced += wave.trace(world);
    }
    traced
}

/// What all paths do at their surface number `depth`.
struct Step<'a> {
    world: &'a World,
    options: &'a PathOptions,
    depth: u32,
}

impl Step<'_> {
    /// Takes `path` from its hit to its next ray: collects light, samples a light, and bounces.
    #[inline]
    fn take(
        &self,
        path: Path,
        ray: &Ray,
        hit: &Hit,
        [first, on_light, onwards]: [Vec2; 3],
        connections: &mut Connections,
        radiance: &mut Vec3,
    ) -> Option<(Path, Ray)> {
        let Self { world, options: PathOptions { max_depth, lights, .. }, depth } = *self;
        if !hit.is_hit() {
            *radiance += path.throughput * sky(world, *lights, &path, ray.direction);
            return None;
        }
        let surface = world.surface_at(hit);
        *radiance += path.throughput * emission(world, *lights, &path, &surface, ray, hit.t);
        if depth == *max_depth {
            return None;
        }

        let surface = surface.facing(ray.direction);
        // The choice takes its last bits from the chance of going on: as neither enters the other's term of the sum, that
        // makes no bias.
        let (choice, chance) = (unit_double(first), first.y);
        let reflected = path.throughput * surface.reflectance();
        if let Stop::Threshold { cutoff, add_back } = self.options.stop
            && reflected.max_element() < cutoff
        {
            if add_back {
                *radiance += reflected * world.lights.mean_radiance();
            }
            return None;
        }
        if let Some(connection) = connect(world, &surface, *lights, choice, on_light) {
            connections.push(path.index, path.throughput, connection);
        }
        let survival = self.survival(reflected);
        if chance >= survival {
            return None;
        }
        let bounce = surface.sample(ray.direction, onwards)?;
        let next = Path {
            index: path.index,
            throughput: path.throughput * bounce.weight / survival,
            density: bounce.density,
            sky_density: sky_density(world, &surface, bounce.direction),
        };
        Some((next, Ray::new(surface.origin_towards(bounce.direction), bounce.direction)))
    }

    /// The probability of going on from a surface after which `reflected` of the path's light is left.
    fn survival(&self, reflected: Vec3) -> f32 {
        match self.options.stop {
            Stop::Roulette { after, survival } if self.depth > after => survive(survival, reflected),
            _ => 1.0,
        }
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
pub(super) fn emission(
    world: &World,
    lights: LightSampling,
    path: &Path,
    surface: &Surface,
    ray: &Ray,
    t: f32,
) -> Vec3 {
    let emitted = surface.emitted(ray.direction);
    if emitted == Vec3::ZERO {
        return emitted;
    }
    emitted * lights.of_bounce(path.density, emitted_density(world, surface, ray.direction, t))
}
