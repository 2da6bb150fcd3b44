//! Clamping of hits to the box of a primitive other than a triangle.
//!
//! A hit's `t` is clamped to the interval in which the ray is inside the primitive's own box, widened by a bound of
//! rounding, as that of a triangle is (see [`geometry`](super)). So culling by boxes never loses a hit, and hits do not
//! depend on the tree, however a primitive rounds.

use super::setup::{MIN_COMPONENT, OWN_PAD, is_in_limits, raise};
use super::{Aabb, Hit, Ray};

/// A hit with a primitive in whose box the ray is in this [`interval`], clamped to that; `None` if it is then outside
/// of the ray's own.
#[inline(always)]
pub(crate) fn clamped(ray: &Ray, (near, far): (f32, f32), hit: Hit) -> Option<Hit> {
    // Adding zero makes a negative zero positive. A NaN fails every comparison.
    let t = hit.t.max(near).min(far) + 0.0;
    (!hit.t.is_nan() && ray.t_min <= t && t <= ray.t_max).then_some(Hit { t, ..hit })
}

/// Where `ray` is in `aabb`, widened by a bound of the rounding; `None` if nowhere, or if the ray is beyond the limits.
#[inline(always)]
pub(crate) fn interval(ray: &Ray, aabb: &Aabb) -> Option<(f32, f32)> {
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
        let inverse = 1.0 / raise(ray.direction[axis], largest * MIN_COMPONENT);
        let (a, b) = ((lower[axis] - pad) * inverse, (upper[axis] + pad) * inverse);
        near = near.max(a.min(b));
        far = far.min(a.max(b));
    }
    (near <= far).then_some((near, far))
}
