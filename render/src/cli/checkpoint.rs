//! A render's film on disk: read to resume it, written periodically and at the end, by one run at a time.

use std::fs;
use std::path::Path;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::{Duration, Instant};

use super::error::{CliError, invalid};
use super::lock::Lock;
use super::messages::{Style, print_warning};
use crate::film::Film;
use crate::output::OutputFile;

/// The file of a film while it is rendered.
#[derive(Debug)]
pub(super) struct Checkpoint {
    file: OutputFile,
    /// How long to wait until it is written again.
    interval: Duration,
    start: Instant,
    /// Milliseconds after the start.
    due: AtomicU64,
    has_failed: AtomicBool,
    _lock: Lock,
}

impl Checkpoint {
    /// Takes hold of a film's place.
    pub(super) fn new(path: &Path, interval: Duration) -> Result<Self, CliError> {
        let file = OutputFile::check(path).map_err(CliError::input)?;
        let lock = Lock::new(path, "rendering this film")?;
        let due = AtomicU64::new(milliseconds(interval));
        Ok(Self { file, interval, start: Instant::now(), due, has_failed: AtomicBool::new(false), _lock: lock })
    }

    /// Whether it is time to write.
    pub(super) fn is_due(&self) -> bool {
        milliseconds(self.start.elapsed()) >= self.due.load(Ordering::Relaxed)
    }

    /// Writes a film that is not complete. A failure is reported once without ending the render, and again at the end.
    pub(super) fn write(&self, film: &Film, style: Style) {
        if let Err(error) = self.file.write(&film.encode())
            && !self.has_failed.swap(true, Ordering::Relaxed)
        {
            print_warning(style, &format!("the checkpoint was not written; the render continues: {error}"));
        }
        self.due.store(milliseconds(self.start.elapsed() + self.interval), Ordering::Relaxed);
    }
}

/// Reads a film.
pub(super) fn read_film(path: &Path) -> Result<Film, CliError> {
    let name = path.display().to_string();
    let bytes = fs::read(path).map_err(|error| {
        invalid(format!("{name}: cannot be read: {error}"), "name a film (.hdf) of `halfdome render`")
    })?;
    Film::decode(&bytes).map_err(|error| CliError::input(error.naming(&name)))
}

fn milliseconds(duration: Duration) -> u64 {
    u64::try_from(duration.as_millis()).unwrap_or(u64::MAX)
}
