//! Errors that end a run early, and their exit codes.

use std::fmt::Display;
use std::io::Write;

use serde_json::json;

use super::messages::{Mode, painted, print_line};
use crate::scene::SceneError;
use crate::settings::Invalid;

/// Done.
pub(super) const EXIT_DONE: u8 = 0;
/// Bad input or usage, found before the render.
pub(super) const EXIT_INPUT: u8 = 1;
/// The system failed, for example while a picture was written.
pub(super) const EXIT_SYSTEM: u8 = 2;
/// Interrupted, with a valid partial picture.
pub(super) const EXIT_INTERRUPTED: u8 = 3;
/// A limit ended the render before its target.
pub(super) const EXIT_LIMIT: u8 = 4;
/// An experiment failed.
pub(super) const EXIT_FAILED: u8 = 5;

/// Why there is no result. The texts may have further lines with help.
#[derive(Debug, thiserror::Error)]
pub(super) enum CliError {
    /// The user can put it right: a file or an option.
    #[error("{0}")]
    Input(String),
    /// The machine is at its limits, or a file cannot be written.
    #[error("{0}")]
    System(String),
    /// A check failed.
    #[error("{0}")]
    Failed(String),
}

impl CliError {
    pub(super) fn input(error: impl Display) -> Self {
        Self::Input(error.to_string())
    }

    pub(super) fn system(error: impl Display) -> Self {
        Self::System(error.to_string())
    }

    pub(super) fn exit_code(&self) -> u8 {
        match self {
            Self::Input(_) => EXIT_INPUT,
            Self::System(_) => EXIT_SYSTEM,
            Self::Failed(_) => EXIT_FAILED,
        }
    }

    /// Prints the error to stderr, as a line of JSON if `mode` asks for lines of JSON.
    pub(super) fn print(&self, mode: Mode) {
        if mode == Mode::Json {
            return print_line(&json!({ "event": "error", "message": self.to_string() }));
        }
        let error = painted("error:", "1;31");
        // If stderr is closed, the message is lost.
        let _ = writeln!(std::io::stderr(), "{error} {self}");
    }
}

impl From<Invalid> for CliError {
    fn from(error: Invalid) -> Self {
        Self::input(error)
    }
}

impl From<SceneError> for CliError {
    fn from(error: SceneError) -> Self {
        Self::input(error)
    }
}

/// An error about the options.
pub(super) fn invalid(problem: impl Into<String>, remedy: impl Into<String>) -> CliError {
    Invalid::new(problem, remedy).into()
}
