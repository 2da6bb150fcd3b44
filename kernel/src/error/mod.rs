//! What can be wrong with triangles, trees and blobs. Tracing itself has no errors: what it relies on is checked
//! before.

mod mesh;
mod scene;
mod tree;

use core::fmt;

pub use mesh::InvalidMesh;
pub use scene::InvalidScene;
pub use tree::{InvalidTree, RefitError};

/// Why a tree or scene cannot be built, read, changed or written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Error {
    /// There are more triangles, points or curves than a tree can hold.
    TooManyPrimitives {
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
    WrongEndianness,
    /// The blob's version cannot be read.
    UnsupportedVersion {
        /// The blob's version.
        found: u32,
        /// The only version that can be read.
        readable: u32,
    },
    /// The blob is truncated.
    Truncated {
        /// The blob's whole length, or at least the length of its header, in bytes.
        needed: u64,
        /// The length that it has.
        found: u64,
    },
    /// Bytes follow the blob.
    TrailingBytes {
        /// The blob's length in bytes.
        needed: u64,
        /// The length that it has.
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

impl core::error::Error for Error {}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::TooManyPrimitives { count, limit } => {
                write!(f, "{count} primitives are too many: a tree holds {limit} at most")
            }
            Self::InvalidTree(error) => error.fmt(f),
            Self::InvalidScene(error) => error.fmt(f),
            Self::Refit(error) => error.fmt(f),
            Self::InvalidMesh(error) => error.fmt(f),
            Self::NotABlob => write!(f, "these bytes are not a tree, which would begin with 89 48 44 42 56 48 0d 0a"),
            Self::NotAScene => write!(f, "these bytes are not a scene, which would begin with 89 48 44 53 43 4e 0d 0a"),
            Self::WrongEndianness => {
                let [theirs, ours] = if cfg!(target_endian = "big") { ["little", "big"] } else { ["big", "little"] };
                write!(f, "the blob was written on a {theirs}-endian machine, and this one is {ours}-endian")
            }
            Self::UnsupportedVersion { found, readable } => {
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
