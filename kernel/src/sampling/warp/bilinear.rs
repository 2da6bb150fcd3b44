//! Points of the unit square whose density follows four weights at its corners.
//!
//! The weights are interpolated: `q(x, y) = (w₀₀ (1-x)(1-y) + w₁₀ x (1-y) + w₀₁ (1-x) y + w₁₁ x y) / mean`. Along each
//! axis that is a line from `a` to `b`, whose distribution is inverted by the root of a quadratic equation in the form
//! that does not cancel (Pharr, Jakob and Humphreys, "Physically Based Rendering", A.5).

use glam::Vec2;

use super::Warp;
use crate::sampling::{ONE_MINUS_EPSILON, into_unit, sqrt};

/// Points of the unit square, by the weights of its corners (0, 0), (1, 0), (0, 1) and (1, 1): all positive,
/// and neither so large nor so small that their squares are no numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bilinear {
    /// The weights, in the order above.
    pub weights: [f32; 4],
}

impl Bilinear {
    /// The weights at both ends of the line across the square at height `y`.
    #[inline(always)]
    fn across(&self, y: f32) -> (f32, f32) {
        let [w00, w10, w01, w11] = self.weights;
        (w00 + (w01 - w00) * y, w10 + (w11 - w10) * y)
    }

    /// The weights of all such lines at the bottom and at the top, twice.
    #[inline(always)]
    fn upwards(&self) -> (f32, f32) {
        let [w00, w10, w01, w11] = self.weights;
        (w00 + w10, w01 + w11)
    }

    /// The density of [`map`](Warp::map) at a point of the square, by area.
    #[inline(always)]
    pub fn density(&self, point: Vec2) -> f32 {
        let (a, b) = self.across(point.y);
        let (bottom, top) = self.upwards();
        4.0 * (a + (b - a) * point.x) / (bottom + top)
    }

    /// The reciprocal of the [`density`](Self::density), up to rounding.
    #[inline(always)]
    pub fn per_density(&self, point: Vec2) -> f32 {
        let (a, b) = self.across(point.y);
        let (bottom, top) = self.upwards();
        (bottom + top) / (4.0 * (a + (b - a) * point.x))
    }
}

impl Warp for Bilinear {
    type Point = Vec2;

    #[inline(always)]
    fn map(&self, u: Vec2) -> Vec2 {
        let y = along(self.upwards(), u.y);
        Vec2::new(along(self.across(y), u.x), y)
    }

    #[inline]
    fn pdf(&self, point: Vec2) -> f32 {
        let is_inside = point.cmpge(Vec2::ZERO).all() && point.cmple(Vec2::ONE).all();
        if is_inside { self.density(point) } else { 0.0 }
    }

    fn inverse(&self, point: Vec2) -> Vec2 {
        Vec2::new(below(self.across(point.y), point.x), below(self.upwards(), point.y))
    }
}

/// The point of [0, 1) below which the part `u` of the line's weight lies.
#[inline(always)]
fn along((a, b): (f32, f32), u: f32) -> f32 {
    (u * (a + b) / (a + sqrt(a * a + (b * b - a * a) * u))).min(ONE_MINUS_EPSILON)
}

/// The part of the line's weight that lies below `x`.
fn below((a, b): (f32, f32), x: f32) -> f32 {
    into_unit(x * (a + a + (b - a) * x) / (a + b))
}
