//! A borrowed scene: what is traced.

use glam::{Affine3A, Vec3};

use super::transform::MAX_ERROR;
use super::{Item, MAX_LEVELS, Object, SceneHit};
use crate::bvh::{BoxTreeView, Node};
use crate::error::{Error, InvalidScene};
use crate::geometry::Aabb;
use crate::simd::Isa;

/// What a leaf of a scene's tree stands for: an item, or one primitive of an item that is a [`Shape`](super::Shape).
#[derive(Clone, Copy, Debug, PartialEq, Eq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct Part {
    /// The item's index.
    pub item: u32,
    /// The shape's primitive; 0 for other items.
    pub prim_id: u32,
}

/// A scene that lies in somebody's memory, checked once so that tracing need not.
///
/// How deep scenes lie in each other is known from the outset, [`MAX_LEVELS`] at most, as each borrows those in it. Tracing
/// recurses once a level, with some 3 KB of stack each.
#[derive(Clone, Copy)]
pub struct SceneView<'a> {
    items: &'a [Item<'a>],
    parts: &'a [Part],
    tree: BoxTreeView<'a>,
    extent: Extent,
    isa: Isa,
}

/// What is known of all items together.
#[derive(Clone, Copy, Debug)]
pub(super) struct Extent {
    reach: Aabb,
    error: Vec3,
    levels: usize,
    keys: usize,
}

impl Extent {
    /// # Errors
    /// [`InvalidScene::TooNested`] and [`InvalidScene::Imprecise`].
    pub(super) fn of(items: &[Item]) -> Result<Self, Error> {
        let mut extent = Self { reach: Aabb::EMPTY, error: Vec3::ZERO, levels: 0, keys: 1 };
        for (index, item) in items.iter().enumerate() {
            let levels = item.levels();
            if levels > MAX_LEVELS {
                return Err(InvalidScene::TooNested { item: index, levels, allowed: MAX_LEVELS }.into());
            }
            let error = item.error();
            // Not for a NaN either.
            if !error.cmple(Vec3::splat(MAX_ERROR)).all() {
                return Err(InvalidScene::Imprecise { item: index }.into());
            }
            extent.reach = extent.reach.union(&item.reach());
            extent.error = extent.error.max(error);
            extent.levels = extent.levels.max(levels);
            extent.keys = extent.keys.max(item.keys());
        }
        Ok(extent)
    }

    /// The number of keys that the tree needs.
    #[cfg(any(feature = "alloc", test))]
    pub(super) fn keys(&self) -> usize {
        self.keys
    }
}

impl<'a> SceneView<'a> {
    /// Borrows a scene whose tree is `nodes` and `numbers`, as in [`BoxTreeView::new`]; the numbers name `parts`. The tree has
    /// as many keys as the item that has most.
    ///
    /// # Errors
    /// [`InvalidTree`](crate::InvalidTree) says what is wrong with the tree, and [`InvalidScene`] what is with the items.
    pub fn new(items: &'a [Item<'a>], parts: &'a [Part], nodes: &'a [Node], numbers: &'a [u32]) -> Result<Self, Error> {
        let extent = Extent::of(items)?;
        let aabb = |key: usize, number: u32| {
            let part = parts.get(number as usize)?;
            let item = items.get(part.item as usize).filter(|item| part.prim_id < item.count())?;
            Some(item.aabb(part.prim_id, key, extent.keys))
        };
        let tree = BoxTreeView::new(nodes, numbers, extent.keys, aabb)?;
        Ok(Self::trusted(items, parts, tree, extent))
    }

    /// Borrows a scene that is known to be valid.
    pub(super) fn trusted(items: &'a [Item<'a>], parts: &'a [Part], tree: BoxTreeView<'a>, extent: Extent) -> Self {
        Self { items, parts, tree, extent, isa: Isa::detect() }
    }

    /// The same scene, traced with the instructions of `isa` instead of those of [`Isa::detect`], whatever the trees in it say.
    #[must_use]
    #[inline]
    pub fn with_isa(self, isa: Isa) -> Self {
        Self { isa, ..self }
    }

    /// What the scene is traced with.
    #[inline]
    pub fn isa(&self) -> Isa {
        self.isa
    }

    /// The items.
    #[inline]
    pub fn items(&self) -> &'a [Item<'a>] {
        self.items
    }

    /// The tree over the boxes of [`parts`](Self::parts).
    #[inline]
    pub fn tree(&self) -> &BoxTreeView<'a> {
        &self.tree
    }

    /// What the tree's boxes stand for.
    #[inline]
    pub fn parts(&self) -> &'a [Part] {
        self.parts
    }

    /// The box around all items at all times; empty if there are none.
    #[inline]
    pub fn bounds(&self) -> Aabb {
        self.tree.bounds()
    }

    /// The number of scenes one in the other, below this one.
    #[inline]
    pub fn levels(&self) -> usize {
        self.extent.levels
    }

    /// The transform from the space of the geometry of a hit to that of this scene at a time, rounded; `None` if the hit
    /// is none of this scene, or the time is NaN. Normals take its inverse transpose.
    pub fn to_scene(&self, hit: &SceneHit, time: f32) -> Option<Affine3A> {
        let mut scene = self;
        let mut whole = Affine3A::IDENTITY;
        for &index in hit.instances.iter().take_while(|&&index| index != SceneHit::NO_INSTANCE) {
            let item = scene.items.get(index as usize)?;
            whole *= item.to_scene(time)?;
            let Object::Scene(inner) = item.object() else {
                return None;
            };
            scene = inner;
        }
        Some(whole * scene.items.get(hit.geometry_id as usize)?.to_scene(time)?)
    }

    /// What rays' reach has to span.
    #[inline(always)]
    pub(super) fn reach(&self) -> Aabb {
        self.extent.reach
    }

    /// How far hits may be off the boxes of their items, in units of a ray's reach.
    #[inline(always)]
    pub(super) fn error(&self) -> Vec3 {
        self.extent.error
    }
}
