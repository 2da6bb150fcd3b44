//! PLY (Turk, "The PLY polygon file format", 1994) in its three encodings, through the crate `ply-rs-bw`.
//!
//! Reads element `vertex` (`x y z`, `nx ny nz`, and `s t`, `u v` or `texture_u texture_v`) and element `face`
//! (`vertex_indices` or `vertex_index`), and passes over all else, colours included. Errors count vertices and faces
//! from 0, as the format does. Polygons are cut into triangles (`polygon.rs`).
//!
//! The crate trusts a header's counts, so they are compared with the file's length before any element is read.

use std::io::ErrorKind;
use std::path::Path;

use glam::{Vec2, Vec3};
use ply_rs_bw::parser::{ParseError, Parser, Reader};
use ply_rs_bw::ply::{
    ElementDef, Encoding, Header, Property, PropertyAccess, PropertyAccessResult, PropertyType, ScalarType,
};

use super::description::unit;
use super::error::count;
use super::polygon::Cutter;
use super::{Material, Mesh, Place, Scene, SceneError};

const TEXCOORDS: [[&str; 2]; 3] = [["s", "t"], ["u", "v"], ["texture_u", "texture_v"]];
const INDICES: [&str; 2] = ["vertex_indices", "vertex_index"];

/// Reads the PLY file in `bytes` as one mesh.
pub(super) fn read(path: &Path, bytes: &[u8]) -> Result<Scene, SceneError> {
    let file = File { path, bytes };
    let mut reader = Reader::new(bytes);
    let header = Parser::<Ignored>::new().read_header(&mut reader).map_err(|error| file.header_error(&error))?;
    let available = reader.get_ref().len();
    file.check_declarations(&header, &bytes[..bytes.len() - available])?;
    file.check_header(&header)?;
    file.check_length(&header, available)?;

    let (mut vertices, mut faces) = (Vec::new(), Vec::new());
    for element in header.elements.values() {
        match element.name.as_str() {
            "vertex" => vertices = file.elements::<Vertex>(&mut reader, element, &header)?,
            "face" => faces = file.elements::<Face>(&mut reader, element, &header)?,
            _ => drop(file.elements::<Ignored>(&mut reader, element, &header)?),
        }
    }
    file.check_vertices(&vertices)?;

    let declared = &header.elements["vertex"].properties;
    let has = |names: &[&str]| names.iter().all(|&name| declared.contains_key(name));
    let mut mesh = Mesh { positions: vertices.iter().map(|vertex| vertex.position).collect(), ..Mesh::default() };
    let mut warnings = Vec::new();
    if has(&["nx", "ny", "nz"]) {
        match vertices.iter().map(|vertex| unit(vertex.normal)).collect() {
            Some(normals) => mesh.normals = normals,
            None => warnings.push(format!("{}: some normals have no direction; shading is flat", path.display())),
        }
    }
    if TEXCOORDS.iter().any(|names| has(names)) {
        // PLY counts from a picture's lower edge.
        let from_above = |texcoord: Vec2| Vec2::new(texcoord.x, 1.0 - texcoord.y);
        mesh.texcoords = vertices.iter().map(|vertex| from_above(vertex.texcoord)).collect();
    }
    let (mut cutter, mut positions) = (Cutter::new(), Vec::new());
    for (index, face) in faces.iter().enumerate() {
        let corners = file.corners(index, face, vertices.len())?;
        positions.clear();
        positions.extend(corners.iter().map(|&corner| mesh.positions[corner as usize]));
        let triangles = cutter.cut(&positions).iter();
        mesh.triangles.extend(triangles.map(|triangle| triangle.map(|corner| corners[corner as usize])));
    }
    Ok(Scene { meshes: vec![mesh], materials: vec![Material::default()], warnings, ..Scene::default() })
}

/// An element of a kind that is passed over.
struct Ignored;

#[derive(Default)]
struct Vertex {
    position: Vec3,
    normal: Vec3,
    texcoord: Vec2,
}

#[derive(Default)]
struct Face {
    /// `None` if one is negative.
    corners: Option<Vec<u32>>,
}

impl PropertyAccess for Ignored {
    fn new() -> Self {
        Self
    }
}

impl PropertyAccess for Vertex {
    fn new() -> Self {
        Self::default()
    }

    fn set_property(&mut self, name: &str, value: Property) -> PropertyAccessResult {
        let target = match name {
            "x" => &mut self.position.x,
            "y" => &mut self.position.y,
            "z" => &mut self.position.z,
            "nx" => &mut self.normal.x,
            "ny" => &mut self.normal.y,
            "nz" => &mut self.normal.z,
            "s" | "u" | "texture_u" => &mut self.texcoord.x,
            "t" | "v" | "texture_v" => &mut self.texcoord.y,
            _ => return PropertyAccessResult::Ignored,
        };
        let Some(value) = value.to_f32_lossy() else { return PropertyAccessResult::UnsupportedType };
        *target = value;
        PropertyAccessResult::Set
    }
}

impl PropertyAccess for Face {
    fn new() -> Self {
        Self::default()
    }

    fn set_property(&mut self, name: &str, value: Property) -> PropertyAccessResult {
        if !INDICES.contains(&name) {
            return PropertyAccessResult::Ignored;
        }
        self.corners = value.to_u32_list();
        PropertyAccessResult::Set
    }
}

/// The file at hand, for errors.
#[derive(Clone, Copy)]
struct File<'a> {
    path: &'a Path,
    bytes: &'a [u8],
}

impl<'a> File<'a> {
    fn error(&self, place: Place, problem: impl Into<String>, remedy: impl Into<String>) -> SceneError {
        SceneError::new(self.path, place, problem, remedy)
    }

    fn header_error(&self, error: &ParseError) -> SceneError {
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
    fn check_header(&self, header: &Header) -> Result<(), SceneError> {
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
    fn check_declarations(&self, header: &Header, text: &[u8]) -> Result<(), SceneError> {
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

    /// Whether what the header announces fits into the `available` bytes that follow it.
    fn check_length(&self, header: &Header, available: usize) -> Result<(), SceneError> {
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

    fn elements<E: PropertyAccess>(
        &self,
        reader: &mut Reader<&[u8]>,
        element: &ElementDef,
        header: &Header,
    ) -> Result<Vec<E>, SceneError> {
        let outcome = Parser::<E>::new().read_payload_for_element(reader, element, header);
        outcome.map_err(|error| {
            let name = &element.name;
            let part = Place::Part(format!("element `{name}`"));
            if error.kind() == ErrorKind::UnexpectedEof {
                let problem = format!("the file ends before the last of {}", element.count);
                return self.error(part, problem, "copy or export the model again");
            }
            if header.encoding != Encoding::Ascii {
                let problem = error.to_string().lines().next().unwrap_or_default().trim_end_matches('.').to_owned();
                return self.error(part, problem, "export the model again");
            }
            let line = error.line().unwrap_or(reader.line());
            let properties: Vec<&str> = element.properties.keys().map(String::as_str).collect();
            let remedy = format!("a line of `{name}` has these numbers: {}", properties.join(" "));
            self.error(Place::Line(line), format!("`{}` is not a `{name}`", self.line(line)), remedy)
        })
    }

    /// The text of a line, cut if it is long.
    fn line(&self, line: usize) -> String {
        let text = self.bytes.split(|&byte| byte == b'\n').nth(line.saturating_sub(1)).unwrap_or_default();
        super::statement::shown(text.trim_ascii())
    }

    fn check_vertices(&self, vertices: &[Vertex]) -> Result<(), SceneError> {
        for (index, Vertex { position, texcoord, .. }) in vertices.iter().enumerate() {
            if !position.is_finite() || !texcoord.is_finite() {
                return Err(self.error(
                    Place::Part(format!("vertex {index}")),
                    "a coordinate is not a finite number",
                    "every coordinate must be finite and in the range of single precision",
                ));
            }
        }
        Ok(())
    }

    /// The corners of face `index`, checked.
    fn corners<'f>(&self, index: usize, face: &'f Face, vertices: usize) -> Result<&'f [u32], SceneError> {
        let place = Place::Part(format!("face {index}"));
        let indices = format!("use vertices from 0 to {}", vertices.saturating_sub(1));
        let Some(corners) = &face.corners else {
            return Err(self.error(place, "it names a vertex by a negative number", indices));
        };
        if let Some(corner) = corners.iter().find(|&&corner| corner as usize >= vertices) {
            let vertices = count(vertices, "vertex", "vertices");
            return Err(self.error(place, format!("vertex {corner} does not exist: the file has {vertices}"), indices));
        }
        if corners.len() < 3 {
            let corners = count(corners.len(), "corner", "corners");
            return Err(self.error(place, format!("it has {corners}"), "a face needs 3 corners or more"));
        }
        Ok(corners)
    }
}

fn is_integer(scalar: &ScalarType) -> bool {
    !matches!(scalar, ScalarType::Float | ScalarType::Double)
}

/// The least number of bytes that a property takes: a digit and a separator, or its binary size.
fn least_size(property: &PropertyType, encoding: Encoding) -> usize {
    let (PropertyType::Scalar(scalar) | PropertyType::List(scalar, _)) = property;
    match (encoding, scalar) {
        (Encoding::Ascii, _) => 2,
        (_, ScalarType::Char | ScalarType::UChar) => 1,
        (_, ScalarType::Short | ScalarType::UShort) => 2,
        (_, ScalarType::Int | ScalarType::UInt | ScalarType::Float) => 4,
        (_, ScalarType::Double) => 8,
    }
}

#[cfg(test)]
mod tests;
