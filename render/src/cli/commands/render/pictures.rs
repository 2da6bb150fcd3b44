//! Pictures on disk: all that can be written are, and what could not is told in the end.

use std::path::{Path, PathBuf};

use crate::cli::error::CliError;
use crate::film::{Picture, is_for_denoising};
use crate::output::{self, ToneMapping};

/// Whether a path is that of an EXR, which alone has all channels.
pub(super) fn is_exr(path: &Path) -> bool {
    output::Format::from_path(path) == Ok(output::Format::Exr)
}

/// The picture's name in a viewer: its file's, or the scene's.
pub(super) fn shown_name(paths: &[PathBuf], scene: &Path) -> String {
    paths.first().map_or(scene, PathBuf::as_path).display().to_string()
}

/// Writes every picture that can be written, for it may have taken hours to make: paths written, errors of the others.
pub(crate) fn write_all(paths: &[PathBuf], picture: &Picture, tone: &ToneMapping) -> (Vec<PathBuf>, Vec<String>) {
    let mut written = Vec::new();
    let mut failures = Vec::new();
    for path in paths {
        match output::write(path, picture, tone) {
            Ok(()) => written.push(path.clone()),
            Err(error) => failures.push(error.to_string()),
        }
    }
    (written, failures)
}

/// An error if there are failures, which lists the files that were written.
pub(crate) fn refuse_failures(written: &[PathBuf], mut failures: Vec<String>) -> Result<(), CliError> {
    if failures.is_empty() {
        return Ok(());
    }
    // An end that names files would look like success.
    failures.extend(written.iter().map(|path| format!("{} was written", path.display())));
    Err(CliError::System(failures.join("\n")))
}

/// The picture without what only denoising needed.
pub(super) fn without_aov(mut picture: Picture) -> Picture {
    picture.channels.retain(|channel| !is_for_denoising(&channel.name));
    picture
}

/// Whether no pixel has any light.
pub(super) fn is_black(picture: &Picture) -> bool {
    ["R", "G", "B"]
        .iter()
        .filter_map(|name| picture.channel(name))
        .all(|channel| channel.values.iter().all(|&v| v == 0.0))
}
