//! Ctrl-C and SIGTERM: the first ends a render early, with its picture so far; the second ends the program at once.

use std::sync::atomic::{AtomicBool, Ordering};

use super::error::CliError;

static REQUESTED: AtomicBool = AtomicBool::new(false);

/// What shells report of a program that SIGINT ended: 128 + 2.
const EXIT_KILLED: i32 = 130;

/// Catches the signals from now on. Until then they end the program as usual, for there is no picture to save.
pub(super) fn catch() -> Result<(), CliError> {
    static CAUGHT: AtomicBool = AtomicBool::new(false);
    if CAUGHT.swap(true, Ordering::Relaxed) {
        return Ok(());
    }
    ctrlc::set_handler(|| {
        if REQUESTED.swap(true, Ordering::Relaxed) {
            std::process::exit(EXIT_KILLED);
        }
    })
    .map_err(|error| CliError::System(format!("cannot catch signals: {error}")))
}

/// Whether a signal has come.
pub(super) fn requested() -> bool {
    REQUESTED.load(Ordering::Relaxed)
}
