//! The irradiance cache from end to end: against exact answers, against path tracing, and on the command line.

mod command;
mod differences;
mod leaks;
mod light;
mod opening;
mod records;
