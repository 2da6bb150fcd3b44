//! Messages on stderr before and after the work of commands without a picture, as text or as lines of JSON.

use std::path::Path;
use std::time::Instant;

use serde_json::{Value, json};

use super::per_second;
use crate::cache::{MORE_PATHS, MORE_RECORDS, missed_accuracy};
use crate::cli::messages::{Style, print_line, print_text, print_warning};
use crate::driver::CacheUse;

/// Work that was announced.
pub(crate) struct Job {
    style: Style,
    start: Instant,
}

/// The outcome.
#[derive(Clone, Copy)]
pub(crate) struct Outcome<'a> {
    /// Whether it was not interrupted.
    pub(crate) finished: bool,
    /// Rays traced.
    pub(crate) rays: u64,
    /// The irradiance cache, and how it was used.
    pub(crate) cache: Option<CacheUse>,
    /// The error that was asked for and an estimate of it, relative.
    pub(crate) accuracy: Option<(f32, f32)>,
    /// The result of interrupted work; else how the work was done, if that is not clear.
    pub(crate) note: &'a str,
    /// The file that was written.
    pub(crate) file: Option<&'a Path>,
}

impl Job {
    /// Announces the work: by a title, or an event with these values.
    pub(crate) fn start(style: Style, title: String, mut event: Value) -> Self {
        if style == Style::Json {
            event["event"] = "start".into();
            print_line(&event);
        } else {
            print_text(style, &title);
        }
        Self { style, start: Instant::now() }
    }

    /// Says how it went.
    pub(crate) fn end(self, outcome: Outcome) {
        let seconds = self.start.elapsed();
        let remedy = if outcome.cache.is_some() { MORE_RECORDS } else { MORE_PATHS };
        let missed = |(asked, estimated)| missed_accuracy(asked, estimated, remedy);
        if let Some(warning) = outcome.accuracy.and_then(missed) {
            print_warning(self.style, &warning);
        }
        if self.style == Style::Json {
            print_line(&outcome.event(seconds.as_secs_f64(), per_second(outcome.rays, seconds)));
        } else {
            print_text(self.style, &outcome.text(seconds.as_secs_f64()));
        }
    }
}

/// The estimated error beside the accuracy that was asked for.
pub(crate) fn accuracy_text(asked: f32, estimated: f32) -> String {
    let [asked, estimated] = [asked, estimated].map(|part| 100.0 * part);
    format!("error: {estimated:.2}% of the mean, estimated; {asked}% was requested")
}

impl Outcome<'_> {
    fn event(&self, elapsed: f64, rays_per_second: f64) -> Value {
        let mut event = json!({
            "event": "end",
            "finished": self.finished,
            "rays": self.rays,
            "rays_per_second": rays_per_second,
            "elapsed": elapsed,
            "cache": self.cache.map(|CacheUse { records, misses, negative }| {
                json!({ "records": records, "misses": misses, "negative": negative })
            }),
            "files": self.file.iter().map(|path| path.display().to_string()).collect::<Vec<_>>(),
        });
        if let Some((asked, estimated)) = self.accuracy {
            // As it was given: it was rounded to `f32` since.
            let asked = (1e6 * f64::from(asked)).round() / 1e6;
            event["accuracy"] = json!({ "asked": asked, "estimated": estimated });
        }
        if !self.note.is_empty() {
            event["message"] = self.note.into();
        }
        event
    }

    fn text(&self, elapsed: f64) -> String {
        let state = if self.finished { "done".to_owned() } else { format!("interrupted; {}", self.note) };
        let mut text = format!("{state}, {elapsed:.2} s, {} rays", self.rays);
        if self.finished && !self.note.is_empty() {
            text += &format!("\n{}", self.note);
        }
        if let Some(CacheUse { records, misses, negative }) = self.cache {
            text += &format!("\n{records} irradiance records; {misses} points had none, {negative} were negative");
        }
        if let Some((asked, estimated)) = self.accuracy {
            text += &format!("\n{}", accuracy_text(asked, estimated));
        }
        if let Some(path) = self.file {
            text += &format!("\nwrote {}", path.display());
        }
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_end_says_what_was_made() {
        let cache = Some(CacheUse { records: 7, misses: 2, negative: 1 });
        let done =
            Outcome { finished: true, rays: 90, cache, accuracy: None, note: "", file: Some(Path::new("e.txt")) };
        let text = "done, 0.50 s, 90 rays\n7 irradiance records; 2 points had none, 1 were negative\nwrote e.txt";
        assert_eq!(done.text(0.5), text);
        let expected = json!({
            "event": "end", "finished": true, "rays": 90, "rays_per_second": 180.0, "elapsed": 0.5,
            "cache": { "records": 7, "misses": 2, "negative": 1 }, "files": ["e.txt"]
        });
        assert_eq!(done.event(0.5, 180.0), expected);
        let noisy = Outcome { accuracy: Some((0.03, 0.0251)), cache: None, note: "by paths", ..done };
        let text =
            "done, 0.50 s, 90 rays\nby paths\nerror: 2.51% of the mean, estimated; 3% was requested\nwrote e.txt";
        assert_eq!(noisy.text(0.5), text);
        let event = noisy.event(0.5, 180.0);
        assert_eq!((&event["accuracy"]["asked"], &event["message"]), (&json!(0.03), &json!("by paths")));
        let stopped = Outcome { finished: false, note: "nothing is written", cache: None, file: None, ..done };
        assert_eq!(stopped.text(0.5), "interrupted; nothing is written, 0.50 s, 90 rays");
        let event = stopped.event(0.5, 180.0);
        assert_eq!((&event["message"], &event["files"]), (&"nothing is written".into(), &json!([])));
    }
}
