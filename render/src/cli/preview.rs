//! `--progressive`: the pictures on disk while they go from coarse to fine.

use std::path::PathBuf;

use serde_json::json;

use super::messages::{Style, print_line};
use super::progress::Progress;
use crate::film::Picture;
use crate::output::{self, ToneMapping};
use crate::watch::Watch;

/// Watches a render as `progress` does, and writes each level.
pub(super) struct Preview<'a> {
    pub(super) progress: &'a Progress,
    /// The side of the first squares, if the picture is to be seen early.
    pub(super) coarsest: Option<u32>,
    pub(super) paths: &'a [PathBuf],
    pub(super) tone: &'a ToneMapping,
    pub(super) style: Style,
}

impl Watch for Preview<'_> {
    fn advance(&self, samples: u64, rays: u64) {
        self.progress.advance(samples, rays);
    }

    fn stop(&self) -> bool {
        self.progress.stop()
    }

    fn coarsest(&self) -> u32 {
        self.coarsest.unwrap_or(1)
    }

    fn level(&self, side: u32, picture: &Picture) {
        // What cannot be written now cannot be written in the end, which tells.
        let written = self.paths.iter().filter(|path| output::write(path, picture, self.tone).is_ok());
        let files: Vec<_> = written.map(|path| path.display().to_string()).collect();
        if self.style == Style::Json {
            print_line(&json!({ "event": "level", "side": side, "files": files }));
        }
    }
}
