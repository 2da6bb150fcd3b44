//! The fraction of a cell's bounces that are guided.
//!
//! The best density is proportional to what bounces find. The Kullback-Leibler divergence measures how far a density is
//! from that: it is less, the greater the sum of `c log p` over bounces that found `c` (Müller 2019; estimates of the
//! second moment itself depend on the few bounces that found most). Directions learned from one half of a cell's
//! bounces are validated on the other half, and vice versa, so that noise does not seem to help.

use super::GuideSample;
use super::directions::{DirectionTrees, to_square, weighted};

/// The candidates.
const FRACTIONS: [f32; 4] = [0.0, 0.25, 0.5, 0.75];
/// Guiding costs time: the mean logarithm of the density must grow by at least this much.
const WORTH: f64 = 0.1;

/// The fraction by which the density is closest to what these bounces find.
pub(super) fn best_fraction(samples: &[GuideSample], side: u8) -> f32 {
    let mut gains = [0.0; FRACTIONS.len()];
    let mut all = 0.0;
    for half in 0..2 {
        let of_half = |half| samples.iter().skip(half).step_by(2);
        let mut learned = weighted(of_half(half), side);
        if !learned.iter().any(|(_, light)| *light > 0.0) {
            return 0.0;
        }
        let mut trees = DirectionTrees::default();
        let tree = trees.add(&mut learned);
        for sample in of_half(1 - half) {
            let is_delta = sample.closure_density == f32::INFINITY;
            let (place, per_angle) = to_square(sample.direction, side);
            // The guide's density relative to the closure's.
            let guide = if is_delta { 0.0 } else { trees.density(tree, place) * per_angle / sample.closure_density };
            for (gain, fraction) in gains.iter_mut().zip(FRACTIONS) {
                let fraction = fraction * sample.share;
                *gain += f64::from(sample.light) * f64::from(fraction * guide + 1.0 - fraction).ln();
            }
            all += f64::from(sample.light);
        }
    }
    let best = (0..FRACTIONS.len()).max_by(|&a, &b| gains[a].total_cmp(&gains[b])).unwrap_or(0);
    if gains[best] > WORTH * all { FRACTIONS[best] } else { 0.0 }
}
