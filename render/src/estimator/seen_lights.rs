//! Punctual lights with a size that rays from mirrors and glossy surfaces hit.
//!
//! A light sample at such a surface is one direction in the cap that the light subtends. Where the surface's lobe is
//! narrower than the cap, bounces have less variance, and at a mirror only they find the light.

use glam::Vec3;
use halfdome_kernel::Ray;

use super::punctual;
use crate::light::{Light, Receiver, SkyPart};
use crate::world::World;

/// A light that a ray has met.
pub(crate) struct SeenLight {
    /// Its number among all lights.
    pub number: u32,
    pub radiance: Vec3,
    /// The distance; infinite for a sun.
    pub distance: f32,
    solid_angle: f32,
}

impl SeenLight {
    /// The density per solid angle with which a light sample at `receiver`, among all lights and this part of the sky, looks there.
    pub(crate) fn density(&self, world: &World, receiver: &Receiver, part: SkyPart) -> f32 {
        world.lights.punctual_probability(self.number, receiver, part) / self.solid_angle
    }
}

/// Calls `see` with all lights that a ray in a unit vector meets by a distance, where they are at a time.
pub(crate) fn seen_lights(world: &World, ray: &Ray, (t_max, time): (f32, f32), mut see: impl FnMut(SeenLight)) {
    let mut meet = |number: u32| {
        let Light::Punctual(light) = &world.lights.lights()[number as usize] else { return };
        let moved = world.motion().and_then(|_| world.moved_light(number, light, time));
        if let Some(seen) = punctual::seen(ray, t_max, moved.as_ref().unwrap_or(light)) {
            let punctual::Seen { radiance, distance, solid_angle } = seen;
            see(SeenLight { number, radiance, distance, solid_angle });
        }
    };
    let sized = &world.lights.sized;
    sized.along(ray, &mut meet);
    if t_max == f32::INFINITY {
        sized.suns().iter().for_each(|&number| meet(number));
    }
}

#[cfg(test)]
mod tests;
