//! Emission that bounces of paths hit, weighted against light samples.

use glam::Vec3;
use halfdome_kernel::Ray;

use super::state::Path;
use crate::estimator::{SeenLight, emitted_density, seen_lights, seen_sky};
use crate::light::{SkyPart, SkyView};
use crate::settings::LightSampling;
use crate::world::{Between, Hit, Surface, World};

/// What a path sees of the sky in this view, that of its ray's direction, weighted against the light sample that might have
/// looked there; of the first rays of a gather, whose points sample the sun, the sky without it.
pub(super) fn sky(
    world: &World,
    (lights, part): (LightSampling, SkyPart),
    path: &Path,
    (ray, view): (&Ray, &SkyView),
) -> Vec3 {
    if path.is_first() && path.density == 0.0 {
        return world.lights.sky.ambient(view);
    }
    if path.density == f32::INFINITY {
        return sky_after_delta(world, path, view);
    }
    let receiver = path.receiver(ray.origin);
    let (radiance, density) = seen_sky(world, &receiver, (path.sky_probability, part), (ray.direction, view));
    radiance * lights.bounce_weight(path.density, density)
}

/// What a path whose last bounce had no density sees of the sky: without its sun if light samples of the surface
/// before know of mirrors and glass between.
#[inline(always)]
pub(super) fn sky_after_delta(world: &World, path: &Path, view: &SkyView) -> Vec3 {
    let sky = &world.lights.sky;
    if path.is_first() || path.sees_lights() { sky.radiance(view) } else { sky.beside_sun(view) }
}

/// Calls `see` with the lights of a size on the way of a path to what it has hit, which is a distance away at a time, and the
/// radiance of each, weighted against the light sample that might have found it.
pub(super) fn lights_on_the_way(
    world: &World,
    (lights, part): (LightSampling, SkyPart),
    path: &Path,
    ray: &Ray,
    (t_max, time): (f32, f32),
    mut see: impl FnMut(&SeenLight, Vec3),
) {
    if world.lights.sized.is_empty() || !path.sees_lights() {
        return;
    }
    seen_lights(world, ray, (t_max, time), |seen| {
        let by_sample = || seen.density(world, &path.receiver(ray.origin), part);
        let sampled = if path.density == f32::INFINITY { 0.0 } else { by_sample() };
        see(&seen, seen.radiance * lights.bounce_weight(path.density, sampled));
    });
}

/// Calls `see` with the lights of a size beyond panes, of which a path has hit the first, and the radiance of each that
/// comes straight through them, weighted against the light sample that finds it there too. Rays that continue through
/// the glass do not count it again.
pub(super) fn lights_beyond_panes(
    world: &World,
    (lights, part): (LightSampling, SkyPart),
    path: &Path,
    ray: &Ray,
    hit: &Hit,
    mut see: impl FnMut(&SeenLight, Vec3),
) {
    if path.density == f32::INFINITY || !path.sees_lights() || !world.is_clear_glass(hit) {
        return;
    }
    seen_lights(world, ray, (f32::INFINITY, hit.time), |seen| {
        let distance = seen.distance;
        if distance <= hit.t {
            return;
        }
        let shadow = if distance == f32::INFINITY { *ray } else { Ray::between(ray.origin, ray.at(distance)) };
        // Behind wedges light samples find all of it.
        if let Between::Panes { rest, transmittance: left, are_exact: true } = world.glass_between(&shadow, hit.time)
            && !world.occluded_at(&rest, hit.time)
        {
            let density = seen.density(world, &path.receiver(ray.origin), part);
            see(&seen, seen.radiance * left * lights.bounce_weight(path.density, density));
        }
    });
}

/// What the surface emits along the path, weighted against the light sample that might have found it: one with this
/// part of the sky.
#[inline(always)]
pub(super) fn emission(
    world: &World,
    (lights, part): (LightSampling, SkyPart),
    path: &Path,
    surface: &Surface,
    ray: &Ray,
    hit: &Hit,
) -> Vec3 {
    // Most surfaces emit nothing.
    if surface.emission == Vec3::ZERO || !surface.emits_towards(ray.direction) {
        return Vec3::ZERO;
    }
    if path.density == f32::INFINITY {
        return surface.emission;
    }
    // What a gather's first rays meet, light samples at its point have found.
    if path.is_first() {
        return if lights == LightSampling::Naive { surface.emission } else { Vec3::ZERO };
    }
    let density = emitted_density(world, &path.receiver(ray.origin), part, surface, ray, hit);
    surface.emission * lights.bounce_weight(path.density, density)
}
