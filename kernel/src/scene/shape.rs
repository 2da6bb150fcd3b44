//! Custom geometry: primitives with boxes, and their test against a ray.
//!
//! A hit's `t` is clamped to the interval in which the ray is inside the primitive's own box (`geometry/own_box.rs`),
//! so that hits do not depend on the tree, however a shape rounds.

use crate::geometry::{Aabb, Hit, Ray, own_box};

/// A set of primitives with the caller's own ray test: spheres, height fields …
///
/// Results must depend on the arguments alone.
pub trait Shape: Sync {
    /// The number of primitives.
    fn count(&self) -> u32;

    /// The box around a primitive at all times; `prim_id` is less than [`count`](Self::count). A primitive whose box is
    /// empty is left out.
    fn bounds(&self, prim_id: u32) -> Aabb;

    /// The nearest hit of `ray` with a primitive within the ray's interval, at a time. The shape defines `u` and `v`;
    /// `prim_id` is ignored. A `t` outside of the primitive's box is clamped to it.
    fn intersect(&self, prim_id: u32, ray: &Ray, time: f32) -> Option<Hit>;
}

/// The hit of a ray with a primitive of a shape: the definition.
pub(super) fn intersect(shape: &dyn Shape, prim_id: u32, ray: &Ray, time: f32) -> Option<Hit> {
    let interval = own_box::interval(ray, &shape.bounds(prim_id))?;
    let hit = shape.intersect(prim_id, ray, time)?;
    own_box::clamped(ray, interval, Hit { prim_id, ..hit })
}
