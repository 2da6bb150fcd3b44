//! Checks of a PLY file's header: required elements, and counts that the file's length allows.

use std::io::ErrorKind;

use ply_rs_bw::parser::ParseError;
use ply_rs_bw::ply::{Encoding, Header, PropertyType, ScalarType};

use super::values::size;
use super::{File, INDICES};
use crate::scene::{Place, SceneError};

impl File<'_> {
    pub(super) fn header_error(&self, error: &ParseError) -> SceneError {
        const REMEDY: &str = "the header goes from `ply` to `end_header`: format, elements and their properties";
        match error.line() {
            Some(line) if error.kind() != ErrorKind::UnexpectedEof => {
                let text = self.line(line);
                self.error(Place::Line(line), format!("`{text}` does not belong in the header of a PLY file"), REMEDY)
            }
            _ if error.kind() == ErrorKind::InvalidInput => {
                self.error(Place::File, "the header has no line with a valid `format`", "write `format ascii 1.0`")
            }
            _ => self.error(Place::File, "the header does not end, or is not text", REMEDY),
        }
    }

    /// Whether the elements and properties that a mesh needs are there, with types that make sense.
    pub(super) fn check_header(&self, header: &Header) -> Result<(), SceneError> {
        let element = |name: &str, property: &str| {
            header.elements.get(name).ok_or_else(|| {
                self.error(
                    Place::File,
                    format!("there is no element `{name}`"),
                    format!("declare `element {name}` with {property}"),
                )
            })
        };
        let vertex = element("vertex", "x, y and z")?;
        for name in ["x", "y", "z"] {
            match vertex.properties.get(name).map(|property| &property.data_type) {
                Some(PropertyType::Scalar(_)) => {}
                _ => {
                    let problem = format!("there is no number `{name}`");
                    let remedy = format!("declare `property float {name}`");
                    return Err(self.error(Place::Part("element `vertex`".to_owned()), problem, remedy));
                }
            }
        }
        let face = element("face", "a list of vertex_indices")?;
        let list = INDICES.iter().find_map(|&name| face.properties.get(name)).map(|property| &property.data_type);
        if !matches!(list, Some(PropertyType::List(length, index)) if is_integer(length) && is_integer(index)) {
            return Err(self.error(
                Place::Part("element `face`".to_owned()),
                "there is no list of whole numbers `vertex_indices` or `vertex_index`",
                "declare `property list uchar int vertex_indices`",
            ));
        }
        Ok(())
    }

    /// Whether everything is declared once. The crate keeps the last of two declarations, and would misread the data.
    pub(super) fn check_declarations(&self, header: &Header, text: &[u8]) -> Result<(), SceneError> {
        let declared = |keyword: &[u8]| {
            let keywords = text.split(|&byte| byte == b'\n').map(|line| line.split(u8::is_ascii_whitespace).next());
            keywords.filter(|&first| first == Some(keyword)).count()
        };
        let properties = header.elements.values().map(|element| element.properties.len()).sum();
        for (keyword, distinct) in [("element", header.elements.len()), ("property", properties)] {
            if declared(keyword.as_bytes()) != distinct {
                let problem = format!("the header declares one {keyword} twice");
                return Err(self.error(Place::File, problem, "give each a name of its own"));
            }
        }
        Ok(())
    }

    /// Whether the lengths of all lists are whole numbers.
    pub(super) fn check_lengths_of_lists(&self, header: &Header) -> Result<(), SceneError> {
        for element in header.elements.values() {
            for (name, property) in &element.properties {
                if matches!(&property.data_type, PropertyType::List(length, _) if !is_integer(length)) {
                    let place = Place::Part(format!("element `{}`", element.name));
                    let problem = format!("the length of the list `{name}` is not a whole number");
                    return Err(self.error(place, problem, "declare it as `uchar`, `ushort` or `uint`"));
                }
            }
        }
        Ok(())
    }

    /// Whether what the header announces fits into the `available` bytes that follow it.
    pub(super) fn check_length(&self, header: &Header, available: usize) -> Result<(), SceneError> {
        let mut least = 0_usize;
        for element in header.elements.values() {
            if element.properties.is_empty() && element.count > 0 {
                let place = Place::Part(format!("element `{}`", element.name));
                return Err(self.error(place, "it has no properties", "declare a property, or no such element"));
            }
            let sizes = element.properties.values().map(|property| least_size(&property.data_type, header.encoding));
            least = least.saturating_add(element.count.saturating_mul(sizes.sum()));
        }
        // The last number of an ascii file needs no separator.
        if least > available + usize::from(header.encoding == Encoding::Ascii) {
            return Err(self.error(
                Place::File,
                format!(
                    "the file is cut short: the header announces at least {least} bytes of data, but {available} follow"
                ),
                "copy or export the model again",
            ));
        }
        Ok(())
    }
}

fn is_integer(scalar: &ScalarType) -> bool {
    !matches!(scalar, ScalarType::Float | ScalarType::Double)
}

/// The least number of bytes that a property takes: a digit and a separator, or its binary size.
fn least_size(property: &PropertyType, encoding: Encoding) -> usize {
    let (PropertyType::Scalar(scalar) | PropertyType::List(scalar, _)) = property;
    if encoding == Encoding::Ascii { 2 } else { size(scalar) }
}
