//! A renderer and light baker for the CPU, on top of [`halfdome_kernel`]: path tracing, irradiance caching, lightmaps,
//! cube maps and light probes. The program `halfdome` is a thin command line over this library.
//!
//! # What one can do
//!
//! Render a scene and write the picture. A [`scene::Scene`] is a description, read from a file or built in memory; a
//! [`world::World`] is a scene prepared for tracing; a [`film::Picture`] is the result. It depends on the scene and the
//! settings alone, not on threads.
//!
//! ```
//! use halfdome::driver::{self, Watch};
//! use halfdome::output::{self, ToneMapping};
//! use halfdome::scene::cornell_box;   // `scene::load(path)` reads OBJ, PLY, glTF and GLB, `scene::open` scene files too
//! use halfdome::settings::Settings;
//! use halfdome::world::World;
//!
//! /// Hears of progress, and may stop a render.
//! struct Unwatched;
//!
//! impl Watch for Unwatched {
//!     fn advance(&self, _samples: u64, _rays: u64) {}
//!     fn stop(&self) -> bool {
//!         false
//!     }
//! }
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let world = World::new(cornell_box())?;
//! let settings = Settings { width: 32, height: 32, spp: 4, ..Settings::default() };
//! let render = driver::render(&world, &settings, &Unwatched);
//! assert!(render.finished);
//!
//! let folder = tempfile::tempdir()?;
//! output::write(&folder.path().join("cornell.png"), &render.picture, &ToneMapping::default())?;
//! # Ok(())
//! # }
//! ```
//!
//! Find the irradiance at a point, in W/m²:
//!
//! ```
//! # use halfdome::driver::Watch;
//! # use halfdome::scene::cornell_box;
//! # use halfdome::world::World;
//! # struct Unwatched;
//! # impl Watch for Unwatched {
//! #     fn advance(&self, _: u64, _: u64) {}
//! #     fn stop(&self) -> bool { false }
//! # }
//! use glam::Vec3;
//! use halfdome::irradiance::{Part, Request, Sensor, by_paths};
//!
//! let world = World::new(cornell_box()).unwrap();
//! let floor = Sensor { position: Vec3::new(0.278, 0.001, 0.279), normal: Vec3::Y };
//! let found = by_paths(&world, &[floor], &Request { spp: 256, seed: 0, part: Part::Total }, &Unwatched);
//! assert!(found.values[0].min_element() > 0.0);
//! ```
//!
//! [`bake`], [`cubemap`] and [`probes`] make lightmaps, prefiltered cube maps and spherical-harmonics probes in the
//! same way: a world or a scene, options, and a [`driver::Watch`].
//!
//! # Modules
//!
//! | module | has |
//! | --- | --- |
//! | [`scene`] | what is in a scene; readers of OBJ, MTL, PLY, glTF, TOML, HDR and EXR skies; the built-in Cornell box |
//! | [`settings`] | what a picture depends on besides the scene: size, samples, filter, integrator |
//! | [`world`] | a scene made ready for tracing |
//! | [`driver`] | renders a picture, on threads or step by step |
//! | [`film`] | pixel filters and pictures |
//! | [`denoise`] | denoising of pictures |
//! | [`cache`] | irradiance caches: records, interpolation, files |
//! | [`irradiance`] | irradiance at points |
//! | [`bake`] | lightmaps and ambient occlusion, for glTF, OBJ and PLY |
//! | [`cubemap`] | prefiltered cube maps |
//! | [`probes`] | light probes and irradiance volumes |
//! | [`lpe`] | light path expressions |
//! | [`output`] | EXR, PNG, Radiance and KTX2 files, tone mapping |
//! | [`overlay`] | where a picture shows the records of a cache |
//! | `view` | a scene to look around in, without a window |
//!
//! # Features
//!
//! `cli` (default) adds the command line and `validate`, the experiments with exact answers. Without it the library
//! builds for WebAssembly too. `oidn` (default) adds denoising by Open Image Denoise, which is loaded at run time.
//! `view` adds the window of `halfdome view`.
#![cfg_attr(not(feature = "cli"), allow(dead_code, unused_imports, reason = "what the command line alone calls"))]
#![forbid(unsafe_code)]

pub mod bake;
mod bsdf;
pub mod cache;
mod camera;
#[cfg(feature = "cli")]
pub mod cli;
pub mod cubemap;
pub mod denoise;
pub mod driver;
mod estimator;
mod executor;
pub mod film;
#[cfg(test)]
mod fixtures;
mod guide;
mod integrator;
pub mod irradiance;
mod light;
pub mod lpe;
pub mod material;
pub mod output;
pub mod overlay;
pub mod probes;
pub mod scene;
pub mod settings;
#[cfg(feature = "cli")]
pub mod validate;
#[cfg(feature = "cli")]
pub mod view;
mod watch;
pub mod world;

pub use executor::RayonExecutor;
