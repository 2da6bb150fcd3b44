//! Where a ray may start that leaves a surface, so that it does not hit the very triangle it leaves.
//!
//! Ize 2013, "Robust BVH Ray Traversal", and Pharr, Jakob and Humphreys, "Physically Based Rendering", 6.8, move the
//! origin along the normal by a bound of its rounding error instead of by a length that somebody guessed for the scene.
//! The bound here is of the triangle's own size and place, which covers the hit point's error and the triangle test's.

use glam::{DVec3, Vec3};

use super::Triangle;

/// In units of the largest coordinate: 16 roundings, where the hit point and the test together make fewer.
const ERROR: f32 = 16.0 / (1u32 << 24) as f32;

/// The unit normal of the side from which the corners of `triangle` run counter-clockwise; zero if it has no area. In
/// `f64`, as the edges of a needle cancel.
pub fn triangle_normal(triangle: &Triangle) -> Vec3 {
    let [a, b, c]: [DVec3; 3] = triangle.map(|p| p.as_dvec3());
    (b - a).cross(c - a).normalize_or_zero().as_vec3()
}

/// The point of `triangle` with the barycentric weights `u` and `v` of a hit, moved along its unit `normal`, to the side
/// to which `direction` points. It scales with the scene: there is no length to tune.
#[inline]
pub fn offset_origin(triangle: &Triangle, normal: Vec3, u: f32, v: f32, direction: Vec3) -> Vec3 {
    let [a, b, c] = *triangle;
    let point = (1.0 - u - v) * a + u * b + v * c;
    let largest = a.abs().max(b.abs()).max(c.abs()).max_element();
    let distance = largest * ERROR * (normal.x.abs() + normal.y.abs() + normal.z.abs());
    let offset = if normal.dot(direction) < 0.0 { -normal } else { normal } * distance;
    let moved = point + offset;
    // The sum may have been rounded back: go one step further, away from the plane.
    Vec3::new(step(moved.x, offset.x), step(moved.y, offset.y), step(moved.z, offset.z))
}

/// The next float after `x` in the direction of `sign`; `x` if that is zero.
#[inline]
fn step(x: f32, sign: f32) -> f32 {
    if sign > 0.0 {
        x.next_up()
    } else if sign < 0.0 {
        x.next_down()
    } else {
        x
    }
}
