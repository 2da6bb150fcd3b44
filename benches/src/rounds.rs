//! The rounds of a benchmark, and the median of their times.

use std::time::Instant;

use clap::Args;

use crate::measure::median;

/// The arguments that all benchmarks have.
#[derive(Args, Clone, Copy, Debug)]
pub struct Rounds {
    /// How many rounds to take the median of
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = clap::value_parser!(u16).range(1..))]
    rounds: u16,
    /// Run everything once, untimed
    #[arg(long)]
    test: bool,
    /// What `cargo bench` passes
    #[arg(long, hide = true)]
    bench: bool,
}

impl Rounds {
    /// The number of timed rounds: none in a test, or without the argument that `cargo bench` passes.
    pub fn timed(&self) -> u16 {
        if self.test || !self.bench { 0 } else { self.rounds }
    }
}

/// The median time of an operation, in nanoseconds, where `round` does `operations` of them; a dash without rounds.
pub fn nanoseconds(rounds: u16, operations: usize, mut round: impl FnMut()) -> String {
    let times = (0..rounds).map(|_| {
        let start = Instant::now();
        round();
        start.elapsed().as_secs_f64() * 1e9 / operations as f64
    });
    match median(times.collect()) {
        time if time.is_nan() => "-".into(),
        time => format!("{time:.2}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rounds_are_counted() {
        for rounds in [0, 3] {
            let mut count = 0;
            let time = nanoseconds(rounds, 10, || count += 1);
            assert_eq!((count, time == "-"), (rounds, rounds == 0));
        }
    }
}
