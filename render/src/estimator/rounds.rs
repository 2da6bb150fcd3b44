//! Means of samples that are taken in rounds, until their standard error is small enough.
//!
//! Samples of one Sobol' sequence are correlated, so their variance does not give that of their mean. So there are
//! eight sequences with independent scrambles (Owen 1995), and the variance of their means gives the variance of the
//! result. A round doubles the number of samples.

use std::ops::Range;

use glam::DVec3;

/// Sequences: more would know the variance better, and be stratified less.
const SEQUENCES: usize = 8;
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
    let (mut sequences, mut count) = (Sequences::<SEQUENCES>::default(), FIRST);
    loop {
        sequences.extend(seed, count, &mut sample);
        let found = sequences.mean();
        if found.variance <= tolerance(found.mean).powi(2) || count >= MOST {
            return found;
        }
        count *= 2;
    }
}

/// The mean of at least `samples` samples in two sequences, of which each has as many, and its standard error. Two are
/// enough where the mean of many such variances is wanted, and are stratified best.
pub(crate) fn mean_of_halves(seed: u64, samples: u32, mut sample: impl FnMut(u64, Range<u32>) -> DVec3) -> RoundsMean {
    let mut halves = Sequences::<2>::default();
    halves.extend(seed, samples.div_ceil(2).max(1), &mut sample);
    halves.mean()
}

/// Sums of the samples of sequences.
struct Sequences<const N: usize> {
    sums: [DVec3; N],
    /// Samples of each.
    count: u32,
}

impl<const N: usize> Default for Sequences<N> {
    fn default() -> Self {
        Self { sums: [DVec3::ZERO; N], count: 0 }
    }
}

impl<const N: usize> Sequences<N> {
    /// Takes samples until there are `count` of each sequence.
    fn extend(&mut self, seed: u64, count: u32, sample: &mut impl FnMut(u64, Range<u32>) -> DVec3) {
        for (number, sum) in (1..).zip(&mut self.sums) {
            *sum += sample(seed.wrapping_add(SALT.wrapping_mul(number)), self.count..count);
        }
        self.count = count;
    }

    /// The mean of all samples.
    fn mean(&self) -> RoundsMean {
        let number = N as f64;
        let means = self.sums.map(|sum| sum / f64::from(self.count));
        let mean = means.iter().sum::<DVec3>() / number;
        let squares = means.iter().map(|of_one| (*of_one - mean).length_squared()).sum::<f64>();
        let variance = squares / (3.0 * number * (number - 1.0));
        RoundsMean { mean, variance, samples: N as u32 * self.count }
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
            SEQUENCES as u32 * FIRST
        );
        let endless =
            mean_in_rounds(1, |_| 1e-9, |seed, numbers| DVec3::ONE * (seed % 97) as f64 * numbers.len() as f64);
        assert_eq!(endless.samples, SEQUENCES as u32 * MOST);
    }
}
