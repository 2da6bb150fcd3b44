//! Progress on stderr while a render runs: a bar for people, lines of JSON for programs.
//!
//! The render's threads add to two counters and never wait; a thread of its own looks at them now and then.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::thread::{Builder, JoinHandle};
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use serde_json::{Value, json};

use super::interrupt;
use super::messages::{Style, print_line};
use crate::watch::Watch;

const BAR_INTERVAL: Duration = Duration::from_millis(100);
const JSON_INTERVAL: Duration = Duration::from_millis(500);

/// Watches a render and shows how far it is.
pub(super) struct Progress {
    counters: Arc<Counters>,
    counted: Counted,
    reporter: Option<(Sender<()>, JoinHandle<()>)>,
}

#[derive(Default)]
struct Counters {
    samples: AtomicU64,
    rays: AtomicU64,
    records: AtomicU64,
    covered: AtomicU64,
}

/// What is counted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Counted {
    /// Samples.
    Samples,
    /// Samples, after irradiance records.
    Records,
    /// Texels, and irradiance records.
    Texels,
    /// Parts of a picture that is denoised.
    Parts,
}

/// How far a render is.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Snapshot {
    samples: u64,
    /// 0 if nobody knows.
    total: u64,
    rays: u64,
    /// Irradiance records made.
    records: u64,
    counted: Counted,
    elapsed: Duration,
}

impl Progress {
    /// Shows the progress towards `total` samples from now on.
    pub(super) fn start(style: Style, total: u64) -> Self {
        Self::counting(style, total, Counted::Samples)
    }

    /// Shows the progress towards `total` samples after irradiance records, or with 0 towards nobody knows how many of these.
    pub(super) fn of_records(style: Style, total: u64) -> Self {
        Self::counting(style, total, Counted::Records)
    }

    /// Shows the progress towards `total` texels.
    pub(super) fn of_texels(style: Style, total: u64) -> Self {
        Self::counting(style, total, Counted::Texels)
    }

    /// Shows how far a picture is denoised, of which there are `total` parts.
    pub(super) fn of_denoising(style: Style, total: u64) -> Self {
        Self::counting(style, total, Counted::Parts)
    }

    fn counting(style: Style, total: u64, counted: Counted) -> Self {
        let counters = Arc::new(Counters::default());
        let seen = Arc::clone(&counters);
        let start = Instant::now();
        let snapshot = move || Snapshot {
            samples: seen.samples.load(Ordering::Relaxed) + seen.covered.load(Ordering::Relaxed),
            total,
            rays: seen.rays.load(Ordering::Relaxed),
            records: seen.records.load(Ordering::Relaxed),
            counted,
            elapsed: start.elapsed(),
        };
        let (stop, stopped) = channel();
        // The wait ends early when `stop` is dropped.
        let wait = move |interval| stopped.recv_timeout(interval) == Err(RecvTimeoutError::Timeout);
        let thread = Builder::new().name("progress".to_owned());
        let reporter = match style {
            Style::Silent => return Self { counters, counted, reporter: None },
            Style::Json => thread.spawn(move || {
                while wait(JSON_INTERVAL) {
                    print_line(&snapshot().json());
                }
            }),
            Style::Bar => thread.spawn(move || {
                let bar = bar(total);
                while wait(BAR_INTERVAL) {
                    let now = snapshot();
                    bar.set_position(now.samples);
                    bar.set_message(now.message());
                }
                bar.finish_and_clear();
            }),
        };
        // A render without a bar is better than none.
        Self { counters, counted, reporter: reporter.ok().map(|reporter| (stop, reporter)) }
    }
}

impl Drop for Progress {
    /// Ends the showing; nothing more is printed afterwards.
    fn drop(&mut self) {
        if let Some((stop, reporter)) = self.reporter.take() {
            drop(stop);
            // A reporter that panicked has said so itself; the picture matters more.
            let _ = reporter.join();
        }
    }
}

impl Watch for Progress {
    fn advance(&self, samples: u64, rays: u64) {
        self.counters.samples.fetch_add(samples, Ordering::Relaxed);
        self.counters.rays.fetch_add(rays, Ordering::Relaxed);
    }

    fn stop(&self) -> bool {
        interrupt::requested()
    }

    fn gathered(&self, records: u64) {
        self.counters.records.fetch_add(records, Ordering::Relaxed);
    }

    fn covered(&self, points: u64) {
        // A renderer's samples are counted when they are taken.
        if self.counted == Counted::Texels {
            self.counters.covered.store(points, Ordering::Relaxed);
        }
    }
}

impl Snapshot {
    /// From 0 to 1, if that is known.
    fn done(&self) -> Option<f64> {
        (self.total > 0).then(|| (self.samples as f64 / self.total as f64).min(1.0))
    }

    /// Seconds left if the rest goes as fast; unknown at the beginning.
    fn remaining(&self) -> Option<f64> {
        let done = self.done().filter(|&done| done > 0.0)?;
        Some(self.elapsed.as_secs_f64() * (1.0 - done) / done)
    }

    fn json(&self) -> Value {
        let mut event = json!({
            "event": "progress",
            "done": self.done(),
            "rays": self.rays,
            "rays_per_second": per_second(self.rays, self.elapsed),
            "elapsed": self.elapsed.as_secs_f64(),
            "remaining": self.remaining(),
        });
        if self.counted == Counted::Texels {
            event["texels"] = self.samples.into();
        }
        if self.counted == Counted::Parts {
            return json!({
                "event": "progress", "stage": "denoise", "done": event["done"], "elapsed": event["elapsed"],
                "remaining": event["remaining"],
            });
        }
        if self.counted != Counted::Samples {
            event["records"] = self.records.into();
        }
        event
    }

    fn message(&self) -> String {
        let samples = per_second(self.samples, self.elapsed) / 1e6;
        let rays = per_second(self.rays, self.elapsed) / 1e6;
        let left = self.remaining().map_or("--:--".to_owned(), clock);
        let Self { samples: texels, total, records, .. } = self;
        match self.counted {
            Counted::Samples => format!("{samples:.2} Msamples/s  {rays:.1} Mrays/s  {left} left"),
            Counted::Records => format!("{records} records  {rays:.1} Mrays/s  {left} left"),
            Counted::Parts => format!("denoising  {left} left"),
            Counted::Texels => format!("{texels}/{total} texels  {records} records  {rays:.1} Mrays/s  {left} left"),
        }
    }
}

/// `count` in a second, zero in no time.
pub(super) fn per_second(count: u64, elapsed: Duration) -> f64 {
    let seconds = elapsed.as_secs_f64();
    if seconds > 0.0 { count as f64 / seconds } else { 0.0 }
}

/// Minutes and seconds, with hours if there are any.
pub(super) fn clock(seconds: f64) -> String {
    let seconds = seconds.round() as u64;
    let (hours, minutes, seconds) = (seconds / 3600, seconds / 60 % 60, seconds % 60);
    if hours > 0 { format!("{hours}:{minutes:02}:{seconds:02}") } else { format!("{minutes:02}:{seconds:02}") }
}

fn bar(total: u64) -> ProgressBar {
    let bar = ProgressBar::with_draw_target(Some(total), ProgressDrawTarget::stderr());
    // Of an unknown number there are no parts.
    let style = ProgressStyle::with_template(match total {
        0 => "{elapsed_precise} {spinner} {msg}",
        _ => "{elapsed_precise} [{wide_bar}] {percent:>3}%  {msg}",
    });
    bar.set_style(style.expect("the template is valid").progress_chars("=> "));
    bar
}

#[cfg(test)]
mod tests {
    use super::*;

    const HALF: Snapshot = Snapshot {
        samples: 50,
        total: 100,
        rays: 3_000_000,
        records: 7,
        counted: Counted::Samples,
        elapsed: Duration::from_secs(2),
    };

    #[test]
    fn a_line_is_valid_json_with_the_promised_keys() {
        let line = HALF.json().to_string();
        assert!(!line.contains('\n'));
        let value: Value = serde_json::from_str(&line).unwrap();
        let expected = json!({
            "event": "progress", "done": 0.5, "rays": 3_000_000, "rays_per_second": 1.5e6, "elapsed": 2.0,
            "remaining": 2.0
        });
        assert_eq!(value, expected);
    }

    #[test]
    fn the_first_line_has_no_infinities() {
        let first = Snapshot { samples: 0, rays: 0, elapsed: Duration::ZERO, ..HALF };
        let value: Value = serde_json::from_str(&first.json().to_string()).unwrap();
        assert_eq!(value["remaining"], Value::Null);
        assert_eq!(value["rays_per_second"], 0.0);
        assert_eq!(first.message(), "0.00 Msamples/s  0.0 Mrays/s  --:-- left");
    }

    #[test]
    fn the_bar_says_rates_and_time_left() {
        assert_eq!(HALF.message(), "0.00 Msamples/s  1.5 Mrays/s  00:02 left");
        let texels = Snapshot { counted: Counted::Texels, ..HALF };
        assert_eq!(texels.message(), "50/100 texels  7 records  1.5 Mrays/s  00:02 left");
        assert_eq!((&texels.json()["texels"], &texels.json()["records"]), (&50.into(), &7.into()));
        let records = Snapshot { counted: Counted::Records, total: 0, ..HALF };
        assert_eq!(records.message(), "7 records  1.5 Mrays/s  --:-- left");
        let parts = Snapshot { counted: Counted::Parts, ..HALF };
        assert_eq!(parts.message(), "denoising  00:02 left");
        assert_eq!((&parts.json()["stage"], &parts.json()["rays"]), (&"denoise".into(), &Value::Null));
        let unknown = records.json();
        let expected = [&Value::Null, &Value::Null, &7.into()];
        assert_eq!([&unknown["done"], &unknown["remaining"], &unknown["records"]], expected);
        assert_eq!(clock(3_725.4), "1:02:05");
        assert_eq!(clock(59.6), "01:00");
    }

    #[test]
    fn counts_add_up_over_threads() {
        let progress = Progress::start(Style::Silent, 1000);
        std::thread::scope(|scope| {
            for _ in 0..4 {
                scope.spawn(|| (0..250).for_each(|_| progress.advance(1, 3)));
            }
        });
        assert_eq!(progress.counters.samples.load(Ordering::Relaxed), 1000);
        assert_eq!(progress.counters.rays.load(Ordering::Relaxed), 3000);
    }
}
