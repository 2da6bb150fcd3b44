//! Quads, as an example of a [`Shape`].

use glam::Vec3;

use super::Shape;
use crate::geometry::{Aabb, Hit, MAX_COORDINATE, Ray, intersect_triangle};

/// Quads by their four corners in order, each of two triangles that meet watertight along the diagonal from the second
/// corner to the fourth. `u` grows from the first corner to the second, and `v` to the fourth; on planar
/// parallelograms the hit is at `p0 + u (p1 - p0) + v (p3 - p0)`.
#[derive(Clone, Copy, Debug)]
pub struct Quads<'a>(pub &'a [[Vec3; 4]]);

impl Shape for Quads<'_> {
    fn count(&self) -> u32 {
        // More are refused, as no tree has room for so many.
        u32::try_from(self.0.len()).unwrap_or(u32::MAX)
    }

    fn bounds(&self, prim_id: u32) -> Aabb {
        let corners = &self.0[prim_id as usize];
        // The minimum of a NaN and a number is the number.
        let good = corners.iter().all(|p| p.abs().cmple(Vec3::splat(MAX_COORDINATE)).all());
        if good { Aabb::around(corners) } else { Aabb::EMPTY }
    }

    fn intersect(&self, prim_id: u32, ray: &Ray, _time: f32) -> Option<Hit> {
        let [a, b, c, d] = self.0[prim_id as usize];
        let first = intersect_triangle(ray, &[a, b, d]);
        let second = intersect_triangle(ray, &[c, d, b]).map(|hit| Hit { u: 1.0 - hit.u, v: 1.0 - hit.v, ..hit });
        match (first, second) {
            (Some(first), Some(second)) if second.t < first.t => Some(second),
            (first, second) => first.or(second),
        }
    }
}
