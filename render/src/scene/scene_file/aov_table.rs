//! `[[aov]]` in scene files: AOVs by light path expressions.
//!
//! ```toml
//! [[aov]]
//! name = "caustics"        # channels caustics.R, caustics.G, caustics.B
//! lpe = "C<RD><.S>+L"      # a light path expression
//! ```

use std::path::Path;

use toml::de::DeValue;

use super::table_reader::TableReader;
use super::toml_text::entries;
use crate::scene::error::SceneError;
use crate::scene::nearest::suggestion;
use crate::settings::Aov;

const KEYS: [&str; 2] = ["name", "lpe"];

/// The tables in an array called `aov`, of a scene file at `path` with this text.
pub(super) fn read(path: &Path, text: &str, tables: &DeValue<'_>, at: usize) -> Result<Vec<Aov>, SceneError> {
    let reader = TableReader { path, text, name: "aov" };
    let aovs = reader.tables(tables, at, |table, at| {
        let entries = entries(table);
        if let Some(entry) = entries.iter().find(|entry| !KEYS.contains(&entry.name)) {
            let problem = format!("unknown key {:?} in [[aov]]", entry.name);
            return Err(reader.error(entry.at.start, problem, suggestion(entry.name, &KEYS)));
        }
        let entry = |key: &str| entries.iter().find(|entry| entry.name == key);
        let text = |key: &str| match entry(key) {
            Some(entry) => reader.text_of(entry),
            None => Err(reader.error(at, format!("this AOV has no {key}"), format!("write {key} = \"…\""))),
        };
        let (name, expression) = (text("name")?, text("lpe")?);
        let at = entry("lpe").map_or(at, |entry| entry.at.start);
        Aov::new(&name, &expression).map_err(|error| reader.error(at, error.problem, error.remedy))
    })?;
    for (number, aov) in aovs.iter().enumerate() {
        if aovs[..number].iter().any(|other| other.name == aov.name) {
            return Err(reader.error(at, format!("two AOVs are called {:?}", aov.name), "give each a name of its own"));
        }
    }
    Ok(aovs)
}
