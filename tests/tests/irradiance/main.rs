//! The kernel's gather against scenes whose irradiance and derivatives are known exactly. Nothing is traced: each scene
//! finds by formula what is along a direction.
//!
//! Tests of the irradiance cache's mathematics, for strata and for the hemicube where both apply:
//!
//! | | claim | where it is tested |
//! | --- | --- | --- |
//! | 1 | a furnace's irradiance, after k reflections and without end | `irradiance_cache/light.rs` by caches; `furnace.rs`, `halfdome validate furnace` by paths |
//! | 2 | the variance of roulette in a furnace | `halfdome validate furnace-variance`, `furnace-survival` |
//! | 3 | a furnace has no translational gradient | `figures.rs` |
//! | 4 | E, ∇_r and ∇_t of random polygon lights, ever better as cells double | `polygons.rs` |
//! | 4b | the same, and the Hessian, of points that were chosen on a light | `sources.rs` |
//! | 5 | a sphere light | `figures.rs` |
//! | 6 | the sky over a wall | `figures.rs` |
//! | 7 | the shadow's edge of an occluder that moves | `figures.rs`; traced, within 3%, in `irradiance_cache/opening.rs` |
//! | 8 | gradients are finite differences, over a sweep of steps | `irradiance_cache/opening.rs` of exact irradiance, `differences.rs` of path tracing |
//! | 9 | a turned azimuth turns the gradients | `symmetry.rs`; traced in `irradiance_cache/opening.rs` |
//! | 10 | scale has no influence | `symmetry.rs`; on whole caches in `irradiance_cache/records.rs` |
//! | 11 | neither have threads and instruction sets | `irradiance_cache/command.rs` |
//! | 12 | error against all rays spent | `halfdome validate cache`, and the benchmark `irradiance_curves` |

mod figures;
mod hessian;
mod polygons;
mod scene;
mod sources;
mod symmetry;
