//! Thin-film interference: the reflectance of a film of some hundred nanometres on a base.
//!
//! Belcour and Barla, "A practical extension to microfacet theory for the modeling of varying iridescence" (2017), as
//! `KHR_materials_iridescence` simplifies it: Airy's sum in the Fourier domain of Gaussian fits to the observer's
//! sensitivities, with the same phases for both polarisations. With `R_12` and `R_23` the reflectances of the film's two
//! faces, `ρ = √(R_12 R_23)`, `R_s = T_12² R_23 / (1 - ρ²)`, `Δ = 2 n d cos θ_2` the optical path difference and `φ` the
//! phase shift,
//!
//! `F = R_12 + R_s + Σ_m 2 ρ^m (R_s - T_12) S(m Δ, m φ)`, of which two terms are taken.
//!
//! Deviations: the faces are Fresnel's, not Schlick's; and white is the colour of a film of no thickness, where the
//! extension's formula is reddish, as it takes equal energy for D65.

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
    /// Of a material that has one.
    #[inline]
    pub(super) fn of(inputs: &Inputs) -> Option<Self> {
        let Inputs { thin_film_weight: weight, thin_film_thickness: thickness, thin_film_ior: ior, .. } = *inputs;
        (weight > 0.0).then_some(Self { weight, thickness, ior })
    }

    /// The reflectance over a dielectric of this refractive index, seen from outside.
    pub fn over_dielectric(&self, cos: f32, ior: f32) -> Vec3 {
        let (_, cos_film) = fresnel::dielectric(cos, self.ior);
        let (base, _) = fresnel::dielectric(cos_film, ior / self.ior);
        let turns = Vec3::splat(if ior < self.ior { 0.5 } else { 0.0 });
        self.interfere(cos, Vec3::splat(base), turns)
    }

    /// The reflectance over a metal whose reflectance at normal incidence in air is `normal`.
    pub fn over_metal(&self, cos: f32, normal: Vec3) -> Vec3 {
        let (_, cos_film) = fresnel::dielectric(cos, self.ior);
        let root = normal.clamp(Vec3::ZERO, Vec3::splat(0.9999)).map(f32::sqrt);
        let ior = (1.0 + root) / (1.0 - root);
        let below = (ior - self.ior) / (ior + self.ior);
        let below = below * below;
        let base = below + (1.0 - below) * schlick(cos_film);
        let turns = ior.map(|ior| if ior < self.ior { 0.5 } else { 0.0 });
        self.interfere(cos, base, turns)
    }

    /// Airy's sum. `turns`: the phase shift at the base, 0 or a half.
    fn interfere(&self, cos: f32, base: Vec3, turns: Vec3) -> Vec3 {
        let (outer, cos_film) = fresnel::dielectric(cos, self.ior);
        // And a half at the top, where the film is denser than what is outside, between the first reflection and others.
        let turns = turns + 0.5;
        let through = 1.0 - outer;
        let product = (outer * base).clamp(Vec3::splat(1e-5), Vec3::splat(0.9999));
        let root = product.map(f32::sqrt);
        let single = through * through * base / (1.0 - product);
        let difference = 2.0 * self.ior * self.thickness * cos_film;
        let mut sum = outer + single;
        let mut term = single - through;
        for order in [1.0, 2.0] {
            term *= root;
            sum += term * (2.0 * sensitivity(order * difference, order * turns));
        }
        sum.clamp(Vec3::ZERO, Vec3::ONE)
    }
}

/// Of light that is reflected alike at all wavelengths but for `cos(2π Δ/λ + φ)`, the part that is seen: 1 for no path
/// difference and no shift. In nanometres and turns.
fn sensitivity(difference: f32, turns: Vec3) -> Vec3 {
    // Fits to the CIE 1931 observer: position and variance of each lobe in cycles by metre, and its height.
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
    let lobe = |k: usize, turns: f32| {
        let height = HEIGHT[k] * (2.0 * PI * VARIANCE[k]).sqrt() / NORM;
        let cycles = POSITION[k] * metres + turns;
        height * sin_cos_turns(cycles - cycles.floor()).1 * (-VARIANCE[k] * phase * phase).exp()
    };
    let seen = |turns: f32| TO_RGB * Vec3::new(lobe(0, turns) + lobe(3, turns), lobe(1, turns), lobe(2, turns));
    let at_zero = TO_RGB
        * Vec3::from_array([
            (HEIGHT[0] * VARIANCE[0].sqrt() + HEIGHT[3] * VARIANCE[3].sqrt()) * (2.0 * PI).sqrt() / NORM,
            HEIGHT[1] * (2.0 * PI * VARIANCE[1]).sqrt() / NORM,
            HEIGHT[2] * (2.0 * PI * VARIANCE[2]).sqrt() / NORM,
        ]);
    Vec3::new(seen(turns.x).x, seen(turns.y).y, seen(turns.z).z) / at_zero
}
