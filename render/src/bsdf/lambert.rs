//! Lambert's closure without a branch, so that loops over it are vectorised; [`Matte`](crate::material::Matte) is the
//! same closure in a shading frame.

use std::f32::consts::FRAC_1_PI;

use glam::Vec3;

use super::Bounce;
use crate::material::{BumpShadowing, bent_normal};
use crate::world::Surface;

/// Of a surface whose normals face the side that light is reflected to.
impl Surface<'_> {
    /// Diffuse reflection in a direction about the normal, given by the cosine; and whether there is any. As
    /// [`lambert`](Self::lambert), without [`bump_shadowing`](Self::bump_shadowing).
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

    /// Bends the shading normal to the viewer, as closures do.
    pub(crate) fn bend(&mut self) {
        let bent = bent_normal(self.normal, self.shading_normal, self.wo);
        if self.smooth_normal == self.shading_normal {
            // Nor has it bumps then.
            self.smooth_normal = bent;
        }
        self.shading_normal = bent;
    }

    /// The factor on light that a matte surface reflects from the unit vector `direction` by the shadowing of bumps that a
    /// normal map draws: of the direction itself and of the one that is mirrored to it.
    #[inline(always)]
    pub(crate) fn bump_shadowing(&self, direction: Vec3) -> Vec3 {
        let bumps = BumpShadowing::new(self.smooth_normal, self.shading_normal, self.diffuse);
        let mirrored = direction - 2.0 * self.normal.dot(direction) * self.normal;
        let [cosine, of_mirrored] = [self.shading_normal.dot(direction), self.shading_normal.dot(mirrored)];
        let (cosine, of_mirrored) = (cosine.max(f32::MIN_POSITIVE), of_mirrored.max(0.0));
        let sum = cosine * bumps.factor(direction) + of_mirrored * bumps.factor(mirrored);
        sum / (cosine + of_mirrored)
    }

    /// The part of a cosine lobe about the shading normal that is above the smooth surface.
    pub(crate) fn seen_above(&self) -> f32 {
        1.0 - 0.25 * (self.smooth_normal - self.shading_normal).length_squared()
    }
}
