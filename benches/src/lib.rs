//! The shared code of the benchmarks: [`scenes`] to trace, [`rays`] to trace in them, the ways to trace them
//! ([`tracer`]) and how those are timed and their answers compared ([`measure`], [`rounds`]).
//!
//! `cargo bench -p halfdome-benches` times the kernel's entry points against each other; the binary `peers` times them
//! against other ray tracers, and `renderers` times the path tracer against other renderers.
#![forbid(unsafe_code)]

pub mod instances;
pub mod measure;
pub mod rays;
pub mod rounds;
pub mod scenes;
pub mod tracer;
pub mod visits;
