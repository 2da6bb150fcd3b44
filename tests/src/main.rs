//! halfdome itself, where the tests find it.
#![forbid(unsafe_code)]

use std::process::ExitCode;

fn main() -> ExitCode {
    halfdome::cli::main()
}
