//! Elements of a PLY file, value by value: words of a line, or bytes of either order.

use ply_rs_bw::ply::{ElementDef, PropertyType, ScalarType};

use super::{INDICES, TEXCOORDS};
use crate::scene::formats::decimal;

/// The data read from an element.
#[derive(Default)]
pub(super) struct Row {
    /// Position, normal, texture coordinates.
    pub(super) numbers: [f32; 8],
    /// The vertex indices of a face.
    pub(super) corners: Vec<i64>,
}

/// A property.
pub(super) struct Field {
    role: Role,
    /// The type of a list's length.
    length: Option<ScalarType>,
    scalar: ScalarType,
}

/// The use of a property.
#[derive(Clone, Copy)]
enum Role {
    Passed,
    /// The number at this place of the row.
    Number(usize),
    Corners,
}

/// The values of elements that follow each other.
pub(super) trait Values<'a> {
    /// A reader of all elements in `bytes`.
    fn new(bytes: &'a [u8]) -> Self;

    /// Goes to the next element.
    fn begin_element(&mut self);

    /// The next value as a number; `None` if it is missing or not one.
    fn number(&mut self, kind: &ScalarType) -> Option<f32>;

    /// The next value as a whole number; `None` if it is missing or not one.
    fn whole(&mut self, kind: &ScalarType) -> Option<i64>;

    /// Passes over so many values; `None` if they are not there.
    fn skip(&mut self, kind: &ScalarType, count: usize) -> Option<()>;
}

impl Field {
    /// The properties of an element, in order.
    pub(super) fn all(element: &ElementDef) -> Vec<Self> {
        let field = |(name, kind): (&str, &PropertyType)| match kind {
            PropertyType::Scalar(scalar) => {
                let role = place(name).map_or(Role::Passed, Role::Number);
                Self { role, length: None, scalar: scalar.clone() }
            }
            PropertyType::List(length, scalar) => {
                let role = if INDICES.contains(&name) { Role::Corners } else { Role::Passed };
                Self { role, length: Some(length.clone()), scalar: scalar.clone() }
            }
        };
        element.properties.iter().map(|(name, property)| field((name, &property.data_type))).collect()
    }

    /// Its size in bytes; `None` for a list.
    pub(super) fn size(&self) -> Option<usize> {
        self.length.is_none().then(|| size(&self.scalar))
    }

    /// Passes over it; `None` if it is not there.
    pub(super) fn skip<'a>(&self, values: &mut impl Values<'a>) -> Option<()> {
        let count = match &self.length {
            Some(length) => usize::try_from(values.whole(length)?).ok()?,
            None => 1,
        };
        values.skip(&self.scalar, count)
    }
}

impl Row {
    /// Reads an element; `None` if something is missing or not what it should be.
    pub(super) fn read<'a>(&mut self, values: &mut impl Values<'a>, fields: &[Field]) -> Option<()> {
        for field in fields {
            match field.role {
                Role::Passed => field.skip(values)?,
                Role::Number(place) => self.numbers[place] = values.number(&field.scalar)?,
                Role::Corners => {
                    let count = values.whole(field.length.as_ref()?).filter(|count| *count >= 0)?;
                    self.corners.clear();
                    for _ in 0..count {
                        self.corners.push(values.whole(&field.scalar)?);
                    }
                }
            }
        }
        Some(())
    }
}

/// The place of a vertex's property in a row.
fn place(name: &str) -> Option<usize> {
    let place = ["x", "y", "z", "nx", "ny", "nz"].iter().position(|known| *known == name);
    let texcoord = |place: usize| TEXCOORDS.iter().any(|names| names[place] == name).then_some(6 + place);
    place.or_else(|| texcoord(0)).or_else(|| texcoord(1))
}

/// The size of a value in bytes.
pub(super) fn size(kind: &ScalarType) -> usize {
    match kind {
        ScalarType::Char | ScalarType::UChar => 1,
        ScalarType::Short | ScalarType::UShort => 2,
        ScalarType::Int | ScalarType::UInt | ScalarType::Float => 4,
        ScalarType::Double => 8,
    }
}

/// Words of ASCII, where each line is an element.
pub(super) struct Words<'a> {
    line: &'a [u8],
    rest: &'a [u8],
}

impl<'a> Words<'a> {
    fn word(&mut self) -> Option<&'a [u8]> {
        self.line = self.line.trim_ascii_start();
        let end = self.line.iter().position(u8::is_ascii_whitespace).unwrap_or(self.line.len());
        let (word, rest) = self.line.split_at(end);
        self.line = rest;
        (!word.is_empty()).then_some(word)
    }
}

impl<'a> Values<'a> for Words<'a> {
    fn new(bytes: &'a [u8]) -> Self {
        Self { line: &[], rest: bytes }
    }

    fn begin_element(&mut self) {
        let end = self.rest.iter().position(|byte| *byte == b'\n').map_or(self.rest.len(), |newline| newline + 1);
        (self.line, self.rest) = self.rest.split_at(end);
    }

    fn number(&mut self, _: &ScalarType) -> Option<f32> {
        self.line = self.line.trim_ascii_start();
        match decimal::prefix(self.line) {
            Some((number, length)) if self.line.get(length).is_none_or(u8::is_ascii_whitespace) => {
                self.line = &self.line[length..];
                Some(number)
            }
            // Infinity and NaN are invalid in a file.
            _ => decimal::parse(self.word().filter(|word| word.iter().all(|byte| b"+-.0123456789eE".contains(byte)))?),
        }
    }

    fn whole(&mut self, _: &ScalarType) -> Option<i64> {
        let word = self.word()?;
        // Most are short.
        if word.len() < 10 && word.iter().all(u8::is_ascii_digit) {
            return Some(word.iter().fold(0, |number, digit| 10 * number + i64::from(digit - b'0')));
        }
        str::from_utf8(word).ok()?.parse().ok()
    }

    fn skip(&mut self, _: &ScalarType, count: usize) -> Option<()> {
        (0..count).try_for_each(|_| self.word().map(drop))
    }
}

/// Binary values, the most significant byte first or last.
pub(super) struct Bytes<'a, const BIG: bool>(pub(super) &'a [u8]);

impl<const BIG: bool> Bytes<'_, BIG> {
    fn take<const N: usize>(&mut self) -> Option<[u8; N]> {
        let (bytes, rest) = self.0.split_first_chunk::<N>()?;
        self.0 = rest;
        let mut bytes = *bytes;
        if BIG {
            bytes.reverse();
        }
        Some(bytes)
    }
}

impl<'a, const BIG: bool> Values<'a> for Bytes<'a, BIG> {
    fn new(bytes: &'a [u8]) -> Self {
        Self(bytes)
    }

    fn begin_element(&mut self) {}

    fn number(&mut self, kind: &ScalarType) -> Option<f32> {
        match kind {
            ScalarType::Float => self.take().map(f32::from_le_bytes),
            ScalarType::Double => self.take().map(|bytes| f64::from_le_bytes(bytes) as f32),
            _ => self.whole(kind).map(|number| number as f32),
        }
    }

    fn whole(&mut self, kind: &ScalarType) -> Option<i64> {
        match kind {
            ScalarType::Char => self.take().map(|bytes| i8::from_le_bytes(bytes).into()),
            ScalarType::UChar => self.take().map(|bytes| u8::from_le_bytes(bytes).into()),
            ScalarType::Short => self.take().map(|bytes| i16::from_le_bytes(bytes).into()),
            ScalarType::UShort => self.take().map(|bytes| u16::from_le_bytes(bytes).into()),
            ScalarType::Int => self.take().map(|bytes| i32::from_le_bytes(bytes).into()),
            ScalarType::UInt => self.take().map(|bytes| u32::from_le_bytes(bytes).into()),
            ScalarType::Float | ScalarType::Double => None,
        }
    }

    fn skip(&mut self, kind: &ScalarType, count: usize) -> Option<()> {
        self.0 = self.0.get(count.checked_mul(size(kind))?..)?;
        Some(())
    }
}
