//! The bounding-volume hierarchy: eight boxes a node, triangles in blocks of eight.
//!
//! Building (`alloc`) runs in stages. `top_down` makes a binary tree, one block of triangles a leaf, splitting by `bins`;
//! `reinsertion` moves its subtrees to better places; `plan` picks the eight-wide tree of least cost that can be made of
//! it, and `collapse` lays that out; [`validate`](BvhView::new) checks what traversal relies on. `refit` moves a
//! tree's triangles. [`BvhView`] borrows the result, from wherever it lies, [bytes](BvhView::from_bytes) included.

#[cfg(any(feature = "alloc", test))]
mod binary;
#[cfg(any(feature = "alloc", test))]
mod bins;
mod blob;
#[cfg(any(feature = "alloc", test))]
mod build;
#[cfg(any(feature = "alloc", test))]
mod collapse;
#[cfg(any(feature = "alloc", test))]
mod executor;
mod node;
#[cfg(any(feature = "alloc", test))]
mod options;
#[cfg(any(feature = "alloc", test))]
mod plan;
#[cfg(any(feature = "alloc", test))]
mod primitive;
#[cfg(any(feature = "alloc", test))]
mod refit;
#[cfg(any(feature = "alloc", test))]
mod reinsertion;
#[cfg(any(feature = "alloc", test))]
mod top_down;
mod validate;
mod view;

#[cfg(any(feature = "alloc", test))]
pub use blob::Blob;
pub use blob::{Aligned, BLOB_ALIGNMENT, BLOB_VERSION};
#[cfg(any(feature = "alloc", test))]
pub use build::{BuildReport, Bvh, TreeStatistics};
#[cfg(any(feature = "alloc", test))]
pub use executor::{Executor, Serial};
pub use node::{Child, MAX_STACK, Node, TriangleBlock, WIDTH};
#[cfg(any(feature = "alloc", test))]
pub use options::{BuildOptions, Quality};
#[cfg(any(feature = "alloc", test))]
pub use refit::Refit;
pub use view::BvhView;

#[cfg(test)]
mod tests;
