//! Light path expressions: they assign the light of a picture to AOVs.
//!
//! A light path is a word: the camera, an event at each surface, and the light. An [`Expression`] is a regular
//! expression of such words, in the language of Open Shading Language, and an automaton (`automaton.rs`) follows a path
//! through all expressions of a picture at once: a path carries one number, its state.
//!
//! Sources: Heckbert, "Adaptive Radiosity Textures for Bidirectional Ray Tracing" (1990), for the notation; the Open
//! Shading Language (Academy Software Foundation), `lpeparse.cpp`, for the language; Thompson (1968) and Rabin and
//! Scott (1959) for the automata.

mod automaton;
mod event;
mod parse;
#[cfg(test)]
mod tests;
mod unmatched;

pub(crate) use automaton::{Alphabet, Automaton};
use event::Pattern;
pub use event::{Event, Kind, Scattering};
pub use parse::LpeError;
pub(crate) use unmatched::Unmatched;

/// A light path expression.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Expression {
    text: String,
    node: Node,
}

/// A regular expression of events.
#[derive(Clone, Debug, PartialEq, Eq)]
enum Node {
    Event(Pattern),
    Sequence(Vec<Node>),
    Either(Vec<Node>),
    /// At least so many times, and at most, if there is a bound.
    Repeat(Box<Node>, u32, Option<u32>),
}

impl Expression {
    /// Parses an expression, for example `C<RD>.*L`.
    ///
    /// # Errors
    /// If it is not one; the error says where, and what would be right.
    pub fn parse(text: &str) -> Result<Self, LpeError> {
        Ok(Self { text: text.to_owned(), node: parse::parse(text)? })
    }

    /// All light of the lamps whose first label this is; never that of the sky.
    pub fn light_group(label: &str) -> Self {
        Self::all_light(format!("C.*<L.{label:?}>"), Pattern::light_group(label))
    }

    /// All light of the sky.
    pub fn sky() -> Self {
        Self::all_light("C.*B".to_owned(), Pattern::sky())
    }

    fn all_light(text: String, of: Pattern) -> Self {
        Self { text, node: Node::Sequence(vec![Node::Event(Pattern::camera()), Node::anything(), Node::Event(of)]) }
    }

    /// The text that it was parsed from.
    pub fn text(&self) -> &str {
        &self.text
    }
}

impl Node {
    fn anything() -> Self {
        Self::Repeat(Box::new(Self::Event(Pattern::default())), 0, None)
    }

    /// Visits the patterns of all events.
    fn patterns<'a>(&'a self, visit: &mut dyn FnMut(&'a Pattern)) {
        match self {
            Self::Event(pattern) => visit(pattern),
            Self::Sequence(nodes) | Self::Either(nodes) => nodes.iter().for_each(|node| node.patterns(visit)),
            Self::Repeat(node, ..) => node.patterns(visit),
        }
    }
}
