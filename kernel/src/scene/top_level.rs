//! The tree over a scene's items: built or refitted.

use alloc::vec::Vec;

use super::item::ItemSummary;
use super::view::SceneSummary;
use super::widening::Widening;
use super::{Item, Part};
use crate::bvh::{BoxTree, BuildOptions, BuildReport, Child, Executor, for_each};
use crate::error::{Error, InvalidTree};
use crate::geometry::Aabb;

/// The cost ratio from which on the tree is rebuilt. It is over few boxes, so a build takes only about ten times as
/// long as a refit.
const REBUILD_COST_RATIO: f32 = 1.2;

/// Items that are one task.
pub(super) const TASK: usize = 256;

/// A tree over the boxes of a scene's parts, at each key.
#[derive(Clone, Debug)]
pub(super) struct TopLevel {
    pub parts: Vec<Part>,
    pub tree: BoxTree,
    /// The bounds of the tree's contents; the tree's own boxes may be widened.
    pub bounds: Aabb,
    /// The boxes of all parts at the first key, then those at the next …
    boxes: Vec<Aabb>,
    keys: usize,
    /// Where the parts of each item begin, and where those of the last end.
    firsts: Vec<u32>,
    /// Whether a part is in the tree.
    is_in_tree: Vec<bool>,
    built_cost: f32,
}

impl TopLevel {
    /// The empty tree.
    pub(super) fn empty() -> Self {
        Self {
            parts: Vec::new(),
            tree: BoxTree::empty(),
            bounds: Aabb::EMPTY,
            boxes: Vec::new(),
            keys: 1,
            firsts: Vec::from([0]),
            is_in_tree: Vec::new(),
            built_cost: 0.0,
        }
    }

    /// Builds the tree over items of which these are the summaries.
    ///
    /// # Errors
    /// [`InvalidTree::TooLarge`].
    pub(super) fn build<E: Executor>(
        executor: &E,
        (items, summaries): (&[Item], &[ItemSummary]),
        summary: &SceneSummary,
        options: &BuildOptions,
    ) -> Result<(Self, BuildReport), Error> {
        let (keys, widening) = (summary.keys(), summary.widening());
        check_count(items.iter().map(Item::count))?;
        let (mut parts, mut firsts) = (Vec::new(), Vec::with_capacity(items.len() + 1));
        for (index, item) in (0..).zip(items) {
            firsts.push(parts.len() as u32);
            parts.extend((0..item.count()).map(|prim_id| Part { item: index, prim_id }));
        }
        firsts.push(parts.len() as u32);
        let mut boxes = Vec::new();
        boxes.resize(keys * parts.len(), Aabb::EMPTY);
        if !parts.is_empty() {
            for (key, boxes) in boxes.chunks_mut(parts.len()).enumerate() {
                let aabb = |part: &Part| items[part.item as usize].aabb(part.prim_id, key, keys);
                for_each(executor, TASK, 0, boxes, &|part, place| *place = aabb(&parts[part]));
            }
        }
        let (tree, report) = if widening.is_by_rays() {
            BoxTree::build_on(executor, &boxes, keys, options)?
        } else {
            let error = |part: usize| summaries[parts[part % parts.len()].item as usize].error;
            let widened = boxes.iter().enumerate().map(|(place, aabb)| widening.in_tree(*aabb, error(place)));
            BoxTree::build_on(executor, &widened.collect::<Vec<_>>(), keys, options)?
        };
        let mut is_in_tree = Vec::new();
        is_in_tree.resize(parts.len(), false);
        tree.view().items().iter().for_each(|&part| is_in_tree[part as usize] = true);
        let built_cost = tree.cost();
        let mut top = Self { parts, tree, bounds: Aabb::EMPTY, boxes, keys, firsts, is_in_tree, built_cost };
        top.measure(widening);
        Ok((top, report))
    }

    /// Computes the bounds.
    fn measure(&mut self, widening: &Widening) {
        self.bounds = self.tree.view().bounds();
        if !widening.is_by_rays() {
            let in_tree = self.boxes.iter().zip(self.is_in_tree.iter().cycle()).filter(|(_, is_in)| **is_in);
            self.bounds = in_tree.fold(Aabb::EMPTY, |sum, (aabb, _)| sum.union(aabb));
        }
    }

    /// Makes the box around all at least as large, until the tree is fitted.
    pub(super) fn widen(&mut self, bounds: &Aabb) {
        self.bounds = self.bounds.union(bounds);
    }

    /// Fits the tree to items some of which have changed. `None` if it has to be or should be rebuilt; then it is
    /// unusable.
    pub(super) fn fit<E: Executor>(
        &mut self,
        executor: &E,
        (items, summaries): (&[Item], &[ItemSummary]),
        changed: &[u32],
        summary: &SceneSummary,
    ) -> Option<()> {
        let (keys, widening) = (summary.keys(), summary.widening());
        if keys != self.keys {
            return None;
        }
        let parts = self.parts.len();
        for &index in changed {
            let item = &items[index as usize];
            let (first, end) = match self.firsts.get(index as usize..) {
                Some(&[first, end, ..]) => (first, end),
                // A new place.
                _ => (0, 0),
            };
            let count = item.count();
            // What is gone leaves its parts behind, as boxes of nothing.
            if count != 0 && count != end - first {
                return None;
            }
            for (prim_id, part) in (0..).zip(first as usize..end as usize) {
                let mut is_seen = true;
                for key in 0..keys {
                    let aabb = if count == 0 { Aabb::EMPTY } else { item.aabb(prim_id, key, keys) };
                    self.boxes[key * parts + part] = aabb;
                    is_seen &= aabb.is_usable();
                }
                if is_seen && !self.is_in_tree[part] {
                    return None;
                }
                if !is_seen {
                    (0..keys).for_each(|key| self.boxes[key * parts + part] = Aabb::EMPTY);
                }
            }
        }
        let (boxes, all) = (&self.boxes, &self.parts);
        let plain = |key: usize, part: u32| boxes[key * parts + part as usize];
        if widening.is_by_rays() {
            self.tree.fit(executor, plain);
        } else {
            // All of them: by how much they are widened depends on what the whole scene reaches.
            let error = |part: u32| summaries[all[part as usize].item as usize].error;
            self.tree.fit(executor, |key, part| widening.in_tree(plain(key, part), error(part)));
        }
        self.measure(widening);
        (self.tree.cost() <= REBUILD_COST_RATIO * self.built_cost).then_some(())
    }

    /// The number of visible parts.
    pub(super) fn count_seen(&self) -> usize {
        self.boxes[..self.parts.len()]
            .iter()
            .zip(&self.is_in_tree)
            .filter(|(b, is_in)| **is_in && !b.is_empty())
            .count()
    }
}

/// Whether a tree can hold this many parts.
///
/// # Errors
/// [`InvalidTree::TooLarge`].
pub(super) fn check_count(counts: impl Iterator<Item = u32>) -> Result<(), Error> {
    if counts.map(u64::from).sum::<u64>() > Child::MAX_INDEX.into() {
        return Err(InvalidTree::TooLarge { limit: Child::MAX_INDEX }.into());
    }
    Ok(())
}
