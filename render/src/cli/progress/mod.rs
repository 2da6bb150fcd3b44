//! Progress on stderr while a render runs: a bar for people, lines of JSON for programs.
//!
//! The render's threads add to two counters and never wait; a separate thread reads them periodically.

pub(super) mod job;
mod pace;
mod snapshot;
pub(super) mod stages;

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::{Builder, JoinHandle};
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

pub(super) use snapshot::per_second;
use snapshot::{Counted, Snapshot};

use super::interrupt;
use super::messages::{Style, print_line, print_text};
use crate::bake::LayoutStep;
use crate::scene::count;
use crate::watch::Watch;
use pace::{Coverage, Pace};

const BAR_INTERVAL: Duration = Duration::from_millis(100);
const JSON_INTERVAL: Duration = Duration::from_millis(500);
/// Layouts of fewer charts finish quickly.
const MANY_CHARTS: usize = 10_000;
/// Steps of a layout that is unwrapped.
const LAYOUT_STEPS: u64 = 1000;

/// Watches a render and shows how far it is.
pub(crate) struct Progress {
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
    /// The work of a cache that is being filled, in samples.
    covered: AtomicU64,
    coverage: Mutex<Coverage>,
}

impl Progress {
    /// Shows the progress towards `total` samples from now on.
    pub(crate) fn start(style: Style, total: u64) -> Self {
        Self::counting(style, total, Counted::Samples)
    }

    /// Shows the progress towards `total` samples after irradiance records, or with 0 towards an unknown number of
    /// records.
    pub(crate) fn of_records(style: Style, total: u64) -> Self {
        Self::counting(style, total, Counted::Records)
    }

    /// Shows the progress of a layout from `begin` on.
    pub(crate) fn of_layout(style: Style, begin: Instant) -> Self {
        Self::counting_from(style, LAYOUT_STEPS, Counted::Layout, begin, Coverage::default())
    }

    /// Shows the progress towards `total` texels, of a bake that was begun at `begin`. They are served by so many
    /// `caches` after their direct light, of which the last may be filled `again`.
    pub(crate) fn of_texels(style: Style, total: u64, begin: Instant, caches: u32, again: bool) -> Self {
        let counted = if caches > 0 { Counted::Texels } else { Counted::PlainTexels };
        let coverage = Coverage::new(caches, total / u64::from(caches + 1), again);
        Self::counting_from(style, total, counted, begin, coverage)
    }

    /// Shows how far a picture is denoised, of which there are `total` parts.
    pub(crate) fn of_denoising(style: Style, total: u64) -> Self {
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
    pub(crate) fn layout(&self, step: LayoutStep) {
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

fn bar(total: u64) -> ProgressBar {
    let bar = ProgressBar::with_draw_target(Some(total), ProgressDrawTarget::stderr());
    bar.set_style(bar_style(total));
    bar
}

fn bar_style(total: u64) -> ProgressStyle {
    // Without a known total there is no fraction.
    let style = ProgressStyle::with_template(match total {
        0 => "{elapsed_precise} {spinner} {msg}",
        _ => "{elapsed_precise} [{wide_bar}] {percent:>3}%  {msg}",
    });
    style.expect("the template is valid").progress_chars("=> ")
}

#[cfg(test)]
mod tests {
    use super::snapshot::tests::HALF;
    use super::*;

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
        assert_eq!(
            (&packing["stage"], &packing["tries"], &packing["done"]),
            (&"pack".into(), &2.into(), &serde_json::Value::Null)
        );
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
