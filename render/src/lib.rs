//! halfdome: a renderer for people who light scenes, on top of [`halfdome_kernel`].
#![forbid(unsafe_code)]

pub mod bake;
mod bsdf;
pub mod cache;
mod camera;
#[cfg(feature = "cli")]
pub mod cli;
pub mod cubemap;
pub mod driver;
mod estimator;
mod executor;
pub mod film;
mod integrator;
pub mod irradiance;
mod light;
pub mod material;
pub mod output;
pub mod overlay;
pub mod probes;
pub mod scene;
pub mod settings;
#[cfg(feature = "cli")]
pub mod validate;
mod watch;
pub mod world;

pub use executor::RayonExecutor;
