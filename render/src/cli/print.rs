//! Results on standard output.

use std::io::{self, Write};

use super::error::CliError;

/// Prints to standard output. Who closes the pipe has seen enough.
pub(super) fn print(text: &str) -> Result<(), CliError> {
    let mut stdout = io::stdout().lock();
    match stdout.write_all(text.as_bytes()).and_then(|()| stdout.flush()) {
        Err(error) if error.kind() != io::ErrorKind::BrokenPipe => {
            Err(CliError::System(format!("cannot write to standard output: {error}")))
        }
        _ => Ok(()),
    }
}
