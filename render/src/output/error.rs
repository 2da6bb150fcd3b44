//! Errors of picture files, with remedies.

use std::fmt;
use std::io;
use std::path::{Path, PathBuf};

/// A picture that cannot be written or read.
///
/// Prints as `file: problem`, then the remedy on a line of its own.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub struct OutputError {
    /// The picture's file.
    pub file: PathBuf,
    /// The problem, as a sentence without a capital or a full stop.
    pub problem: String,
    /// The remedy, likewise.
    pub remedy: String,
}

impl OutputError {
    /// An error about `file`.
    pub fn new(file: &Path, problem: impl Into<String>, remedy: impl Into<String>) -> Self {
        Self { file: file.to_owned(), problem: problem.into(), remedy: remedy.into() }
    }

    /// An error of the operating system while writing `file`.
    pub(super) fn unwritable(file: &Path, error: &io::Error) -> Self {
        let remedy = match error.kind() {
            io::ErrorKind::PermissionDenied => "give this user the right to write into the folder, or choose another",
            io::ErrorKind::ReadOnlyFilesystem => "choose a folder on a disk that can be written",
            io::ErrorKind::StorageFull | io::ErrorKind::QuotaExceeded => "make room on the disk, or choose another",
            io::ErrorKind::InvalidFilename => "choose a shorter name without special characters",
            _ => "choose another folder",
        };
        Self::new(file, format!("cannot be written: {error}"), remedy)
    }

    /// An error of the operating system while reading `file`.
    pub(super) fn unreadable(file: &Path, error: &io::Error) -> Self {
        let (problem, remedy) = match error.kind() {
            io::ErrorKind::NotFound => ("no such file".to_owned(), "check the path"),
            io::ErrorKind::PermissionDenied => {
                (format!("cannot be read: {error}"), "give this user the right to read it")
            }
            io::ErrorKind::IsADirectory => ("is a folder".to_owned(), "name a file in it"),
            _ => (format!("cannot be read: {error}"), "check that the file can be read"),
        };
        Self::new(file, problem, remedy)
    }
}

impl fmt::Display for OutputError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}\n  help: {}", self.file.display(), self.problem, self.remedy)
    }
}
