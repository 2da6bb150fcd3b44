//! A borrowed tree over boxes instead of triangles, static or moving: the nodes are the same, and a leaf is one box.
//!
//! A moving tree has one set of nodes a key, of the same shape: each set is a tree around the boxes at that key, and
//! between two keys each box is interpolated (see `geometry/moment.rs`).

use super::moving_view::part;
use super::{Node, validate};
use crate::error::{Error, InvalidTree};
use crate::geometry::Aabb;

/// A tree over boxes in borrowed memory, checked once so that tracing needs no checks.
#[derive(Clone, Copy, Debug)]
pub struct BoxTreeView<'a> {
    nodes: &'a [Node],
    items: &'a [u32],
    keys: usize,
    bounds: Aabb,
}

impl<'a> BoxTreeView<'a> {
    /// Borrows a tree of `keys` consecutive sets of nodes, whose leaves refer to places in `items`, the indices of
    /// boxes. `boxes` gives the box of an item at a key, and `None` for an item that does not exist.
    ///
    /// # Errors
    /// [`InvalidTree`] says what is wrong, as for a tree of triangles; [`InvalidTree::BadItem`] is an item without a
    /// box, and [`InvalidTree::BadKeys`] says that the keys differ in more than their boxes.
    pub fn new(
        nodes: &'a [Node],
        items: &'a [u32],
        keys: usize,
        boxes: impl Fn(usize, u32) -> Option<Aabb>,
    ) -> Result<Self, Error> {
        if keys == 0 || !nodes.len().is_multiple_of(keys) || nodes.is_empty() {
            return Err(InvalidTree::BadKeys { keys }.into());
        }
        let count = nodes.len() / keys;
        for (key, moved) in nodes.chunks(count).enumerate() {
            validate::validate_nodes(moved, items.len(), |first, end| {
                let mut bounds = Aabb::EMPTY;
                for (place, &item) in (first..).zip(&items[first..end]) {
                    let bad_item = InvalidTree::BadItem { place: place as u32 };
                    bounds = bounds.union(&boxes(key, item).filter(|aabb| !aabb.is_empty()).ok_or(bad_item)?);
                }
                Ok(bounds)
            })?;
            if moved.iter().zip(nodes).any(|(a, b)| a.children != b.children) {
                return Err(InvalidTree::BadKeys { keys }.into());
            }
        }
        Ok(Self::trusted(nodes, items, keys))
    }

    /// Borrows a tree that is known to be valid.
    pub(crate) fn trusted(nodes: &'a [Node], items: &'a [u32], keys: usize) -> Self {
        let roots = nodes.chunks(nodes.len() / keys).map(|nodes| nodes[0].bounds());
        Self { nodes, items, keys, bounds: roots.fold(Aabb::EMPTY, |a, b| a.union(&b)) }
    }

    /// Borrows a tree that is known to be valid, with its bounds.
    #[cfg(any(feature = "alloc", test))]
    pub(super) fn with_bounds(nodes: &'a [Node], items: &'a [u32], keys: usize, bounds: Aabb) -> Self {
        Self { nodes, items, keys, bounds }
    }

    /// The nodes at a key, which is less than [`keys`](Self::keys); the first one is the root.
    #[inline]
    pub fn nodes(&self, key: usize) -> &'a [Node] {
        part(self.nodes, key, self.keys)
    }

    /// The indices of the boxes, in the order of the leaves.
    #[inline]
    pub fn items(&self) -> &'a [u32] {
        self.items
    }

    /// The number of keys; 1 if nothing moves.
    #[inline]
    pub fn keys(&self) -> usize {
        self.keys
    }

    /// The box around all boxes at all times; empty if there are none.
    #[inline]
    pub fn bounds(&self) -> Aabb {
        self.bounds
    }
}
