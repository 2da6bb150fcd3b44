//! Rays, hits and closest points in scenes.

use bytemuck::{Pod, Zeroable};

use crate::geometry::{Hit, Ray, SurfacePoint};

/// A ray in a scene, with its time and mask.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct SceneRay {
    /// The ray.
    pub ray: Ray,
    /// The time in 0..=1, over which keys are spread; other times are clamped. With NaN the ray hits nothing.
    pub time: f32,
    /// The ray's mask: it sees items whose mask has a bit in common with it, at every level.
    pub mask: u32,
}

/// A hit of a ray in a scene.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct SceneHit {
    /// The hit in the item's geometry. `t` is the same in all spaces, as the direction is not normalised.
    pub hit: Hit,
    /// The index of the item with the geometry, in the scene that has the item.
    pub item: u32,
    /// The number of nested scenes around the item; 0 in the outermost scene itself.
    pub depth: u32,
    /// The index of the path to it among all paths of the scene; [`SceneView::instances`](super::SceneView::instances)
    /// lists its items.
    pub path: u64,
}

/// A point on a surface of a scene that is closest to another point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ScenePoint {
    /// The point and its distance in the scene's space, and where it is on its triangle.
    pub point: SurfacePoint,
    /// The index of the item with the triangle, in the scene that has the item.
    pub item: u32,
    /// The number of nested scenes around the item, as in [`SceneHit`].
    pub depth: u32,
    /// The index of the path to the item, as in [`SceneHit`].
    pub path: u64,
}

impl SceneRay {
    /// A ray at time 0 that sees all items.
    #[inline]
    pub fn new(ray: Ray) -> Self {
        Self { ray, time: 0.0, mask: u32::MAX }
    }

    /// The ray at another time.
    #[inline]
    #[must_use]
    pub fn at_time(self, time: f32) -> Self {
        Self { time, ..self }
    }

    /// The ray with another mask.
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
    pub const MISS: Self = Self { hit: Hit::MISS, item: u32::MAX, depth: 0, path: u64::MAX };

    /// Whether something was hit.
    #[inline]
    pub fn is_hit(&self) -> bool {
        self.hit.is_hit()
    }

    /// Whether this hit is nearer than `other`, or as near and before it: by geometry, then by part, then by path.
    #[inline]
    pub(super) fn precedes(&self, other: &Self) -> bool {
        let order = |hit: &Self| (hit.item, hit.hit.prim_id, hit.path);
        self.hit.t < other.hit.t || self.hit.t == other.hit.t && order(self) < order(other)
    }
}

impl ScenePoint {
    /// The point as a hit, whose `t` is the distance: for [`SceneView::instances`](super::SceneView::instances) and
    /// [`SceneView::to_scene`](super::SceneView::to_scene).
    pub fn to_hit(&self) -> SceneHit {
        SceneHit { hit: self.point.to_hit(), item: self.item, depth: self.depth, path: self.path }
    }
}
