//! Builds a scene and owns its tree.

use alloc::vec::Vec;

use super::view::SceneSummary;
use super::{Item, Part, SceneView};
use crate::bvh::{BoxTree, BuildOptions, BuildReport, Child, Executor, Serial};
use crate::error::{Error, InvalidTree};

/// A scene that owns its list of items and their tree; what items are is borrowed.
#[derive(Clone)]
pub struct Scene<'a> {
    items: Vec<Item<'a>>,
    parts: Vec<Part>,
    tree: BoxTree,
    summary: SceneSummary,
}

impl<'a> Scene<'a> {
    /// Builds a scene of `items`, on this thread. A hit names an item by its index. The report counts parts, which are
    /// items, or primitives of items that are shapes: those with an empty box as degenerate, and those that reach beyond the
    /// [numeric limits](crate#numeric-limits) at some time as out of range. Neither are in the scene.
    ///
    /// # Errors
    /// [`InvalidScene::Imprecise`](crate::InvalidScene::Imprecise) if distorting transforms lie one in the other so that rounding
    /// gets out of hand, [`InvalidScene::TooManyPaths`](crate::InvalidScene::TooManyPaths), and [`InvalidTree::TooLarge`].
    pub fn build(items: Vec<Item<'a>>, options: &BuildOptions) -> Result<(Self, BuildReport), Error> {
        Self::build_on(&Serial, items, options)
    }

    /// Like [`build`](Self::build), where `executor` says. The scene does not depend on it.
    ///
    /// # Errors
    /// Those of [`build`](Self::build).
    pub fn build_on<E: Executor>(
        executor: &E,
        mut items: Vec<Item<'a>>,
        options: &BuildOptions,
    ) -> Result<(Self, BuildReport), Error> {
        let summary = SceneSummary::of(&mut items)?;
        let count = items.iter().map(|item| u64::from(item.count())).sum::<u64>();
        if count > Child::MAX_INDEX.into() {
            return Err(InvalidTree::TooLarge { limit: Child::MAX_INDEX }.into());
        }
        let parts: Vec<Part> = (0..)
            .zip(&items)
            .flat_map(|(index, item)| (0..item.count()).map(move |prim_id| Part { item: index, prim_id }))
            .collect();
        let keys = summary.keys();
        let aabb = |key: usize, part: &Part| items[part.item as usize].aabb(part.prim_id, key, keys);
        let boxes: Vec<_> = (0..keys).flat_map(|key| parts.iter().map(move |part| aabb(key, part))).collect();
        let (tree, report) = BoxTree::build_on(executor, &boxes, keys, options)?;
        Ok((Self { items, parts, tree, summary }, report))
    }

    /// Borrows the scene for tracing.
    pub fn view(&self) -> SceneView<'_> {
        SceneView::trusted(&self.items, &self.parts, self.tree.view(), self.summary)
    }

    /// Memory of items, parts and the tree in bytes; what items borrow is not counted.
    pub fn bytes(&self) -> usize {
        size_of_val(&self.items[..]) + size_of_val(&self.parts[..]) + self.tree.bytes()
    }
}
