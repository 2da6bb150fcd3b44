//! Messages on stderr before and after a render, as text or as lines of JSON.

use std::cell::RefCell;
use std::collections::BTreeSet;
use std::io::Write;
use std::path::PathBuf;

use serde_json::{Value, json};

use crate::cli::messages::{Style, print_line, print_warning};
use crate::cli::progress::job::accuracy_text;
use crate::cli::progress::per_second;
use crate::driver::{CacheUse, Render};
use crate::scene::count;
use crate::settings::{Integrator, Settings};

/// The end of a render.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum End {
    /// At its target: all samples, or the error that was asked for.
    Done,
    /// At a limit.
    Limit,
    /// The run was interrupted by a signal.
    Interrupted,
}

/// The warnings of a sequence that were printed: each is printed once, however many frames have it.
#[derive(Debug, Default)]
pub(super) struct Told(RefCell<BTreeSet<String>>);

impl Told {
    /// Prints a warning if it has not been.
    fn print(&self, style: Style, warning: &str) {
        if self.0.borrow_mut().insert(warning.to_owned()) {
            print_warning(style, warning);
        }
    }
}

/// The scene and settings.
pub(super) struct RenderReport<'a> {
    /// As the user calls it.
    pub(super) scene: String,
    pub(super) settings: &'a Settings,
    pub(super) threads: usize,
    pub(super) warnings: Vec<String>,
    pub(super) told: &'a Told,
}

impl RenderReport<'_> {
    /// Announces the job and its warnings.
    pub(super) fn print_start(&self, style: Style) {
        match style {
            Style::Silent => {}
            Style::Json => print_line(&self.start_event()),
            Style::Bar => {
                let _ = writeln!(std::io::stderr(), "{}", self.title());
            }
        }
        self.warnings.iter().for_each(|warning| self.told.print(style, warning));
    }

    /// Adds a warning after the start.
    pub(super) fn warn(&mut self, style: Style, warning: String) {
        self.told.print(style, &warning);
        self.warnings.push(warning);
    }

    /// Says how it went and what was written.
    pub(super) fn print_end(&self, style: Style, render: &Render, end: End, files: &[PathBuf]) {
        match style {
            Style::Silent => {}
            Style::Json => print_line(&self.end_event(render, end, files)),
            Style::Bar => {
                let _ = std::io::stderr().write_all(self.end_text(render, end, files).as_bytes());
            }
        }
    }

    fn title(&self) -> String {
        let Settings { width, height, spp, integrator, .. } = self.settings;
        let threads = count(self.threads, "thread", "threads");
        format!("{}: {width}x{height}, {spp} spp, {}, {threads}", self.scene, integrator.name())
    }

    fn end_text(&self, render: &Render, end: End, files: &[PathBuf]) -> String {
        let state = match end {
            End::Done => "rendered",
            End::Limit => "ended at a limit before its target; the picture so far was rendered",
            End::Interrupted => "interrupted; the picture so far was rendered",
        };
        let seconds = render.elapsed.as_secs_f64();
        let rays = per_second(render.rays, render.elapsed) / 1e6;
        let mut text = format!("{state} in {seconds:.2} s at {rays:.1} Mrays/s ({} rays)\n", render.rays);
        if let Some(CacheUse { records, misses, negative }) = render.cache {
            text += &format!("{records} irradiance records; {misses} points had none, {negative} were negative\n");
        }
        if let (Integrator::Cached(options), Some(estimated)) = (&self.settings.integrator, render.cache_error) {
            text += &options.accuracy.map(|asked| accuracy_text(asked, estimated) + "\n").unwrap_or_default();
        }
        if let Some(error) = render.film.relative_error() {
            let samples = render.film.samples();
            let error = 100.0 * error;
            text += &format!("{} to {} samples a pixel, estimated error {error:.2}%\n", samples.start, samples.end);
        }
        for file in files {
            text += &format!("wrote {}\n", file.display());
        }
        if !self.warnings.is_empty() {
            text += &format!("{}, above\n", count(self.warnings.len(), "warning", "warnings"));
        }
        text
    }

    fn start_event(&self) -> Value {
        json!({
            "event": "start",
            "scene": self.scene,
            "width": self.settings.width,
            "height": self.settings.height,
            "spp": self.settings.spp,
            "integrator": self.settings.integrator.name(),
            "seed": self.settings.seed,
            "threads": self.threads,
        })
    }

    fn end_event(&self, render: &Render, end: End, files: &[PathBuf]) -> Value {
        let files: Vec<_> = files.iter().map(|file| file.display().to_string()).collect();
        json!({
            "event": "end",
            "finished": end == End::Done,
            "samples": { "least": render.film.samples().start, "most": render.film.samples().end },
            "error": render.film.relative_error(),
            "width": self.settings.width,
            "height": self.settings.height,
            "spp": self.settings.spp,
            "rays": render.rays,
            "rays_per_second": per_second(render.rays, render.elapsed),
            "elapsed": render.elapsed.as_secs_f64(),
            "cache": render.cache.map(|CacheUse { records, misses, negative }| {
                json!({ "records": records, "misses": misses, "negative": negative })
            }),
            "files": files,
            "warnings": self.warnings,
        })
    }
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;
    use crate::driver::{self, Watch};
    use crate::scene::cornell_box;
    use crate::world::World;

    struct Unwatched;

    impl Watch for Unwatched {
        fn advance(&self, _samples: u64, _rays: u64) {}
        fn stop(&self) -> bool {
            false
        }
    }

    fn render() -> Render {
        let settings = Settings { width: 4, height: 4, spp: 1, ..Settings::default() };
        let render = driver::render(&World::new(cornell_box()).unwrap(), &settings, &Unwatched);
        Render { rays: 5_000_000, elapsed: Duration::from_millis(2500), ..render }
    }

    #[test]
    fn the_text_says_what_was_done() {
        let settings = Settings::default();
        let warnings = vec!["no light".to_owned()];
        let report =
            RenderReport { scene: "cornell".into(), settings: &settings, threads: 2, warnings, told: &Told::default() };
        assert_eq!(report.title(), "cornell: 512x512, 64 spp, path, 2 threads");
        let text = report.end_text(&render(), End::Done, &["a.exr".into()]);
        assert_eq!(text, "rendered in 2.50 s at 2.0 Mrays/s (5000000 rays)\nwrote a.exr\n1 warning, above\n");
        assert!(report.end_text(&render(), End::Interrupted, &[]).starts_with("interrupted"));
        assert!(report.end_text(&render(), End::Limit, &[]).starts_with("ended at a limit"));
        let cache = Some(CacheUse { records: 7, misses: 2, negative: 0 });
        let text = report.end_text(&Render { cache, ..render() }, End::Done, &[]);
        assert!(text.contains("\n7 irradiance records; 2 points had none, 0 were negative\n"), "{text}");
    }

    #[test]
    fn the_events_are_valid_json_whatever_the_names() {
        let settings = Settings::default();
        let warnings = vec!["a \"quoted\"\nline".to_owned()];
        let report =
            RenderReport { scene: "a\"b\\c".into(), settings: &settings, threads: 1, warnings, told: &Told::default() };
        let start: Value = serde_json::from_str(&report.start_event().to_string()).unwrap();
        assert_eq!(start["scene"], "a\"b\\c");
        let line = report.end_event(&render(), End::Interrupted, &["a.exr".into()]).to_string();
        assert!(!line.contains('\n'));
        let end: Value = serde_json::from_str(&line).unwrap();
        assert_eq!(end["finished"], false);
        assert_eq!(end["rays_per_second"], 2e6);
        assert_eq!(end["files"], json!(["a.exr"]));
        assert_eq!(end["warnings"], json!(["a \"quoted\"\nline"]));
    }
}
