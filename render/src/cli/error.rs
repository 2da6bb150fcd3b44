//! What ends a run before it is done, and the exit code that it has.

use std::fmt::Display;
use std::io::{IsTerminal, Write};

use serde_json::json;

use super::progress::{Mode, print_line};
use super::{EXIT_INPUT, EXIT_SYSTEM};
use crate::scene::SceneError;
use crate::settings::Invalid;

/// Why there is no result. The texts may have further lines with help.
#[derive(Debug, thiserror::Error)]
pub(super) enum CliError {
    /// The user can put it right: a file or an option.
    #[error("{0}")]
    Input(String),
    /// The machine is at its limits, or a file cannot be written.
    #[error("{0}")]
    System(String),
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
        }
    }

    /// Prints the error to stderr, as a line of JSON if `mode` asks for lines of JSON.
    pub(super) fn print(&self, mode: Mode) {
        if mode == Mode::Json {
            return print_line(&json!({ "event": "error", "message": self.to_string() }));
        }
        let error = painted("error:", "1;31");
        // If stderr is closed, there is nobody to tell.
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

/// `text` in the style of ECMA-48's `codes` if stderr is a terminal and `NO_COLOR` is unset or empty.
pub(super) fn painted(text: &str, codes: &str) -> String {
    let plain = std::env::var_os("NO_COLOR").is_some_and(|value| !value.is_empty());
    if plain || !std::io::stderr().is_terminal() { text.to_owned() } else { format!("\x1b[{codes}m{text}\x1b[0m") }
}
