//! "Did you mean": the known word nearest to a misspelt one.

/// The entry of `known` nearest to `word` by Damerau and Levenshtein's distance, if it is near: at most a third of the
/// word's letters, and at least one, may differ. Case does not matter.
pub(crate) fn nearest<'a>(word: &str, known: &[&'a str]) -> Option<&'a str> {
    let word = word.to_lowercase();
    let allowed = (word.chars().count() / 3).max(1);
    let distances =
        known.iter().map(|&candidate| (strsim::damerau_levenshtein(&word, &candidate.to_lowercase()), candidate));
    distances.filter(|&(distance, _)| distance <= allowed).min_by_key(|&(distance, _)| distance).map(|(_, word)| word)
}

/// A remedy for an unknown `word`: the nearest of `known`, those that it is a part of, or all of them.
pub(super) fn suggestion(word: &str, known: &[&str]) -> String {
    let is_part = |name: &&&str| name.split('_').any(|part| part == word);
    let longer: Vec<String> = known.iter().filter(is_part).map(|name| format!("`{name}`")).collect();
    match (nearest(word, known), longer.as_slice()) {
        (Some(near), _) => format!("did you mean `{near}`?"),
        (None, []) if known.is_empty() => "there is none".to_owned(),
        (None, []) => format!("known are {}", known.join(", ")),
        (None, [names @ .., last]) if !names.is_empty() => format!("did you mean {} or {last}?", names.join(", ")),
        (None, [name, ..]) => format!("did you mean {name}?"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn near_words_are_named_and_far_ones_get_the_list() {
        let known = ["width", "height", "filter", "filter_width"];
        assert_eq!(nearest("widht", &known), Some("width"));
        assert_eq!(nearest("Filter", &known), Some("filter"));
        assert_eq!(nearest("Flor", &["Ceiling", "Floor"]), Some("Floor"));
        assert_eq!(nearest("filterwidth", &known), Some("filter_width"));
        assert_eq!(nearest("resolution", &known), None);
        assert_eq!(nearest("", &known), None);
        assert_eq!(suggestion("heigth", &known), "did you mean `height`?");
        assert_eq!(suggestion("roughness", &["specular_roughness"]), "did you mean `specular_roughness`?");
        let known_roughnesses = ["coat_roughness", "roughness_map", "weight"];
        assert_eq!(suggestion("roughness", &known_roughnesses), "did you mean `coat_roughness` or `roughness_map`?");
        assert_eq!(suggestion("bokeh", &[]), "there is none");
        assert_eq!(suggestion("bokeh", &known), "known are width, height, filter, filter_width");
    }
}
