//! Bumps that a normal map draws keep light from each other, and reflect to each other what they catch.
//!
//! Where a map tilts the normal by `θd` from the smooth one, the part
//!
//! `G(ω) = 2 / (1 + √(1 + α² tan² θ))`, `α² = tan² θd / 8`, at most 1
//!
//! of light from a direction at the angle `θ` from the smooth normal reaches the bumps, and 0 from below the smooth
//! surface (Conty Estevez, Lecocq and Stein 2019, "A Microfacet-Based Shadowing Function to Solve the Bump Terminator
//! Problem"). The rest meets another bump first, which has the albedo `A` and reflects it on: closures are multiplied by
//! `1 - (1 - A) (1 - G)`. So white bumps lose no light, and dark ones most of what they catch.
//!
//! # Deviations
//!
//! The paper has `A = 0`. What another bump reflects on is taken to come from the direction in which it was going to be,
//! and is not caught again.

use bytemuck::{Pod, Zeroable};
use glam::Vec3;

/// The shadowing at a point. Its normal and the directions that it is asked for are of one frame.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct BumpShadowing {
    /// The normal without what maps do to it.
    smooth: Vec3,
    alpha2: f32,
    /// What bumps absorb of the light that they catch; 0 where the normal is not tilted.
    absorbed: Vec3,
}

impl BumpShadowing {
    /// No bumps.
    pub(crate) const NONE: Self = Self { smooth: Vec3::Z, alpha2: 0.0, absorbed: Vec3::ZERO };

    /// Of unit vectors, and of the albedo of the bumps around. Exactly 1 everywhere where both normals are equal.
    #[inline(always)]
    pub(crate) fn new(smooth: Vec3, tilted: Vec3, albedo: Vec3) -> Self {
        // By the chord, which is 0 for equal normals; `dot` may not be 1.
        let cos = 1.0 - 0.5 * (smooth - tilted).length_squared();
        let cos2 = cos.max(0.0) * cos.max(0.0);
        let alpha2 = (0.125 * (1.0 - cos2) / cos2.max(1e-6)).min(1.0);
        Self { smooth, alpha2, absorbed: if alpha2 > 0.0 { Vec3::ONE - albedo } else { Vec3::ZERO } }
    }

    /// Whether there are any; if not, [`factor`](Self::factor) is 1.
    #[inline]
    pub(crate) fn are_there(&self) -> bool {
        self.alpha2 > 0.0
    }

    /// The same in another frame.
    #[inline(always)]
    pub(crate) fn with_smooth(self, smooth: Vec3) -> Self {
        Self { smooth, ..self }
    }

    /// By what a closure is multiplied for light from the unit vector `wi`; where light is mirrored at the surface, from
    /// where the tilted normal has it.
    #[inline(always)]
    pub(crate) fn factor(&self, wi: Vec3) -> Vec3 {
        let cos = self.smooth.dot(wi);
        let tan2 = ((1.0 - cos) * (1.0 + cos)).max(0.0) / (cos * cos).max(1e-12);
        let reaches = 2.0 / (1.0 + (1.0 + self.alpha2 * tan2).sqrt());
        Vec3::ONE - self.absorbed * if cos > 0.0 { 1.0 - reaches } else { 1.0 }
    }

    /// The mean of [`factor`](Self::factor) for diffuse light, which loses `0.88 (1 - cos θd)` to other bumps, within 0.006
    /// up to 70°.
    #[inline]
    pub(crate) fn mean(&self) -> Vec3 {
        let cos = (1.0 + 8.0 * self.alpha2).sqrt().recip();
        Vec3::ONE - self.absorbed * (0.88 * (1.0 - cos))
    }
}
