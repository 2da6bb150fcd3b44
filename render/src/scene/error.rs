//! Errors of input files: the file, the place in it, the problem, and the remedy.

use std::fmt;
use std::path::{Path, PathBuf};

/// A problem with a scene, model or settings file.
///
/// Prints as `file:line: problem` or `file: place: problem`, then the remedy on a line of its own.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub struct SceneError {
    /// The file that is wrong.
    pub file: PathBuf,
    /// The place in the file.
    pub place: Place,
    /// The problem, as a sentence without a capital or a full stop.
    pub problem: String,
    /// The remedy, likewise.
    pub remedy: String,
}

/// A place in a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Place {
    /// The file as a whole.
    File,
    /// A line, counted from 1.
    Line(usize),
    /// A named part, such as `accessor 3` or `node 5 ("lamp")`.
    Part(String),
}

impl SceneError {
    /// An error in `file` at `place`.
    pub fn new(file: &Path, place: Place, problem: impl Into<String>, remedy: impl Into<String>) -> Self {
        Self { file: file.to_owned(), place, problem: problem.into(), remedy: remedy.into() }
    }

    /// An error of the operating system while reading `file`.
    pub fn unreadable(file: &Path, error: &std::io::Error) -> Self {
        let remedy = match error.kind() {
            std::io::ErrorKind::NotFound => "check the path, which is relative to the folder of the file that names it",
            std::io::ErrorKind::PermissionDenied => "give this user the right to read it",
            std::io::ErrorKind::IsADirectory => "name a file, not a folder",
            _ => "check that the file can be read",
        };
        let problem = match error.kind() {
            std::io::ErrorKind::NotFound => "no such file".to_owned(),
            _ => format!("cannot be read: {error}"),
        };
        Self::new(file, Place::File, problem, remedy)
    }
}

impl fmt::Display for SceneError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let file = self.file.display();
        match &self.place {
            Place::File => write!(f, "{file}: ")?,
            Place::Line(line) => write!(f, "{file}:{line}: ")?,
            Place::Part(part) => write!(f, "{file}: {part}: ")?,
        }
        write!(f, "{}\n  help: {}", self.problem, self.remedy)
    }
}

/// Names that are listed at most.
const MAX_LISTED: usize = 5;

/// "a", "a and b", "a, b and 3 more".
pub(crate) fn listed(names: &[String]) -> String {
    let (shown, rest) = names.split_at(names.len().min(MAX_LISTED));
    match (shown, rest.len()) {
        ([], _) => String::new(),
        ([one], 0) => one.clone(),
        ([first @ .., last], 0) => format!("{} and {last}", first.join(", ")),
        (shown, more) => format!("{} and {more} more", shown.join(", ")),
    }
}

/// "1 face", "2 faces".
pub(crate) fn count(number: usize, one: &str, many: &str) -> String {
    format!("{number} {}", if number == 1 { one } else { many })
}
