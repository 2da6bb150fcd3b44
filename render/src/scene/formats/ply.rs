//! PLY (Turk, "The PLY polygon file format", 1994) in its three encodings. The crate `ply-rs-bw` reads the header. What
//! follows is cut into pieces of one element (`ply/pieces.rs`), whose values (`ply/values.rs`) are read in parallel.
//!
//! Reads element `vertex` (`x y z`, `nx ny nz`, and `s t`, `u v` or `texture_u texture_v`) and element `face`
//! (`vertex_indices` or `vertex_index`), and ignores everything else, colours included. Errors count vertices and faces
//! from 0, as the format does. Polygons are cut into triangles (`meshes/polygon.rs`).
//!
//! A header's counts are compared with the file's length before any element is read. In ASCII an element is a line.

mod header;
mod pieces;
mod values;

use std::path::Path;

use glam::{Vec2, Vec3};
use ply_rs_bw::parser::{Parser, Reader};
use ply_rs_bw::ply::{ElementDef, Encoding, Header, PropertyAccess};

use super::blocks::read_in_order;
use super::load_options::Loading;
use crate::scene::description::unit;
use crate::scene::error::count;
use crate::scene::meshes::polygon::Cutter;
use crate::scene::{LoadWatch, Material, Mesh, Place, Scene, SceneError};
use pieces::Piece;
use values::{Bytes, Field, Row, Values, Words};

const TEXCOORDS: [[&str; 2]; 3] = [["s", "t"], ["u", "v"], ["texture_u", "texture_v"]];
const INDICES: [&str; 2] = ["vertex_indices", "vertex_index"];

/// Reads the PLY file in `bytes` as one mesh.
pub(super) fn read(path: &Path, bytes: &[u8], watch: Option<&dyn LoadWatch>) -> Result<Scene, SceneError> {
    let file = File { path, bytes };
    let mut loading = Loading::new(path, bytes.len(), watch);
    let mut reader = Reader::new(bytes);
    let header = Parser::<Ignored>::new().read_header(&mut reader).map_err(|error| file.header_error(&error))?;
    let available = reader.get_ref().len();
    let (text, data) = bytes.split_at(bytes.len() - available);
    file.check_declarations(&header, text)?;
    file.check_header(&header)?;
    file.check_length(&header, available)?;
    file.check_lengths_of_lists(&header)?;
    match header.encoding {
        Encoding::Ascii => {
            let line = 1 + text.iter().filter(|byte| **byte == b'\n').count();
            file.mesh::<Words>(&header, &mut loading, &pieces::of_text(&file, &header, data, line)?)
        }
        Encoding::BinaryLittleEndian => {
            file.mesh::<Bytes<false>>(&header, &mut loading, &pieces::of_bytes::<false>(&file, &header, data)?)
        }
        Encoding::BinaryBigEndian => {
            file.mesh::<Bytes<true>>(&header, &mut loading, &pieces::of_bytes::<true>(&file, &header, data)?)
        }
    }
}

/// Ignores elements, to read a header alone.
struct Ignored;

impl PropertyAccess for Ignored {
    fn new() -> Self {
        Self
    }
}

/// What is read of a piece's vertices.
#[derive(Default)]
struct Vertices {
    /// How many they were read from.
    bytes: usize,
    positions: Vec<Vec3>,
    texcoords: Vec<Vec2>,
    /// Unit normals; `None` if one has no direction.
    normals: Option<Vec<Vec3>>,
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

    /// Reads all vertices and faces.
    fn mesh<V: Values<'a>>(
        &self,
        header: &Header,
        loading: &mut Loading,
        pieces: &[Piece<'a>],
    ) -> Result<Scene, SceneError> {
        let (vertex, face) = (&header.elements["vertex"], &header.elements["face"]);
        let (vertices, faces): (Vec<&Piece>, Vec<&Piece>) =
            pieces.iter().filter(|piece| ["vertex", "face"].contains(&piece.name)).partition(|it| it.name == "vertex");
        let has = |names: &[&str]| names.iter().all(|&name| vertex.properties.contains_key(name));
        let (has_normals, has_texcoords) = (has(&["nx", "ny", "nz"]), TEXCOORDS.iter().any(|names| has(names)));
        let mut mesh = Mesh { positions: Vec::with_capacity(vertex.count), ..Mesh::default() };
        let mut all_normals = has_normals.then(|| Vec::with_capacity(vertex.count));
        if has_texcoords {
            mesh.texcoords.reserve_exact(vertex.count);
        }
        let fields = Field::all(vertex);
        let read = |piece: &&Piece<'a>| self.vertices::<V>(piece, &fields, vertex, has_texcoords, has_normals);
        read_in_order(&vertices, read, |part| {
            loading.advance(part.bytes);
            mesh.positions.extend(part.positions);
            mesh.texcoords.extend(part.texcoords);
            match (&mut all_normals, part.normals) {
                (Some(all), Some(normals)) => all.extend(normals),
                _ => all_normals = None,
            }
            Ok(())
        })?;
        let mut warnings = Vec::new();
        if has_normals && all_normals.is_none() {
            warnings.push(format!("{}: some normals have no direction; shading is flat", self.path.display()));
        }
        mesh.normals = all_normals.unwrap_or_default();
        let mut triangles = Vec::with_capacity(face.count);
        let fields = Field::all(face);
        let read = |piece: &&Piece<'a>| {
            let triangles = self.triangles::<V>(piece, &fields, face, &mesh.positions)?;
            Ok((piece.bytes.len(), triangles))
        };
        read_in_order(&faces, read, |(bytes, part)| {
            loading.advance(bytes);
            triangles.extend(part);
            Ok(())
        })?;
        mesh.triangles = triangles;
        Ok(Scene { meshes: vec![mesh], materials: vec![Material::default()], warnings, ..Scene::default() })
    }

    fn vertices<V: Values<'a>>(
        &self,
        piece: &Piece<'a>,
        fields: &[Field],
        element: &ElementDef,
        has_texcoords: bool,
        has_normals: bool,
    ) -> Result<Vertices, SceneError> {
        let mut vertices =
            Vertices { bytes: piece.bytes.len(), normals: has_normals.then(Vec::new), ..Vertices::default() };
        self.elements::<V>(piece, fields, element, |number, row| {
            let [x, y, z, nx, ny, nz, s, t] = row.numbers;
            let (position, texcoord) = (Vec3::new(x, y, z), Vec2::new(s, t));
            if !position.is_finite() || !texcoord.is_finite() {
                return Err(self.error(
                    Place::Part(format!("vertex {number}")),
                    "a coordinate is not a finite number",
                    "every coordinate must be finite and in the range of single precision",
                ));
            }
            vertices.positions.push(position);
            if has_texcoords {
                // PLY counts from a picture's lower edge.
                vertices.texcoords.push(Vec2::new(s, 1.0 - t));
            }
            match (&mut vertices.normals, unit(Vec3::new(nx, ny, nz))) {
                (Some(normals), Some(normal)) => normals.push(normal),
                _ => vertices.normals = None,
            }
            Ok(())
        })?;
        Ok(vertices)
    }

    fn triangles<V: Values<'a>>(
        &self,
        piece: &Piece<'a>,
        fields: &[Field],
        element: &ElementDef,
        positions: &[Vec3],
    ) -> Result<Vec<[u32; 3]>, SceneError> {
        let mut triangles = Vec::with_capacity(piece.count);
        let (mut corners, mut places, mut cutter) = (Vec::new(), Vec::new(), Cutter::new());
        self.elements::<V>(piece, fields, element, |number, row| {
            self.check_corners(number, &row.corners, positions.len())?;
            corners.clear();
            corners.extend(row.corners.iter().map(|&corner| corner as u32));
            if let [a, b, c] = corners[..] {
                triangles.push([a, b, c]);
                return Ok(());
            }
            places.clear();
            places.extend(corners.iter().map(|&corner| positions[corner as usize]));
            let cut = cutter.cut(&places).iter();
            triangles.extend(cut.map(|triangle| triangle.map(|corner| corners[corner as usize])));
            Ok(())
        })?;
        Ok(triangles)
    }

    /// Calls `take` with the index and the values of each element of a piece.
    fn elements<V: Values<'a>>(
        &self,
        piece: &Piece<'a>,
        fields: &[Field],
        element: &ElementDef,
        mut take: impl FnMut(usize, &Row) -> Result<(), SceneError>,
    ) -> Result<(), SceneError> {
        let (mut values, mut row) = (V::new(piece.bytes), Row::default());
        for place in 0..piece.count {
            values.begin_element();
            row.read(&mut values, fields).ok_or_else(|| {
                let name = &element.name;
                if piece.line == 0 {
                    let part = Place::Part(format!("{name} {}", piece.first + place));
                    return self.error(part, "its values do not match the header", "export the model again");
                }
                let line = piece.line + place;
                let properties: Vec<&str> = element.properties.keys().map(String::as_str).collect();
                let remedy = format!("a line of `{name}` has these numbers: {}", properties.join(" "));
                self.error(Place::Line(line), format!("`{}` is not a `{name}`", self.line(line)), remedy)
            })?;
            take(piece.first + place, &row)?;
        }
        Ok(())
    }

    /// The text of a line, cut if it is long.
    fn line(&self, line: usize) -> String {
        let text = self.bytes.split(|&byte| byte == b'\n').nth(line.saturating_sub(1)).unwrap_or_default();
        super::statement::shown(text.trim_ascii())
    }

    fn check_corners(&self, face: usize, corners: &[i64], vertices: usize) -> Result<(), SceneError> {
        let wrong = |problem: String, remedy: &str| self.error(Place::Part(format!("face {face}")), problem, remedy);
        let indices = || format!("use vertices from 0 to {}", vertices.saturating_sub(1));
        if corners.iter().any(|&corner| corner < 0) {
            return Err(wrong("it names a vertex by a negative number".to_owned(), &indices()));
        }
        if let Some(corner) = corners.iter().find(|&&corner| corner >= vertices as i64) {
            let vertices = count(vertices, "vertex", "vertices");
            return Err(wrong(format!("vertex {corner} does not exist: the file has {vertices}"), &indices()));
        }
        if corners.len() < 3 {
            let corners = count(corners.len(), "corner", "corners");
            return Err(wrong(format!("it has {corners}"), "a face needs 3 corners or more"));
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests;
