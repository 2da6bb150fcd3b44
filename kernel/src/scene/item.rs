//! What a scene is made of.

use glam::{Affine3A, Vec3};

use super::SceneView;
use super::shape::Shape;
use super::transform::{MOVING_PAD, Placement};
use crate::bvh::{BvhView, MovingView};
use crate::error::Error;
use crate::geometry::moment::Moment;
use crate::geometry::{Aabb, MAX_COORDINATE};

/// What an item is. Memory is borrowed, so that many items may share it.
#[derive(Clone, Copy)]
#[non_exhaustive]
pub enum Object<'a> {
    /// Triangles.
    Mesh(BvhView<'a>),
    /// Triangles that move by themselves.
    Moving(MovingView<'a>),
    /// Geometry of the caller's.
    Shape(&'a dyn Shape),
    /// A scene.
    Scene(&'a SceneView<'a>),
}

/// An object in a scene: where it is, and who sees it.
#[derive(Clone, Copy)]
pub struct Item<'a> {
    pub(super) object: Object<'a>,
    pub(super) placement: Placement<'a>,
    pub(super) mask: u32,
    /// The paths through items before it in its scene.
    pub(super) first_path: u64,
}

impl<'a> Item<'a> {
    /// An object where its own coordinates say, for all rays to see.
    pub fn new(object: impl Into<Object<'a>>) -> Self {
        Self { object: object.into(), placement: Placement::AsItIs, mask: u32::MAX, first_path: 0 }
    }

    /// The item where `to_scene` takes its points.
    ///
    /// # Errors
    /// [`InvalidScene::NotFinite`](crate::InvalidScene::NotFinite), and
    /// [`InvalidScene::Singular`](crate::InvalidScene::Singular) if there is no inverse that is worth its name: the greatest row
    /// sums of it and of the matrix may have a product of [`MAX_CONDITION`](super::MAX_CONDITION).
    pub fn placed(self, to_scene: &Affine3A) -> Result<Self, Error> {
        Ok(Self { placement: Placement::still(to_scene)?, ..self })
    }

    /// The item where transforms take its points, each at its time; times are evenly spaced over 0..=1, and in between the
    /// elements are interpolated, so that points move in straight lines. Wheels want a key every eighth of a turn or so.
    ///
    /// # Errors
    /// Those of [`placed`](Self::placed), at a key or between, as halfway through half a turn; and
    /// [`InvalidScene::NoKeys`](crate::InvalidScene::NoKeys).
    pub fn moving(self, keys: &'a [Affine3A]) -> Result<Self, Error> {
        Ok(Self { placement: Placement::moving(keys)?, ..self })
    }

    /// The item with a mask: rays see it whose mask has a bit in common. Zero hides it.
    #[must_use]
    pub fn with_mask(self, mask: u32) -> Self {
        Self { mask, ..self }
    }

    /// What it is.
    pub fn object(&self) -> Object<'a> {
        self.object
    }

    /// The transform from the object's space to that of the scene at a time (see [`SceneRay`](super::SceneRay)); `None`
    /// if that is NaN.
    pub fn to_scene(&self, time: f32) -> Option<Affine3A> {
        self.placement.to_scene(time)
    }

    /// The number of things that have boxes of their own in the scene's tree.
    pub(super) fn count(&self) -> u32 {
        match self.object {
            Object::Shape(shape) => shape.count(),
            _ => 1,
        }
    }

    /// The number of keys between which boxes move in straight lines.
    pub(super) fn keys(&self) -> usize {
        match (self.placement.keys(), self.object) {
            (1, Object::Moving(tree)) => tree.keys(),
            (keys, _) => keys,
        }
    }

    /// The box of a part at a key, of which there are [`keys`](Self::keys).
    pub(super) fn aabb_at_key(&self, part: u32, key: usize) -> Aabb {
        let (local, key) = match self.object {
            Object::Mesh(tree) => (tree.bounds(), key),
            Object::Moving(tree) if self.placement.keys() == 1 && tree.keys() > 1 => {
                // The scene's own fraction of time is rounded otherwise than the tree's.
                return self.placement.aabb(0, &widened(&tree.at_key(key).bounds(), &tree.bounds()));
            }
            Object::Moving(tree) => (tree.bounds(), key),
            Object::Shape(shape) => (shape.bounds(part), key),
            Object::Scene(scene) => (scene.bounds(), key),
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

    /// What a ray's reach has to span for this item.
    pub(super) fn reach(&self) -> Aabb {
        match self.object {
            Object::Mesh(tree) => self.placement.reach(&tree.bounds()),
            Object::Moving(tree) => self.placement.reach(&tree.bounds()),
            Object::Shape(shape) => {
                let boxes = (0..shape.count()).map(|part| shape.bounds(part)).filter(is_in_range);
                self.placement.reach(&boxes.fold(Aabb::EMPTY, |sum, aabb| sum.union(&aabb)))
            }
            Object::Scene(scene) => self.placement.reach(&scene.reach()),
        }
    }

    /// How far hits may be off the item's box, in units of a ray's reach.
    pub(super) fn error(&self) -> Vec3 {
        self.placement.error(match self.object {
            Object::Scene(scene) => scene.error().max_element(),
            _ => 0.0,
        })
    }

    /// The number of paths through the item.
    pub(super) fn paths(&self) -> u64 {
        match self.object {
            Object::Scene(scene) => scene.paths(),
            _ => 0,
        }
    }

    /// The number of scenes one in the other, from here on.
    pub(super) fn levels(&self) -> usize {
        match self.object {
            Object::Scene(scene) => 1 + scene.levels(),
            _ => 0,
        }
    }
}

/// A box around something that moves between places all of which are in `everywhere`, widened for rounding.
fn widened(aabb: &Aabb, everywhere: &Aabb) -> Aabb {
    let largest = everywhere.min.abs().max(everywhere.max.abs()).max_element();
    let pad = largest * MOVING_PAD as f32;
    if aabb.is_empty() { *aabb } else { Aabb { min: aabb.min - pad, max: aabb.max + pad } }
}

/// Whether a box is not empty and within the numeric limits.
fn is_in_range(aabb: &Aabb) -> bool {
    let limit = Vec3::splat(MAX_COORDINATE);
    !aabb.is_empty() && aabb.min.abs().cmple(limit).all() && aabb.max.abs().cmple(limit).all()
}

impl<'a> From<BvhView<'a>> for Object<'a> {
    fn from(tree: BvhView<'a>) -> Self {
        Self::Mesh(tree)
    }
}

impl<'a> From<MovingView<'a>> for Object<'a> {
    fn from(tree: MovingView<'a>) -> Self {
        Self::Moving(tree)
    }
}

impl<'a, S: Shape> From<&'a S> for Object<'a> {
    fn from(shape: &'a S) -> Self {
        Self::Shape(shape)
    }
}

impl<'a> From<&'a SceneView<'a>> for Object<'a> {
    fn from(scene: &'a SceneView<'a>) -> Self {
        Self::Scene(scene)
    }
}
