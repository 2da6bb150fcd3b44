//! Watches a render: shows progress, writes early pictures (`--progressive`) and checkpoints, enforces a time limit.

use std::path::PathBuf;
use std::time::Instant;

use serde_json::json;

use super::statistics::Recorder;
use crate::cli::checkpoint::Checkpoint;
use crate::cli::messages::{Style, print_line};
use crate::cli::progress::Progress;
use crate::cli::tev::Tev;
use crate::film::{Film, Picture};
use crate::output::{self, ToneMapping};
use crate::watch::Watch;

/// Watches a render as `progress` does.
pub(super) struct RenderWatch<'a> {
    pub(super) progress: &'a Progress,
    /// The side of the first squares, if the picture is to be seen early.
    pub(super) coarsest: Option<u32>,
    /// The path of early pictures.
    pub(super) paths: &'a [PathBuf],
    pub(super) tone: &'a ToneMapping,
    pub(super) style: Style,
    /// When time is up.
    pub(super) deadline: Option<Instant>,
    /// The path of the film.
    pub(super) checkpoint: Option<&'a Checkpoint>,
    /// The recorder of progress.
    pub(super) recorder: Option<&'a Recorder>,
    /// The display of progress.
    pub(super) tev: Option<&'a Tev>,
}

impl RenderWatch<'_> {
    /// Whether time is up.
    pub(super) fn is_late(&self) -> bool {
        self.deadline.is_some_and(|deadline| Instant::now() >= deadline)
    }
}

impl Watch for RenderWatch<'_> {
    fn advance(&self, samples: u64, rays: u64) {
        self.progress.advance(samples, rays);
    }

    fn stop(&self) -> bool {
        self.progress.stop() || self.is_late()
    }

    fn coarsest(&self) -> u32 {
        self.coarsest.unwrap_or(1)
    }

    fn level(&self, side: u32, picture: &Picture) {
        if let Some(tev) = self.tev {
            tev.show(picture, true);
        }
        // A file that cannot be written now cannot be written at the end, where the error is reported.
        let written = self.paths.iter().filter(|path| output::write(path, picture, self.tone).is_ok());
        let files: Vec<_> = written.map(|path| path.display().to_string()).collect();
        if self.style == Style::Json {
            print_line(&json!({ "event": "level", "side": side, "files": files }));
        }
    }

    fn wave(&self, film: &Film) {
        if let Some(recorder) = self.recorder {
            recorder.note(film);
        }
        if let Some(tev) = self.tev {
            tev.show_film(film);
        }
    }

    fn wants_film(&self) -> bool {
        self.checkpoint.is_some_and(Checkpoint::is_due)
    }

    fn film(&self, film: &Film) {
        if let Some(checkpoint) = self.checkpoint {
            checkpoint.write(film, self.style);
        }
    }
}
