//! The attributes in an OpenEXR file's header that hold a picture's [`Metadata`].
//!
//! By pbrt's and the standard's names: `samplesPerPixel` (int), `renderTimeSeconds` (float), `worldToCamera` (m44f),
//! `integrator` and `software` (string), and, as no integer of the format holds 64 bits, `seed` (decimal) and
//! `sceneHash` (hexadecimal) as strings; and the strings of Cryptomatte layers, `cryptomatte/…`.
//!
//! `worldToCamera` follows the OpenEXR standard and its matrix library, Imath: points are row vectors, `p' = p M`,
//! so that a translation stands in the last row; camera space is left-handed with x to the right, y up and z into the
//! picture. [`Metadata`] has column vectors and a z axis that points backwards, so the matrix is transposed and its z
//! negated on the way. (pbrt stores its column-vector matrix as it is, the transpose of what the standard says.)
//!
//! Source: "Standard Attributes" of the OpenEXR documentation, version 3.

use std::path::Path;

use exr::prelude::{AttributeValue, LayerAttributes, Text};

use crate::film::Metadata;
use crate::output::OutputError;

/// The attributes for `metadata`; `path` is for messages.
pub(super) fn from_metadata(path: &Path, metadata: &Metadata) -> Result<LayerAttributes, OutputError> {
    let samples = i32::try_from(metadata.samples_per_pixel).map_err(|_| {
        let problem = format!("OpenEXR cannot hold {} samples per pixel", metadata.samples_per_pixel);
        OutputError::new(path, problem, format!("take at most {} samples per pixel", i32::MAX))
    })?;
    let mut attributes = LayerAttributes {
        software_name: Some(Text::from(concat!("halfdome ", env!("CARGO_PKG_VERSION")))),
        world_to_camera: metadata.world_to_camera.map(to_imath),
        ..LayerAttributes::default()
    };
    attributes.other.extend([
        (Text::from("samplesPerPixel"), AttributeValue::I32(samples)),
        (Text::from("renderTimeSeconds"), AttributeValue::F32(metadata.render_time_seconds)),
        (Text::from("seed"), AttributeValue::Text(Text::from(metadata.seed.to_string().as_str()))),
        (Text::from("sceneHash"), AttributeValue::Text(Text::from(format!("{:016x}", metadata.scene_hash).as_str()))),
    ]);
    if !metadata.integrator.is_empty() {
        attributes
            .other
            .insert(Text::from("integrator"), AttributeValue::Text(super::text(path, &metadata.integrator)?));
    }
    for (name, value) in &metadata.attributes {
        attributes.other.insert(super::text(path, name)?, AttributeValue::Text(Text::from(value.as_str())));
    }
    Ok(attributes)
}

/// The metadata in `attributes`; what is not there is as in `Metadata::default()`, what is of another type an error.
pub(super) fn to_metadata(path: &Path, attributes: &LayerAttributes) -> Result<Metadata, OutputError> {
    let wrong = |name: &str, remedy: &str| {
        OutputError::new(path, format!("the attribute {name} has a value of the wrong kind"), remedy)
    };
    let other = |name: &str| attributes.other.get(name.as_bytes());
    let number = |name: &str, radix: u32, remedy: &str| match other(name) {
        None => Ok(0),
        Some(AttributeValue::Text(digits)) => {
            u64::from_str_radix(&digits.to_string(), radix).map_err(|_| wrong(name, remedy))
        }
        Some(_) => Err(wrong(name, remedy)),
    };
    Ok(Metadata {
        samples_per_pixel: match other("samplesPerPixel") {
            None => 0,
            Some(&AttributeValue::I32(samples)) if samples >= 0 => samples.unsigned_abs(),
            Some(_) => return Err(wrong("samplesPerPixel", "store an int of at least 0")),
        },
        render_time_seconds: match other("renderTimeSeconds") {
            None => 0.0,
            Some(&AttributeValue::F32(seconds)) => seconds,
            Some(_) => return Err(wrong("renderTimeSeconds", "store a float")),
        },
        world_to_camera: attributes.world_to_camera.map(from_imath),
        seed: number("seed", 10, "store a decimal number of up to 64 bits as a string")?,
        scene_hash: number("sceneHash", 16, "store up to 16 hexadecimal digits as a string")?,
        integrator: match other("integrator") {
            None => String::new(),
            Some(AttributeValue::Text(name)) => name.to_string(),
            Some(_) => return Err(wrong("integrator", "store a string")),
        },
        attributes: attributes.other.iter().filter_map(|(name, value)| further(name, value)).collect(),
    })
}

/// The name and value of a further attribute that pictures keep.
fn further(name: &Text, value: &AttributeValue) -> Option<(String, String)> {
    let name = name.to_string();
    let AttributeValue::Text(value) = value else { return None };
    name.starts_with("cryptomatte/").then(|| (name, value.to_string()))
}

/// From rows of a matrix for column vectors, z backwards, to rows of one for row vectors, z forwards.
fn to_imath(rows: [[f32; 4]; 4]) -> [f32; 16] {
    core::array::from_fn(|i| {
        let (row, column) = (i % 4, i / 4);
        if row == 2 { -rows[row][column] } else { rows[row][column] }
    })
}

/// The inverse of [`to_imath`].
fn from_imath(matrix: [f32; 16]) -> [[f32; 4]; 4] {
    core::array::from_fn(|row| {
        core::array::from_fn(|column| {
            let value = matrix[4 * column + row];
            if row == 2 { -value } else { value }
        })
    })
}

/// Sorts the attributes in the header by name, as OpenEXR's own library writes them. The encoder keeps some of them in
/// a hash map, whose order differs from one run to the next.
///
/// After 8 bytes of magic number and version, an attribute is a name and a type, both ended by a zero byte, a 32-bit
/// size and so many bytes; a zero byte ends the header.
pub(super) fn sort(file: &mut [u8]) {
    let header = &file[8..];
    let mut attributes = Vec::new();
    let mut start = 0;
    while header[start] != 0 {
        let length_to_zero = |from: usize| header[from..].iter().take_while(|&&byte| byte != 0).count();
        let kind = start + length_to_zero(start) + 1;
        let size = kind + length_to_zero(kind) + 1;
        let bytes = [header[size], header[size + 1], header[size + 2], header[size + 3]];
        let end = size + 4 + u32::from_le_bytes(bytes) as usize;
        attributes.push(&header[start..end]);
        start = end;
    }
    // A name is unique and ends in zero: so whole attributes compare as their names do.
    attributes.sort_unstable();
    let sorted = attributes.concat();
    file[8..][..sorted.len()].copy_from_slice(&sorted);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_camera_matrix_is_the_standards() {
        // A camera at (1, 2, 3) that looks along -z with y up, as at the identity.
        let rows = [[1.0, 0.0, 0.0, -1.0], [0.0, 1.0, 0.0, -2.0], [0.0, 0.0, 1.0, -3.0], [0.0, 0.0, 0.0, 1.0]];
        let matrix = to_imath(rows);
        let transform = |point: [f32; 3]| -> [f32; 3] {
            let [x, y, z] = point;
            core::array::from_fn(|i| x * matrix[i] + y * matrix[4 + i] + z * matrix[8 + i] + matrix[12 + i])
        };
        assert_eq!(transform([1.0, 2.0, -7.0]), [0.0, 0.0, 10.0], "ten in front");
        assert_eq!(transform([5.0, 2.0, 3.0]), [4.0, 0.0, 0.0], "to the right");
        assert_eq!(transform([1.0, 9.0, 3.0]), [0.0, 7.0, 0.0], "above");
        assert_eq!(from_imath(matrix), rows);
        let numbered = core::array::from_fn(|row| core::array::from_fn(|column| (4 * row + column) as f32));
        assert_eq!(from_imath(to_imath(numbered)), numbered);
    }

    #[test]
    fn sorting_moves_whole_attributes() {
        let header = |attributes: [&[u8]; 3]| [b"magic+v2", attributes.concat().as_slice(), b"\0pixels"].concat();
        let (a, ab, z) = (b"a\0int\0\x04\0\0\0\0\0\0\x07", b"ab\0string\0\x02\0\0\0\0\0", b"z\0box\0\0\0\0\0");
        let mut file = header([z, ab, a]);
        sort(&mut file);
        assert_eq!(file, header([a, ab, z]));
    }

    #[test]
    fn attributes_of_the_wrong_kind_are_named() {
        for (name, value, remedy) in [
            ("samplesPerPixel", AttributeValue::I32(-1), "store an int of at least 0"),
            ("renderTimeSeconds", AttributeValue::I32(1), "store a float"),
            ("seed", AttributeValue::Text(Text::from("x")), "store a decimal number of up to 64 bits as a string"),
            ("sceneHash", AttributeValue::I32(1), "store up to 16 hexadecimal digits as a string"),
            ("integrator", AttributeValue::F32(1.0), "store a string"),
        ] {
            let mut attributes = LayerAttributes::default();
            attributes.other.insert(Text::from(name), value);
            let error = to_metadata(Path::new("a.exr"), &attributes).unwrap_err();
            let problem = format!("the attribute {name} has a value of the wrong kind");
            assert_eq!(error, OutputError::new(Path::new("a.exr"), problem, remedy));
        }
        assert_eq!(to_metadata(Path::new("a.exr"), &LayerAttributes::default()), Ok(Metadata::default()));
    }
}
