//! A scene that owns its items: built from a list, or by commits of staged changes.

mod changes;

use alloc::vec::Vec;
use core::fmt;
use core::mem;

use super::handle::Places;
use super::item::ItemSummary;
use super::top_level::{TASK, TopLevel, check_count};
use super::view::SceneSummary;
use super::widening::Errors;
use super::{Item, SceneView};
use crate::bvh::{BuildOptions, BuildReport, Executor, Serial, for_each};
use crate::error::Error;
#[cfg(doc)]
use crate::error::InvalidScene;
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
    summaries: Vec<ItemSummary>,
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
            summaries: Vec::new(),
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
        let mut summaries = Vec::new();
        summaries.resize(items.len(), ItemSummary::NOTHING);
        for_each(executor, TASK, 0, &mut summaries, &|place, summary| *summary = items[place].summary());
        scene.staged_at = alloc::vec![UNCHANGED; items.len()];
        (scene.items, scene.summaries) = (items, summaries);
        scene.summary = scene.new_summary()?;
        let (top, report) = TopLevel::build(executor, (&scene.items, &scene.summaries), &scene.summary, options)?;
        scene.top = top;
        scene.number_paths();
        Ok((scene, report))
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
            let mut summaries = Vec::new();
            summaries.resize(changed, ItemSummary::NOTHING);
            for_each(executor, TASK, 0, &mut summaries, &|place, summary| *summary = self.staged[place].item.summary());
            self.exchange_summaries(&mut summaries);
            let summary = match self.new_summary() {
                Ok(summary) => summary,
                Err(error) => {
                    self.exchange_summaries(&mut summaries);
                    return Err(error);
                }
            };
            // From here on nothing fails, but for a tree that gets too deep.
            self.exchange_items();
            let indices: Vec<u32> = self.staged.iter().map(|staged| staged.index).collect();
            if self.top.fit(executor, (&self.items, &self.summaries), &indices, &summary).is_none() {
                match TopLevel::build(executor, (&self.items, &self.summaries), &summary, &self.options) {
                    Ok((top, built)) => (self.top, report) = (top, built),
                    Err(error) => {
                        self.exchange_items();
                        self.exchange_summaries(&mut summaries);
                        self.number_paths();
                        // What was built before can be built again.
                        let list = (&self.items[..], &self.summaries[..]);
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

    fn exchange_summaries(&mut self, summaries: &mut [ItemSummary]) {
        for (staged, summary) in self.staged.iter().zip(summaries) {
            mem::swap(&mut self.summaries[staged.index as usize], summary);
        }
    }

    fn exchange_items(&mut self) {
        for staged in &mut self.staged {
            mem::swap(&mut self.items[staged.index as usize], &mut staged.item);
        }
    }

    fn new_summary(&self) -> Result<SceneSummary, Error> {
        let (mut summary, mut errors) = (SceneSummary::NOTHING, Errors::NONE);
        for (index, item) in self.summaries.iter().enumerate() {
            summary.add(index, item, &mut errors)?;
        }
        summary.finish(&errors);
        check_count(self.summaries.iter().map(|item| item.count))?;
        Ok(summary)
    }

    /// Numbers the paths through items.
    fn number_paths(&mut self) {
        let mut paths = 0;
        for (item, summary) in self.items.iter_mut().zip(&self.summaries) {
            item.first_path = paths;
            paths += summary.paths;
        }
    }
}
