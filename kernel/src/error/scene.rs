//! What can be wrong with a scene of items.

use core::fmt;

use super::Error;

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
    /// There are more items than indices.
    TooManyItems {
        /// How many there may be, removed ones included until the next commit.
        limit: usize,
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
    NotSerializable {
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
    BufferTooSmall {
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
            Self::TooManyItems { limit } => write!(f, "a scene holds {limit} items at most"),
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
            Self::NotSerializable { item, depth } => {
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
            Self::BufferTooSmall { what, needed, given } => {
                write!(f, "the scene needs {needed} {what}, and {given} were given")
            }
        }
    }
}
