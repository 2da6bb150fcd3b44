//! A borrowed scene, for tracing.

use core::cell::Cell;

use glam::{Affine3A, Vec3};

use super::item::ItemSummary;
use super::object::Target;
use super::transform::MAX_ERROR;
use super::widening::{Errors, Widening};
use super::{Item, SceneHit};
use crate::bvh::{BoxTreeView, Node};
use crate::error::{Error, InvalidScene};
use crate::geometry::Aabb;
use crate::simd::Isa;

/// The contents of a leaf of a scene's tree: an item, or one primitive of an item that is a [`Shape`](super::Shape).
#[derive(Clone, Copy, Debug, PartialEq, Eq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct Part {
    /// The item's index.
    pub item: u32,
    /// The shape's primitive; 0 for other items.
    pub prim_id: u32,
}

/// A scene in borrowed memory, checked once so that tracing needs no checks.
///
/// The depth of nesting is known from the start, as each scene borrows the nested ones.
#[derive(Clone, Copy)]
pub struct SceneView<'a> {
    items: &'a [Item<'a>],
    parts: &'a [Part],
    tree: BoxTreeView<'a>,
    summary: SceneSummary,
    /// The box around all items at all times; boxes of the tree may be wider.
    bounds: Aabb,
    isa: Isa,
}

/// The deepest nesting of scenes below a scene: tracing takes some 9 KB of stack for each level.
pub const MAX_LEVELS: usize = 64;

/// The summary of all items.
#[derive(Clone, Copy, Debug)]
pub(super) struct SceneSummary {
    reach: Aabb,
    widening: Widening,
    levels: usize,
    /// Never 0.
    paths: u64,
    keys: usize,
}

impl SceneSummary {
    /// The summary of an empty scene.
    pub(super) const NOTHING: Self =
        Self { reach: Aabb::EMPTY, widening: Widening::NONE, levels: 0, paths: 1, keys: 1 };

    /// Numbers the paths through items too.
    ///
    /// # Errors
    /// [`InvalidScene::TooManyPaths`], [`InvalidScene::TooDeep`] and [`InvalidScene::Imprecise`].
    fn of(items: &mut [Item]) -> Result<Self, InvalidScene> {
        let (mut summary, mut errors) = (Self::NOTHING, Errors::NONE);
        for (index, item) in items.iter_mut().enumerate() {
            item.first_path = summary.first_path();
            summary.add(index, &item.summary(), &mut errors)?;
        }
        summary.finish(&errors);
        Ok(summary)
    }

    /// The first of the paths through the item that is added next.
    pub(super) fn first_path(&self) -> u64 {
        self.paths - 1
    }

    /// Adds an item, and its error to those of others.
    ///
    /// # Errors
    /// [`InvalidScene::TooManyPaths`], [`InvalidScene::TooDeep`] and [`InvalidScene::Imprecise`].
    pub(super) fn add(&mut self, index: usize, item: &ItemSummary, errors: &mut Errors) -> Result<(), InvalidScene> {
        self.paths = self.paths.checked_add(item.paths).ok_or(InvalidScene::TooManyPaths { item: index })?;
        if item.levels > MAX_LEVELS {
            return Err(InvalidScene::TooDeep { item: index });
        }
        // False for NaN.
        if !item.error.cmple(Vec3::splat(MAX_ERROR)).all() {
            return Err(InvalidScene::Imprecise { item: index });
        }
        self.reach = self.reach.union(&item.reach);
        errors.add(item.error);
        self.levels = self.levels.max(item.levels);
        self.keys = self.keys.max(item.keys);
        Ok(())
    }

    /// Finishes the summary after the last item; `errors` are those of all items.
    pub(super) fn finish(&mut self, errors: &Errors) {
        self.widening = Widening::of(errors, &self.reach);
    }

    /// How boxes are widened.
    #[cfg(any(feature = "alloc", test))]
    pub(super) fn widening(&self) -> &Widening {
        &self.widening
    }

    /// The number of keys that the tree needs.
    #[cfg(any(feature = "alloc", test))]
    pub(super) fn keys(&self) -> usize {
        self.keys
    }
}

impl<'a> SceneView<'a> {
    /// Borrows a scene whose tree is `nodes` and `indices`, as in [`BoxTreeView::new`]; these are indices of `parts`.
    /// The tree has as many keys as the item that has most. The items' paths are numbered.
    ///
    /// # Errors
    /// [`InvalidTree`](crate::InvalidTree) for the tree, and [`InvalidScene`] for the items.
    pub fn new<'b: 'a>(
        items: &'a mut [Item<'b>],
        parts: &'a [Part],
        nodes: &'a [Node],
        indices: &'a [u32],
    ) -> Result<Self, Error> {
        let summary = SceneSummary::of(items)?;
        let items: &'a [Item<'a>] = items;
        let with = |widening: Widening| {
            let bounds = Cell::new(Aabb::EMPTY);
            let aabb = |key: usize, index: u32| {
                let part = parts.get(index as usize)?;
                let item = items.get(part.item as usize).filter(|item| part.prim_id < item.count())?;
                let aabb = item.aabb(part.prim_id, key, summary.keys);
                bounds.set(bounds.get().union(&aabb));
                Some(if widening.is_by_rays() { aabb } else { widening.in_tree(aabb, item.error()) })
            };
            let tree = BoxTreeView::new(nodes, indices, summary.keys, aabb)?;
            let bounds = if widening.is_by_rays() { tree.bounds() } else { bounds.get() };
            Ok(Self { items, parts, tree, summary: SceneSummary { widening, ..summary }, bounds, isa: Isa::detect() })
        };
        let widening = summary.widening;
        match with(widening) {
            // Trees in older blobs are around the boxes as they are.
            Err(_) if !widening.is_by_rays() => with(widening.by_rays()),
            checked => checked,
        }
    }

    /// Borrows a scene that is known to be valid, and whose boxes are in the tree as its
    /// [widening](SceneSummary::widening) says.
    #[cfg(any(feature = "alloc", test))]
    pub(super) fn trusted(
        items: &'a [Item<'a>],
        parts: &'a [Part],
        tree: BoxTreeView<'a>,
        summary: SceneSummary,
        bounds: Aabb,
    ) -> Self {
        Self { items, parts, tree, summary, bounds, isa: Isa::detect() }
    }

    /// The scene, traced with the instructions of `isa` instead of those of [`Isa::detect`], whatever the trees in it
    /// say. With [`Isa::SCALAR`] that is a loop over all triangles, for small scenes.
    #[must_use]
    #[inline]
    pub fn with_isa(self, isa: Isa) -> Self {
        Self { isa, ..self }
    }

    /// The instruction set that the scene is traced with.
    #[inline]
    pub fn isa(&self) -> Isa {
        self.isa
    }

    /// The items.
    #[inline]
    pub fn items(&self) -> &'a [Item<'a>] {
        self.items
    }

    /// The tree over the boxes of [`parts`](Self::parts). Boxes of items distorted by more than about 100 are wider
    /// than their contents there, to allow for the rounding of rays.
    #[inline]
    pub fn tree(&self) -> &BoxTreeView<'a> {
        &self.tree
    }

    /// The items or primitives that the tree's boxes stand for.
    #[inline]
    pub fn parts(&self) -> &'a [Part] {
        self.parts
    }

    /// The entry with the box of this index in the tree, and its item.
    #[inline(always)]
    pub(super) fn item_of(&self, index: u32) -> Option<(&'a Part, &'a Item<'a>)> {
        let part = self.parts.get(index as usize)?;
        Some((part, self.items.get(part.item as usize)?))
    }

    /// The box around all items at all times; empty if there are none.
    #[inline]
    pub fn bounds(&self) -> Aabb {
        self.bounds
    }

    /// The depth of nested scenes below this one.
    #[inline]
    pub fn levels(&self) -> usize {
        self.summary.levels
    }

    /// The transform from the space of the geometry of a hit to that of this scene at a time, rounded; `None` if the
    /// hit does not belong to this scene, or the time is NaN. Normals take its inverse transpose.
    pub fn to_scene(&self, hit: &SceneHit, time: f32) -> Option<Affine3A> {
        let mut instances = self.instances(hit);
        let mut whole = Affine3A::IDENTITY;
        for (_, item) in instances.by_ref() {
            whole *= item.to_scene(time)?;
        }
        Some(whole * instances.scene?.items.get(hit.item as usize)?.to_scene(time)?)
    }

    /// The items with nested scenes on the path to a hit, the outermost first; empty for a hit of another scene.
    pub fn instances(&self, hit: &SceneHit) -> Instances<'a> {
        Instances { scene: (hit.path < self.paths()).then_some(*self), path: hit.path }
    }

    /// The number of paths in this scene: its own, and those through its items.
    #[inline(always)]
    pub(super) fn paths(&self) -> u64 {
        self.summary.paths
    }

    /// The summary of all items.
    #[cfg(any(feature = "alloc", test))]
    pub(super) fn summary(&self) -> &SceneSummary {
        &self.summary
    }

    /// The box that a ray's reach has to span.
    #[inline(always)]
    pub(super) fn reach(&self) -> Aabb {
        self.summary.reach
    }

    /// How boxes are widened.
    #[inline(always)]
    pub(super) fn widening(&self) -> &Widening {
        &self.summary.widening
    }

    /// How far hits may be off the boxes of their items, in units of a ray's reach.
    pub(super) fn error(&self) -> Vec3 {
        self.summary.widening.greatest()
    }
}

/// The items on the path to a hit, each with its index in the scene that has it; returned by [`SceneView::instances`].
#[derive(Clone, Debug)]
pub struct Instances<'a> {
    /// The scene that the path has reached so far; `None` if there is no such path.
    scene: Option<SceneView<'a>>,
    /// The rest of the path, from there.
    path: u64,
}

impl<'a> Iterator for Instances<'a> {
    type Item = (u32, &'a Item<'a>);

    fn next(&mut self) -> Option<Self::Item> {
        let scene = self.scene?;
        if self.path + 1 == scene.paths() {
            return None;
        }
        // Of items with the same first path the last is the scene that has it.
        let index = scene.items.partition_point(|item| item.first_path <= self.path).checked_sub(1)?;
        let item = &scene.items[index];
        let Target::Scene(inner) = item.object.target() else {
            return None;
        };
        *self = Self { scene: Some(inner), path: self.path - item.first_path };
        Some((index as u32, item))
    }
}
