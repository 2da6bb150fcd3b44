//! Spherical harmonics up to the second degree: radiance around a point in nine numbers a channel.
//!
//! They are real and orthonormal over the sphere, and all signs are positive, without the factor `(-1)ᵐ` of Condon and
//! Shortley: `Y₀₀ = ½ √(1/π)`, `Y₁₋₁, Y₁₀, Y₁₁ = √(3/4π) (y, z, x)`, `Y₂₋₂, Y₂₋₁, Y₂₁ = ½ √(15/π) (xy, yz, xz)`,
//! `Y₂₀ = ¼ √(5/π) (3z² - 1)`, `Y₂₂ = ¼ √(15/π) (x² - y²)`, in this order of l and then of m, in world space. So have
//! them Ramamoorthi and Hanrahan, "An Efficient Representation for Irradiance Environment Maps" (2001), three.js and
//! others.
//!
//! A coefficient is `L_lm = ∫ L Y_lm dω`, and irradiance `E(n) = Σ A_l L_lm Y_lm(n)` with `A = π, 2π/3, π/4`. What is
//! left out by ending there is at most a few percent of the irradiance, and may make it negative opposite to a small
//! bright light.

use std::f64::consts::PI;

use glam::{DVec3, Vec3};

/// Names of the nine, by degree and order.
pub const NAMES: [&str; 9] = ["0", "1-1", "10", "11", "2-2", "2-1", "20", "21", "22"];

/// The nine at a unit vector.
pub fn basis(DVec3 { x, y, z }: DVec3) -> [f64; 9] {
    let zeroth = 0.5 / PI.sqrt();
    let first = (3.0 / (4.0 * PI)).sqrt();
    let second = 0.5 * (15.0 / PI).sqrt();
    let about_z = 0.25 * (5.0 / PI).sqrt() * (3.0 * z * z - 1.0);
    let across = 0.5 * second * (x * x - y * y);
    [zeroth, first * y, first * z, first * x, second * x * y, second * y * z, about_z, second * x * z, across]
}

/// Irradiance on a surface with this unit normal, W/m² if the coefficients are of radiance. Channels may be negative.
pub fn irradiance(coefficients: &[Vec3; 9], normal: Vec3) -> Vec3 {
    let lobes = [PI, 2.0 * PI / 3.0, PI / 4.0];
    let degree = |i: usize| [0, 1, 1, 1, 2, 2, 2, 2, 2][i];
    let terms = coefficients.iter().zip(basis(normal.as_dvec3())).enumerate();
    terms.map(|(i, (value, y))| value.as_dvec3() * (lobes[degree(i)] * y)).sum::<DVec3>().as_vec3()
}

#[cfg(test)]
mod tests {
    use super::super::quadrature::Quadrature;
    use super::*;

    #[test]
    fn they_are_orthonormal() {
        let sphere = Quadrature::new(8);
        for i in 0..9 {
            for j in 0..9 {
                let product: f64 = sphere.points().map(|(d, weight)| weight * basis(d)[i] * basis(d)[j]).sum();
                assert!((product - f64::from(u8::from(i == j))).abs() < 1e-13, "{i} {j}: {product}");
            }
        }
    }

    /// The constants that Ramamoorthi and Hanrahan print, at directions where a single function is not zero or all
    /// signs show.
    #[test]
    fn values_and_signs_are_the_published_ones() {
        let near = |found: f64, expected: f64| assert!((found - expected).abs() < 1e-6, "{found}, not {expected}");
        let [x, y, z] = [DVec3::X, DVec3::Y, DVec3::Z].map(basis);
        near(x[0], 0.282_095);
        near(y[1], 0.488_603);
        near(z[2], 0.488_603);
        near(x[3], 0.488_603);
        near(z[6], 0.315_392 * 2.0);
        near(x[8], 0.546_274);
        let d = DVec3::new(1.0, 2.0, 2.0) / 3.0;
        near(basis(d)[4], 1.092_548 * 2.0 / 9.0);
        near(basis(d)[5], 1.092_548 * 4.0 / 9.0);
        near(basis(d)[7], 1.092_548 * 2.0 / 9.0);
    }

    /// Of polynomials up to the second degree, whose irradiance has a closed form: `π (a + 2/3 b·n + 1/4 (q(n) -
    /// trace/3) + trace/3)` for `L = a + b·d + q(d)`.
    #[test]
    fn irradiance_of_what_is_smooth_is_exact() {
        let light =
            |d: DVec3| 1.0 + 0.5 * d.x - 0.25 * d.y + 0.75 * d.z + 0.6 * d.x * d.y + 0.9 * d.z * d.z - 0.3 * d.x * d.z;
        let quadratic = |d: DVec3| 0.6 * d.x * d.y + 0.9 * d.z * d.z - 0.3 * d.x * d.z;
        let mut coefficients = [Vec3::ZERO; 9];
        for (d, weight) in Quadrature::new(6).points() {
            for (sum, y) in coefficients.iter_mut().zip(basis(d)) {
                *sum += Vec3::splat((weight * y * light(d)) as f32);
            }
        }
        for n in [DVec3::X, DVec3::NEG_Z, DVec3::new(0.48, -0.6, 0.64)] {
            let linear = DVec3::new(0.5, -0.25, 0.75).dot(n);
            let expected = PI * (1.0 + 2.0 / 3.0 * linear + 0.25 * (quadratic(n) - 0.3) + 0.3);
            let found = irradiance(&coefficients, n.as_vec3()).x;
            assert!((f64::from(found) - expected).abs() < 1e-5, "{n}: {found}, not {expected}");
        }
    }
}
