//! Progress on stderr while a render runs: a bar for people, lines of JSON for programs.
//!
//! The render's threads add to two counters and never wait; a thread of its own looks at them now and then.

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::{Builder, JoinHandle};
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use serde_json::{Value, json};

use super::interrupt;
use super::messages::{Style, print_line, print_text};
use super::pace::{Coverage, Pace};
use crate::bake::LayoutStep;
use crate::scene::count;
use crate::watch::Watch;

const BAR_INTERVAL: Duration = Duration::from_millis(100);
const JSON_INTERVAL: Duration = Duration::from_millis(500);
/// Layouts of fewer charts are done before anybody wonders.
const MANY_CHARTS: usize = 10_000;
/// Steps of a layout that is unwrapped.
const LAYOUT_STEPS: u64 = 1000;

/// Watches a render and shows how far it is.
pub(super) struct Progress {
    counters: Arc<Counters>,
    counted: Counted,
    style: Style,
    reporter: Option<(Sender<()>, JoinHandle<()>)>,
}

#[derive(Default)]
struct Counters {
    samples: AtomicU64,
    rays: AtomicU64,
    records: AtomicU64,
    /// What a cache that is being filled adds to the samples.
    covered: AtomicU64,
    coverage: Mutex<Coverage>,
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
    /// Texels alone.
    PlainTexels,
    /// Parts of a picture that is denoised.
    Parts,
    /// Thousandths of a layout that is unwrapped, and then how often it is packed.
    Layout,
}

/// How far a render is.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Snapshot {
    samples: u64,
    /// 0 if nobody knows.
    total: u64,
    rays: u64,
    /// Irradiance records made, or how often a layout is packed.
    records: u64,
    counted: Counted,
    /// Since the command's work began.
    elapsed: Duration,
    /// Since what is counted was begun.
    counting: Duration,
    /// Samples taken at a known pace, and how long that took; it was begun after all that is not counted.
    pace: Option<(u64, Duration)>,
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

    /// Shows the progress of a layout from `begin` on.
    pub(super) fn of_layout(style: Style, begin: Instant) -> Self {
        Self::counting_from(style, LAYOUT_STEPS, Counted::Layout, begin, Coverage::default())
    }

    /// Shows the progress towards `total` texels, of a bake that was begun at `begin`. They are served by so many `caches`
    /// after their direct light, of which the last may be filled `again`.
    pub(super) fn of_texels(style: Style, total: u64, begin: Instant, caches: u32, again: bool) -> Self {
        let counted = if caches > 0 { Counted::Texels } else { Counted::PlainTexels };
        let coverage = Coverage::new(caches, total / u64::from(caches + 1), again);
        Self::counting_from(style, total, counted, begin, coverage)
    }

    /// Shows how far a picture is denoised, of which there are `total` parts.
    pub(super) fn of_denoising(style: Style, total: u64) -> Self {
        Self::counting(style, total, Counted::Parts)
    }

    fn counting(style: Style, total: u64, counted: Counted) -> Self {
        Self::counting_from(style, total, counted, Instant::now(), Coverage::default())
    }

    fn counting_from(style: Style, total: u64, counted: Counted, begin: Instant, coverage: Coverage) -> Self {
        let counters = Arc::new(Counters { coverage: Mutex::new(coverage), ..Counters::default() });
        let seen = Arc::clone(&counters);
        let start = Instant::now();
        let mut pace = Pace::default();
        let mut snapshot = move || {
            let counting = start.elapsed();
            let (samples, pace) = pace.at(seen.done(), counting);
            Snapshot {
                samples,
                total,
                rays: seen.rays.load(Ordering::Relaxed),
                records: seen.records.load(Ordering::Relaxed),
                counted,
                elapsed: begin.elapsed(),
                counting,
                pace,
            }
        };
        let (stop, stopped) = channel();
        // The wait ends early when `stop` is dropped.
        let wait = move |interval| stopped.recv_timeout(interval) == Err(RecvTimeoutError::Timeout);
        let thread = Builder::new().name("progress".to_owned());
        let reporter = match style {
            Style::Silent => return Self { counters, counted, style, reporter: None },
            Style::Json => thread.spawn(move || {
                while wait(JSON_INTERVAL) {
                    print_line(&snapshot().json());
                }
            }),
            Style::Bar => thread.spawn(move || {
                let bar = bar(total);
                while wait(BAR_INTERVAL) {
                    let now = snapshot();
                    if now.done().is_none() {
                        bar.set_style(bar_style(0));
                    }
                    bar.set_position(now.samples);
                    bar.set_message(now.message());
                }
                bar.finish_and_clear();
            }),
        };
        // A render without a bar is better than none.
        Self { counters, counted, style, reporter: reporter.ok().map(|reporter| (stop, reporter)) }
    }

    fn coverage(&self) -> MutexGuard<'_, Coverage> {
        // Numbers alone, which are right whatever happened to a thread.
        self.counters.coverage.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// A layout is so far.
    pub(super) fn layout(&self, step: LayoutStep) {
        match step {
            LayoutStep::Begin { triangles, charts, pages } if charts >= MANY_CHARTS => {
                let pages = count(pages as usize, "page", "pages");
                let triangles = count(triangles, "triangle", "triangles");
                print_text(self.style, &format!("unwrapping {triangles}: {charts} charts or more, on {pages} or more"));
            }
            LayoutStep::Begin { .. } => {}
            LayoutStep::Unwrap(part) => {
                let steps = (part.clamp(0.0, 1.0) * LAYOUT_STEPS as f32) as u64;
                self.counters.samples.fetch_max(steps, Ordering::Relaxed);
            }
            LayoutStep::Pack => {
                self.counters.records.fetch_add(1, Ordering::Relaxed);
            }
        }
    }
}

impl Counters {
    /// Samples, and what a cache that is being filled adds to them.
    fn done(&self) -> u64 {
        self.samples.load(Ordering::Relaxed) + self.covered.load(Ordering::Relaxed)
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
            let covered = self.coverage().covered(points);
            self.counters.covered.store(covered, Ordering::Relaxed);
        }
    }

    fn filled(&self) {
        self.coverage().next();
        self.counters.covered.store(0, Ordering::Relaxed);
    }
}

impl Snapshot {
    /// From 0 to 1, if that is known.
    fn done(&self) -> Option<f64> {
        let is_packed = self.counted == Counted::Layout && self.records > 0;
        (self.total > 0 && !is_packed).then(|| (self.samples as f64 / self.total as f64).min(1.0))
    }

    /// Seconds left if the rest goes as fast; unknown at the beginning, and where steps differ: a cache's last texels
    /// take as long as all before.
    fn remaining(&self) -> Option<f64> {
        let (samples, time) = self.pace.filter(|(samples, _)| *samples > 0)?;
        let is_even = !matches!(self.counted, Counted::Texels | Counted::Layout) && self.total > 0;
        is_even.then(|| time.as_secs_f64() * self.total.saturating_sub(self.samples) as f64 / samples as f64)
    }

    fn json(&self) -> Value {
        let mut event = json!({
            "event": "progress",
            "done": self.done(),
            "rays": self.rays,
            "rays_per_second": per_second(self.rays, self.counting),
            "elapsed": self.elapsed.as_secs_f64(),
            "remaining": self.remaining(),
        });
        if self.is_of_texels() {
            event["texels"] = self.samples.into();
        }
        if self.counted == Counted::Layout {
            let (stage, tries) =
                if self.records == 0 { ("unwrap", Value::Null) } else { ("pack", self.records.into()) };
            return json!({
                "event": "progress", "stage": stage, "done": event["done"], "tries": tries,
                "elapsed": event["elapsed"], "remaining": null,
            });
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

    fn is_of_texels(&self) -> bool {
        matches!(self.counted, Counted::Texels | Counted::PlainTexels)
    }

    fn message(&self) -> String {
        let samples = per_second(self.samples, self.counting) / 1e6;
        let rays = per_second(self.rays, self.counting) / 1e6;
        let left = self.remaining().map_or("--:--".to_owned(), clock);
        let Self { samples: texels, total, records, .. } = self;
        match self.counted {
            Counted::Samples => format!("{samples:.2} Msamples/s  {rays:.1} Mrays/s  {left} left"),
            Counted::Records => format!("{records} records  {rays:.1} Mrays/s  {left} left"),
            Counted::Parts => format!("denoising  {left} left"),
            Counted::Layout if *records == 0 => "unwrapping".to_owned(),
            Counted::Layout => format!("packing charts, try {records}"),
            Counted::Texels | Counted::PlainTexels => {
                format!("{texels}/{total} texels  {records} records  {rays:.1} Mrays/s  {left} left")
            }
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
    bar.set_style(bar_style(total));
    bar
}

fn bar_style(total: u64) -> ProgressStyle {
    // Of an unknown number there are no parts.
    let style = ProgressStyle::with_template(match total {
        0 => "{elapsed_precise} {spinner} {msg}",
        _ => "{elapsed_precise} [{wide_bar}] {percent:>3}%  {msg}",
    });
    style.expect("the template is valid").progress_chars("=> ")
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
        counting: Duration::from_secs(2),
        pace: Some((50, Duration::from_secs(2))),
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
        let first =
            Snapshot { samples: 0, rays: 0, elapsed: Duration::ZERO, counting: Duration::ZERO, pace: None, ..HALF };
        let value: Value = serde_json::from_str(&first.json().to_string()).unwrap();
        assert_eq!(value["remaining"], Value::Null);
        assert_eq!(value["rays_per_second"], 0.0);
        assert_eq!(first.message(), "0.00 Msamples/s  0.0 Mrays/s  --:-- left");
    }

    #[test]
    fn the_bar_says_rates_and_time_left() {
        assert_eq!(HALF.message(), "0.00 Msamples/s  1.5 Mrays/s  00:02 left");
        let texels = Snapshot { counted: Counted::PlainTexels, ..HALF };
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
    fn nothing_is_said_of_the_time_that_a_cache_takes() {
        let texels = Snapshot { counted: Counted::Texels, ..HALF };
        assert_eq!(texels.message(), "50/100 texels  7 records  1.5 Mrays/s  --:-- left");
        let event = texels.json();
        assert_eq!((&event["done"], &event["remaining"], &event["texels"]), (&0.5.into(), &Value::Null, &50.into()));
    }

    #[test]
    fn time_before_the_first_sample_is_not_its_pace() {
        let (mut pace, seconds) = (Pace::default(), Duration::from_secs);
        assert_eq!(pace.at(0, seconds(60)), (0, None));
        let (samples, taken) = pace.at(10, seconds(61));
        let now = Snapshot { samples, pace: taken, elapsed: seconds(70), counting: seconds(61), ..HALF };
        assert_eq!(now.remaining(), Some(9.0));
        assert_eq!(now.json()["elapsed"], 70.0);
        // Not even if the counters go back.
        assert_eq!(pace.at(5, seconds(62)), (10, Some((10, seconds(2)))));
    }

    #[test]
    fn a_layout_is_unwrapped_and_then_packed_who_knows_how_often() {
        let progress = Progress::of_layout(Style::Silent, Instant::now());
        let event = || {
            let (samples, records) = (progress.counters.done(), progress.counters.records.load(Ordering::Relaxed));
            Snapshot { samples, records, total: LAYOUT_STEPS, counted: Counted::Layout, ..HALF }
        };
        // A second layout begins anew.
        [0.25, 0.5, 0.1].iter().for_each(|&part| progress.layout(LayoutStep::Unwrap(part)));
        let unwrapping = event().json();
        assert_eq!(unwrapping["stage"], "unwrap");
        assert_eq!((&unwrapping["done"], &unwrapping["elapsed"]), (&0.5.into(), &2.0.into()));
        progress.layout(LayoutStep::Pack);
        progress.layout(LayoutStep::Pack);
        let packing = event().json();
        assert_eq!((&packing["stage"], &packing["tries"], &packing["done"]), (&"pack".into(), &2.into(), &Value::Null));
        assert_eq!(event().message(), "packing charts, try 2");
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
