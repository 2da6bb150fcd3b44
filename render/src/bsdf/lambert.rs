//! Lambert's closure without a branch, so that loops over it are vectorised; [`Matte`](crate::material::Matte) is the
//! same closure in a shading frame.

use std::f32::consts::FRAC_1_PI;

use glam::Vec3;

use super::Bounce;
use crate::world::Surface;

/// Of a surface whose normals face the side that light is reflected to.
impl Surface<'_> {
    /// Diffuse reflection in a direction about the normal, given by the cosine; and whether there is any.
    #[inline(always)]
    pub(crate) fn scatter(&self, local: Vec3) -> (Bounce, bool) {
        let sampled = self.frame().to_world(local);
        let height = self.normal.dot(sampled);
        let direction = self.above(sampled);
        let mirrored = self.shading_normal.dot(sampled) - 2.0 * height * self.normal.dot(self.shading_normal);
        let density = local.z * FRAC_1_PI + mirrored.max(0.0) * FRAC_1_PI;
        let reflects = (height != 0.0) & (self.diffuse.max_element() > 0.0);
        (Bounce { direction, weight: self.diffuse, density }, reflects)
    }

    /// The unit vector `direction`, mirrored if it leads below the surface, as a shading normal's hemisphere may: so
    /// what a surface receives about that normal has no gap, and is what its closure reflects.
    #[inline(always)]
    pub(crate) fn above(&self, direction: Vec3) -> Vec3 {
        direction - 2.0 * self.normal.dot(direction).min(0.0) * self.normal
    }

    /// `cos θ / π` of the unit vector `direction`, with that of the direction which is mirrored to it; 0 from behind.
    #[inline(always)]
    pub(crate) fn lambert(&self, direction: Vec3) -> f32 {
        let height = self.normal.dot(direction);
        let cosine = self.shading_normal.dot(direction);
        let mirrored = cosine - 2.0 * height * self.normal.dot(self.shading_normal);
        let sum = cosine.max(0.0) * FRAC_1_PI + mirrored.max(0.0) * FRAC_1_PI;
        if height > 0.0 { sum } else { 0.0 }
    }
}
