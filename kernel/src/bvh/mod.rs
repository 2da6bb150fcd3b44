//! The bounding-volume hierarchy: eight boxes a node, triangles in blocks of eight.
//!
//! Building runs in three stages. A binary tree with one triangle a leaf comes from obvhs (`std`) or from median splits
//! (`alloc`); `collapse` then picks the eight-wide tree of least cost that can be made of it, and lays it out;
//! [`validate`](BvhView::new) checks what traversal relies on. [`BvhView`] borrows the result, from wherever it lies.

#[cfg(any(feature = "alloc", test))]
mod binary;
#[cfg(any(feature = "alloc", test))]
mod build;
#[cfg(any(feature = "alloc", test))]
mod collapse;
#[cfg(any(feature = "alloc", test))]
mod median;
mod node;
#[cfg(feature = "std")]
mod obvhs;
mod validate;
mod view;

#[cfg(any(feature = "alloc", test))]
pub use build::{BuildError, BuildOptions, BuildReport, Bvh, TreeStatistics};
pub use node::{Child, MAX_STACK, Node, TriangleBlock, WIDTH};
pub use validate::InvalidTree;
pub use view::BvhView;
