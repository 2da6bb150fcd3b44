//! Pictures for looking at geometry: shading normals and diffuse reflectance. Rays that hit nothing are black.

use glam::Vec3;

use super::CameraRays;
use crate::world::{Surface, World};

/// Shading normals, from -1..=1 to 0..=1 per channel, on the side that the camera sees.
pub(super) fn normals(world: &World, camera: &CameraRays, radiance: &mut [Vec3]) -> u64 {
    show(world, camera, radiance, |surface| surface.shading_normal * 0.5 + 0.5)
}

/// Diffuse reflectance.
pub(super) fn albedo(world: &World, camera: &CameraRays, radiance: &mut [Vec3]) -> u64 {
    show(world, camera, radiance, |surface| surface.material.diffuse)
}

fn show(world: &World, camera: &CameraRays, radiance: &mut [Vec3], color: impl Fn(&Surface) -> Vec3) -> u64 {
    for ((ray, hit), radiance) in camera.rays.iter().zip(camera.hits).zip(radiance) {
        *radiance = match hit.is_hit() {
            true => color(&world.surface_at(hit).facing(ray.direction)),
            false => Vec3::ZERO,
        };
    }
    0
}
