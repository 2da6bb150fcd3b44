//! A scene that owns its items and follows their changes.

use alloc::vec::Vec;
use core::fmt;
use core::mem;

use glam::Affine3A;

use super::handle::{Handle, Places};
use super::item::ItemSummary;
use super::top_level::{TASK, TopLevel, check_count};
use super::transform::Placement;
use super::view::SceneSummary;
use super::widening::Errors;
use super::{Item, Object, SceneView};
use crate::bvh::{BuildOptions, BuildReport, Executor, Serial, for_each};
use crate::error::{Error, InvalidScene};
use crate::geometry::Aabb;

/// A scene that owns its list of items and their tree. The items' objects are borrowed or shared; where all are shared,
/// by [`Arc`](alloc::sync::Arc), this is a `Scene<'static>`.
///
/// Changes are staged until [`commit`](Self::commit): [`view`](Self::view) shows the scene as of the last one.
#[derive(Clone)]
pub struct Scene<'a> {
    options: BuildOptions,
    /// As of the last commit, by index.
    items: Vec<Item<'a>>,
    facts: Vec<ItemSummary>,
    places: Places,
    staged: Vec<Staged<'a>>,
    /// For each index its place in `staged`, or [`UNCHANGED`].
    staged_at: Vec<u32>,
    top: TopLevel,
    summary: SceneSummary,
}

/// The staged change of the item at an index.
#[derive(Clone)]
struct Staged<'a> {
    index: u32,
    item: Item<'a>,
}

const UNCHANGED: u32 = u32::MAX;

/// What a commit did.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Commit {
    /// How many items were inserted, changed or removed.
    pub changed: usize,
    /// Whether the scene's tree was rebuilt; otherwise it was refitted.
    pub is_rebuilt: bool,
    /// How many items, or primitives of items that are shapes, are in the tree, so that rays whose mask allows it can
    /// hit them. Empty, flat and removed items are not, nor those that reach beyond the [numeric
    /// limits](crate#numeric-limits).
    pub seen: usize,
    /// The expected number of nodes visited by a random ray that meets the scene's box.
    pub cost: f32,
}

impl Default for Scene<'_> {
    fn default() -> Self {
        Self::new(BuildOptions::default())
    }
}

impl fmt::Debug for Scene<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (items, staged) = (self.places.handles().count(), self.staged.len());
        f.debug_struct("Scene").field("items", &items).field("staged", &staged).finish_non_exhaustive()
    }
}

impl<'a> Scene<'a> {
    /// An empty scene. `options` are for its own tree, which is over items: if they move each frame, choose
    /// [`Quality::Fast`](crate::Quality::Fast), as the tree is rebuilt from time to time.
    pub fn new(options: BuildOptions) -> Self {
        Self {
            options,
            items: Vec::new(),
            facts: Vec::new(),
            places: Places::default(),
            staged: Vec::new(),
            staged_at: Vec::new(),
            top: TopLevel::empty(),
            summary: SceneSummary::NOTHING,
        }
    }

    /// Builds a scene of `items`, on this thread. A hit names an item by its index. The report counts parts, which are
    /// items, or primitives of items that are shapes: those with an empty box as degenerate, and those that reach
    /// beyond the [numeric limits](crate#numeric-limits) at some time as out of range. Neither is in the scene.
    ///
    /// # Errors
    /// [`InvalidScene::TooManyItems`] and the errors of [`commit`](Self::commit).
    pub fn build(items: Vec<Item<'a>>, options: &BuildOptions) -> Result<(Self, BuildReport), Error> {
        Self::build_on(&Serial, items, options)
    }

    /// Like [`build`](Self::build), on the threads of `executor`. The scene does not depend on it.
    ///
    /// # Errors
    /// The errors of [`build`](Self::build).
    pub fn build_on<E: Executor>(
        executor: &E,
        items: Vec<Item<'a>>,
        options: &BuildOptions,
    ) -> Result<(Self, BuildReport), Error> {
        let mut scene = Self::new(*options);
        scene.places = Places::taken(items.len())?;
        let mut facts = Vec::new();
        facts.resize(items.len(), ItemSummary::NOTHING);
        for_each(executor, TASK, 0, &mut facts, &|place, facts| *facts = items[place].facts());
        scene.staged_at = alloc::vec![UNCHANGED; items.len()];
        (scene.items, scene.facts) = (items, facts);
        scene.summary = scene.new_summary()?;
        let (top, report) = TopLevel::build(executor, (&scene.items, &scene.facts), &scene.summary, options)?;
        scene.top = top;
        scene.number_paths();
        Ok((scene, report))
    }

    /// Adds an item, from the next commit on.
    ///
    /// # Errors
    /// [`InvalidScene::TooManyItems`] if there are 2³² - 1 items.
    pub fn insert(&mut self, item: Item<'a>) -> Result<Handle, Error> {
        let handle = self.places.take()?;
        let index = handle.index as usize;
        if index == self.items.len() {
            // Nothing yet, with the paths of nothing: none.
            self.items.push(Item { first_path: self.summary.first_path(), ..Item::nothing() });
            self.facts.push(ItemSummary::NOTHING);
            self.staged_at.push(UNCHANGED);
        }
        *self.stage(handle.index) = item;
        Ok(handle)
    }

    /// Removes an item, from the next commit on, and its handle at once.
    ///
    /// # Errors
    /// [`InvalidScene::NoSuchItem`].
    pub fn remove(&mut self, handle: Handle) -> Result<(), Error> {
        *self.item_mut(handle)? = Item::nothing();
        self.places.free(handle);
        Ok(())
    }

    /// Sets an item's transform, from the next commit on. A transform that flattens hides it.
    ///
    /// # Errors
    /// [`InvalidScene::NoSuchItem`] and those of [`Item::placed`]; the item then keeps its transform.
    pub fn set_transform(&mut self, handle: Handle, to_scene: &Affine3A) -> Result<(), Error> {
        let placement = Placement::still(to_scene)?;
        self.item_mut(handle)?.placement = placement;
        Ok(())
    }

    /// Sets an item's mask, from the next commit on; 0 hides it.
    ///
    /// # Errors
    /// [`InvalidScene::NoSuchItem`].
    pub fn set_mask(&mut self, handle: Handle, mask: u32) -> Result<(), Error> {
        self.item_mut(handle)?.mask = mask;
        Ok(())
    }

    /// Sets an item's object, from the next commit on; its transform and mask stay. A deforming mesh can use two trees,
    /// one in the scene while the other is refitted: after the commit the first is no longer shared.
    ///
    /// # Errors
    /// [`InvalidScene::NoSuchItem`].
    pub fn set_object(&mut self, handle: Handle, object: impl Into<Object<'a>>) -> Result<(), Error> {
        self.item_mut(handle)?.object = object.into();
        Ok(())
    }

    /// Replaces an item, from the next commit on; the handle stays.
    ///
    /// # Errors
    /// [`InvalidScene::NoSuchItem`].
    pub fn set_item(&mut self, handle: Handle, item: Item<'a>) -> Result<(), Error> {
        *self.item_mut(handle)? = item;
        Ok(())
    }

    /// An item with its changes since the last commit; `None` if it was removed.
    pub fn get(&self, handle: Handle) -> Option<&Item<'a>> {
        if !self.places.contains(handle) {
            return None;
        }
        match self.staged_at[handle.index as usize] {
            UNCHANGED => self.items.get(handle.index as usize),
            place => self.staged.get(place as usize).map(|staged| &staged.item),
        }
    }

    /// The handle of the item that a hit names by its `item`; `None` if it has been removed since.
    pub fn handle(&self, item: u32) -> Option<Handle> {
        self.places.handle(item)
    }

    /// The handles of all items, in the order of their indices.
    pub fn handles(&self) -> impl Iterator<Item = Handle> {
        self.places.handles()
    }

    /// Whether there were no changes since the last commit.
    pub fn is_committed(&self) -> bool {
        self.staged.is_empty()
    }

    /// Makes all changes since the last commit, on this thread: from now on rays see them. The scene's tree is refitted
    /// to its items; if there are new ones, or its cost exceeds that of its build by a fifth, it is rebuilt.
    ///
    /// # Errors
    /// [`InvalidScene::Imprecise`] if nested distorting transforms make the bound of rounding too large,
    /// [`InvalidScene::TooManyPaths`], [`InvalidScene::TooDeep`], and
    /// [`InvalidTree::TooLarge`](crate::InvalidTree::TooLarge). The scene then stays as of the last commit, and the
    /// changes stay pending.
    pub fn commit(&mut self) -> Result<Commit, Error> {
        self.commit_on(&Serial)
    }

    /// Like [`commit`](Self::commit), on the threads of `executor`. The scene does not depend on it.
    ///
    /// # Errors
    /// The errors of [`commit`](Self::commit).
    pub fn commit_on<E: Executor>(&mut self, executor: &E) -> Result<Commit, Error> {
        self.commit_with_report(executor).map(|(commit, _)| commit)
    }

    /// The report is that of a rebuilt tree, and else empty.
    fn commit_with_report<E: Executor>(&mut self, executor: &E) -> Result<(Commit, BuildReport), Error> {
        let changed = self.staged.len();
        let mut report = BuildReport::default();
        let mut is_rebuilt = false;
        if changed > 0 {
            let mut facts = Vec::new();
            facts.resize(changed, ItemSummary::NOTHING);
            for_each(executor, TASK, 0, &mut facts, &|place, facts| *facts = self.staged[place].item.facts());
            self.exchange_facts(&mut facts);
            let summary = match self.new_summary() {
                Ok(summary) => summary,
                Err(error) => {
                    self.exchange_facts(&mut facts);
                    return Err(error);
                }
            };
            // From here on nothing fails, but for a tree that gets too deep.
            self.exchange_items();
            let indices: Vec<u32> = self.staged.iter().map(|staged| staged.index).collect();
            if self.top.fit(executor, (&self.items, &self.facts), &indices, &summary).is_none() {
                match TopLevel::build(executor, (&self.items, &self.facts), &summary, &self.options) {
                    Ok((top, built)) => (self.top, report) = (top, built),
                    Err(error) => {
                        self.exchange_items();
                        self.exchange_facts(&mut facts);
                        self.number_paths();
                        // What was built before can be built again.
                        let list = (&self.items[..], &self.facts[..]);
                        (self.top, _) = TopLevel::build(executor, list, &self.summary, &self.options)?;
                        return Err(error);
                    }
                }
                is_rebuilt = true;
            }
            self.summary = summary;
            self.number_paths();
            for staged in mem::take(&mut self.staged) {
                self.staged_at[staged.index as usize] = UNCHANGED;
            }
            self.places.commit();
        }
        let commit = Commit { changed, is_rebuilt, seen: self.top.count_seen(), cost: self.top.tree.cost() };
        Ok((commit, report))
    }

    /// Borrows the scene, as of its last commit, for tracing.
    pub fn view(&self) -> SceneView<'_> {
        SceneView::trusted(&self.items, &self.top.parts, self.top.tree.view(), self.summary, self.top.bounds)
    }

    /// Memory of items, parts and the tree in bytes; borrowed and shared objects are not counted.
    pub fn memory_bytes(&self) -> usize {
        size_of_val(&self.items[..]) + size_of_val(&self.top.parts[..]) + self.top.tree.memory_bytes()
    }

    /// The options of its own tree.
    pub fn options(&self) -> BuildOptions {
        self.options
    }

    /// Makes the scene's box at least as large, until the next commit.
    pub(super) fn widen(&mut self, bounds: &Aabb) {
        self.top.widen(bounds);
    }

    fn item_mut(&mut self, handle: Handle) -> Result<&mut Item<'a>, InvalidScene> {
        if !self.places.contains(handle) {
            let Handle { index, generation } = handle;
            return Err(InvalidScene::NoSuchItem { index, generation });
        }
        Ok(self.stage(handle.index))
    }

    /// The item at an index, to be changed.
    fn stage(&mut self, index: u32) -> &mut Item<'a> {
        let place = &mut self.staged_at[index as usize];
        if *place == UNCHANGED {
            *place = self.staged.len() as u32;
            self.staged.push(Staged { index, item: self.items[index as usize].clone() });
        }
        &mut self.staged[*place as usize].item
    }

    fn exchange_facts(&mut self, facts: &mut [ItemSummary]) {
        for (staged, facts) in self.staged.iter().zip(facts) {
            mem::swap(&mut self.facts[staged.index as usize], facts);
        }
    }

    fn exchange_items(&mut self) {
        for staged in &mut self.staged {
            mem::swap(&mut self.items[staged.index as usize], &mut staged.item);
        }
    }

    fn new_summary(&self) -> Result<SceneSummary, Error> {
        let (mut summary, mut errors) = (SceneSummary::NOTHING, Errors::NONE);
        for (index, facts) in self.facts.iter().enumerate() {
            summary.add(index, facts, &mut errors)?;
        }
        summary.finish(&errors);
        check_count(self.facts.iter().map(|facts| facts.count))?;
        Ok(summary)
    }

    /// Numbers the paths through items.
    fn number_paths(&mut self) {
        let mut paths = 0;
        for (item, facts) in self.items.iter_mut().zip(&self.facts) {
            item.first_path = paths;
            paths += facts.paths;
        }
    }
}
