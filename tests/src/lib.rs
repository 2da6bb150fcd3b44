//! What the tests of more than one topic share: random numbers, exact lights, renders with their statistics, and runs of the program.
#![forbid(unsafe_code)]

pub mod polygon_light;
pub mod program;
pub mod random;
pub mod render;
