//! The items of a scene.

#[cfg(any(feature = "alloc", test))]
use alloc::sync::Arc;

use glam::{Affine3A, Vec3};

use super::image_box::MOVING_PAD;
use super::object::{Object, Target};
use super::transform::{Keys, Placement};
use crate::error::Error;
use crate::geometry::Aabb;
use crate::geometry::moment::Moment;

/// An object in a scene, with its transform and its mask.
#[derive(Clone)]
pub struct Item<'a> {
    pub(super) object: Object<'a>,
    pub(super) placement: Placement<'a>,
    pub(super) mask: u32,
    /// The paths through items before it in its scene.
    pub(super) first_path: u64,
}

/// A summary of an item for its scene; see the methods of the same names.
#[derive(Clone, Copy, Debug)]
pub(super) struct ItemSummary {
    pub reach: Aabb,
    pub error: Vec3,
    pub levels: usize,
    pub paths: u64,
    pub keys: usize,
    #[cfg(any(feature = "alloc", test))]
    pub count: u32,
}

impl ItemSummary {
    /// The summary of an item without an object.
    #[cfg(any(feature = "alloc", test))]
    pub(super) const NOTHING: Self =
        Self { reach: Aabb::EMPTY, error: Vec3::ZERO, levels: 0, paths: 0, keys: 1, count: 0 };
}

impl<'a> Item<'a> {
    /// An object without a transform, visible to all rays.
    pub fn new(object: impl Into<Object<'a>>) -> Self {
        Self { object: object.into(), placement: Placement::AsItIs, mask: u32::MAX, first_path: 0 }
    }

    /// An empty item: a free place in a scene.
    pub const fn nothing() -> Self {
        Self { object: Object::Nothing, placement: Placement::AsItIs, mask: 0, first_path: 0 }
    }

    /// The item with the transform `to_scene`. A transform that flattens them, such as a scale of zero, hides it.
    ///
    /// # Errors
    /// [`InvalidScene::NotFinite`](crate::InvalidScene::NotFinite), and
    /// [`InvalidScene::Singular`](crate::InvalidScene::Singular) if the transform is nearly singular: the product of
    /// the greatest row sums of it and of its inverse may be [`MAX_CONDITION`](super::MAX_CONDITION) at most.
    pub fn placed(self, to_scene: &Affine3A) -> Result<Self, Error> {
        Ok(Self { placement: Placement::still(to_scene)?, ..self })
    }

    /// The item with a transform at each of several times, evenly spaced over 0..=1; in between the elements are
    /// interpolated, so that points move in straight lines. A wheel needs about a key every eighth of a turn.
    ///
    /// # Errors
    /// The errors of [`placed`](Self::placed), at a key or between keys, as halfway through half a turn; and
    /// [`InvalidScene::NoKeys`](crate::InvalidScene::NoKeys).
    pub fn moving(self, keys: &'a [Affine3A]) -> Result<Self, Error> {
        Ok(Self { placement: Placement::moving(Keys::Borrowed(keys))?, ..self })
    }

    /// [`moving`](Self::moving) with transforms that the item owns.
    ///
    /// # Errors
    /// The errors of [`moving`](Self::moving).
    #[cfg(any(feature = "alloc", test))]
    pub fn moving_shared(self, keys: Arc<[Affine3A]>) -> Result<Self, Error> {
        Ok(Self { placement: Placement::moving(Keys::Shared(keys))?, ..self })
    }

    /// The item with a mask: rays see it whose mask has a bit in common. Zero hides it.
    #[must_use]
    pub fn with_mask(self, mask: u32) -> Self {
        Self { mask, ..self }
    }

    /// The item's object.
    pub fn object(&self) -> &Object<'a> {
        &self.object
    }

    /// The item's mask.
    pub fn mask(&self) -> u32 {
        self.mask
    }

    /// Whether its transform flattens it, so that no ray hits it.
    pub fn is_flat(&self) -> bool {
        matches!(self.placement, Placement::Flat { .. })
    }

    /// The transform from the object's space to that of the scene at a time (see [`SceneRay`](super::SceneRay)); `None`
    /// if that is NaN.
    pub fn to_scene(&self, time: f32) -> Option<Affine3A> {
        self.placement.to_scene(time)
    }

    /// The number of things that have boxes of their own in the scene's tree.
    pub(super) fn count(&self) -> u32 {
        match &self.object {
            Object::Nothing => 0,
            Object::Shape(shape) => shape.count(),
            #[cfg(any(feature = "alloc", test))]
            Object::SharedShape(shape) => shape.count(),
            _ => 1,
        }
    }

    /// The number of keys between which boxes move in straight lines.
    pub(super) fn keys(&self) -> usize {
        match (self.placement.keys(), self.object.target()) {
            (1, Target::Moving(tree)) => tree.keys(),
            (keys, _) => keys,
        }
    }

    /// The box of a part at a key, of which there are [`keys`](Self::keys).
    pub(super) fn aabb_at_key(&self, part: u32, key: usize) -> Aabb {
        let (local, key) = match self.object.target() {
            Target::Nothing => return Aabb::EMPTY,
            Target::Mesh(tree) => return self.placement.mesh_aabb(key, &tree),
            Target::Moving(tree) if self.placement.keys() == 1 && tree.keys() > 1 => {
                // The scene's own fraction of time is rounded otherwise than the tree's.
                return self.placement.aabb(0, &widened(&tree.at_key(key).bounds(), &tree.bounds()));
            }
            Target::Moving(tree) => (tree.bounds(), key),
            Target::Round(tree) => (tree.bounds(), key),
            Target::Shape(shape) => (shape.bounds(part), key),
            Target::Scene(scene) => (scene.bounds(), key),
        };
        self.placement.aabb(key, &local)
    }
}

impl Item<'_> {
    /// The box of a part at one of a scene's `keys`. Between two of them, the interpolated box encloses the part.
    pub(super) fn aabb(&self, part: u32, key: usize, keys: usize) -> Aabb {
        let (own, all) = (self.keys() - 1, keys - 1);
        if own == 0 {
            return self.aabb_at_key(part, 0);
        }
        if !all.is_multiple_of(own) {
            // Its own keys lie between those of the scene: everywhere it gets.
            return (0..=own).fold(Aabb::EMPTY, |sum, key| sum.union(&self.aabb_at_key(part, key)));
        }
        let (before, rest) = (key * own / all, key * own % all);
        let from = self.aabb_at_key(part, before);
        if rest == 0 {
            return from;
        }
        Moment { key: before, fraction: rest as f32 / all as f32 }.aabb(&from, &self.aabb_at_key(part, before + 1))
    }

    /// The box that a ray's reach has to span for this item.
    fn reach(&self) -> Aabb {
        match self.object.target() {
            Target::Nothing => Aabb::EMPTY,
            Target::Mesh(tree) => self.placement.reach(&tree.bounds()),
            Target::Moving(tree) => self.placement.reach(&tree.bounds()),
            Target::Round(tree) => self.placement.reach(&tree.bounds()),
            Target::Shape(shape) => {
                let boxes = (0..shape.count()).map(|part| shape.bounds(part)).filter(Aabb::is_usable);
                self.placement.reach(&boxes.fold(Aabb::EMPTY, |sum, aabb| sum.union(&aabb)))
            }
            Target::Scene(scene) => self.placement.reach(&scene.reach()),
        }
    }

    /// The item's summary for its scene.
    pub(super) fn summary(&self) -> ItemSummary {
        ItemSummary {
            reach: self.reach(),
            error: self.error(),
            levels: self.levels(),
            paths: self.paths(),
            keys: self.keys(),
            #[cfg(any(feature = "alloc", test))]
            count: self.count(),
        }
    }

    /// How far hits may be off the item's box, in units of a ray's reach.
    pub(super) fn error(&self) -> Vec3 {
        self.placement.error(match self.object.target() {
            Target::Scene(scene) => scene.error().max_element(),
            _ => 0.0,
        })
    }

    /// The number of paths through the item.
    fn paths(&self) -> u64 {
        match self.object.target() {
            Target::Scene(scene) => scene.paths(),
            _ => 0,
        }
    }

    /// The depth of nested scenes from here on.
    fn levels(&self) -> usize {
        match self.object.target() {
            Target::Scene(scene) => 1 + scene.levels(),
            _ => 0,
        }
    }
}

/// A box around an object that moves within `everywhere`, widened for rounding.
fn widened(aabb: &Aabb, everywhere: &Aabb) -> Aabb {
    let largest = everywhere.min.abs().max(everywhere.max.abs()).max_element();
    let pad = largest * MOVING_PAD as f32;
    if aabb.is_empty() { *aabb } else { Aabb { min: aabb.min - pad, max: aabb.max + pad } }
}
