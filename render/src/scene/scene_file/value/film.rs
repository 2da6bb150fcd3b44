//! Values of options about channels of the film.

use super::{Reading, Value, expected};
use crate::settings::{Cryptomatte, MatteKind};

/// The names that Cryptomatte layers distinguish.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MatteKinds(pub Vec<MatteKind>);

/// One kind, or a list of them.
pub(in crate::scene) fn matte_kinds(value: &Value) -> Reading<MatteKinds> {
    let names = match value {
        Value::List(values) => values.clone(),
        Value::Text(text) => text.split(',').map(|name| Value::Text(name.trim().to_owned())).collect(),
        _ => return expected("object, material or object,material"),
    };
    let known = MatteKind::ALL.map(|kind| (kind.name(), kind));
    let kinds = names.iter().map(|name| name.one_of(&known)).collect::<Reading<Vec<_>>>()?;
    let is_twice = kinds.iter().enumerate().any(|(number, kind)| kinds[..number].contains(kind));
    if is_twice { expected("each of object and material once") } else { Ok(MatteKinds(kinds)) }
}

/// How many names a pixel has.
pub(in crate::scene) fn matte_levels(value: &Value) -> Reading<u32> {
    let most = Cryptomatte::MAX_LEVELS;
    let levels = value.integer::<u32>().filter(|levels| (1..=most).contains(levels));
    levels.map_or_else(|| expected(format!("a whole number from 1 to {most}")), Ok)
}
