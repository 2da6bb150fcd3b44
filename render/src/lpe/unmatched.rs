//! Labels in expressions that nothing in a scene has: misspelt ones, which would give black AOVs without a word.

use super::Expression;
use super::event::{Event, Pattern};

/// A label that no event has where an expression names it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Unmatched<'a> {
    /// The label.
    pub label: &'a str,
    /// Its place: 0 for the first label of an event.
    pub place: usize,
    pattern: &'a Pattern,
}

impl Unmatched<'_> {
    /// Whether its pattern is for events of this one's kind.
    pub(crate) fn is_for(&self, event: &Event) -> bool {
        self.pattern.has_kind_of(event)
    }
}

impl Expression {
    /// The labels that it names and that no event of their kind has in their place, each once for each kind.
    pub(crate) fn unmatched_labels(&self, events: &[Event]) -> Vec<Unmatched<'_>> {
        let mut unmatched: Vec<Unmatched> = Vec::new();
        self.node.patterns(&mut |pattern| {
            pattern.placed(&mut |place, label| {
                let is_same =
                    |it: &Unmatched| it.label == label && it.place == place && it.pattern.kind == pattern.kind;
                if !pattern.finds(events, place, label) && !unmatched.iter().any(is_same) {
                    unmatched.push(Unmatched { label, place, pattern });
                }
            });
        });
        unmatched
    }
}

impl Pattern {
    /// Visits the labels that it names, with their places.
    fn placed<'a>(&'a self, visit: &mut dyn FnMut(usize, &'a str)) {
        for (place, choice) in self.labels.iter().enumerate() {
            choice.symbols(&mut |label| visit(place, label));
        }
    }

    /// Whether an event of its kind has this label in this place. Scattering depends on materials, and is ignored.
    fn finds(&self, events: &[Event], place: usize, label: &str) -> bool {
        events.iter().any(|event| self.has_kind_of(event) && event.labels.get(place).is_some_and(|it| it == label))
    }
}
