//! Changes to JSON as text: unchanged content keeps its bytes: numbers, escapes, spaces and the order of members.
//!
//! A value is the text that stands for it. `serde_json` finds where members and elements begin and end (`RawValue`
//! borrows from the text); here strings are cut and joined. Texts are valid JSON of the kind that a function expects,
//! as the file has been parsed before; others are treated as empty.

use std::collections::BTreeMap;
use std::fmt;
use std::ops::Range;

use serde::Deserialize;
use serde::de::{Deserializer, MapAccess, Visitor};
use serde_json::value::RawValue;

/// An object's members in their order.
struct Members<'a>(Vec<(String, &'a RawValue)>);

impl<'a> Deserialize<'a> for Members<'a> {
    fn deserialize<D: Deserializer<'a>>(deserializer: D) -> Result<Self, D::Error> {
        struct Collect;
        impl<'a> Visitor<'a> for Collect {
            type Value = Members<'a>;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("an object")
            }

            fn visit_map<A: MapAccess<'a>>(self, mut map: A) -> Result<Members<'a>, A::Error> {
                let mut members = Vec::new();
                while let Some(member) = map.next_entry()? {
                    members.push(member);
                }
                Ok(Members(members))
            }
        }
        deserializer.deserialize_map(Collect)
    }
}

/// The members of `object` in their order.
pub(super) fn members(object: &str) -> Vec<(String, &str)> {
    let members = serde_json::from_str::<Members>(object).map_or(Vec::new(), |members| members.0);
    members.into_iter().map(|(name, value)| (name, value.get())).collect()
}

/// The member `name` of `object`.
pub(super) fn member<'a>(object: &'a str, name: &str) -> Option<&'a str> {
    members(object).into_iter().find(|(other, _)| other == name).map(|(_, value)| value)
}

/// The elements of `array` in their order.
pub(super) fn elements(array: &str) -> Vec<&str> {
    let elements = serde_json::from_str::<Vec<&RawValue>>(array).unwrap_or_default();
    elements.into_iter().map(RawValue::get).collect()
}

/// `object` with `value` as its member `name`: in the place of the old one, or at the end.
pub(super) fn set(object: &str, name: &str, value: &str) -> String {
    match member(object, name) {
        Some(old) => splice(object, [(span(object, old), value.to_owned())]),
        None => {
            let last = members(object).last().map(|(_, last)| span(object, last).end);
            let (at, comma) = last.map_or((object.find('{').map_or(0, |brace| brace + 1), ""), |end| (end, ","));
            splice(object, [(at..at, format!("{comma}{}:{value}", string(name)))])
        }
    }
}

/// `object` with `value` as the member that `path` leads to; objects that are missing on the way are made.
pub(super) fn set_at(object: &str, path: &[&str], value: &str) -> String {
    match path {
        [] => value.to_owned(),
        [name, rest @ ..] => set(object, name, &set_at(member(object, name).unwrap_or("{}"), rest, value)),
    }
}

/// `object` without its member `name`. The others keep their bytes, but not what is between them.
pub(super) fn without(object: &str, name: &str) -> String {
    let kept = members(object).into_iter().filter(|(other, _)| other != name);
    let kept: Vec<String> = kept.map(|(name, value)| format!("{}:{value}", string(&name))).collect();
    format!("{{{}}}", kept.join(","))
}

/// `array` with some elements replaced by others, and more at the end.
pub(super) fn change(array: &str, replaced: &BTreeMap<usize, String>, more: &[String]) -> String {
    let old = elements(array);
    let replacements =
        replaced.iter().filter_map(|(&index, new)| old.get(index).map(|old| (span(array, old), new.clone())));
    let end = old.last().map(|last| span(array, last).end);
    let (at, comma) = end.map_or((array.find('[').map_or(0, |bracket| bracket + 1), ""), |end| (end, ","));
    let more = (!more.is_empty()).then(|| (at..at, format!("{comma}{}", more.join(","))));
    splice(array, replacements.chain(more))
}

/// `object` with `change`d elements of the array that is its member `name`, which is made if it is missing.
pub(super) fn change_member(object: &str, name: &str, replaced: &BTreeMap<usize, String>, more: &[String]) -> String {
    if replaced.is_empty() && more.is_empty() {
        return object.to_owned();
    }
    set(object, name, &change(member(object, name).unwrap_or("[]"), replaced, more))
}

/// `text` as a JSON string.
pub(super) fn string(text: &str) -> String {
    serde_json::Value::from(text).to_string()
}

/// Where `part`, which is borrowed from `text`, is in it.
fn span(text: &str, part: &str) -> Range<usize> {
    let start = part.as_ptr().addr() - text.as_ptr().addr();
    start..start + part.len()
}

/// `text` with the contents of some ranges replaced, which are given in their order.
fn splice(text: &str, edits: impl IntoIterator<Item = (Range<usize>, String)>) -> String {
    let (mut result, mut done) = (String::with_capacity(text.len()), 0);
    for (range, new) in edits {
        result.push_str(&text[done..range.start]);
        result.push_str(&new);
        done = range.end;
    }
    result + &text[done..]
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = r#" { "a" : 1.00e+2, "b":{ "\u00e9" : [ ] ,"c":null }, "d":[ 1,"x\/y" , {} ] } "#;

    #[test]
    fn members_and_elements_are_found_as_they_are_written() {
        let names: Vec<(String, &str)> = members(TEXT);
        let expected = [("a", "1.00e+2"), ("b", r#"{ "\u00e9" : [ ] ,"c":null }"#), ("d", r#"[ 1,"x\/y" , {} ]"#)];
        assert_eq!(names, expected.map(|(name, value)| (name.to_owned(), value)));
        assert_eq!(member(expected[1].1, "é"), Some("[ ]"));
        assert_eq!(elements(expected[2].1), ["1", r#""x\/y""#, "{}"]);
        assert_eq!((members("3"), elements("{}")), (Vec::new(), Vec::new()));
    }

    #[test]
    fn what_is_not_changed_keeps_its_bytes() {
        assert_eq!(set(TEXT, "a", "7"), TEXT.replace("1.00e+2", "7"));
        assert_eq!(set(TEXT, "e\"", "7"), TEXT.replace(" ] } ", r#" ],"e\"":7 } "#));
        assert_eq!(set(" { } ", "a", "7"), r#" {"a":7 } "#);
        assert_eq!(set_at(TEXT, &["b", "f", "g"], "7"), TEXT.replace("null", r#"null,"f":{"g":7}"#));
        assert_eq!(without(TEXT, "d"), r#"{"a":1.00e+2,"b":{ "\u00e9" : [ ] ,"c":null }}"#);
    }

    #[test]
    fn arrays_are_changed_and_grow() {
        let (one, none) = (BTreeMap::from([(1, "2".to_owned())]), BTreeMap::new());
        let more = ["3".to_owned(), "4".to_owned()];
        assert_eq!(change_member(TEXT, "d", &one, &more), TEXT.replace(r#""x\/y" , {}"#, "2 , {},3,4"));
        assert_eq!(change("[ ]", &none, &more), "[3,4 ]");
        assert_eq!(change_member("{}", "d", &none, &more), r#"{"d":[3,4]}"#);
        assert_eq!(change_member(TEXT, "z", &none, &[]), TEXT);
    }
}
