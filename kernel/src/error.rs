//! Errors of triangles, trees, scenes and blobs. Tracing itself has no errors: its preconditions are checked before.

use core::fmt;

use crate::geometry::MAX_COORDINATE;

/// Why a tree or scene cannot be built, read, changed or written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Error {
    /// There are more triangles than a tree can hold.
    TooManyTriangles {
        /// How many there are.
        count: usize,
        /// How many there may be.
        limit: usize,
    },
    /// The nodes and blocks are not a tree that can be traced.
    InvalidTree(InvalidTree),
    /// The items are not a scene that can be traced.
    InvalidScene(InvalidScene),
    /// A tree cannot be refitted to these triangles.
    Refit(RefitError),
    /// The buffers are not a mesh.
    InvalidMesh(InvalidMesh),
    /// The bytes do not begin with the magic number of a tree's blob.
    NotABlob,
    /// The bytes do not begin with the magic number of a scene's blob.
    NotAScene,
    /// The blob was written by a machine of the other endianness.
    OtherByteOrder,
    /// The blob's version cannot be read.
    OtherVersion {
        /// The blob's version.
        found: u32,
        /// The only version that can be read.
        readable: u32,
    },
    /// The blob is truncated.
    Truncated {
        /// The blob's whole length, or at least the length of its header, in bytes.
        needed: u64,
        /// The length of the given bytes.
        found: u64,
    },
    /// Bytes follow the blob.
    TrailingBytes {
        /// The blob's length in bytes.
        needed: u64,
        /// The length of the given bytes.
        found: u64,
    },
    /// The blob begins at an address where it cannot be traced.
    Misaligned {
        /// The alignment that the address needs.
        alignment: usize,
    },
    /// The blob has changed since it was written.
    Damaged {
        /// The checksum stored in the blob.
        stored: u32,
        /// The checksum of the given bytes.
        computed: u32,
    },
    /// The blob's header does not describe what is in it.
    BadHeader {
        /// The invalid field.
        field: &'static str,
    },
}

/// What is wrong with a tree.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum InvalidTree {
    /// There is no node; even an empty tree has a root.
    NoRoot,
    /// There are more nodes or blocks than an index can address.
    TooLarge {
        /// How many there may be of each.
        limit: u32,
    },
    /// A child that is out of range or not where a depth-first walk meets it.
    BadChild {
        /// The node that has it.
        node: u32,
        /// The child's place in the node.
        slot: u32,
    },
    /// An order of children that does not list each child once.
    BadOrder {
        /// The node that has it.
        node: u32,
    },
    /// A node that no other refers to.
    ForgottenNode {
        /// Its index.
        node: u32,
    },
    /// A block that no leaf refers to.
    ForgottenBlock {
        /// Its index.
        block: u32,
    },
    /// A box that does not enclose its contents, or is not finite.
    BadBox {
        /// The node that has it.
        node: u32,
        /// The child's place in the node.
        slot: u32,
    },
    /// A triangle that is not finite or out of limits, or an unused lane that is not empty.
    BadTriangle {
        /// The block that has it.
        block: u32,
        /// Its lane.
        lane: u32,
    },
    /// A point or curve that no ray can hit, as it is not finite, out of limits or without a radius, or an unused lane
    /// that is not empty.
    BadPrimitive {
        /// The block that has it.
        block: u32,
        /// Its lane.
        lane: u32,
    },
    /// A leaf refers to an item that does not exist or has no box.
    BadItem {
        /// The place in the list of items.
        place: u32,
    },
    /// There are no keys, or they differ in their number of triangles, boxes or nodes, or in the tree's shape.
    BadKeys {
        /// The number of keys.
        keys: usize,
    },
    /// Traversal would need a larger stack than it has.
    TooDeep {
        /// Entries needed.
        needed: u32,
        /// Entries that there are.
        allowed: u32,
    },
}

/// What is wrong with an item or a scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum InvalidScene {
    /// A handle whose item was removed, or that belongs to another scene.
    NoSuchItem {
        /// The handle's index.
        index: u32,
        /// The handle's generation.
        generation: u32,
    },
    /// A motion without a key.
    NoKeys,
    /// A transform with an element that is infinite or NaN.
    NotFinite {
        /// The transform's index; 0 if it stands still.
        key: usize,
    },
    /// A transform that is singular, or so nearly that its inverse is rounding noise.
    Singular {
        /// The transform's index: this key, or an interpolated transform between it and the next key, is singular.
        key: usize,
    },
    /// An item whose bound of rounding is too large: each level of nested scenes multiplies it by the greatest row sums
    /// of the item's transform and of its inverse. For rotations the factor is 1 to 3, however small their own rounding
    /// is.
    Imprecise {
        /// The item's index.
        item: usize,
    },
    /// Scenes are nested deeper than [`scene::MAX_LEVELS`](crate::scene::MAX_LEVELS).
    TooDeep {
        /// The index of the item that is too deep.
        item: usize,
    },
    /// Nested scenes have more paths than a number of 64 bits can count.
    TooManyPaths {
        /// The index of the item with which they become too many.
        item: usize,
    },
    /// An item is a custom shape, which cannot be written as bytes.
    NotSaved {
        /// The item's index in its scene.
        item: usize,
        /// How many scenes enclose that scene.
        depth: usize,
    },
    /// A record in a scene's blob that refers to something that does not exist.
    BadRecord {
        /// The kind of record.
        record: &'static str,
        /// Its index among the records of that kind.
        index: usize,
    },
    /// Less memory, or fewer scenes, were given than a scene's blob needs.
    TooFew {
        /// What there are too few of.
        what: &'static str,
        /// How many are needed.
        needed: usize,
        /// How many there are.
        given: usize,
    },
}

impl core::error::Error for InvalidScene {}

impl From<InvalidScene> for Error {
    fn from(error: InvalidScene) -> Self {
        Self::InvalidScene(error)
    }
}

impl fmt::Display for InvalidScene {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoSuchItem { index, generation } => {
                write!(f, "there is no item {index} of generation {generation}: it was removed, or is in another scene")
            }
            Self::NoKeys => write!(f, "a motion needs at least one key, and has none"),
            Self::NotFinite { key } => write!(f, "transform {key} has an element that is infinite or not a number"),
            Self::Singular { key } => write!(
                f,
                "transform {key}, or its interpolation to the next, has no useful inverse: it should not flatten its \
                 object, and keys of a rotation should be less than half a turn apart"
            ),
            Self::Imprecise { item } => {
                write!(
                    f,
                    "item {item}: the rounding error of its nested transforms may exceed a quarter of the scene. Each level \
                     multiplies the error: a rotation by up to 3, a stretch by its ratio. Nest fewer scenes, or combine \
                     transforms"
                )
            }
            Self::TooDeep { item } => write!(
                f,
                "item {item} nests more than scene::MAX_LEVELS scenes, which is more than tracing has stack for; nest fewer"
            ),
            Self::TooManyPaths { item } => {
                write!(f, "with item {item} there are more than 2^64 - 1 paths through nested scenes")
            }
            Self::NotSaved { item, depth } => {
                write!(f, "item {item} is a custom shape, which cannot be written as bytes")?;
                match depth {
                    0 => Ok(()),
                    1 => write!(f, "; it is in a scene nested in the scene"),
                    _ => write!(f, "; it is in a scene nested {depth} levels deep"),
                }
            }
            Self::BadRecord { record, index } => {
                write!(f, "the blob's {record} {index} refers to something that does not exist, or is out of order")
            }
            Self::TooFew { what, needed, given } => {
                write!(f, "the scene needs {needed} {what}, and {given} were given")
            }
        }
    }
}

/// What is wrong with a mesh's buffers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum InvalidMesh {
    /// Positions that would overlap.
    BadStride {
        /// The distance between positions in bytes.
        stride: usize,
        /// The length of a position in bytes.
        least: usize,
    },
    /// The indices, or without them the positions, are not a multiple of three.
    NotThrees {
        /// How many there are.
        count: usize,
    },
    /// An index of a vertex that does not exist.
    IndexOutOfRange {
        /// The index's place among the indices.
        place: usize,
        /// The index.
        index: u32,
        /// How many vertices there are.
        count: usize,
    },
}

impl core::error::Error for InvalidMesh {}

impl From<InvalidMesh> for Error {
    fn from(error: InvalidMesh) -> Self {
        Self::InvalidMesh(error)
    }
}

impl fmt::Display for InvalidMesh {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::BadStride { stride, least } => {
                write!(f, "positions of {least} bytes cannot lie {stride} bytes apart")
            }
            Self::NotThrees { count } => write!(f, "{count} corners are not a multiple of 3"),
            Self::IndexOutOfRange { place, index, count } => {
                write!(f, "index {place} is {index}, but there are only {count} vertices")
            }
        }
    }
}

/// Why a tree cannot be refitted: the triangles that can be hit are not those that are in the tree.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum RefitError {
    /// A triangle of the tree is not among those given.
    Missing {
        /// Its index.
        prim_id: u32,
        /// How many are given.
        count: usize,
    },
    /// A triangle of the tree now has a coordinate out of limits, or two equal corners.
    Vanished {
        /// Its index.
        prim_id: u32,
    },
    /// Triangles that are not in the tree can now be hit.
    Appeared {
        /// How many more.
        count: usize,
    },
}

impl core::error::Error for Error {}

impl core::error::Error for RefitError {}

impl core::error::Error for InvalidTree {}

impl From<RefitError> for Error {
    fn from(error: RefitError) -> Self {
        Self::Refit(error)
    }
}

impl From<InvalidTree> for Error {
    fn from(error: InvalidTree) -> Self {
        Self::InvalidTree(error)
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::TooManyTriangles { count, limit } => {
                write!(f, "{count} triangles are too many: a tree holds {limit} at most")
            }
            Self::InvalidTree(error) => error.fmt(f),
            Self::InvalidScene(error) => error.fmt(f),
            Self::Refit(error) => error.fmt(f),
            Self::InvalidMesh(error) => error.fmt(f),
            Self::NotABlob => write!(f, "these bytes are not a tree, which would begin with 89 48 44 42 56 48 0d 0a"),
            Self::NotAScene => write!(f, "these bytes are not a scene, which would begin with 89 48 44 53 43 4e 0d 0a"),
            Self::OtherByteOrder => {
                let [theirs, ours] = if cfg!(target_endian = "big") { ["little", "big"] } else { ["big", "little"] };
                write!(f, "the blob was written on a {theirs}-endian machine, and this one is {ours}-endian")
            }
            Self::OtherVersion { found, readable } => {
                let age = if found < readable { "older" } else { "newer" };
                write!(f, "the blob is of version {found}, {age} than {readable}, the only one that can be read here")
            }
            Self::Truncated { needed, found } => {
                write!(f, "the blob is cut off: {found} bytes of at least {needed} are there")
            }
            Self::TrailingBytes { needed, found } => {
                write!(f, "the blob has {needed} bytes, and {} more follow it", found - needed)
            }
            Self::Misaligned { alignment } => {
                write!(f, "the blob begins at an address that is not a multiple of {alignment}")
            }
            Self::Damaged { stored, computed } => {
                write!(f, "the blob is damaged: its checksum should be {stored:08x} and is {computed:08x}")
            }
            Self::BadHeader { field } => write!(f, "the blob's header is invalid: {field}"),
        }
    }
}

impl fmt::Display for RefitError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Missing { prim_id, count } => {
                write!(
                    f,
                    "triangle {prim_id} is in the tree, but there are only {count}; give all that it was built from"
                )
            }
            Self::Vanished { prim_id } => write!(
                f,
                "triangle {prim_id} is in the tree, but now has two equal corners, or a coordinate that is not finite or \
                 beyond ±{MAX_COORDINATE:e}; build the tree again"
            ),
            Self::Appeared { count } => {
                write!(f, "{count} triangles that are not in the tree can now be hit; build it again")
            }
        }
    }
}

impl fmt::Display for InvalidTree {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoRoot => write!(f, "the tree has no root node"),
            Self::TooLarge { limit } => write!(f, "the tree has more than {limit} nodes or blocks"),
            Self::BadChild { node, slot } => {
                write!(f, "child {slot} of node {node} is out of range or out of order")
            }
            Self::BadOrder { node } => {
                write!(f, "an order of the children of node {node} does not list each child once")
            }
            Self::ForgottenNode { node } => write!(f, "node {node} has no parent"),
            Self::ForgottenBlock { block } => write!(f, "block {block} is in no leaf"),
            Self::BadBox { node, slot } => {
                write!(f, "the box of child {slot} of node {node} does not enclose what is in it")
            }
            Self::BadTriangle { block, lane } => {
                write!(
                    f,
                    "triangle {lane} of block {block} has a coordinate that is not finite or beyond ±{MAX_COORDINATE:e}"
                )
            }
            Self::BadPrimitive { block, lane } => write!(
                f,
                "primitive {lane} of block {block} has no radius, or a coordinate that is not finite or beyond \
                 ±{MAX_COORDINATE:e}"
            ),
            Self::BadItem { place } => write!(f, "item {place} in the leaves does not exist, or has no box"),
            Self::BadKeys { keys } => {
                write!(
                    f,
                    "a moving tree of {keys} keys needs at least one, and all keys need the same shape and number of parts"
                )
            }
            Self::TooDeep { needed, allowed } => {
                write!(f, "the tree is too deep: it needs a stack of {needed} entries, and there are {allowed}")
            }
        }
    }
}
