//! The solids that a path is in, and what they leave of its light: `exp(-σ d)` (Beer-Lambert).
//!
//! A path enters a solid where it passes through the front of its surface, and leaves it through the back. The solid entered
//! last absorbs: so what stands in tinted glass is seen through glass, and wine may overlap its cup. A path that begins in a
//! solid knows of that only from the back that it meets. Refraction is between a solid and air, whatever else is there.

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

impl Media {
    /// What is left of light on its way to a boundary.
    pub(super) fn transmittance_to(&self, world: &World, boundary: &Boundary, distance: f32) -> Vec3 {
        let inside = match self.materials[0] {
            0 if boundary.is_back => boundary.material + 1,
            material => material,
        };
        transmittance(world, inside, distance)
    }

    /// What is left of light along a shadow ray. One without an end leaves the solid somewhere, or nothing would block it.
    pub(super) fn transmittance_along(&self, world: &World, ray: &Ray) -> Vec3 {
        let distance = ray.t_max * ray.direction.length();
        if distance < f32::INFINITY { transmittance(world, self.materials[0], distance) } else { Vec3::ONE }
    }

    /// What the path is in if it goes on from a boundary in this direction.
    pub(super) fn towards(mut self, world: &World, boundary: &Boundary, direction: Vec3) -> Self {
        if boundary.normal.dot(direction) >= 0.0 || world.absorption(boundary.material).is_none() {
            return self;
        }
        let material = boundary.material + 1;
        if !boundary.is_back {
            self.materials.rotate_right(1);
            self.materials[0] = material;
        } else if let Some(place) = self.materials.iter().position(|&other| other == material) {
            self.materials[place..].rotate_left(1);
            self.materials[MOST - 1] = 0;
        }
        self
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
