//! Samples are as dense as densities say: Pearson's χ² test over bins of the sphere, with Šidák's correction.

use std::f64::consts::TAU;

use super::cases::{coloured, tilted};
use super::*;

const HEIGHTS: usize = 48;
const AZIMUTHS: usize = 64;
const SAMPLES: u32 = 60_000;
/// Bins of which less is expected are put together.
const LEAST: f64 = 8.0;

/// The height of bins, which are narrow at the horizon, where lobes are: `cos θ = h|h|`.
fn cosine(height: f64) -> f64 {
    height * height.abs()
}

/// The integral of the density over each bin of height and azimuth, by Gauss and Legendre's rule of 4 × 4 points.
fn expected(closure: &Closure, wo: Vec3) -> Vec<f64> {
    const NODES: [(f64, f64); 4] = [
        (0.069_431_844_202_973_71, 0.173_927_422_568_726_93),
        (0.330_009_478_207_571_87, 0.326_072_577_431_273_07),
        (0.669_990_521_792_428_1, 0.326_072_577_431_273_07),
        (0.930_568_155_797_026_3, 0.173_927_422_568_726_93),
    ];
    let area = 2.0 / HEIGHTS as f64 * TAU / AZIMUTHS as f64;
    let bin = |height: usize, azimuth: usize| -> f64 {
        let mut sum = 0.0;
        for (x, x_weight) in NODES {
            for (y, y_weight) in NODES {
                let height = 2.0 * (height as f64 + x) / HEIGHTS as f64 - 1.0;
                let azimuth = TAU * (azimuth as f64 + y) / AZIMUTHS as f64;
                let density = closure.eval(wo, direction(cosine(height) as f32, azimuth as f32)).density;
                sum += x_weight * y_weight * 2.0 * height.abs() * f64::from(density);
            }
        }
        sum * area
    };
    (0..HEIGHTS * AZIMUTHS).map(|k| bin(k / AZIMUTHS, k % AZIMUTHS)).collect()
}

/// The probability of a χ² of at least this much: Wilson and Hilferty 1931.
fn probability(chi_square: f64, freedom: f64) -> f64 {
    let variance = 2.0 / (9.0 * freedom);
    let z = ((chi_square / freedom).cbrt() - 1.0 + variance) / variance.sqrt();
    // The normal distribution's upper tail: Abramowitz and Stegun 26.2.17.
    let t = 1.0 / (1.0 + 0.231_641_9 * z.abs());
    let tail = (-0.5 * z * z).exp() / TAU.sqrt()
        * t
        * (0.319_381_530 + t * (-0.356_563_782 + t * (1.781_477_937 + t * (-1.821_255_978 + t * 1.330_274_429))));
    if z > 0.0 { tail } else { 1.0 - tail }
}

#[test]
fn samples_are_as_dense_as_told() {
    let cases: Vec<_> = coloured().into_iter().chain(tilted().into_iter().step_by(3)).collect();
    let cosines = [0.15, 0.7];
    let tests = (cases.len() * 2 * cosines.len()) as f64;
    let significance = 1.0 - 0.99f64.powf(1.0 / tests);
    for (number, (name, inputs)) in cases.into_iter().enumerate() {
        for is_inside in [false, true] {
            for cos in cosines {
                let closure = Closure::new(&inputs, is_inside);
                let wo = direction(cos, 0.7);
                let expected = expected(&closure, wo);
                let mut observed = vec![0u32; expected.len()];
                let mut elsewhere = 0;
                for i in 0..SAMPLES {
                    let u = Sampler::new(Pattern::Random, 5, number as u32, i).uniform2(0);
                    let Some(sample) = closure.sample(wo, u).filter(|sample| sample.density.is_finite()) else {
                        elsewhere += 1;
                        continue;
                    };
                    let turn = f64::from(sample.wi.y).atan2(f64::from(sample.wi.x)) / TAU;
                    let z = f64::from(sample.wi.z);
                    let height = (z.signum() * z.abs().sqrt() + 1.0) * 0.5 * HEIGHTS as f64;
                    let azimuth = (turn - turn.floor()) * AZIMUTHS as f64;
                    observed[(height as usize).min(HEIGHTS - 1) * AZIMUTHS + (azimuth as usize).min(AZIMUTHS - 1)] += 1;
                }
                // Absorbed, or a delta function: all that the density lacks.
                let lost = f64::from(elsewhere) / f64::from(SAMPLES);
                let total: f64 = expected.iter().sum::<f64>() + lost;
                assert!((total - 1.0).abs() < 0.01, "{name}, inside {is_inside}, cos {cos}: {total}, of which {lost}");

                let (mut chi_square, mut bins) = (0.0, 0);
                let (mut rest_expected, mut rest_observed) = (0.0, 0.0);
                for (&expected, &observed) in expected.iter().zip(&observed) {
                    let (expected, observed) = (expected * f64::from(SAMPLES), f64::from(observed));
                    if expected < LEAST {
                        rest_expected += expected;
                        rest_observed += observed;
                    } else {
                        chi_square += (observed - expected).powi(2) / expected;
                        bins += 1;
                    }
                }
                if rest_expected >= LEAST {
                    chi_square += (rest_observed - rest_expected).powi(2) / rest_expected;
                    bins += 1;
                }
                let probability = probability(chi_square, f64::from(bins - 1));
                assert!(
                    probability > significance,
                    "{name}, inside {is_inside}, cos {cos}: chi square {chi_square} of {bins} bins, probability {probability}"
                );
            }
        }
    }
}

#[test]
fn the_test_tells_what_is_likely() {
    for (chi_square, freedom, exact) in [(124.342, 100.0, 0.05), (135.807, 100.0, 0.01), (99.334, 100.0, 0.5)] {
        assert!((probability(chi_square, freedom) - exact).abs() < 0.002, "{}", probability(chi_square, freedom));
    }
    let closure = Closure::new(&crate::material::Inputs::default(), false);
    let sum: f64 = expected(&closure, direction(0.5, 0.0)).iter().sum();
    assert!((sum - 1.0).abs() < 1e-3, "{sum}");
}
