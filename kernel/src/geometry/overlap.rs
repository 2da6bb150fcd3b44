//! Whether a triangle and a box have a point in common, by separating axes: Akenine-Möller 2001, "Fast 3D Triangle-Box
//! Overlap Testing".
//!
//! The box's three axes are decided exactly. The triangle's plane and the nine products of edges and axes are computed
//! in `f64`, and separate only if they do so by more than a bound of the rounding: so the test is conservative. It
//! never misses an overlap, touching included; a reported overlap may have a gap of 2⁻⁴⁸ of the coordinates' size along
//! such an axis, which is below the resolution of `f32`.

use glam::DVec3;

use super::{Aabb, Triangle};

/// A bound of the rounding of all operations on an axis, with room to spare.
const ERROR: f64 = 1.0 / (1u64 << 48) as f64;

/// Whether `triangle` and `aabb`, edges and faces included, have a point in common. An empty box, or one with a NaN,
/// has none.
pub fn overlaps(triangle: &Triangle, aabb: &Aabb) -> bool {
    let around = Aabb::around(triangle);
    if aabb.is_empty() || !around.min.cmple(aabb.max).all() || !aabb.min.cmple(around.max).all() {
        return false;
    }
    // What is beyond the triangle's own box is of no consequence, even if the box has no end there.
    let (min, max) = (aabb.min.max(around.min).as_dvec3(), aabb.max.min(around.max).as_dvec3());
    let (center, half) = (0.5 * (min + max), 0.5 * (max - min));
    let corners = triangle.map(|p| p.as_dvec3() - center);
    let size = corners.iter().fold(half, |size, p| size.max(p.abs())).max_element();
    // Whether the corners' projections onto an axis, with errors up to `error`, are all beyond the box's.
    let separates = |axis: DVec3, error: f64| {
        let [a, b, c] = corners.map(|p| axis.dot(p));
        let reach = axis.abs().dot(half) + error * size * ERROR;
        a.min(b).min(c) > reach || a.max(b).max(c) < -reach
    };
    let [a, b, c] = corners;
    let edges = [b - a, c - b, a - c];
    let normal = edges[0].cross(edges[1]);
    let ([e, f], [x, y, z]) = ([edges[0].abs(), edges[1].abs()], [0, 1, 2]);
    let terms = e[y] * f[z] + e[z] * f[y] + e[z] * f[x] + e[x] * f[z] + e[x] * f[y] + e[y] * f[x];
    if separates(normal, terms) {
        return false;
    }
    for edge in edges {
        for axis in [DVec3::X, DVec3::Y, DVec3::Z] {
            if separates(axis.cross(edge), edge.abs().element_sum()) {
                return false;
            }
        }
    }
    true
}
