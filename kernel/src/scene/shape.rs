//! Geometry of the caller's: boxes, and what decides whether a ray hits what is in them.
//!
//! A hit's `t` is clamped to the interval in which the ray is inside the shape's own box, widened by a bound of rounding, as
//! that of a triangle is (see [`geometry`](crate::geometry)). So boxes cull nothing that counts, and what is hit does not
//! depend on the tree, however a shape rounds.

use crate::geometry::setup::{LEAST_COMPONENT, OWN_PAD, is_in_limits, raise};
use crate::geometry::{Aabb, Hit, Ray};

/// A set of primitives that the caller knows how to hit: spheres, curves, height fields …
///
/// Answers depend on the arguments alone.
pub trait Shape: Sync {
    /// The number of primitives.
    fn count(&self) -> u32;

    /// The box around a primitive at all times; `prim_id` is less than [`count`](Self::count). A primitive whose box is
    /// empty is left out.
    fn bounds(&self, prim_id: u32) -> Aabb;

    /// The nearest hit of `ray` with a primitive within the ray's interval, at a time. What its `u` and `v` mean is up to the
    /// shape; its `prim_id` is not looked at. A `t` outside of the primitive's box is moved to where the ray leaves it.
    fn intersect(&self, prim_id: u32, ray: &Ray, time: f32) -> Option<Hit>;
}

/// The hit of a ray with a primitive of a shape: the definition.
pub(super) fn intersect(shape: &dyn Shape, prim_id: u32, ray: &Ray, time: f32) -> Option<Hit> {
    let (near, far) = interval(ray, &shape.bounds(prim_id))?;
    let hit = shape.intersect(prim_id, ray, time)?;
    // Adding zero makes a negative zero positive. A NaN fails every comparison.
    let t = hit.t.max(near).min(far) + 0.0;
    (!hit.t.is_nan() && ray.t_min <= t && t <= ray.t_max).then_some(Hit { t, prim_id, ..hit })
}

/// Where `ray` is in `aabb`, widened by a bound of the rounding; `None` if nowhere, or if the ray is beyond the limits.
fn interval(ray: &Ray, aabb: &Aabb) -> Option<(f32, f32)> {
    if aabb.is_empty() || !is_in_limits(ray) {
        return None;
    }
    let size = ray.direction.abs();
    let largest = size.max_element();
    let main = (0..3).find(|&axis| size[axis] == largest)?;
    let (lower, upper) = (aabb.min - ray.origin, aabb.max - ray.origin);
    let reach = lower.abs().max(upper.abs());
    let (mut near, mut far) = (f32::NEG_INFINITY, f32::INFINITY);
    for axis in 0..3 {
        let pad = (reach[axis] + reach[main]) * OWN_PAD;
        let inverse = 1.0 / raise(ray.direction[axis], largest * LEAST_COMPONENT);
        let (a, b) = ((lower[axis] - pad) * inverse, (upper[axis] + pad) * inverse);
        near = near.max(a.min(b));
        far = far.min(a.max(b));
    }
    (near <= far).then_some((near, far))
}
