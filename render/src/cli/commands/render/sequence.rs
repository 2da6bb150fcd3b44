//! `halfdome render --frames`: one picture after the other.

use std::io::IsTerminal;
use std::path::PathBuf;

use super::render;
use super::summary::Told;
use crate::cli::args::RenderArguments;
use crate::cli::error::{CliError, EXIT_DONE, EXIT_INTERRUPTED, EXIT_LIMIT};
use crate::cli::interrupt;
use crate::cli::messages::print_text;

/// Renders frames one after the other, each written when it is done.
pub(super) fn sequence(arguments: &RenderArguments, frames: impl Iterator<Item = i32>) -> Result<u8, CliError> {
    let style = arguments.common.progress.style(std::io::stderr().is_terminal());
    arguments.check_skipping()?;
    let mut code = EXIT_DONE;
    let told = Told::default();
    for frame in frames {
        let arguments = arguments.of_frame(frame)?;
        // A file without a byte is what a full disk or a failed copy leaves.
        let is_there = |path: &PathBuf| path.metadata().is_ok_and(|file| file.len() > 0);
        if arguments.sequence.skip_existing && arguments.outputs()?.iter().all(is_there) {
            print_text(style, &format!("frame {frame} is there"));
            continue;
        }
        if interrupt::requested() {
            return Ok(EXIT_INTERRUPTED);
        }
        print_text(style, &format!("frame {frame}"));
        match render(&arguments, &told)? {
            EXIT_INTERRUPTED => return Ok(EXIT_INTERRUPTED),
            EXIT_LIMIT => code = EXIT_LIMIT,
            _ => {}
        }
    }
    Ok(code)
}
