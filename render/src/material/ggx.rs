//! The microfacets of rough surfaces: GGX, anisotropic, with height-correlated masking and shadowing.
//!
//! Trowbridge and Reitz 1975; Walter, Marschner, Li and Torrance 2007; Heitz 2014. With `h` a microfacet's normal,
//!
//! `D(h) = 1 / (π α_x α_y (h_x²/α_x² + h_y²/α_y² + h_z²)²)`,
//! `Λ(w) = (√(1 + (α_x² w_x² + α_y² w_y²)/w_z²) - 1) / 2`, `G₁ = 1/(1 + Λ)`, `G₂ = 1/(1 + Λ(wo) + Λ(wi))`.
//!
//! Visible normals are sampled by spherical caps (Dupuy and Benyoub 2023); those of reflections by caps that are cut
//! where they would mostly reflect below the horizon (Eto and Tokuyoshi 2023).

use std::f32::consts::PI;

use bytemuck::{Pod, Zeroable};
use glam::{Vec2, Vec3};
use halfdome_kernel::sampling::sin_cos_turns;

use super::DELTA_ALPHA;

/// A distribution of microfacets.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct Ggx {
    /// `α_x`, `α_y`.
    pub alpha: Vec2,
}

impl Ggx {
    /// The distribution by OpenPBR's roughness and anisotropy, 0 to 1.
    #[inline(always)]
    pub fn new(roughness: f32, anisotropy: f32) -> Self {
        let ratio = 1.0 - anisotropy;
        let x = roughness * roughness * (2.0 / (1.0 + ratio * ratio)).sqrt();
        let alpha = Vec2::new(x, ratio * x).min(Vec2::ONE);
        if alpha.max_element() < DELTA_ALPHA {
            Self { alpha: Vec2::ZERO }
        } else {
            Self { alpha: alpha.max(Vec2::splat(DELTA_ALPHA)) }
        }
    }

    /// Whether it is a mirror.
    #[inline(always)]
    pub fn is_delta(&self) -> bool {
        self.alpha.x == 0.0
    }

    /// The roughness of isotropic microfacets whose albedo is about the same: 0 of a mirror.
    #[inline(always)]
    pub fn mean_roughness(&self) -> f32 {
        (0.5 * self.alpha.length_squared()).sqrt().sqrt()
    }

    /// Density of microfacets, by solid angle and projected area.
    #[inline(always)]
    pub fn d(&self, h: Vec3) -> f32 {
        let slope = h.truncate() / self.alpha;
        let e = slope.length_squared() + h.z * h.z;
        1.0 / (PI * self.alpha.x * self.alpha.y * e * e)
    }

    /// Smith's Λ, for a direction on either side.
    #[inline(always)]
    pub fn lambda(&self, w: Vec3) -> f32 {
        let tan2 = (self.alpha * w.truncate()).length_squared() / (w.z * w.z);
        0.5 * ((1.0 + tan2).sqrt() - 1.0)
    }

    /// The part of microfacets that is seen from `w`.
    #[inline(always)]
    pub fn g1(&self, w: Vec3) -> f32 {
        1.0 / (1.0 + self.lambda(w))
    }

    /// The part of microfacets that is seen from both directions.
    #[inline(always)]
    pub fn g2(&self, wo: Vec3, wi: Vec3) -> f32 {
        1.0 / (1.0 + self.lambda(wo) + self.lambda(wi))
    }

    /// The microfacet normal that `wo` sees: density [`normal_density`](Self::normal_density).
    #[inline(always)]
    pub fn sample_normal(&self, wo: Vec3, u: Vec2) -> Vec3 {
        let stretched = self.stretch(wo);
        self.cap(stretched, stretched.z, u)
    }

    /// Density per solid angle of `sample_normal`.
    #[inline(always)]
    pub fn normal_density(&self, wo: Vec3, h: Vec3) -> f32 {
        self.d(h) * self.g1(wo) * wo.dot(h).abs() / wo.z.abs()
    }

    /// A microfacet normal for a reflection.
    #[inline(always)]
    pub fn sample_reflection(&self, wo: Vec3, u: Vec2) -> Vec3 {
        let stretched = self.stretch(wo);
        self.cap(stretched, self.bound(wo) * stretched.z, u)
    }

    /// Density per solid angle of the direction that [`sample_reflection`](Self::sample_reflection) reflects to. Its
    /// integral lacks what is reflected below the horizon.
    #[inline(always)]
    pub fn reflection_density(&self, wo: Vec3, h: Vec3) -> f32 {
        let length = ((self.alpha * wo.truncate()).length_squared() + wo.z * wo.z).sqrt();
        self.d(h) / (2.0 * (self.bound(wo) * wo.z + length))
    }

    #[inline(always)]
    fn stretch(&self, w: Vec3) -> Vec3 {
        (self.alpha * w.truncate()).extend(w.z).normalize()
    }

    /// How far down the cap of reflections reaches: equation 5 of Eto and Tokuyoshi.
    #[inline(always)]
    fn bound(&self, wo: Vec3) -> f32 {
        let a2 = self.alpha.min_element() * self.alpha.min_element();
        let s = 1.0 + wo.truncate().length();
        let s2 = s * s;
        (1.0 - a2) * s2 / (s2 + a2 * wo.z * wo.z)
    }

    /// A point of the spherical cap above `-bound`, halved with the stretched direction.
    #[inline(always)]
    fn cap(&self, stretched: Vec3, bound: f32, u: Vec2) -> Vec3 {
        let (sin_phi, cos_phi) = sin_cos_turns(u.x);
        let z = (1.0 - u.y) * (1.0 + bound) - bound;
        let sin = ((1.0 - z) * (1.0 + z)).max(0.0).sqrt();
        let h = Vec3::new(sin * cos_phi, sin * sin_phi, z) + stretched;
        (self.alpha * h.truncate()).extend(h.z.max(0.0)).normalize_or(Vec3::Z)
    }
}

/// The mirror image of `w` about the unit vector `h`.
#[inline(always)]
pub fn reflect(w: Vec3, h: Vec3) -> Vec3 {
    2.0 * w.dot(h) * h - w
}

/// The normal that reflects one direction to the other, and its cosine with both: the same if they change places.
#[inline(always)]
pub fn half(wo: Vec3, wi: Vec3) -> (Vec3, f32) {
    let sum = wo + wi;
    let length = sum.length();
    (sum / length.max(f32::MIN_POSITIVE), (0.5 * length).min(1.0))
}
