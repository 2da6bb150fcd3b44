//! The widening of boxes in a scene's tree, so that no hit is lost at the box of an item.
//!
//! A hit with item `i` is off the item's box, along each axis, by at most `e_i ρ`: `e_i` is the item's
//! [error](super::transform) and `ρ` the ray's reach, the greatest distance along an axis from its origin to anything
//! that the scene's reach spans. `ρ` depends on the ray, so it is not known when the tree is built. If each ray widened
//! all boxes by the greatest `e_i`, one strongly distorted item would make all rays visit most of the scene. So there
//! are two kinds of items:
//!
//! - Ordinary ones have an error of at most a limit. Their boxes are in the tree unchanged. `E` is the greatest of
//!   their errors.
//! - The boxes of distorted ones are in the tree widened by `e_i N`, where the near reach `N` is
//!   [twice](MAX_WIDENED_REACH) the extent of what the scene's reach spans. `F` is the greatest of their errors.
//!
//! and a ray widens all boxes, those of inner nodes too, by `max(E ρ, F (ρ - N))`. That is enough for every item and
//! every ray: for an ordinary one `e_i ρ <= E ρ`, and for a distorted one `e_i ρ = e_i N + e_i (ρ - N) <= e_i N + F
//! (ρ - N)` if `ρ > N`, and `e_i ρ <= e_i N` if not. An origin in what the reach spans has `ρ <= N / 2`, and one that
//! is as far out as that is large has `ρ <= N`: such rays are affected by the boxes of distorted items only.
//!
//! The limit does not affect correctness: it is the least power of two, from [`ORDINARY`] on, that
//! [few](may_be_distorted) items exceed. Where many are distorted, it is better that rays widen boxes by what they need
//! than that boxes are widened for all rays.
//!
//! Rounding: the module [`transform`](super::transform) says that 26 of the 32 units in its `e_i` are needed. The rest,
//! `3 u` of each `u` and more of the whole, has room for a few roundings here, for those of the distances to planes
//! that lie farther out by `e_i N`, and for those of boxes between keys, each of which is widened by the same.
//!
//! Where anything reaches out so far that a widened box might be beyond the [numeric limits](crate#numeric-limits), no
//! box in the tree is widened, and rays widen all of them by `ρ` times the greatest error of all items.

use core::ops::Range;

use glam::Vec3;

use crate::geometry::{Aabb, MAX_COORDINATE};

/// The least error of a distorted item, in units of a ray's reach: that of a stretch by about 120. Widening all boxes
/// by this much costs a ray little.
const ORDINARY: f32 = 1.0 / 4096.0;

/// Limits that there may be, each twice the one before; the last is that of [all](super::transform::MAX_ERROR).
const LIMITS: usize = 11;

/// How many of `count` items may be distorted.
fn may_be_distorted(items: usize) -> usize {
    (items / 16).max(16)
}

/// Up to what reach of rays widened boxes are enough, in extents of what the reach spans.
const MAX_WIDENED_REACH: f32 = 2.0;

/// The errors of the items of a scene: how many there are up to each limit, above that before it, and the greatest of
/// them.
#[derive(Clone, Copy)]
pub(super) struct Errors([(usize, Vec3); LIMITS]);

impl Errors {
    pub(super) const NONE: Self = Self([(0, Vec3::ZERO); LIMITS]);

    /// Adds an item's error.
    pub(super) fn add(&mut self, error: Vec3) {
        let size = error.max_element();
        let mut limits = self.0.iter_mut().enumerate();
        // The last takes what is left.
        if let Some((_, (count, greatest))) = limits.find(|(i, _)| size <= limit(*i) || *i + 1 == LIMITS) {
            *count += 1;
            *greatest = greatest.max(error);
        }
    }

    fn greatest(&self, limits: Range<usize>) -> Vec3 {
        self.0[limits].iter().fold(Vec3::ZERO, |greatest, (_, error)| greatest.max(*error))
    }
}

/// How boxes are widened, in the tree and by rays.
#[derive(Clone, Copy, Debug)]
pub(super) struct Widening {
    /// `E`, the greatest error of ordinary items.
    pub ordinary: Vec3,
    /// `F`, the greatest error of distorted items.
    pub distorted: Vec3,
    /// `N`. Where it is zero, all boxes are in the tree unchanged.
    pub near: f32,
    /// The greatest error of an ordinary item along any axis.
    limit: f32,
}

impl Widening {
    /// The widening of an empty scene.
    pub(super) const NONE: Self = Self { ordinary: Vec3::ZERO, distorted: Vec3::ZERO, near: 0.0, limit: f32::INFINITY };

    /// The widening of a scene whose items have these errors and this reach.
    pub(super) fn of(errors: &Errors, reach: &Aabb) -> Self {
        let may_be = may_be_distorted(errors.0.iter().map(|(count, _)| count).sum());
        // From the end, as long as not too many are distorted.
        let (mut last, mut count) = (LIMITS - 1, 0);
        while last > 0 && count + errors.0[last].0 <= may_be {
            count += errors.0[last].0;
            last -= 1;
        }
        let (ordinary, distorted) = (errors.greatest(0..last + 1), errors.greatest(last + 1..LIMITS));
        let near = MAX_WIDENED_REACH * (reach.max - reach.min).max_element();
        let farthest = reach.min.abs().max(reach.max.abs()).max_element();
        // False for infinity and NaN.
        let has_room = near <= MAX_COORDINATE / 4.0 && farthest <= MAX_COORDINATE / 4.0;
        let widening = Self { ordinary, distorted, near, limit: limit(last) };
        if distorted == Vec3::ZERO || !has_room { widening.by_rays() } else { widening }
    }

    /// The widening for a tree whose boxes are all unchanged.
    pub(super) fn by_rays(self) -> Self {
        Self { ordinary: self.greatest(), distorted: self.greatest(), near: 0.0, limit: f32::INFINITY }
    }

    /// The greatest error of all items.
    pub(super) fn greatest(&self) -> Vec3 {
        self.ordinary.max(self.distorted)
    }

    /// Whether all boxes are in the tree unchanged.
    pub(super) fn is_by_rays(&self) -> bool {
        self.near == 0.0
    }

    /// The box in the tree for a box in an item with this error.
    pub(super) fn in_tree(&self, aabb: Aabb, error: Vec3) -> Aabb {
        // Boxes that cannot be hit stay empty.
        if self.is_by_rays() || error.max_element() <= self.limit || !aabb.is_usable() {
            return aabb;
        }
        let pad = error * self.near;
        let (min, max) = ((aabb.min - pad).to_array(), (aabb.max + pad).to_array());
        Aabb { min: Vec3::from_array(min.map(f32::next_down)), max: Vec3::from_array(max.map(f32::next_up)) }
    }

    /// The amount by which a ray of this reach widens all boxes of the tree.
    #[inline(always)]
    pub(super) fn of_ray(&self, reach: f32) -> Vec3 {
        (self.ordinary * reach).max(self.distorted * (reach - self.near))
    }
}

/// The limit of this index.
fn limit(index: usize) -> f32 {
    ORDINARY * (1u32 << index) as f32
}
