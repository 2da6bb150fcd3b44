//! Warps: maps from the unit square to a domain with a known density, with their exact inverses.
//!
//! Directions are unit vectors about z, and their densities are per steradian. For every warp and every u in [0, 1)²,
//! `pdf(map(u)) > 0` and `inverse(map(u))` is u up to rounding (save where the map itself is singular, as an azimuth
//! at the pole); the integral of `pdf` over the domain is 1.
//!
//! [`map`](Warp::map) is the reference, one point at a time; [`map_many`](Warp::map_many) is the same in lanes.

mod bilinear;
mod hemisphere;
mod shapes;
#[cfg(test)]
mod tests;

use glam::Vec2;

use super::batch::{Function, apply_many};
use crate::simd::Isa;
pub use bilinear::Bilinear;
pub use hemisphere::{
    ConcentricHemisphere, CosineHemisphere, MalleyHemisphere, PowerCosineHemisphere, UniformHemisphere,
};
pub use shapes::{ConcentricDisc, Cone, PolarDisc, Triangle, UniformSphere};

/// A map from the unit square to the points of a domain.
pub trait Warp {
    /// A point of the domain.
    type Point;

    /// The point for `u` in [0, 1)².
    fn map(&self, u: Vec2) -> Self::Point;

    /// The density of `map` at a point, by the domain's measure; 0 outside of the domain.
    fn pdf(&self, point: Self::Point) -> f32;

    /// The `u` in [0, 1)² that `map` carries to a point of the domain.
    fn inverse(&self, point: Self::Point) -> Vec2;

    /// [`map`](Self::map) of each `u`, with the instructions of `isa`: faster, and equal bit for bit. Elements beyond
    /// the end of the shorter slice are left unchanged.
    fn map_many(&self, isa: Isa, u: &[Vec2], points: &mut [Self::Point])
    where
        Self: Sized,
    {
        apply_many(isa, Map(self), u, points);
    }
}

/// A warp's map as a function of one element.
struct Map<'a, W>(&'a W);

impl<W: Warp> Function for Map<'_, W> {
    type Input = Vec2;
    type Output = W::Point;
    #[inline(always)]
    fn apply(&self, u: Vec2) -> W::Point {
        self.0.map(u)
    }
}
