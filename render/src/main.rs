//! The command line of halfdome.
#![forbid(unsafe_code)]

fn main() {}
