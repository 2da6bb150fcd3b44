//! The solids that a path is in, and their transmittance `exp(-σ d)` (Beer-Lambert).
//!
//! A path enters a solid where it passes through the front of its surface, and leaves it through the back. The solid
//! entered last absorbs: so objects in tinted glass are seen through the glass, and wine may overlap its cup. A path
//! that begins in a solid is only known to be inside when it hits a back. Refraction is always between a solid and air.

use glam::Vec3;
use halfdome_kernel::Ray;

use crate::world::{Boundary, World};

/// Solids that a path may be in at once; of more, those entered first are forgotten.
const MOST: usize = 4;

/// The solids that a path is in.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Media {
    /// Numbers of materials, plus one; 0 for none. The one entered last comes first.
    materials: [u32; MOST],
}

/// A path where it has arrived at what may be the surface of a solid.
#[derive(Clone, Copy)]
pub(super) struct Arrival<'w> {
    pub(super) world: &'w World,
    pub(super) media: Media,
    pub(super) boundary: Boundary,
}

impl Media {
    /// The transmittance over a distance in these solids, if no surface is hit.
    pub(super) fn transmittance(&self, world: &World, distance: f32) -> Vec3 {
        if distance < f32::INFINITY { transmittance(world, self.materials[0], distance) } else { Vec3::ONE }
    }
}

impl Arrival<'_> {
    /// The transmittance on the way to the hit.
    pub(super) fn transmittance(&self, distance: f32) -> Vec3 {
        let inside = match self.media.materials[0] {
            0 if self.boundary.is_back => self.boundary.material + 1,
            material => material,
        };
        transmittance(self.world, inside, distance)
    }

    /// The transmittance along a shadow ray from there. A ray without an end leaves the solid somewhere, or would be
    /// blocked.
    pub(super) fn transmittance_of(&self, shadow_ray: &Ray) -> Vec3 {
        let distance = shadow_ray.t_max * shadow_ray.direction.length();
        let inside = self.onwards(shadow_ray.direction).materials[0];
        if distance < f32::INFINITY { transmittance(self.world, inside, distance) } else { Vec3::ONE }
    }

    /// The media of the path if it continues in this direction.
    pub(super) fn onwards(&self, direction: Vec3) -> Media {
        let Self { world, mut media, boundary } = *self;
        if boundary.normal.dot(direction) >= 0.0 || world.absorption(boundary.material).is_none() {
            return media;
        }
        let material = boundary.material + 1;
        if !boundary.is_back {
            media.materials.rotate_right(1);
            media.materials[0] = material;
        } else if let Some(place) = media.materials.iter().position(|&other| other == material) {
            media.materials[place..].rotate_left(1);
            media.materials[MOST - 1] = 0;
        }
        media
    }
}

fn transmittance(world: &World, material: u32, distance: f32) -> Vec3 {
    match material.checked_sub(1).and_then(|material| world.absorption(material)) {
        Some(absorption) if absorption != Vec3::ZERO => (-distance * absorption).exp(),
        _ => Vec3::ONE,
    }
}

#[cfg(test)]
mod tests;
