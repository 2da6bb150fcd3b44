//! Progress on stderr while a large model is read, and while its tree is built.

use std::path::Path;
use std::sync::Mutex;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use serde_json::{Value, json};

use super::JSON_INTERVAL;
use crate::cli::messages::{Style, print_line};
use crate::scene::LoadWatch;

/// Trees of fewer triangles are built quickly.
const LARGE: usize = 1_000_000;
/// As are files of fewer bytes read.
const LARGE_FILE: usize = 100_000_000;
/// Steps of the bar.
const STEPS: u64 = 1000;

/// Shows how far something is; on being dropped, nothing any more.
pub(crate) struct StageProgress {
    /// Its name for programs.
    stage: &'static str,
    state: Mutex<State>,
}

/// Shows how far files are read.
pub(crate) struct LoadProgress {
    style: Style,
    shown: Mutex<Option<StageProgress>>,
}

struct State {
    done: f64,
    start: Instant,
    shown: Instant,
    output: Output,
}

enum Output {
    None,
    Json,
    Bar(ProgressBar),
}

impl StageProgress {
    /// Shows the progress of a build of `triangles`, if that takes long.
    pub(crate) fn of_build(style: Style, triangles: usize) -> Self {
        Self::start(if triangles < LARGE { Style::Silent } else { style }, "build", "building the tree")
    }

    fn start(style: Style, stage: &'static str, label: &str) -> Self {
        let output = match style {
            Style::Silent => Output::None,
            Style::Json => Output::Json,
            Style::Bar => Output::Bar(bar(label)),
        };
        let now = Instant::now();
        Self { stage, state: Mutex::new(State { done: 0.0, start: now, shown: now, output }) }
    }

    /// `fraction` more is done.
    pub(crate) fn advance(&self, fraction: f32) {
        self.change(|done| done + f64::from(fraction));
    }

    fn set(&self, done: f64) {
        self.change(|_| done);
    }

    fn change(&self, done: impl Fn(f64) -> f64) {
        // A thread that panicked has said so itself.
        let Ok(mut state) = self.state.lock() else { return };
        state.done = done(state.done).min(1.0);
        match &state.output {
            Output::None => {}
            Output::Json if state.shown.elapsed() < JSON_INTERVAL => {}
            Output::Json => {
                print_line(&event(self.stage, state.done, state.start.elapsed()));
                state.shown = Instant::now();
            }
            Output::Bar(bar) => bar.set_position((state.done * STEPS as f64) as u64),
        }
    }
}

impl LoadProgress {
    /// Shows the progress of files that take long from now on.
    pub(crate) fn start(style: Style) -> Self {
        Self { style, shown: Mutex::default() }
    }
}

impl LoadWatch for LoadProgress {
    fn read(&self, path: &Path, done: usize, total: usize) {
        if total < LARGE_FILE {
            return;
        }
        let Ok(mut shown) = self.shown.lock() else { return };
        let stage = shown.get_or_insert_with(|| {
            let name = path.file_name().unwrap_or_default().display();
            StageProgress::start(self.style, "load", &format!("reading {name}"))
        });
        stage.set(done as f64 / total as f64);
        if done == total {
            *shown = None;
        }
    }
}

impl Drop for StageProgress {
    fn drop(&mut self) {
        if let Ok(State { output: Output::Bar(bar), .. }) = self.state.get_mut() {
            bar.finish_and_clear();
        }
    }
}

fn event(stage: &str, done: f64, elapsed: Duration) -> Value {
    json!({ "event": stage, "done": done, "elapsed": elapsed.as_secs_f64() })
}

fn bar(label: &str) -> ProgressBar {
    let bar = ProgressBar::with_draw_target(Some(STEPS), ProgressDrawTarget::stderr());
    let style = ProgressStyle::with_template("{elapsed_precise} [{wide_bar}] {percent:>3}%  {msg}");
    bar.set_style(style.expect("the template is valid").progress_chars("=> "));
    bar.set_message(label.to_owned());
    bar
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_large_models_are_worth_a_word() {
        let shows = |style, triangles| {
            !matches!(StageProgress::of_build(style, triangles).state.get_mut().unwrap().output, Output::None)
        };
        assert!(shows(Style::Json, LARGE) && shows(Style::Bar, LARGE));
        assert!(!shows(Style::Silent, LARGE) && !shows(Style::Json, LARGE - 1) && !shows(Style::Bar, LARGE - 1));
    }

    #[test]
    fn only_large_files_are_worth_a_word() {
        let loading = LoadProgress::start(Style::Silent);
        let done = |done, total| {
            loading.read(Path::new("field.obj"), done, total);
            loading.shown.lock().unwrap().as_ref().map(|stage| stage.state.lock().unwrap().done)
        };
        assert_eq!(done(1, LARGE_FILE - 1), None);
        assert_eq!(done(LARGE_FILE, 2 * LARGE_FILE), Some(0.5));
        assert_eq!(done(2 * LARGE_FILE, 2 * LARGE_FILE), None, "the bar goes when all is read");
    }

    #[test]
    fn fractions_add_up_to_one_at_most() {
        let building = StageProgress::of_build(Style::Silent, LARGE);
        (0..3).for_each(|_| building.advance(0.25));
        assert_eq!(building.state.lock().unwrap().done, 0.75);
        building.advance(0.5);
        assert_eq!(building.state.lock().unwrap().done, 1.0);
        assert_eq!(
            event("build", 0.5, Duration::from_secs(2)),
            json!({ "event": "build", "done": 0.5, "elapsed": 2.0 })
        );
    }
}
