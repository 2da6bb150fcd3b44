//! Laws of every closure: energy, reciprocity, and densities that match the samples.

mod cases;
mod chi_square;
mod laws;
mod parts;
mod shading;

use glam::{DVec3, Vec2, Vec3};
use halfdome_kernel::sampling::{Pattern, Sampler};

use super::{Bsdf, Closure};

/// Points of the unit square, evenly spread.
fn points(count: u32) -> impl Iterator<Item = Vec2> {
    (0..count).map(|i| Sampler::new(Pattern::Sobol, 7, 1, i).uniform2(0))
}

/// A direction by the cosine of its polar angle and its azimuth.
fn direction(cos: f32, azimuth: f32) -> Vec3 {
    let sin = ((1.0 - cos) * (1.0 + cos)).sqrt();
    Vec3::new(sin * azimuth.cos(), sin * azimuth.sin(), cos)
}

/// A direction as seen from the other side of the surface.
fn turned(w: Vec3) -> Vec3 {
    Vec3::new(w.x, w.y, -w.z)
}

/// The part of uniform light that reaches `wo`, by samples.
fn furnace(closure: &Closure, wo: Vec3, count: u32) -> Vec3 {
    let sum: DVec3 = points(count).filter_map(|u| closure.sample(wo, u)).map(|sample| sample.weight.as_dvec3()).sum();
    (sum / f64::from(count)).as_vec3()
}
