//! Timing tracers against each other, and comparing their results.
//!
//! All tracers take turns in every round, so that a machine that slows down slows all of them; a ratio is the median of
//! the rounds' ratios, which drift cancels from.

use std::time::Instant;

use halfdome_kernel::Hit;

use crate::rays::RaySet;
use crate::tracer::Tracer;

/// How far two tracers' distances may be apart for the same hit, relative to the nearer.
pub const TOLERANCE: f32 = 1e-4;

/// What a tracer answers for a set of rays.
#[derive(Clone, Debug, PartialEq)]
pub enum Answers {
    /// The nearest hit of each ray.
    Nearest(Vec<Hit>),
    /// Whether each ray hits anything.
    Any(Vec<bool>),
}

impl Answers {
    /// Traces `set` with `tracer`.
    pub fn of(tracer: &dyn Tracer, set: &RaySet) -> Self {
        let mut answers = if set.kind.any_hit() {
            Self::Any(vec![false; set.rays.len()])
        } else {
            Self::Nearest(vec![Hit::MISS; set.rays.len()])
        };
        answers.trace(tracer, set);
        answers
    }

    /// Traces again, writing over these answers, which are of the same set.
    fn trace(&mut self, tracer: &dyn Tracer, set: &RaySet) {
        match self {
            Self::Nearest(hits) => tracer.intersect(&set.rays, hits),
            Self::Any(occluded) => tracer.occluded(&set.rays, occluded),
        }
    }

    /// How many rays hit something.
    pub fn hits(&self) -> usize {
        match self {
            Self::Nearest(hits) => hits.iter().filter(|hit| hit.is_hit()).count(),
            Self::Any(occluded) => occluded.iter().filter(|&&occluded| occluded).count(),
        }
    }

    /// A hash of every bit of `t` and `prim_id`, or of every answer, in order.
    pub fn checksum(&self) -> u64 {
        let mix = |hash: u64, word: u64| (hash ^ word).wrapping_mul(0x9E37_79B9_7F4A_7C15).rotate_left(29);
        match self {
            Self::Nearest(hits) => {
                hits.iter().fold(0, |hash, hit| mix(hash, u64::from(hit.t.to_bits()) << 32 | u64::from(hit.prim_id)))
            }
            Self::Any(occluded) => occluded.iter().fold(0, |hash, &occluded| mix(hash, 1 + u64::from(occluded))),
        }
    }

    /// Where the answers of another tracer to the same rays differ. That it names another primitive at the same
    /// distance does not count, for two may be equally near.
    pub fn difference(&self, other: &Self) -> Difference {
        let mut difference = Difference::default();
        match (self, other) {
            (Self::Nearest(a), Self::Nearest(b)) => a.iter().zip(b).for_each(|(a, b)| difference.count_hits(a, b)),
            (Self::Any(a), Self::Any(b)) => a.iter().zip(b).for_each(|(&a, &b)| difference.count(a, b)),
            _ => panic!("answers to different questions"),
        }
        difference
    }

    /// The numbers of the rays to which another tracer's answers [differ](Self::difference).
    pub fn differing<'a>(&'a self, other: &'a Self) -> impl Iterator<Item = usize> + 'a {
        (0..self.len()).filter(move |&number| {
            let mut difference = Difference::default();
            match (self, other) {
                (Self::Nearest(a), Self::Nearest(b)) => difference.count_hits(&a[number], &b[number]),
                (Self::Any(a), Self::Any(b)) => difference.count(a[number], b[number]),
                _ => panic!("answers to different questions"),
            }
            difference.rays() > 0
        })
    }

    /// Whether another tracer finds the same: as many hits, and the same for at least 9,999 rays in 10,000.
    pub fn agrees_with(&self, other: &Self) -> bool {
        self.hits() == other.hits() && self.difference(other).rays() * 10_000 <= self.len()
    }

    /// How many rays were traced.
    #[expect(clippy::len_without_is_empty, reason = "nobody asks whether there are none")]
    pub fn len(&self) -> usize {
        match self {
            Self::Nearest(hits) => hits.len(),
            Self::Any(occluded) => occluded.len(),
        }
    }
}

/// For how many rays a tracer's answers differ from another's, and how.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Difference {
    /// Rays that only the first says hit something.
    pub missed: usize,
    /// Rays that only the other says hit something.
    pub extra: usize,
    /// Rays that both say hit something, at distances farther apart than [`TOLERANCE`].
    pub apart: usize,
}

impl Difference {
    /// All rays with different answers.
    pub fn rays(&self) -> usize {
        self.missed + self.extra + self.apart
    }

    fn count(&mut self, first: bool, other: bool) {
        self.missed += usize::from(first && !other);
        self.extra += usize::from(other && !first);
    }

    fn count_hits(&mut self, first: &Hit, other: &Hit) {
        let (both, nearer) = (first.is_hit() && other.is_hit(), first.t.min(other.t));
        self.apart += usize::from(both && (first.t - other.t).abs() > TOLERANCE * nearer);
        self.count(first.is_hit(), other.is_hit());
    }
}

/// A tracer's speed, and what it answered.
#[derive(Clone, Debug)]
pub struct Timing {
    /// Million rays a second, one figure a round.
    pub rates: Vec<f64>,
    /// Its answers, the same in every round.
    pub answers: Answers,
}

impl Timing {
    /// The median rate in million rays a second; NaN without a round.
    pub fn rate(&self) -> f64 {
        median(self.rates.clone())
    }

    /// The median over the rounds of how many times as fast as `other` this was, in the same run.
    pub fn ratio(&self, other: &Self) -> f64 {
        median(self.rates.iter().zip(&other.rates).map(|(a, b)| a / b).collect())
    }
}

/// Times the tracers on `set`, in turns, `rounds` times each after a round that is not timed.
pub fn interleaved(tracers: &[&dyn Tracer], set: &RaySet, rounds: usize) -> Vec<Timing> {
    let warm_up =
        |tracer: &&dyn Tracer| Timing { rates: Vec::with_capacity(rounds), answers: Answers::of(*tracer, set) };
    let mut timings: Vec<Timing> = tracers.iter().map(warm_up).collect();
    for _ in 0..rounds {
        for (tracer, timing) in tracers.iter().zip(&mut timings) {
            let start = Instant::now();
            timing.answers.trace(*tracer, set);
            timing.rates.push(set.rays.len() as f64 / start.elapsed().as_secs_f64() / 1e6);
        }
    }
    timings
}

/// The middle value, or the mean of the two in the middle; NaN of nothing.
pub fn median(mut values: Vec<f64>) -> f64 {
    values.sort_unstable_by(f64::total_cmp);
    let half = values.len() / 2;
    match values.len() {
        0 => f64::NAN,
        n if n % 2 == 1 => values[half],
        _ => 0.5 * (values[half - 1] + values[half]),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn hits(t: &[f32]) -> Answers {
        let hit = |&t: &f32| if t.is_finite() { Hit { t, prim_id: 7, ..Hit::MISS } } else { Hit::MISS };
        Answers::Nearest(t.iter().map(hit).collect())
    }

    #[test]
    fn medians() {
        assert_eq!(median(vec![3.0, 1.0, 2.0]), 2.0);
        assert_eq!(median(vec![4.0, 1.0, 2.0, 3.0]), 2.5);
        assert!(median(Vec::new()).is_nan());
    }

    #[test]
    fn ratios_are_taken_round_by_round() {
        let timing = |rates: &[f64]| Timing { rates: rates.to_vec(), answers: hits(&[]) };
        // Both slow down in the second round, and the ratio does not.
        assert_eq!(timing(&[4.0, 1.0, 6.0]).ratio(&timing(&[2.0, 0.5, 3.0])), 2.0);
    }

    #[test]
    fn checksums_see_every_bit_and_the_order() {
        let base = hits(&[1.0, 2.0, f32::INFINITY]).checksum();
        assert_ne!(base, hits(&[1.0, 2f32.next_up(), f32::INFINITY]).checksum());
        assert_ne!(base, hits(&[2.0, 1.0, f32::INFINITY]).checksum());
        let mut other_prim = hits(&[1.0, 2.0, f32::INFINITY]);
        let Answers::Nearest(list) = &mut other_prim else { unreachable!() };
        list[1].prim_id = 8;
        assert_ne!(base, other_prim.checksum());
        assert_ne!(Answers::Any(vec![true, false]).checksum(), Answers::Any(vec![false, true]).checksum());
        assert_ne!(Answers::Any(vec![false]).checksum(), Answers::Any(vec![false, false]).checksum());
    }

    #[test]
    fn answers_agree_within_the_tolerance() {
        let base = hits(&[1.0, 100.0, f32::INFINITY]);
        assert_eq!(base.hits(), 2);
        assert_eq!(base.difference(&hits(&[1.00009, 99.991, f32::INFINITY])), Difference::default());
        let difference = base.difference(&hits(&[1.0002, f32::INFINITY, 5.0]));
        assert_eq!(difference, Difference { missed: 1, extra: 1, apart: 1 });
        assert_eq!(difference.rays(), 3);
        assert!(base.agrees_with(&base));
        assert!(!base.agrees_with(&hits(&[1.0, f32::INFINITY, f32::INFINITY])));
        let difference = Answers::Any(vec![true, false]).difference(&Answers::Any(vec![true, true]));
        assert_eq!(difference, Difference { missed: 0, extra: 1, apart: 0 });
    }

    #[test]
    fn one_ray_in_ten_thousand_may_differ() {
        let base = vec![1.0; 10_000];
        let mut one = base.clone();
        one[3] = 2.0;
        let mut two = one.clone();
        two[4] = 2.0;
        assert!(hits(&base).agrees_with(&hits(&one)));
        assert!(!hits(&base).agrees_with(&hits(&two)));
    }
}
