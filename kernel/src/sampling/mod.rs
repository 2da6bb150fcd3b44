//! Random and quasi-random numbers, and warps that turn them into directions and points.
//!
//! A *sampler* addresses numbers by (seed, pixel, sample, set) and so has no state: any thread may ask for any number
//! in any order. A *warp* carries the unit square to a domain with a known density and back again.
//!
//! Every function is plain additions, multiplications, divisions and square roots (all correctly rounded by IEEE 754),
//! or a soft-float routine of `libm`. Nothing is fused and nothing asks the platform's mathematics library, so results
//! are equal bit for bit on every target with IEEE single precision, and as well one by one as in batches, which run in
//! lanes ([`fill2`], [`fill4`], [`warp::Warp::map_many`], [`Frame::from_normals`]).
//!
//! ```
//! use glam::Vec3;
//! use halfdome_kernel::sampling::warp::{CosineHemisphere, Warp};
//! use halfdome_kernel::sampling::{Frame, Pattern, Sampler};
//!
//! // A direction about a normal for the bounce of sample 3 in pixel 1234 that uses set 2.
//! let sampler = Sampler::new(Pattern::Sobol, 0, 1234, 3);
//! let local = CosineHemisphere.map(sampler.uniform2(2));
//! let direction = Frame::from_normal(Vec3::X).to_world(local);
//! assert!(direction.x > 0.0 && CosineHemisphere.pdf(local) > 0.0);
//! ```

mod alias;
mod batch;
mod circle;
mod fill;
mod frame;
mod heuristic;
mod rng;
mod sampler;
mod sequence;
mod strata;
#[cfg(test)]
mod tests;
pub mod warp;

use glam::Vec2;

pub use alias::{AliasEntry, AliasError, AliasTable};
pub use circle::{sin_cos_turns, turns};
pub use fill::{SampleId, fill2, fill4};
pub use frame::Frame;
pub use heuristic::{balance, power};
pub use rng::{Stream, philox4x32};
pub use sampler::{Pattern, Sampler};
pub use sequence::{DIMENSIONS, nested_uniform_scramble, r2, sobol};
pub use strata::{Strata, StrataError, Stratum};

/// The largest `f32` below 1: the upper end of every unit interval [0, 1) here.
pub const ONE_MINUS_EPSILON: f32 = 1.0 - f32::EPSILON / 2.0;

/// The correctly rounded square root; with `std` a version that the compiler can vectorise.
#[inline(always)]
fn sqrt(x: f32) -> f32 {
    #[cfg(feature = "std")]
    return x.sqrt();
    #[cfg(not(feature = "std"))]
    return libm::sqrtf(x);
}

/// A 32-bit fraction as a float in [0, 1): its upper 24 bits, so that no rounding can reach 1.
#[inline(always)]
fn unit_float(bits: u32) -> f32 {
    (bits >> 8) as f32 * (1.0 / 16_777_216.0)
}

/// One number in [0, 1) of 48 bits from two of 24: `u.x` by its multiples of 2⁻²⁴, and `u.y` between them. Where `u`
/// are points of low discrepancy, this number is as well distributed as their first coordinate.
#[inline]
pub fn unit_double(u: Vec2) -> f64 {
    f64::from(u.x) + f64::from(u.y) * (1.0 / 16_777_216.0)
}

/// Pushes what rounding carried out of [0, 1) back into it.
#[inline(always)]
fn into_unit(x: f32) -> f32 {
    x.clamp(0.0, ONE_MINUS_EPSILON)
}
