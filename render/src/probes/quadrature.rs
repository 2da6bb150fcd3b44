//! Directions and weights that integrate smooth functions over the sphere without error: Gauss's and Legendre's nodes
//! along z, and as many steps around as a ring needs. With `m` rings of `2m` directions, all polynomials of degree
//! `2m - 1` in x, y and z are exact; so are, for any `m` of 3 or more, the harmonics of light that has no finer detail.

use std::f64::consts::{PI, TAU};

use glam::DVec3;

/// A rule for the sphere.
#[derive(Clone, Debug)]
pub(super) struct Quadrature {
    /// Height and weight of the rings.
    rings: Vec<[f64; 2]>,
}

impl Quadrature {
    /// A quadrature with this many rings, at least 1.
    pub(super) fn new(rings: u32) -> Self {
        Self { rings: (0..rings).map(|ring| node(ring, rings)).collect() }
    }

    /// A quadrature with about this many directions, at least as many as the second degree needs.
    pub(super) fn with_directions(directions: u32) -> Self {
        Self::new(((f64::from(directions) / 2.0).sqrt().round() as u32).max(3))
    }

    /// Unit vectors with their weights, which add up to 4π.
    pub(super) fn points(&self) -> impl Iterator<Item = (DVec3, f64)> {
        let steps = 2 * self.rings.len();
        self.rings.iter().enumerate().flat_map(move |(ring, &[z, weight])| {
            let radius = (1.0 - z * z).sqrt();
            (0..steps).map(move |step| {
                // Every other ring is turned by half a step.
                let phi = TAU * (step as f64 + 0.5 * (ring % 2) as f64) / steps as f64;
                (DVec3::new(radius * phi.cos(), radius * phi.sin(), z), weight * TAU / steps as f64)
            })
        })
    }
}

/// A zero of the Legendre polynomial of degree `n`, by Newton's method, and its weight.
fn node(index: u32, n: u32) -> [f64; 2] {
    let n = f64::from(n);
    let mut z = (PI * (f64::from(index) + 0.75) / (n + 0.5)).cos();
    let mut slope = 1.0;
    for _ in 0..16 {
        // Bonnet's recursion.
        let (mut previous, mut value) = (1.0, z);
        let mut degree = 1.0;
        while degree < n {
            (previous, value) = (value, ((2.0 * degree + 1.0) * z * value - degree * previous) / (degree + 1.0));
            degree += 1.0;
        }
        slope = n * (z * value - previous) / (z * z - 1.0);
        z -= value / slope;
    }
    [z, 2.0 / ((1.0 - z * z) * slope * slope)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nodes_are_the_published_ones() {
        for (n, index, expected) in [
            (1, 0, [0.0, 2.0]),
            (2, 0, [1.0 / 3f64.sqrt(), 1.0]),
            (3, 0, [0.6f64.sqrt(), 5.0 / 9.0]),
            (3, 1, [0.0, 8.0 / 9.0]),
            (5, 0, [0.906_179_845_938_664, 0.236_926_885_056_189]),
        ] {
            let found = node(index, n);
            assert!((found[0] - expected[0]).abs() < 1e-14 && (found[1] - expected[1]).abs() < 1e-14, "{found:?}");
        }
    }

    /// `∫ x^a y^b z^c dω` is 4π (a-1)!! (b-1)!! (c-1)!! / (a+b+c+1)!! if all are even, else 0.
    #[test]
    fn polynomials_are_integrated_without_error() {
        let odd_factorial = |n: i32| (1..=n).rev().step_by(2).map(f64::from).product::<f64>();
        let rule = Quadrature::new(4);
        for (a, b, c) in (0..8).flat_map(|a| (0..8 - a).flat_map(move |b| (0..8 - a - b).map(move |c| (a, b, c)))) {
            let found: f64 = rule.points().map(|(d, w)| w * d.x.powi(a) * d.y.powi(b) * d.z.powi(c)).sum();
            let even = [a, b, c].iter().all(|power| power % 2 == 0);
            let product = odd_factorial(a - 1) * odd_factorial(b - 1) * odd_factorial(c - 1);
            let expected = if even { 4.0 * PI * product / odd_factorial(a + b + c + 1) } else { 0.0 };
            assert!((found - expected).abs() < 1e-13, "{a} {b} {c}: {found}, not {expected}");
        }
    }

    #[test]
    fn there_are_about_as_many_directions_as_asked_for() {
        for (asked, got) in [(1, 18), (128, 128), (1024, 1058), (1 << 20, 2 * 724 * 724)] {
            let rule = Quadrature::with_directions(asked);
            assert_eq!(rule.points().count() as u32, got);
        }
    }
}
