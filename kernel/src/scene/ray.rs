//! Rays and hits in scenes.

use bytemuck::{Pod, Zeroable};

use crate::geometry::{Hit, Ray};

/// A ray with what a scene asks of it besides.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct SceneRay {
    /// The ray.
    pub ray: Ray,
    /// When: in 0..=1, over which keys are spread; less counts as 0 and more as 1. With a NaN it hits nothing.
    pub time: f32,
    /// What it sees: items whose mask has a bit in common with it, at every level.
    pub mask: u32,
}

/// Where a ray meets something in a scene.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct SceneHit {
    /// Where, and which part of the geometry. `t` is the same in all spaces, as the direction is not normalised.
    pub hit: Hit,
    /// The item that has the geometry: its index in the scene that has the item.
    pub geometry_id: u32,
    /// How many items that are scenes the ray went through on its way there; 0 in the outermost scene itself.
    pub depth: u32,
    /// The number of that way among all in the scene; [`SceneView::instances`](super::SceneView::instances) lists the items.
    pub path: u64,
}

impl SceneRay {
    /// At time 0, seeing all.
    #[inline]
    pub fn new(ray: Ray) -> Self {
        Self { ray, time: 0.0, mask: u32::MAX }
    }

    /// The same ray at another time.
    #[inline]
    #[must_use]
    pub fn at_time(self, time: f32) -> Self {
        Self { time, ..self }
    }

    /// The same ray with another mask.
    #[inline]
    #[must_use]
    pub fn with_mask(self, mask: u32) -> Self {
        Self { mask, ..self }
    }
}

impl From<Ray> for SceneRay {
    fn from(ray: Ray) -> Self {
        Self::new(ray)
    }
}

impl SceneHit {
    /// What batches write for a ray that hits nothing.
    pub const MISS: Self = Self { hit: Hit::MISS, geometry_id: u32::MAX, depth: 0, path: u64::MAX };

    /// Whether something was hit.
    #[inline]
    pub fn is_hit(&self) -> bool {
        self.hit.is_hit()
    }

    /// Whether this hit is nearer than `other`, or as near and before it: by geometry, then by part, then by path.
    #[inline]
    pub(super) fn precedes(&self, other: &Self) -> bool {
        let order = |hit: &Self| (hit.geometry_id, hit.hit.prim_id, hit.path);
        self.hit.t < other.hit.t || self.hit.t == other.hit.t && order(self) < order(other)
    }
}
