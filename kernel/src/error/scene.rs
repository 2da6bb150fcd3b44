//! What can be wrong with a scene of items.

use core::fmt;

use super::Error;

/// What is wrong with an item or a scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum InvalidScene {
    /// A handle whose item was removed, or that is of another scene.
    NoSuchItem {
        /// The handle's index.
        index: u32,
        /// The handle's generation.
        generation: u32,
    },
    /// Something that moves needs a key at least.
    NoKeys,
    /// A transform with an element that is infinite or NaN.
    NotFinite {
        /// The transform's index; 0 if it stands still.
        key: usize,
    },
    /// A transform without an inverse, or so near to one that the inverse is noise.
    Singular {
        /// The transform's index; it is this one, or one on the way to the next.
        key: usize,
    },
    /// An item for which the bound of rounding gets out of hand: each level of scenes in scenes multiplies it, by the greatest
    /// row sums of the item's transform and of its inverse. For rotations that is 1 to 3, however little they round.
    Imprecise {
        /// The item's index.
        item: usize,
    },
    /// More scenes lie one in the other than [`scene::MAX_LEVELS`](crate::scene::MAX_LEVELS).
    TooDeep {
        /// The index of the item that is so deep.
        item: usize,
    },
    /// Scenes lie in others so often that the ways through them are more than a number of 64 bits tells apart.
    TooManyPaths {
        /// The index of the item with which they become too many.
        item: usize,
    },
    /// An item is a shape of the caller's, which cannot be written as bytes.
    NotSaved {
        /// The item's index in its scene.
        item: usize,
        /// How many scenes that lies in.
        depth: usize,
    },
    /// A record in a scene's blob that names what there is not.
    BadRecord {
        /// What the record is of.
        record: &'static str,
        /// Its index among those.
        index: usize,
    },
    /// There is less memory, or fewer scenes were given, than a scene's blob needs.
    TooFew {
        /// What there is too few of.
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
            Self::NoKeys => write!(f, "what moves needs a key at least, and has none"),
            Self::NotFinite { key } => write!(f, "transform {key} has an element that is infinite or not a number"),
            Self::Singular { key } => write!(
                f,
                "transform {key} has no useful inverse, or loses it on the way to the next: it should not flatten what it \
                 moves, and keys of a rotation should be less than half a turn apart"
            ),
            Self::Imprecise { item } => {
                write!(
                    f,
                    "the bound of the rounding error of item {item} is more than a quarter of the scene: transforms of scenes in \
                     scenes multiply it, rotations by up to 3 a level and stretches by more; nest less deep, or combine \
                     transforms into one"
                )
            }
            Self::TooDeep { item } => write!(
                f,
                "with item {item} more scenes lie one in the other than tracing has stack for (scene::MAX_LEVELS); nest less deep"
            ),
            Self::TooManyPaths { item } => {
                write!(f, "with item {item} there are more than 2^64 - 1 ways through scenes in scenes")
            }
            Self::NotSaved { item, depth } => {
                write!(f, "item {item} is a shape of the program's, which cannot be written as bytes")?;
                match depth {
                    0 => Ok(()),
                    1 => write!(f, "; it is in a scene in the scene"),
                    _ => write!(f, "; it is in a scene {depth} scenes down"),
                }
            }
            Self::BadRecord { record, index } => {
                write!(f, "the blob's {record} {index} names what there is not, or is out of order")
            }
            Self::TooFew { what, needed, given } => {
                write!(f, "the scene needs {needed} {what}, and {given} were given")
            }
        }
    }
}
