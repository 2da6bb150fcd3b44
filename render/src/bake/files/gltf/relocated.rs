//! References to files, which are relative to the folder of the file that has them.

use std::collections::BTreeMap;

use super::text;
use crate::bake::files::relocated::in_uri;

/// Where a file lists its photometric profiles.
pub(super) const PROFILES: [&str; 2] = ["extensions", "EXT_lights_ies"];

/// The JSON of a file whose references begin with these folders: those of buffers, pictures and photometric profiles.
pub(super) fn relocated(json: &str, folders: &[String]) -> String {
    if folders.is_empty() {
        return json.to_owned();
    }
    let prefix: String = folders.iter().map(|folder| in_uri(folder) + "/").collect();
    let mut relocated = with_uris(&with_uris(json, "buffers", &prefix), "images", &prefix);
    let profiles = PROFILES.iter().try_fold(relocated.as_str(), |object, name| text::member(object, name));
    if let Some(changed) = profiles.map(|profiles| with_uris(profiles, "lights", &prefix)) {
        relocated = text::set_at(&relocated, &PROFILES, &changed);
    }
    relocated
}

/// The object with this before the URI of each element of an array, if that is a relative path.
fn with_uris(object: &str, array: &str, prefix: &str) -> String {
    let elements = text::elements(text::member(object, array).unwrap_or("[]"));
    let changed = elements.iter().enumerate().filter_map(|(number, element)| {
        let uri: String = serde_json::from_str(text::member(element, "uri")?).ok()?;
        let is_relative = !uri.starts_with('/') && !uri.split('/').next().is_some_and(|start| start.contains(':'));
        is_relative.then(|| (number, text::set(element, "uri", &text::string(&format!("{prefix}{uri}")))))
    });
    let changed: BTreeMap<usize, String> = changed.collect();
    text::change_member(object, array, &changed, &[])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn relative_paths_alone_are_changed() {
        let json = r#"{ "buffers":[ {"uri":"a%20b.bin","x":1.00},{"byteLength":3} ],
            "images": [{"uri":"data:image/png;base64,AA=="}, {"name":"n","uri" : "t/c.png"}],
            "extensions":{"EXT_lights_ies":{"lights":[{"uri":"lamp.ies"}]}} }"#;
        let folders = ["..".to_owned(), "level one".to_owned()];
        let expected = json
            .replace("a%20b.bin", "../level%20one/a%20b.bin")
            .replace("t/c.png", "../level%20one/t/c.png")
            .replace("lamp.ies", "../level%20one/lamp.ies");
        assert_eq!(relocated(json, &folders), expected);
        assert_eq!(relocated(json, &[]), json);
        assert_eq!(relocated("{}", &folders), "{}");
    }
}
