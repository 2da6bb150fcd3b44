//! Labels in expressions that nothing in a scene has: misspelt ones, which would give black AOVs without a word.

use super::Expression;
use super::event::{Event, Pattern};

impl Expression {
    /// The labels that it names and that no event of their kind has in their place, each once, with that place: 0 for
    /// the first label of an event.
    pub(crate) fn unmatched_labels(&self, events: &[Event]) -> Vec<(&str, usize)> {
        let mut unmatched = Vec::new();
        self.node.patterns(&mut |pattern| {
            pattern.placed(&mut |place, label| {
                if !pattern.finds(events, place, label) && !unmatched.contains(&(label, place)) {
                    unmatched.push((label, place));
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
