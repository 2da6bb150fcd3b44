//! Progress on stderr while the tree of a large model is built.

use std::sync::Mutex;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use serde_json::{Value, json};

use super::messages::{Style, print_line};

/// Trees of fewer triangles are built before anybody wonders.
const LARGE: usize = 1_000_000;
/// Steps of the bar.
const STEPS: u64 = 1000;
const JSON_INTERVAL: Duration = Duration::from_millis(500);

/// Shows how far a build is; on being dropped, nothing any more.
pub(super) struct BuildProgress {
    state: Mutex<State>,
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

impl BuildProgress {
    /// Shows the progress of a build of `triangles`, if that takes long.
    pub(super) fn start(style: Style, triangles: usize) -> Self {
        let output = match style {
            _ if triangles < LARGE => Output::None,
            Style::Silent => Output::None,
            Style::Json => Output::Json,
            Style::Bar => Output::Bar(bar()),
        };
        let now = Instant::now();
        Self { state: Mutex::new(State { done: 0.0, start: now, shown: now, output }) }
    }

    /// `fraction` more is done.
    pub(super) fn advance(&self, fraction: f32) {
        // A thread that panicked has said so itself.
        let Ok(mut state) = self.state.lock() else { return };
        state.done = (state.done + f64::from(fraction)).min(1.0);
        match &state.output {
            Output::None => {}
            Output::Json if state.shown.elapsed() < JSON_INTERVAL => {}
            Output::Json => {
                print_line(&event(state.done, state.start.elapsed()));
                state.shown = Instant::now();
            }
            Output::Bar(bar) => bar.set_position((state.done * STEPS as f64) as u64),
        }
    }
}

impl Drop for BuildProgress {
    fn drop(&mut self) {
        if let Ok(State { output: Output::Bar(bar), .. }) = self.state.get_mut() {
            bar.finish_and_clear();
        }
    }
}

fn event(done: f64, elapsed: Duration) -> Value {
    json!({ "event": "build", "done": done, "elapsed": elapsed.as_secs_f64() })
}

fn bar() -> ProgressBar {
    let bar = ProgressBar::with_draw_target(Some(STEPS), ProgressDrawTarget::stderr());
    let style = ProgressStyle::with_template("{elapsed_precise} [{wide_bar}] {percent:>3}%  building the tree");
    bar.set_style(style.expect("the template is valid").progress_chars("=> "));
    bar
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_large_models_are_worth_a_word() {
        let shows = |style, triangles| {
            !matches!(BuildProgress::start(style, triangles).state.get_mut().unwrap().output, Output::None)
        };
        assert!(shows(Style::Json, LARGE) && shows(Style::Bar, LARGE));
        assert!(!shows(Style::Silent, LARGE) && !shows(Style::Json, LARGE - 1) && !shows(Style::Bar, LARGE - 1));
    }

    #[test]
    fn fractions_add_up_to_one_at_most() {
        let building = BuildProgress::start(Style::Silent, LARGE);
        (0..3).for_each(|_| building.advance(0.25));
        assert_eq!(building.state.lock().unwrap().done, 0.75);
        building.advance(0.5);
        assert_eq!(building.state.lock().unwrap().done, 1.0);
        assert_eq!(event(0.5, Duration::from_secs(2)), json!({ "event": "build", "done": 0.5, "elapsed": 2.0 }));
    }
}
