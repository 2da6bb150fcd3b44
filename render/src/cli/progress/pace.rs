//! Progress and pace of work in several stages.

use std::time::Duration;

/// The caches of a bake, of which the last may be filled several times.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Coverage {
    /// The number of unfinished caches.
    caches: u32,
    /// The texels that each serves.
    texels: u64,
    /// Whether the last may be refilled an unknown number of times: each time then counts as half of the remainder.
    again: bool,
    /// The finished work at the last restart.
    before: u64,
    /// The most that it served since.
    most: u64,
}

impl Coverage {
    /// The pace of `caches` caches, each for `texels` texels.
    pub(crate) fn new(caches: u32, texels: u64, again: bool) -> Self {
        Self { caches, texels, again, before: 0, most: 0 }
    }

    /// The finished part of a cache for this many texels.
    pub(crate) fn covered(&mut self, texels: u64) -> u64 {
        let texels = texels.min(self.texels);
        // Few texels lose their records while a cache is filled; most do when it is filled anew.
        if texels < self.most / 2 {
            (self.before, self.most) = (self.done(), 0);
        }
        self.most = self.most.max(texels);
        self.done()
    }

    fn done(&self) -> u64 {
        let part = if self.again && self.caches <= 1 { 0.5 } else { 1.0 };
        let left = self.texels.saturating_sub(self.before) as f64;
        self.before + (part * left * self.most as f64 / self.texels.max(1) as f64) as u64
    }

    /// Another cache follows.
    pub(crate) fn next(&mut self) {
        (self.caches, self.before, self.most) = (self.caches.saturating_sub(1), 0, 0);
    }
}

/// The rate of samples.
#[derive(Debug, Default)]
pub(super) struct Pace {
    /// The time at which there were none yet.
    idle: Duration,
    most: u64,
}

impl Pace {
    /// Samples, which are never fewer than before, and how many were taken since there were none; `now` is the time
    /// since the beginning.
    pub(crate) fn at(&mut self, samples: u64, now: Duration) -> (u64, Option<(u64, Duration)>) {
        self.most = self.most.max(samples);
        if self.most == 0 {
            self.idle = now;
            return (0, None);
        }
        (self.most, Some((self.most, now.saturating_sub(self.idle))))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_caches_cover_never_goes_back_though_the_last_is_filled_again() {
        let mut coverage = Coverage::new(2, 100, true);
        let covered = |coverage: &mut Coverage, points: &[u64]| -> Vec<u64> {
            points.iter().map(|&points| coverage.covered(points)).collect()
        };
        // Fewer texels are served again where records reach less far.
        assert_eq!(covered(&mut coverage, &[0, 60, 90, 85, 98]), [0, 60, 90, 90, 98]);
        coverage.next();
        assert_eq!(covered(&mut coverage, &[0, 80, 100, 0, 50, 100, 10, 100]), [0, 40, 50, 50, 62, 75, 76, 87]);
        // As many as there are, whatever the sites of deeper caches.
        assert_eq!(covered(&mut Coverage::new(1, 100, false), &[400]), [100]);
    }

    #[test]
    fn samples_never_go_back_and_their_pace_leaves_out_what_was_before() {
        let (mut pace, seconds) = (Pace::default(), Duration::from_secs);
        assert_eq!(pace.at(0, seconds(60)), (0, None));
        assert_eq!(pace.at(10, seconds(61)), (10, Some((10, seconds(1)))));
        assert_eq!(pace.at(5, seconds(62)), (10, Some((10, seconds(2)))));
    }
}
