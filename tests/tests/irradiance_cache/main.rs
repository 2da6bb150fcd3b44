//! The irradiance cache from end to end: against exact answers, against path tracing, and on the command line.

mod accuracy;
mod command;
mod curved;
mod differences;
mod lamps;
mod leaks;
mod light;
mod opening;
mod records;
