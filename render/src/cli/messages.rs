//! Messages on stderr, as text or as lines of JSON.

use std::io::{IsTerminal, Write};

use serde_json::{Value, json};

/// The requested display of progress.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(super) enum Mode {
    /// A bar if stderr is a terminal, else lines of JSON
    Auto,
    /// A bar (only if stderr is a terminal) and a summary
    Bar,
    /// Lines of JSON: start, progress (at most twice a second), warning, and end or error; for large models, load
    /// and build before start; for bakes, progress of the stages unwrap and pack first
    Json,
    /// Only warnings and errors
    None,
}

/// The display of progress.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Style {
    Bar,
    Json,
    Silent,
}

impl Style {
    /// For commands whose output is for people: a bar if stderr is a terminal.
    pub(super) fn for_people() -> Self {
        if std::io::stderr().is_terminal() { Self::Bar } else { Self::Silent }
    }
}

impl Mode {
    /// The style, on a terminal or elsewhere.
    pub(super) fn style(self, terminal: bool) -> Style {
        match self {
            Self::Auto if terminal => Style::Bar,
            Self::Auto | Self::Json => Style::Json,
            Self::Bar => Style::Bar,
            Self::None => Style::Silent,
        }
    }
}

/// Prints one line of JSON to stderr, and ignores a closed stderr.
pub(super) fn print_line(event: &Value) {
    let _ = writeln!(std::io::stderr(), "{event}");
}

/// Warnings are printed even without progress.
pub(super) fn print_warning(style: Style, warning: &str) {
    match style {
        Style::Json => print_line(&json!({ "event": "warning", "message": warning })),
        Style::Bar | Style::Silent => {
            let _ = writeln!(std::io::stderr(), "{} {warning}", painted("warning:", "1;33"));
        }
    }
}

/// Prints warnings, and takes them out.
pub(super) fn warn(style: Style, warnings: &mut Vec<String>) {
    warnings.drain(..).for_each(|warning| print_warning(style, &warning));
}

/// Tells what happens, in the form that progress has.
pub(super) fn print_text(style: Style, text: &str) {
    match style {
        Style::Silent => {}
        Style::Json => print_line(&json!({ "event": "note", "message": text })),
        Style::Bar => {
            let _ = writeln!(std::io::stderr(), "{text}");
        }
    }
}

/// `text` in the style of ECMA-48's `codes` if stderr is a terminal and `NO_COLOR` is unset or empty.
pub(super) fn painted(text: &str, codes: &str) -> String {
    let plain = std::env::var_os("NO_COLOR").is_some_and(|value| !value.is_empty());
    if plain || !std::io::stderr().is_terminal() { text.to_owned() } else { format!("\x1b[{codes}m{text}\x1b[0m") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn auto_depends_on_the_terminal_alone() {
        assert_eq!(Mode::Auto.style(true), Style::Bar);
        assert_eq!(Mode::Auto.style(false), Style::Json);
        assert_eq!(Mode::Bar.style(false), Style::Bar);
        assert_eq!(Mode::Json.style(true), Style::Json);
        assert_eq!(Mode::None.style(true), Style::Silent);
    }
}
