//! Events on a light path, and patterns of them.

use std::fmt::{self, Write as _};

/// The kind: the first symbol of an event. A light may be of several kinds.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Kind(u8);

impl Kind {
    /// `C`: the camera.
    pub const CAMERA: Self = Self(1);
    /// `L`: any light but the background.
    pub const LIGHT: Self = Self(2);
    /// `O`: a surface of the model that emits; it is a light too.
    pub const OBJECT: Self = Self(4);
    /// `B`: the background, the sky.
    pub const BACKGROUND: Self = Self(8);
    /// `R`: reflection.
    pub const REFLECTION: Self = Self(16);
    /// `T`: transmission.
    pub const TRANSMISSION: Self = Self(32);
    /// `V`: scattering in a volume, of which there are none.
    pub const VOLUME: Self = Self(64);

    /// All letters, with what they mean.
    pub(super) const LETTERS: [(char, Self); 7] = [
        ('C', Self::CAMERA),
        ('L', Self::LIGHT),
        ('O', Self::OBJECT),
        ('B', Self::BACKGROUND),
        ('R', Self::REFLECTION),
        ('T', Self::TRANSMISSION),
        ('V', Self::VOLUME),
    ];

    /// Both of these.
    pub const fn and(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }
}

/// The scattering lobe: the second symbol of an event.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Scattering(u8);

impl Scattering {
    /// `x`: none, as at a camera and a light.
    pub const NONE: Self = Self(1);
    /// `D`: a wide lobe.
    pub const DIFFUSE: Self = Self(2);
    /// `G`: a rough reflection or refraction.
    pub const GLOSSY: Self = Self(4);
    /// `S`: a mirror, clear glass.
    pub const SINGULAR: Self = Self(8);
    /// `s`: straight through, which is no event here.
    pub const STRAIGHT: Self = Self(16);

    /// All letters, with what they mean.
    pub(super) const LETTERS: [(char, Self); 5] =
        [('x', Self::NONE), ('D', Self::DIFFUSE), ('G', Self::GLOSSY), ('S', Self::SINGULAR), ('s', Self::STRAIGHT)];
}

/// An event on a path.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Event {
    /// The kind.
    pub kind: Kind,
    /// The scattering lobe.
    pub scattering: Scattering,
    /// What was there: of a surface the names of the object and the material, of a light those of its group and itself.
    pub labels: Vec<String>,
}

impl fmt::Display for Event {
    /// Its symbols as in an expression, without `x`, then the name of the object or of the light: `RD floor`, `O lamp`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // A light that is a surface is the latter.
        let kind = if self.kind.0 & Kind::OBJECT.0 != 0 { Kind::OBJECT } else { self.kind };
        let kinds = Kind::LETTERS.iter().filter(|(_, it)| it.0 & kind.0 != 0).map(|(letter, _)| *letter);
        let lobes = Scattering::LETTERS.iter().filter(|(_, it)| it.0 & self.scattering.0 & !Scattering::NONE.0 != 0);
        kinds.chain(lobes.map(|(letter, _)| *letter)).try_for_each(|letter| f.write_char(letter))?;
        let is_light = self.scattering == Scattering::NONE;
        let label = if is_light { self.labels.last() } else { self.labels.first() };
        label.map_or(Ok(()), |label| write!(f, " {label}"))
    }
}

/// A set of events.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Pattern {
    pub kind: Choice<u8>,
    pub scattering: Choice<u8>,
    /// Patterns of the first labels; further labels are arbitrary.
    pub labels: Vec<Choice<String>>,
}

/// A set of symbols: any of these.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) enum Choice<T> {
    #[default]
    Any,
    Is(T),
    /// None of these.
    Not(Vec<T>),
    AnyOf(Vec<Choice<T>>),
}

impl<T> Choice<T> {
    fn contains(&self, is: &impl Fn(&T) -> bool) -> bool {
        match self {
            Self::Any => true,
            Self::Is(symbol) => is(symbol),
            Self::Not(symbols) => !symbols.iter().any(is),
            Self::AnyOf(choices) => choices.iter().any(|choice| choice.contains(is)),
        }
    }

    pub(super) fn symbols<'a>(&'a self, visit: &mut dyn FnMut(&'a T)) {
        match self {
            Self::Any => {}
            Self::Is(symbol) => visit(symbol),
            Self::Not(symbols) => symbols.iter().for_each(visit),
            Self::AnyOf(choices) => choices.iter().for_each(|choice| choice.symbols(visit)),
        }
    }
}

impl Pattern {
    /// The camera.
    pub(super) fn camera() -> Self {
        Self { kind: Choice::Is(Kind::CAMERA.0), ..Self::default() }
    }

    /// Lights with this first label, but for the sky.
    pub(super) fn light_group(label: &str) -> Self {
        let labels = vec![Choice::Is(label.to_owned())];
        Self { kind: Choice::Is(Kind::LIGHT.0), labels, ..Self::default() }
    }

    /// The sky.
    pub(super) fn sky() -> Self {
        Self { kind: Choice::Is(Kind::BACKGROUND.0), ..Self::default() }
    }

    /// Whether it has an event.
    pub(super) fn contains(&self, event: &Event) -> bool {
        let has_labels = self.labels.len() <= event.labels.len();
        let mut labels = self.labels.iter().zip(&event.labels);
        self.has_kind_of(event)
            && self.scattering.contains(&|scattering| scattering & event.scattering.0 != 0)
            && has_labels
            && labels.all(|(choice, label)| choice.contains(&|it| it == label))
    }

    /// Whether it has events of this one's kind.
    pub(super) fn has_kind_of(&self, event: &Event) -> bool {
        self.kind.contains(&|kind| kind & event.kind.0 != 0)
    }

    /// Visits the labels that it names.
    pub(super) fn named<'a>(&'a self, visit: &mut dyn FnMut(&'a String)) {
        self.labels.iter().for_each(|choice| choice.symbols(visit));
    }
}

/// A symbol's bits: those of a kind, or those of a scattering.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Letter {
    Kind(u8),
    Scattering(u8),
}

/// The meaning of a letter.
pub(super) fn letter(letter: char) -> Option<Letter> {
    let kind = Kind::LETTERS.iter().find(|(it, _)| *it == letter).map(|(_, kind)| Letter::Kind(kind.0));
    let scattering = || Scattering::LETTERS.iter().find(|(it, _)| *it == letter);
    kind.or_else(|| scattering().map(|(_, scattering)| Letter::Scattering(scattering.0)))
}
