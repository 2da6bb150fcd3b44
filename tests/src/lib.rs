//! What the tests of more than one topic share: random numbers, renders with their statistics, and runs of the program.
#![forbid(unsafe_code)]

pub mod program;
pub mod random;
pub mod render;
