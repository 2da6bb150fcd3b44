//! What can be wrong with a mesh.

use core::fmt;

use super::Error;

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
    IncompleteTriangle {
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
            Self::IncompleteTriangle { count } => write!(f, "{count} corners are not a multiple of 3"),
            Self::IndexOutOfRange { place, index, count } => {
                write!(f, "index {place} is {index}, but there are only {count} vertices")
            }
        }
    }
}
