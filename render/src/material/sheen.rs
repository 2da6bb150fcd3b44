//! Fuzz: the sheen of fibres that stand on a surface.
//!
//! Zeltner, Burley and Chiang, "Practical multiple-scattering sheen using linearly transformed cosines" (2022), by the
//! rational fits to its table that MaterialX uses (Stephen Hill): of directions `w` in the frame whose x axis `wo` is above,
//!
//! `ρ(wo, wi) = E(wo) a² / (π ((a x + b z)² + (a y)² + z²)²)`, with `a`, `b` and `E` functions of `wo_z` and roughness.
//!
//! It is chosen over the Charlie distribution, which `KHR_materials_sheen` describes, as it is bounded, has a known albedo,
//! and is what Blender and OpenPBR use.
//!
//! Deviation: ρ is a fit to a reciprocal function, but is not exactly reciprocal itself; here `f = (ρ(wo, wi) + ρ(wi,
//! wo)) / 2`. Its albedo is tabled anew.

use std::array;
use std::f32::consts::PI;
use std::sync::LazyLock;

use glam::{Vec2, Vec3};
use halfdome_kernel::sampling::r2;
use halfdome_kernel::sampling::warp::{CosineHemisphere, Warp};

use super::column::Column;

/// Fuzz that is white and covers all.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sheen {
    roughness: f32,
    /// The fit's albedo, and that of what is made of it.
    fitted: Column,
    pub(super) albedo: Column,
}

/// The terms of one direction.
#[derive(Clone, Copy)]
struct Lobe {
    albedo: f32,
    a: f32,
    b: f32,
}

const ROUGHNESSES: usize = 33;
/// The fits are made for this much and more.
const LEAST_ROUGHNESS: f32 = 0.01;

impl Sheen {
    #[inline]
    pub(super) fn new(roughness: f32) -> Self {
        static ROWS: LazyLock<[[Column; 2]; ROUGHNESSES]> = LazyLock::new(|| {
            array::from_fn(|r| {
                let roughness = (r as f32 / (ROUGHNESSES - 1) as f32).max(LEAST_ROUGHNESS);
                let fitted = Column::from_fn(|cos| fitted_albedo(cos, roughness));
                let sheen = Sheen { roughness, fitted, albedo: fitted };
                [fitted, Column::from_fn(|cos| sheen.integrate(cos))]
            })
        });
        let roughness = roughness.max(LEAST_ROUGHNESS);
        let x = roughness * (ROUGHNESSES - 1) as f32;
        let r = (x as usize).min(ROUGHNESSES - 2);
        let column = |k: usize| ROWS[r][k].lerp(&ROWS[r + 1][k], x - r as f32);
        Self { roughness, fitted: column(0), albedo: column(1) }
    }

    #[inline]
    fn lobe(&self, cos: f32) -> Lobe {
        let (x, y) = (cos.clamp(0.0, 1.0), self.roughness);
        let a = (2.58126 * x + 0.813_703 * y) * y / (1.0 + 0.310_327 * x * x + 2.60994 * x * y);
        let b = (1.0 - x).sqrt() * (y - 1.0) * y * y * y
            / (0.000_025_405_3 + 1.71228 * x - 1.71506 * x * y + 1.34174 * y * y);
        Lobe { albedo: self.fitted.at(x), a, b }
    }

    /// `f(wo, wi)`, and the densities of `wi` and of `wo`; all above the horizon.
    #[inline]
    pub(super) fn eval(&self, wo: Vec3, wi: Vec3) -> (f32, f32, f32) {
        let (o, i) = (self.lobe(wo.z), self.lobe(wi.z));
        let dot = wo.truncate().dot(wi.truncate());
        let cross2 = wo.truncate().perp_dot(wi.truncate()).powi(2);
        // Densities by projected solid angle.
        let density = |lobe: &Lobe, from: Vec3, to: Vec3| {
            let sin = from.truncate().length();
            let (x, y2) = if sin > 1e-6 { (dot / sin, cross2 / (sin * sin)) } else { (to.x, to.y * to.y) };
            let across = lobe.a * x + lobe.b * to.z;
            let length2 = across * across + lobe.a * lobe.a * y2 + to.z * to.z;
            lobe.a * lobe.a / (PI * length2 * length2)
        };
        let (forth, back) = (density(&o, wo, wi), density(&i, wi, wo));
        (0.5 * (o.albedo * forth + i.albedo * back), forth * wi.z, back * wo.z)
    }

    /// A direction by the density for `wi`.
    #[inline]
    pub(super) fn sample(&self, wo: Vec3, u: Vec2) -> Vec3 {
        let Lobe { a, b, .. } = self.lobe(wo.z);
        let cosine = CosineHemisphere.map(u);
        let w = Vec3::new((cosine.x - b * cosine.z) / a, cosine.y / a, cosine.z).normalize();
        let sin = wo.truncate().length();
        let x = if sin > 1e-6 { wo.truncate() / sin } else { Vec2::X };
        Vec3::new(w.x * x.x - w.y * x.y, w.x * x.y + w.y * x.x, w.z)
    }

    fn integrate(&self, cos: f32) -> f32 {
        const POINTS: u32 = 512;
        let cos = cos.max(1e-4);
        let wo = Vec3::new(((1.0 - cos) * (1.0 + cos)).sqrt(), 0.0, cos);
        let mut sum = 0.0;
        for point in 0..POINTS {
            let [x, y] = r2(point, [1 << 31; 2]);
            let unit = |word: u32| (word >> 8) as f32 * (1.0 / 16_777_216.0);
            let (x, y) = (unit(x), unit(y));
            let wi = self.sample(wo, Vec2::new(x, y));
            let (f, density, _) = self.eval(wo, wi);
            sum += f * wi.z / density;
        }
        sum / POINTS as f32
    }
}

/// The fit to the model's albedo.
fn fitted_albedo(x: f32, y: f32) -> f32 {
    let s = y * (0.020_660_7 + 1.58491 * y) / (0.037_942_4 + y * (1.32227 + y));
    let m = y * (-0.193_854 + y * (-1.14885 + y * (1.7932 - 0.95943 * y * y))) / (0.046_391 + y);
    let o = y * (0.000_654_023 + (-0.020_781_8 + 0.119_681 * y) * y) / (1.26264 + y * (-1.92021 + y));
    let z = (x - m) / s;
    ((-0.5 * z * z).exp() / (s * (2.0 * PI).sqrt()) + o).clamp(0.0, 1.0)
}
