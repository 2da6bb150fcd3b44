//! Means of samples that are taken in rounds, until their standard error is small enough.
//!
//! Samples of one Sobol' sequence are correlated, so their variance does not give that of their mean. So there are
//! eight sequences with independent scrambles (Owen 1995), and the variance of their means gives the variance of the
//! result. A round doubles the number of samples.

use std::ops::Range;

use glam::DVec3;

/// Sequences: more would know the variance better, and be stratified less.
const SEQUENCES: u32 = 8;
/// Samples of a sequence in the first round ...
const FIRST: u32 = 4;
/// ... and the most.
const MOST: u32 = 2048;
/// Keeps the scrambles of sequences apart.
const SALT: u64 = 0x9e37_79b9_7f4a_7c15;

/// A mean, and what is known of it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RoundsMean {
    pub(crate) mean: DVec3,
    /// The square of its standard error, as a mean over the channels; up to twice as much in truth, as rounds end where it looks
    /// small.
    pub(crate) variance: f64,
    /// How many samples it is of.
    pub(crate) samples: u32,
}

/// The mean of `sample` with a standard error of at most `tolerance(mean)`, or of as many samples as there may be.
/// `sample(seed, numbers)` gives the sum of the samples of these numbers in the sequence of a seed.
pub(crate) fn mean_in_rounds(
    seed: u64,
    tolerance: impl Fn(DVec3) -> f64,
    mut sample: impl FnMut(u64, Range<u32>) -> DVec3,
) -> RoundsMean {
    let mut sums = [DVec3::ZERO; SEQUENCES as usize];
    let (mut done, mut count) = (0, FIRST);
    loop {
        for (number, sum) in (1..).zip(&mut sums) {
            *sum += sample(seed.wrapping_add(SALT.wrapping_mul(number)), done..count);
        }
        let means = sums.map(|sum| sum / f64::from(count));
        let mean = means.iter().sum::<DVec3>() / f64::from(SEQUENCES);
        let squares = means.iter().map(|of_one| (*of_one - mean).length_squared()).sum::<f64>();
        let variance = squares / (3.0 * f64::from(SEQUENCES * (SEQUENCES - 1)));
        if variance <= tolerance(mean).powi(2) || count >= MOST {
            return RoundsMean { mean, variance, samples: SEQUENCES * count };
        }
        (done, count) = (count, 2 * count);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use halfdome_kernel::sampling::Stream;

    /// Independent samples of a known variance: as many as that asks for, and an error as it was asked for.
    #[test]
    fn the_error_is_what_was_asked_for() {
        for tolerance in [0.1, 0.03] {
            let (mut squares, mut told, mut samples) = (0.0, 0.0, 0.0);
            let points = 2000;
            for point in 0..points {
                let uniform = |seed: u64, i| Stream::new(seed, point, i).uniform2(0).x;
                let found = mean_in_rounds(
                    7,
                    |_| tolerance,
                    |seed, numbers| {
                        numbers.map(|i| DVec3::splat(12f64.sqrt() * f64::from(uniform(seed, i) - 0.5))).sum()
                    },
                );
                squares += found.mean.x.powi(2);
                told += found.variance;
                samples += f64::from(found.samples);
            }
            let [squares, told, samples] = [squares, told, samples].map(|sum| sum / f64::from(points));
            assert!(squares.sqrt() < 1.1 * tolerance, "{} for {tolerance}", squares.sqrt());
            // Less than the truth, as means end where they look right.
            assert!((0.5..1.2).contains(&(told / squares)), "{told} told of {squares}");
            assert!(samples < 3.0 / (tolerance * tolerance), "{samples} samples for {tolerance}");
        }
        // No noise, no second round; noise without an end has one.
        assert_eq!(
            mean_in_rounds(1, |_| 0.0, |_, numbers| DVec3::ONE * numbers.len() as f64).samples,
            SEQUENCES * FIRST
        );
        let endless =
            mean_in_rounds(1, |_| 1e-9, |seed, numbers| DVec3::ONE * (seed % 97) as f64 * numbers.len() as f64);
        assert_eq!(endless.samples, SEQUENCES * MOST);
    }
}
