//! One ray and one hit.

use core::hint::select_unpredictable;

use bytemuck::{Pod, Zeroable};
use glam::Vec3;

/// The points `origin + t * direction` for `t_min <= t <= t_max`.
///
/// The direction need not have unit length; `t` is in units of its length. A ray that is out of the kernel's [numeric
/// limits](crate#numeric-limits), has a NaN, or has `t_min > t_max` hits nothing.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct Ray {
    /// Where `t` is zero.
    pub origin: Vec3,
    /// The least accepted `t`, inclusive; negative values reach behind the origin.
    pub t_min: f32,
    /// The direction, of any length within the limits.
    pub direction: Vec3,
    /// The greatest accepted `t`, inclusive; may be infinite.
    pub t_max: f32,
}

/// Where a ray meets a triangle: at `origin + t * direction`, which is `(1 - u - v) v0 + u v1 + v v2`.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct Hit {
    /// Distance in units of the direction's length.
    pub t: f32,
    /// Barycentric weight of the triangle's second corner, 0..=1.
    pub u: f32,
    /// Barycentric weight of the triangle's third corner, 0..=1.
    pub v: f32,
    /// The triangle's index in the slice that the tree was built from; [`Hit::NO_PRIM`] if nothing was hit.
    pub prim_id: u32,
}

impl Ray {
    /// A ray from `origin` with `t` in 0..=∞.
    #[inline]
    pub fn new(origin: Vec3, direction: Vec3) -> Self {
        Self { origin, t_min: 0.0, direction, t_max: f32::INFINITY }
    }

    /// A ray from `origin` to `target`, with `t` in 0..=1, ends included: a surface through either end is hit.
    #[inline]
    pub fn between(origin: Vec3, target: Vec3) -> Self {
        Self { origin, t_min: 0.0, direction: target - origin, t_max: 1.0 }
    }

    /// The point at `t`.
    #[inline]
    pub fn at(&self, t: f32) -> Vec3 {
        self.origin + t * self.direction
    }
}

impl Hit {
    /// The `prim_id` of a miss.
    pub const NO_PRIM: u32 = u32::MAX;

    /// What batches and packets write for a ray that hits nothing.
    pub const MISS: Self = Self { t: f32::INFINITY, u: 0.0, v: 0.0, prim_id: Self::NO_PRIM };

    /// Whether something was hit.
    #[inline]
    pub fn is_hit(&self) -> bool {
        self.prim_id != Self::NO_PRIM
    }

    /// Whether this hit is nearer than `other`, or as near on a triangle that comes first.
    #[inline(always)]
    pub(crate) fn precedes(&self, other: &Self) -> bool {
        self.t < other.t || self.t == other.t && self.prim_id < other.prim_id
    }

    /// The initial hit of a search: any hit up to `t_max` precedes it.
    #[inline(always)]
    pub(crate) fn none_before(t_max: f32) -> Self {
        Self { t: t_max, ..Self::MISS }
    }

    /// A hit that stands for any hit, or a miss.
    #[inline(always)]
    pub(crate) fn any_if(is_hit: bool) -> Self {
        Self { prim_id: if is_hit { 0 } else { Self::NO_PRIM }, ..Self::MISS }
    }

    /// The result of a search, or a miss: without a branch, which would be unpredictable.
    #[inline(always)]
    pub(crate) fn or_miss(self) -> Self {
        Self { t: select_unpredictable(self.is_hit(), self.t, Self::MISS.t), ..self }
    }

    /// The result of a search.
    #[inline(always)]
    pub(crate) fn found(self) -> Option<Self> {
        self.is_hit().then_some(self)
    }
}
