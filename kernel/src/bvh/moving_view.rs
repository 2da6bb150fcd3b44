//! A borrowed tree of triangles that move.
//!
//! It holds one tree a key, all of one shape: the nodes and blocks of a key are a tree around the triangles at that
//! key. Between two keys, corners and boxes are interpolated (see `geometry/moment.rs`).

use super::{BvhView, Node, TriangleBlock};
use crate::error::{Error, InvalidTree};
use crate::geometry::Aabb;

/// A tree of moving triangles in borrowed memory, checked once so that tracing needs no checks.
#[derive(Clone, Copy, Debug)]
pub struct MovingBvhView<'a> {
    nodes: &'a [Node],
    blocks: &'a [TriangleBlock],
    keys: usize,
    bounds: Aabb,
}

impl<'a> MovingBvhView<'a> {
    /// Borrows a tree of `keys` keys, with nodes and blocks stored key by key.
    ///
    /// # Errors
    /// The errors of [`BvhView::new`], as each key is a tree, and [`InvalidTree::BadKeys`] if they are not of one shape
    /// with the same triangles.
    pub fn new(nodes: &'a [Node], blocks: &'a [TriangleBlock], keys: usize) -> Result<Self, Error> {
        let bad_keys = InvalidTree::BadKeys { keys };
        let divided = keys > 0 && nodes.len().is_multiple_of(keys) && blocks.len().is_multiple_of(keys);
        if !divided || nodes.is_empty() {
            return Err(bad_keys.into());
        }
        let view = Self::trusted(nodes, blocks, keys);
        let first = BvhView::new(view.nodes(0), view.blocks(0))?;
        for key in 1..keys {
            let other = BvhView::new(view.nodes(key), view.blocks(key))?;
            let same_shape = other.nodes().iter().zip(first.nodes()).all(|(a, b)| a.children == b.children);
            let same_triangles = other.blocks().iter().zip(first.blocks()).all(|(a, b)| a.prim_id == b.prim_id);
            if !(same_shape && same_triangles) {
                return Err(bad_keys.into());
            }
        }
        Ok(view)
    }

    /// Borrows a tree that is known to be valid.
    pub(crate) fn trusted(nodes: &'a [Node], blocks: &'a [TriangleBlock], keys: usize) -> Self {
        let roots = nodes.chunks(nodes.len() / keys).map(|nodes| nodes[0].bounds());
        Self::with_bounds(nodes, blocks, keys, roots.fold(Aabb::EMPTY, |a, b| a.union(&b)))
    }

    /// Borrows a tree that is known to be valid, and whose bounds are known.
    pub(super) fn with_bounds(nodes: &'a [Node], blocks: &'a [TriangleBlock], keys: usize, bounds: Aabb) -> Self {
        Self { nodes, blocks, keys, bounds }
    }

    /// The nodes at a key, which is less than [`keys`](Self::keys); the first one is the root.
    #[inline]
    pub fn nodes(&self, key: usize) -> &'a [Node] {
        part(self.nodes, key, self.keys)
    }

    /// The triangles at a key, which is less than [`keys`](Self::keys).
    #[inline]
    pub fn blocks(&self, key: usize) -> &'a [TriangleBlock] {
        part(self.blocks, key, self.keys)
    }

    /// The tree at a key, which is less than [`keys`](Self::keys).
    #[inline]
    pub fn at_key(&self, key: usize) -> BvhView<'a> {
        BvhView::trusted(self.nodes(key), self.blocks(key))
    }

    /// The number of keys.
    #[inline]
    pub fn keys(&self) -> usize {
        self.keys
    }

    /// The box around all triangles at all times; empty if there are none.
    #[inline]
    pub fn bounds(&self) -> Aabb {
        self.bounds
    }
}

/// One of `parts` parts of equal length; nothing beyond the last.
#[inline]
pub(super) fn part<T>(all: &[T], index: usize, parts: usize) -> &[T] {
    let count = all.len() / parts;
    all.get(index * count..).and_then(|rest| rest.get(..count)).unwrap_or(&[])
}
