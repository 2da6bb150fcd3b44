//! TOML values with their positions in the text.

use std::borrow::Cow;
use std::ops::Range;

use toml::de::{DeTable, DeValue};

use super::value::Value;

/// A key or section with its value, and their positions in the text.
pub(crate) struct Entry<'a> {
    pub(crate) name: &'a str,
    pub(crate) at: Range<usize>,
    pub(crate) value: &'a DeValue<'a>,
    pub(crate) value_at: Range<usize>,
}

/// The entries of a table in the order of the text.
pub(super) fn entries<'a>(table: &'a DeTable<'a>) -> Vec<Entry<'a>> {
    let entry = |(key, value): (&'a toml::Spanned<_>, &'a toml::Spanned<_>)| {
        let name: &Cow<'_, str> = key.get_ref();
        Entry { name, at: key.span(), value: value.get_ref(), value_at: value.span() }
    };
    let mut entries: Vec<_> = table.iter().map(entry).collect();
    entries.sort_by_key(|entry| entry.at.start);
    entries
}

pub(super) fn value_of(value: &DeValue<'_>) -> Value {
    match value {
        DeValue::String(text) => Value::Text(text.clone().into_owned()),
        DeValue::Integer(integer) => {
            i128::from_str_radix(integer.as_str(), integer.radix()).map_or(Value::Other, Value::Integer)
        }
        DeValue::Float(float) => float.as_str().parse().map_or(Value::Other, Value::Number),
        DeValue::Array(values) => Value::List(values.iter().map(|value| value_of(value.get_ref())).collect()),
        DeValue::Boolean(flag) => Value::Boolean(*flag),
        DeValue::Datetime(_) | DeValue::Table(_) => Value::Other,
    }
}

/// The line, from 1, of the byte at `offset`.
pub(super) fn line_of(text: &[u8], offset: usize) -> usize {
    1 + text.iter().take(offset).filter(|&&byte| byte == b'\n').count()
}

/// The first line of `text`, at most 40 characters of it.
pub(super) fn shortened(text: &str) -> String {
    let line = text.lines().next().unwrap_or_default();
    let short: String = line.chars().take(40).collect();
    if short.len() < text.len() { format!("{short}...") } else { short }
}
