//! Warps: maps from the unit square to a domain with a known density, with their exact inverses.
//!
//! Directions are unit vectors about z, and their densities are per steradian. For every warp and every u in [0, 1)²,
//! `pdf(map(u)) > 0` and `inverse(map(u))` is u up to rounding (save where the map itself is singular, as an azimuth
//! at the pole); the integral of `pdf` over the domain is 1.

mod hemisphere;
mod shapes;
#[cfg(test)]
mod tests;

use glam::{Vec2, Vec3};

use super::Lanes;
pub use hemisphere::{ConcentricCosineHemisphere, CosineHemisphere, PowerCosineHemisphere, UniformHemisphere};
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
}

/// A warp to directions that has a version in lanes, equal to [`Warp::map`] bit for bit.
pub trait WarpLanes: Warp<Point = Vec3> {
    /// The directions' x, y and z for the two coordinates of `u`, each in [0, 1).
    fn map_lanes<L: Lanes>(&self, u: [L; 2]) -> [L; 3];
}
