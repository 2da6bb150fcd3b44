//! Shared code of the tests: all ways to trace compared, random numbers, exact lights, renders with their statistics,
//! and runs of the program.
#![forbid(unsafe_code)]

pub mod check;
pub mod polygon_light;
pub mod program;
pub mod random;
pub mod render;
pub mod scenes;
pub mod ways;
