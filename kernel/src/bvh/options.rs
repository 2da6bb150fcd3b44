//! Options of a build: quality and effort.

use core::fmt;
use core::str::FromStr;

use super::bins::MAX_BINS;
use super::reinsertion::Patience;
use super::top_down::Splitting;

/// How to build a tree.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct BuildOptions {
    /// The trade between build time and tracing time.
    pub quality: Quality,
}

/// The trade between build time and tracing time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub enum Quality {
    /// Splits by few bins: for trees that few rays are traced through.
    Fast,
    /// Splits by more bins, with few rounds of reinsertion.
    Medium,
    /// Splits by many bins, with reinsertion until a round gains little.
    #[default]
    High,
}

/// The parameters of a quality.
#[derive(Clone, Copy, Debug)]
pub(super) struct Effort {
    pub splitting: Splitting,
    pub patience: Patience,
}

impl Effort {
    /// Splits by cost, without reinsertion: hardly deeper than [`LEVELS`].
    pub(super) const SPLIT_ONLY: Self = Self {
        splitting: Splitting { bins: MAX_BINS, levels: LEVELS, part_leaves: true },
        patience: Patience { rounds: 0, least_gain: 0.0 },
    };

    /// Always splits in the middle: the least possible depth.
    pub(super) const MEDIAN: Self = Self {
        splitting: Splitting { bins: 0, levels: 0, part_leaves: true },
        patience: Patience { rounds: 0, least_gain: 0.0 },
    };
}

/// Levels that are split by cost. A tree of halves over the most triangles that there can be has 29 levels.
const LEVELS: u32 = 64;

impl Quality {
    /// All qualities, the fastest build first.
    pub const ALL: [Self; 3] = [Self::Fast, Self::Medium, Self::High];

    /// `fast`, `medium` or `high`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Fast => "fast",
            Self::Medium => "medium",
            Self::High => "high",
        }
    }

    pub(super) fn effort(self) -> Effort {
        let (bins, rounds, least_gain) = match self {
            Self::Fast => (8, 0, 0.0),
            Self::Medium => (16, 8, 0.02),
            Self::High => (MAX_BINS, 16, 0.002),
        };
        let splitting = Splitting { bins, levels: LEVELS, part_leaves: self > Self::Fast };
        Effort { splitting, patience: Patience { rounds, least_gain } }
    }
}

impl From<Quality> for BuildOptions {
    fn from(quality: Quality) -> Self {
        Self { quality }
    }
}

impl fmt::Display for Quality {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for Quality {
    type Err = UnknownQuality;

    /// The quality of this [`name`](Self::name).
    fn from_str(name: &str) -> Result<Self, UnknownQuality> {
        Self::ALL.into_iter().find(|quality| quality.name() == name).ok_or(UnknownQuality)
    }
}

/// A name that is not the name of a [`Quality`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct UnknownQuality;

impl fmt::Display for UnknownQuality {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("qualities are named fast, medium and high")
    }
}

impl core::error::Error for UnknownQuality {}
