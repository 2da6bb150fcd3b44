//! Light that paths find by themselves, weighted against the light samples that might have found it too.

use glam::Vec3;
use halfdome_kernel::Ray;

use super::state::Path;
use crate::estimator::emitted_density;
use crate::light::SkyPart;
use crate::settings::LightSampling;
use crate::world::{Hit, Surface, World};

/// What a path sees of the sky in its direction, weighted against the light sample that might have looked there.
pub(super) fn sky(world: &World, lights: LightSampling, path: &Path, direction: Vec3) -> Vec3 {
    world.lights.sky.radiance(direction) * lights.bounce_weight(path.density, path.sky_density)
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
