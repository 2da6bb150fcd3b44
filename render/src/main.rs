//! The command line of halfdome.
#![forbid(unsafe_code)]

use std::process::ExitCode;

fn main() -> ExitCode {
    halfdome::cli::main()
}
