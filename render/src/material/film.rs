//! Thin-film interference: the reflectance of a film of some hundred nanometres on a base.
//!
//! Belcour and Barla, "A practical extension to microfacet theory for the modeling of varying iridescence" (2017): Airy's sum
//! in the Fourier domain of Gaussian fits to the observer's sensitivities. For each polarization, with `r_12` and `r_23` the
//! amplitudes that the film's two faces reflect, `ρ = -r_12 r_23`, `T = 1 - r_12²`, `R_s = T² r_23² / (1 - ρ²)` and
//! `Δ = 2 n d cos θ_2` the optical path difference,
//!
//! `F = r_12² + R_s + Σ_m 2 ρ^m (R_s - T) S(m Δ)`, of which two terms are taken.
//!
//! Deviations: a metal reflects both polarizations by Schlick's formula, as `KHR_materials_iridescence` has it; and white is
//! the colour of a film of no thickness, where the extension's formula is reddish, as it takes equal energy for D65.

use std::f32::consts::PI;

use glam::{Mat3, Vec3};
use halfdome_kernel::sampling::sin_cos_turns;

use super::Inputs;
use super::fresnel::{self, schlick};

/// A film on a part of a surface.
#[derive(Clone, Copy, Debug)]
pub struct Film {
    /// The part of the surface that it covers, 0 to 1.
    pub weight: f32,
    /// In nanometres.
    pub thickness: f32,
    /// Refractive index.
    pub ior: f32,
}

impl Film {
    /// The film of a material, if it has one.
    #[inline]
    pub(super) fn of(inputs: &Inputs) -> Option<Self> {
        let Inputs { thin_film_weight: weight, thin_film_thickness: thickness, thin_film_ior: ior, .. } = *inputs;
        (weight > 0.0).then_some(Self { weight, thickness, ior })
    }

    /// The reflectance over a dielectric of this refractive index, seen from outside.
    pub fn over_dielectric(&self, cos: f32, ior: f32) -> Vec3 {
        let (_, cos_film) = fresnel::dielectric(cos, self.ior);
        let (_, cos_base) = fresnel::dielectric(cos_film, ior / self.ior);
        if cos_base == 0.0 && ior < self.ior {
            return Vec3::ONE;
        }
        let base = amplitudes(cos_film, cos_base, ior / self.ior);
        self.interfere(cos, base.map(Vec3::splat))
    }

    /// The reflectance over a metal whose reflectance at normal incidence in air is `normal`.
    pub fn over_metal(&self, cos: f32, normal: Vec3) -> Vec3 {
        let (_, cos_film) = fresnel::dielectric(cos, self.ior);
        let root = normal.clamp(Vec3::ZERO, Vec3::splat(0.9999)).map(f32::sqrt);
        let ior = (1.0 + root) / (1.0 - root);
        let root = (ior - self.ior) / (ior + self.ior);
        let reflectance = root * root + (1.0 - root * root) * schlick(cos_film);
        let parallel = reflectance.map(f32::sqrt) * root.signum();
        self.interfere(cos, [-parallel, parallel])
    }

    /// Airy's sum, for the base's amplitudes: the mean of both polarizations.
    fn interfere(&self, cos: f32, base: [Vec3; 2]) -> Vec3 {
        let (_, cos_film) = fresnel::dielectric(cos, self.ior);
        let difference = 2.0 * self.ior * self.thickness * cos_film;
        let seen = [1.0, 2.0].map(|order| 2.0 * sensitivity(order * difference));
        let outer = amplitudes(cos, cos_film, self.ior);
        let mut sum = Vec3::ZERO;
        for (outer, base) in outer.into_iter().zip(base) {
            let reflected = outer * outer;
            let through = 1.0 - reflected;
            // Negative where one of the two reflections turns the wave by a half.
            let product = -outer * base;
            let single = through * through * base * base / (1.0 - product * product).max(Vec3::splat(1e-4));
            let term = (single - through) * product;
            sum += reflected + single + term * seen[0] + term * product * seen[1];
        }
        (0.5 * sum).clamp(Vec3::ZERO, Vec3::ONE)
    }
}

/// Fresnel's amplitudes, perpendicular and parallel.
fn amplitudes(cos: f32, cos_beyond: f32, eta: f32) -> [f32; 2] {
    [(cos - eta * cos_beyond) / (cos + eta * cos_beyond), (eta * cos - cos_beyond) / (eta * cos + cos_beyond)]
}

/// The observer's response to light whose reflectance varies as `cos(2π Δ/λ)`: 1 for a path difference of 0. The path
/// difference is in nanometres.
fn sensitivity(difference: f32) -> Vec3 {
    // Fits to the CIE 1931 observer: the position and variance of each lobe in cycles by metre, and its height.
    const HEIGHT: [f32; 4] = [5.4856e-13, 4.4201e-13, 5.2481e-13, 9.7470e-14];
    const POSITION: [f32; 4] = [1.6810e6, 1.7953e6, 2.2084e6, 2.2399e6];
    const VARIANCE: [f32; 4] = [4.3278e9, 9.3046e9, 6.6121e9, 4.5282e9];
    const NORM: f32 = 1.0685e-7;
    /// XYZ to linear sRGB.
    const TO_RGB: Mat3 = Mat3::from_cols(
        Vec3::new(3.240_454_2, -0.969_266, 0.055_643_4),
        Vec3::new(-1.537_138_5, 1.876_010_8, -0.204_025_9),
        Vec3::new(-0.498_531_4, 0.041_556, 1.057_225_2),
    );
    let metres = difference * 1e-9;
    let phase = 2.0 * PI * metres;
    let height = |k: usize| HEIGHT[k] * (2.0 * PI * VARIANCE[k]).sqrt() / NORM;
    let lobe = |k: usize| {
        let cycles = POSITION[k] * metres;
        height(k) * sin_cos_turns(cycles - cycles.floor()).1 * (-VARIANCE[k] * phase * phase).exp()
    };
    let seen = TO_RGB * Vec3::new(lobe(0) + lobe(3), lobe(1), lobe(2));
    seen / (TO_RGB * Vec3::new(height(0) + height(3), height(1), height(2)))
}
