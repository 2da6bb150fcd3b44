//! Integrals over the microfacets that are visible, of which the tables of albedos are made.

use glam::{Vec2, Vec3};
use halfdome_kernel::sampling::r2;

use super::fresnel;
use super::ggx::{Ggx, reflect};

/// The weight of a reflection by a visible normal, `G₂/G₁`, where all is reflected.
pub(super) fn reflected(ggx: &Ggx, wo: Vec3, h: Vec3) -> f32 {
    let wi = reflect(wo, h);
    if wi.z > 0.0 { ggx.g2(wo, wi) / ggx.g1(wo) } else { 0.0 }
}

/// The albedo of reflection and refraction.
pub(super) fn interface(ggx: &Ggx, wo: Vec3, h: Vec3, cos: f32, eta: f32) -> f32 {
    let (reflectance, cos_beyond) = fresnel::dielectric(cos, eta);
    let refracted = if reflectance < 1.0 {
        let wi = (cos / eta - cos_beyond) * h - wo / eta;
        if wi.z < 0.0 { ggx.g2(wo, wi) / ggx.g1(wo) } else { 0.0 }
    } else {
        0.0
    };
    reflectance * reflected(ggx, wo, h) + (1.0 - reflectance) * refracted
}

/// The mean of a weight over the normals that are visible from a direction with this cosine. They are symmetric about
/// its plane: half of them do. There are more points where normals are steep: few are, but they reflect below the
/// horizon.
pub(super) fn integrate(ggx: &Ggx, cos: f32, weight: impl Fn(Vec3, Vec3, f32) -> f32) -> f32 {
    let mut sum = 0.0;
    each_visible(ggx, cos, |wo, h, share| sum += share * weight(wo, h, wo.dot(h).clamp(0.0, 1.0)));
    sum
}

/// Calls `see` with a direction of this cosine, with normals that are visible from there, and with the share of each.
pub(super) fn each_visible(ggx: &Ggx, cos: f32, mut see: impl FnMut(Vec3, Vec3, f32)) {
    const POINTS: u32 = 1024;
    let cos = cos.max(1e-4);
    let wo = Vec3::new(((1.0 - cos) * (1.0 + cos)).sqrt(), 0.0, cos);
    if ggx.alpha.x == 0.0 {
        return see(wo, Vec3::Z, 1.0);
    }
    let unit = |word: u32| (word >> 8) as f32 * (1.0 / 16_777_216.0);
    let shares: f32 = (0..POINTS).map(|point| unit(r2(point, [1 << 31; 2])[1])).sum();
    for point in 0..POINTS {
        let [x, y] = r2(point, [1 << 31; 2]);
        let (x, y) = (unit(x), unit(y));
        let h = ggx.sample_normal(wo, Vec2::new(0.5 * x, 1.0 - y * y));
        see(wo, h, y / shares);
    }
}
