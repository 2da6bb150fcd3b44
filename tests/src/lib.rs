//! What the tests of more than one topic share: all ways to trace compared, random numbers, exact lights, renders with their
//! statistics, and runs of the program.
#![forbid(unsafe_code)]

pub mod check;
pub mod polygon_light;
pub mod program;
pub mod random;
pub mod render;
