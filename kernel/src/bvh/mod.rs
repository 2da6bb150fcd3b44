//! The bounding-volume hierarchy: eight boxes a node, triangles in blocks of eight.
//!
//! Building (`alloc`) runs in stages. `top_down` makes a binary tree, one block of triangles a leaf, splitting by
//! `bins`; `reinsertion` moves its subtrees to better places; `plan` picks the eight-wide tree of least cost that can
//! be made of it, and `collapse` lays that out; [`validate`](BvhView::new) checks what traversal relies on. `refit`
//! moves a tree's triangles. [`BvhView`] borrows the result, wherever it is stored; as a [`blob`] it can be written to
//! a file and traced there.
//!
//! A [`RoundBvhView`] has blocks of points or curves, all of one kind, and the same nodes.

#[cfg(any(feature = "alloc", test))]
mod binary;
#[cfg(any(feature = "alloc", test))]
mod bins;
pub mod blob;
pub(crate) mod blob_header;
#[cfg(any(feature = "alloc", test))]
mod box_tree;
mod box_view;
#[cfg(any(feature = "alloc", test))]
mod build;
#[cfg(any(feature = "alloc", test))]
mod collapse;
#[cfg(any(feature = "alloc", test))]
mod contents;
#[cfg(any(feature = "alloc", test))]
mod copy;
#[cfg(any(feature = "alloc", test))]
mod executor;
#[cfg(any(feature = "alloc", test))]
mod fit;
mod lookup;
#[cfg(any(feature = "alloc", test))]
mod moving;
mod moving_view;
mod node;
#[cfg(feature = "obvhs")]
mod obvhs;
#[cfg(any(feature = "alloc", test))]
mod options;
#[cfg(any(feature = "alloc", test))]
mod pages;
#[cfg(any(feature = "alloc", test))]
mod plan;
#[cfg(any(feature = "alloc", test))]
mod primitive;
#[cfg(any(feature = "alloc", test))]
mod refit;
#[cfg(any(feature = "alloc", test))]
mod reinsertion;
mod round_block;
#[cfg(any(feature = "alloc", test))]
mod round_tree;
mod round_view;
#[cfg(any(feature = "alloc", test))]
mod top_down;
mod validate;
mod view;

#[cfg(any(feature = "alloc", test))]
pub use blob::Blob;
pub use blob::{Aligned, BLOB_ALIGNMENT, BLOB_VERSION};
#[cfg(any(feature = "alloc", test))]
pub use box_tree::BoxTree;
pub use box_view::BoxTreeView;
#[cfg(any(feature = "alloc", test))]
pub use build::{BuildReport, Bvh, TreeStatistics};
#[cfg(feature = "rayon")]
pub use executor::RayonExecutor;
#[cfg(any(feature = "alloc", test))]
pub(crate) use executor::for_each;
#[cfg(any(feature = "alloc", test))]
pub use executor::{Executor, Serial};
#[cfg(any(feature = "alloc", test))]
pub use lookup::TriangleIndex;
#[cfg(any(feature = "alloc", test))]
pub use moving::MovingBvh;
pub use moving_view::MovingBvhView;
pub(crate) use node::SLOTS_IN_ORDER;
pub use node::{Child, MAX_STACK, Node, TriangleBlock, WIDTH};
#[cfg(any(feature = "alloc", test))]
pub use options::{BuildOptions, Quality, UnknownQuality};
#[cfg(any(feature = "alloc", test))]
pub use refit::Refit;
pub use round_block::{CubicCurveBlock, DiscBlock, LinearCurveBlock, RoundBlock, RoundBlocks, SphereBlock};
pub(crate) use round_block::{used_lanes, with_blocks};
#[cfg(any(feature = "alloc", test))]
pub use round_tree::{RoundBuild, RoundBvh};
pub use round_view::RoundBvhView;
pub use view::BvhView;

#[cfg(test)]
mod tests;
