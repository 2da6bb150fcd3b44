//! Hits of rays in the world.

use halfdome_kernel as kernel;

/// A kernel's hit, and which instance it lies in.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Hit {
    /// Distance along the ray, in units of its direction's length.
    pub t: f32,
    /// Weight of the second corner.
    pub u: f32,
    /// Weight of the third corner.
    pub v: f32,
    /// The triangle: an index into [`World::triangle_records`](super::World::triangle_records).
    pub prim_id: u32,
    /// Where that is: an index into the world's instance records, of which 0 is the world itself.
    pub instance: u32,
    /// When: from 0, where the shutter opens, to 1, where it closes.
    pub time: f32,
}

/// The middle of the time that the shutter is open, as which rays see the world that have no time.
pub(crate) const MIDDLE: f32 = 0.5;

/// The time of a ray, if there are times.
#[inline(always)]
pub(crate) fn time_of(times: &[f32], ray: usize) -> f32 {
    times.get(ray).copied().unwrap_or(MIDDLE)
}

impl Hit {
    /// The `prim_id` of no triangle.
    pub(crate) const NO_PRIM: u32 = kernel::Hit::NO_PRIM;
    /// No hit.
    pub(crate) const MISS: Self = Self::of(&kernel::Hit::MISS);

    /// A hit of the tree of all triangles that are in world space.
    #[inline(always)]
    pub(crate) const fn of(hit: &kernel::Hit) -> Self {
        let kernel::Hit { t, u, v, prim_id } = *hit;
        Self { t, u, v, prim_id, instance: 0, time: MIDDLE }
    }

    /// Whether something was hit.
    #[inline(always)]
    pub(crate) fn is_hit(&self) -> bool {
        self.prim_id != Self::NO_PRIM
    }
}
