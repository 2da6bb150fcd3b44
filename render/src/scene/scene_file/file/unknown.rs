//! What a scene file has outside of its sections: a misspelt section, or a key.

use toml::de::DeValue;

use super::{Parser, SECTIONS, TABLES};
use crate::scene::nearest::suggestion;
use crate::scene::scene_file::toml_text::{Entry, shortened};
use crate::scene::{Overrides, SceneError};

impl Parser<'_> {
    /// The error about an entry of the whole file that is no known section: a section, or a key outside of all.
    pub(super) fn unknown(&self, entry: &Entry<'_>) -> SceneError {
        let name = entry.name;
        let is_section = match entry.value {
            DeValue::Table(_) => true,
            DeValue::Array(items) => items.iter().any(|item| matches!(item.get_ref(), DeValue::Table(_))),
            _ => false,
        };
        if is_section {
            let known = [SECTIONS, TABLES].concat();
            return self.error(entry.at.start, format!("unknown section {name:?}"), suggestion(name, &known));
        }
        let remedy = match SECTIONS.iter().find(|section| Overrides::keys(section).contains(&name)) {
            _ if ["file", "model"].contains(&name) => {
                let written = self.text.get(entry.value_at.clone()).unwrap_or_default();
                format!("name the model in its section: [scene] on a line, then file = {}", shortened(written))
            }
            Some(section) => format!("write it in its section: below [{section}]"),
            None => format!("every key is in a section: {}", SECTIONS.map(|section| format!("[{section}]")).join(", ")),
        };
        self.error(entry.at.start, format!("the key {name:?} is in no section"), remedy)
    }
}
