//! Values of scene files and command lines, with the types and ranges that options require.
//!
//! Both sources are read by the same functions, so that they accept the same values and give the same errors.

mod film;
mod integrating;
mod light;
mod optical;
mod picture;
mod shutter;
#[cfg(test)]
mod tests;

use glam::{Vec2, Vec3};
use halfdome_kernel::Quality;

use crate::scene::Sharing;
use crate::scene::nearest::nearest;

pub use film::MatteKinds;
pub(super) use film::{matte_kinds, matte_levels};
pub(crate) use integrating::accuracy;
pub(super) use integrating::*;
pub(crate) use light::*;
pub(super) use optical::*;
pub(super) use picture::*;
pub(super) use shutter::{shutter, shutter_keys, shutter_ramp};

/// A value whose meaning is not known yet.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Value {
    Integer(i128),
    Number(f64),
    Boolean(bool),
    Text(String),
    List(Vec<Value>),
    /// A kind that no option takes.
    Other,
}

/// The remedy for a wrong value.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("expected {0}")]
pub(crate) struct Expected(pub(crate) String);

type Reading<T> = Result<T, Expected>;

impl Value {
    /// The value of a command-line argument: a list if it has commas, else a number if it reads as one.
    fn from_argument(text: &str) -> Self {
        if text.contains(',') {
            return Self::List(text.split(',').map(Self::from_argument).collect());
        }
        let text = text.trim();
        let integer = text.parse().map(Self::Integer).ok();
        let number = || text.parse().map(Self::Number).ok();
        let boolean = || text.parse().map(Self::Boolean).ok();
        integer.or_else(number).or_else(boolean).unwrap_or_else(|| Self::Text(text.to_owned()))
    }

    /// The number, unless it is NaN or out of a 32-bit float's range.
    pub(crate) fn finite(&self) -> Option<f32> {
        let number = match self {
            Self::Integer(value) => *value as f32,
            Self::Number(value) => *value as f32,
            _ => return None,
        };
        number.is_finite().then_some(number)
    }

    /// The number in double precision.
    fn double(&self) -> Option<f64> {
        match self {
            Self::Integer(value) => Some(*value as f64),
            Self::Number(value) => Some(*value),
            _ => None,
        }
    }

    pub(super) fn three(&self) -> Option<Vec3> {
        let Self::List(values) = self else { return None };
        let [x, y, z] = values.as_slice() else { return None };
        Some(Vec3::new(x.finite()?, y.finite()?, z.finite()?))
    }

    /// Two numbers.
    fn two(&self) -> Option<Vec2> {
        let Self::List(values) = self else { return None };
        let [x, y] = values.as_slice() else { return None };
        Some(Vec2::new(x.finite()?, y.finite()?))
    }

    fn integer<T: TryFrom<i128>>(&self) -> Option<T> {
        let Self::Integer(value) = self else { return None };
        T::try_from(*value).ok()
    }

    /// What `named` makes of one of the names.
    fn named<T>(&self, names: &[&str], named: fn(&str) -> Option<T>) -> Reading<T> {
        let known: Vec<_> = names.iter().map(|&name| (name, name)).collect();
        self.one_of(&known).map(|name| named(name).expect("every listed name has a value"))
    }

    pub(super) fn one_of<T: Copy>(&self, known: &[(&str, T)]) -> Reading<T> {
        let Self::Text(text) = self else { return expected(list(known)) };
        let found = known.iter().find(|(name, _)| name == text);
        found.map_or_else(|| expected(meant(text, known)), |&(_, value)| Ok(value))
    }
}

/// Reads command-line arguments with `read`.
pub(crate) fn argument<T>(read: fn(&Value) -> Reading<T>) -> impl Fn(&str) -> Reading<T> + Clone {
    move |text| {
        // A name may look like a number or a list.
        let as_text = |error| read(&Value::Text(text.to_owned())).map_err(|_| error);
        read(&Value::from_argument(text)).or_else(as_text)
    }
}

fn expected<T>(what: impl Into<String>) -> Reading<T> {
    Err(Expected(what.into()))
}

fn list<T>(known: &[(&str, T)]) -> String {
    let names: Vec<_> = known.iter().map(|(name, _)| *name).collect();
    format!("one of {}", names.join(", "))
}

fn meant<T>(text: &str, known: &[(&str, T)]) -> String {
    let names: Vec<_> = known.iter().map(|(name, _)| *name).collect();
    match nearest(text, &names) {
        Some(near) => format!("{}; did you mean `{near}`?", list(known)),
        None => list(known),
    }
}

/// Any text.
pub(super) fn text(value: &Value) -> Reading<String> {
    match value {
        Value::Text(text) => Ok(text.clone()),
        _ => expected("text"),
    }
}

/// A point in space.
pub(crate) fn point(value: &Value) -> Reading<Vec3> {
    value.three().map_or_else(|| expected("three finite numbers x, y, z"), Ok)
}

/// A vector that has a direction.
pub(super) fn direction(value: &Value) -> Reading<Vec3> {
    match value.three() {
        Some(v) if v != Vec3::ZERO => Ok(v),
        _ => expected("three finite numbers x, y, z that are not all zero"),
    }
}

/// A field of view in degrees.
pub(super) fn vfov(value: &Value) -> Reading<f32> {
    match value.finite() {
        Some(degrees) if degrees > 0.0 && degrees < 180.0 => Ok(degrees),
        _ => expected("degrees, more than 0 and less than 180"),
    }
}

/// An angle.
pub(crate) fn degrees(value: &Value) -> Reading<f32> {
    value.finite().map_or_else(|| expected("a finite number of degrees"), Ok)
}

/// Something of which there is at least one.
pub(super) fn count(value: &Value) -> Reading<u32> {
    match value.integer() {
        Some(count @ 1..) => Ok(count),
        _ => expected(format!("a whole number from 1 to {}", u32::MAX)),
    }
}

/// Something of which there may be none.
pub(super) fn number(value: &Value) -> Reading<u32> {
    value.integer().map_or_else(|| expected(format!("a whole number from 0 to {}", u32::MAX)), Ok)
}

/// A seed.
pub(super) fn seed(value: &Value) -> Reading<u64> {
    value.integer().map_or_else(|| expected(format!("a whole number from 0 to {}", u64::MAX)), Ok)
}

/// A name, or several.
pub(super) fn names(value: &Value) -> Reading<Vec<String>> {
    match value {
        Value::List(values) if !values.is_empty() => values.iter().map(text).collect(),
        value => text(value).map(|name| vec![name]),
    }
}

/// Whether something is wanted.
pub(super) fn flag(value: &Value) -> Reading<bool> {
    match value {
        Value::Boolean(flag) => Ok(*flag),
        _ => expected("true or false"),
    }
}

/// The quality of a tree.
pub(crate) fn quality(value: &Value) -> Reading<Quality> {
    value.one_of(&Quality::ALL.map(|quality| (quality.name(), quality)))
}

/// Whether what is shown several times is kept once.
pub(crate) fn sharing(value: &Value) -> Reading<Sharing> {
    value.one_of(&[("auto", Sharing::Auto), ("always", Sharing::Always), ("never", Sharing::Never)])
}
