//! Collects skipped content, so that each kind becomes one warning that names the affected elements.

use std::collections::{BTreeMap, HashSet};
use std::path::Path;

/// The most names in one warning.
const MAX_NAMES: usize = 3;

/// Sentences, each with the parts of the file that it is about.
#[derive(Default)]
pub(crate) struct Notes {
    notes: BTreeMap<String, Places>,
}

/// The first few parts, and all of them.
#[derive(Default)]
struct Places {
    first: Vec<String>,
    all: HashSet<String>,
}

impl Notes {
    /// Notes that `what` is true of `place`.
    pub(crate) fn add(&mut self, what: impl Into<String>, place: impl Into<String>) {
        let places = self.notes.entry(what.into()).or_default();
        let place = place.into();
        if places.all.insert(place.clone()) && places.first.len() < MAX_NAMES {
            places.first.push(place);
        }
    }

    /// Notes that `what` is true of the file, unless places have been named already.
    pub(crate) fn add_unless_told(&mut self, what: &str) {
        self.notes.entry(what.to_owned()).or_default();
    }

    /// A warning for each sentence: "file: sentence: first, second and 3 more".
    pub(crate) fn warnings(self, path: &Path) -> impl Iterator<Item = String> {
        self.notes.into_iter().map(move |(what, places)| {
            let more = places.all.len() - places.first.len();
            let mut names = places.first.join(", ");
            if more > 0 {
                names += &format!(" and {more} more");
            }
            let (path, colon) = (path.display(), if names.is_empty() { "" } else { ": " });
            format!("{path}: {what}{colon}{names}")
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_kind_is_told_once_with_some_of_its_places() {
        let mut notes = Notes::default();
        for place in ["a", "b", "a", "c", "d", "e"] {
            notes.add("x is not read", place);
        }
        notes.add_unless_told("alone");
        notes.add_unless_told("x is not read");
        let warnings: Vec<_> = notes.warnings(Path::new("m.glb")).collect();
        assert_eq!(warnings, ["m.glb: alone", "m.glb: x is not read: a, b, c and 2 more"]);
    }
}
