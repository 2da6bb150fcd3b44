//! Pictures of surfaces without lighting: colours, shading normals, albedo.

use glam::Vec3;

use super::RayBatch;
use crate::world::{Surface, World};

/// "A really simple single-threaded ray tracer that just displayed the color of the surface it hit" (Driscoll, less one
/// thread): what surfaces reflect or let through, and what they emit; the sky elsewhere.
pub(super) fn colors(world: &World, batch: &RayBatch, radiance: &mut [Vec3]) -> u64 {
    show(
        world,
        batch,
        radiance,
        |direction| world.lights.sky.radiance(&world.lights.sky.view(direction)),
        |surface, direction| {
            let emitted = surface.emitted(direction);
            world.scattering(&mut surface.facing(direction)).albedo() + emitted
        },
    )
}

/// Shading normals, from -1..=1 to 0..=1 per channel, on the side that the camera sees; black elsewhere.
pub(super) fn normals(world: &World, batch: &RayBatch, radiance: &mut [Vec3]) -> u64 {
    show(
        world,
        batch,
        radiance,
        |_| Vec3::ZERO,
        |surface, direction| surface.facing(direction).shading_normal * 0.5 + 0.5,
    )
}

/// The part of uniform light that surfaces scatter; black elsewhere.
pub(super) fn albedo(world: &World, batch: &RayBatch, radiance: &mut [Vec3]) -> u64 {
    let albedo = |surface: Surface, direction| world.scattering(&mut surface.facing(direction)).albedo();
    show(world, batch, radiance, |_| Vec3::ZERO, albedo)
}

/// Writes the `color` of the surface that each ray hits, or `elsewhere` by its direction where there is none.
fn show(
    world: &World,
    batch: &RayBatch,
    radiance: &mut [Vec3],
    elsewhere: impl Fn(Vec3) -> Vec3,
    color: impl Fn(Surface, Vec3) -> Vec3,
) -> u64 {
    for ((ray, hit), radiance) in batch.rays.iter().zip(batch.hits).zip(radiance) {
        *radiance = match hit.is_hit() {
            true => color(world.surface_at(hit), ray.direction),
            false => elsewhere(ray.direction),
        };
    }
    0
}
