//! Shapes as meshes, in their own coordinates: triangles, patches, PLY files; round ones are in `round.rs`.
//!
//! Bilinear patches that are not flat become a grid of [`GRID`] by [`GRID`] quadrilaterals. As in pbrt, fronts are
//! where corners run counter-clockwise, or where the normals point; texture coordinates are turned upside down.

use std::io::Read as _;

use glam::{DVec2, DVec3, Vec2};

use super::Reader;
use super::parameters::Parameters;
use super::round::{cylinder, disk, sphere};
use crate::scene::description::unit;
use crate::scene::formats::ply;
use crate::scene::nearest::suggestion;
use crate::scene::{Mesh, SceneError};

/// Quadrilaterals along each side of a curved patch.
const GRID: u32 = 8;
/// The most bytes that a compressed file may grow to.
const MAX_BYTES: u64 = 1 << 32;

const KNOWN: [&str; 7] = ["bilinearmesh", "cylinder", "disk", "loopsubdiv", "plymesh", "sphere", "trianglemesh"];

impl Reader<'_> {
    /// The mesh of a shape; `None`, with a warning, if the kind is not read.
    pub(super) fn shape_mesh(&mut self, kind: &str, parameters: &Parameters) -> Result<Option<Mesh>, SceneError> {
        let mesh = match kind {
            "trianglemesh" => self.triangles(parameters)?,
            "bilinearmesh" => self.patches(parameters)?,
            "plymesh" => self.ply(parameters)?,
            "sphere" => sphere(parameters)?,
            "disk" => disk(parameters)?,
            "cylinder" => cylinder(parameters)?,
            "loopsubdiv" => {
                self.note(&parameters.at, "a shape \"loopsubdiv\" is not subdivided");
                parameters.ignore(&["levels", "scheme"]);
                self.triangles(parameters)?
            }
            "curve" => {
                self.note(&parameters.at, "a shape \"curve\" is not read");
                return Ok(None);
            }
            "cone" | "paraboloid" | "hyperboloid" | "heightfield" | "nurbs" => {
                return Err(super::of_v3(&parameters.at, &format!("the shape {kind:?}")));
            }
            _ => {
                let problem = format!("there is no shape {kind:?}");
                return Err(parameters.at.error(problem, suggestion(kind, &KNOWN)));
            }
        };
        Ok(Some(mesh))
    }

    fn triangles(&mut self, parameters: &Parameters) -> Result<Mesh, SceneError> {
        parameters.ignore(&["S", "faceIndices"]);
        let mut mesh = vertices(parameters)?;
        let indices = indices(parameters, 3, mesh.positions.len())?;
        mesh.triangles = indices.chunks_exact(3).map(|corners| [corners[0], corners[1], corners[2]]).collect();
        Ok(mesh)
    }

    fn patches(&mut self, parameters: &Parameters) -> Result<Mesh, SceneError> {
        parameters.ignore(&["faceIndices"]);
        if parameters.get("emissionfilename").is_some() {
            self.note(&parameters.at, "`emissionfilename` is not read");
        }
        let given = vertices(parameters)?;
        let indices = indices(parameters, 4, given.positions.len())?;
        let mut mesh = Mesh::default();
        for patch in indices.chunks_exact(4) {
            add_patch(&given, [0, 1, 2, 3].map(|corner| patch[corner] as usize), &mut mesh);
        }
        Ok(mesh)
    }

    fn ply(&mut self, parameters: &Parameters) -> Result<Mesh, SceneError> {
        let Some(name) = parameters.text("filename")? else {
            return Err(parameters.at.error("a plymesh names no file", "write `\"string filename\" \"statue.ply\"`"));
        };
        if parameters.get("displacement").is_some() {
            self.note(&parameters.at, "the displacement of meshes is not read");
            parameters.ignore(&["edgelength", "displacement.edgelength"]);
        }
        let path = self.resolve(name, &parameters.at);
        let bytes = self.read_file(&path, &parameters.at)?;
        let read = ply::read(&path, &bytes, None)?;
        self.scene.warnings.extend(read.warnings);
        Ok(read.meshes.into_iter().next().unwrap_or_default())
    }

    /// The bytes of a file that the scene names, unpacked if it is compressed by gzip.
    pub(super) fn read_file(&self, path: &std::path::Path, at: &super::tokens::At) -> Result<Vec<u8>, SceneError> {
        let bytes = self.files.read(path).map_err(|error| {
            let SceneError { problem, .. } = SceneError::unreadable(path, &error);
            at.error(
                format!("{}: {problem}", path.display()),
                "check the path, which is relative to the scene's folder",
            )
        })?;
        if !bytes.starts_with(b"\x1f\x8b") {
            return Ok(bytes.into_owned());
        }
        let mut unpacked = Vec::new();
        let read = flate2::read::MultiGzDecoder::new(&*bytes).take(MAX_BYTES + 1).read_to_end(&mut unpacked);
        match read {
            Ok(length) if length as u64 <= MAX_BYTES => Ok(unpacked),
            Ok(_) => Err(at.error(format!("{}: it is larger than 4 GiB", path.display()), "split it")),
            Err(error) => {
                Err(at.error(format!("{}: it is no valid gzip archive: {error}", path.display()), "copy it again"))
            }
        }
    }
}

/// `P`, `N` and `uv`.
fn vertices(parameters: &Parameters) -> Result<Mesh, SceneError> {
    let Some(positions) = parameters.points("P")? else {
        let problem = format!("{} has no positions", parameters.of);
        return Err(parameters.at.error(problem, "write `\"point3 P\" [ x y z ... ]`"));
    };
    let count = positions.len();
    let check = |name: &str, found: usize| {
        if found == count {
            return Ok(());
        }
        let problem = format!("{} has {count} of `P` and {found} of `{name}`", parameters.of);
        Err(parameters.at.error(problem, "write one for each position"))
    };
    let mut mesh = Mesh { positions, ..Mesh::default() };
    if let Some(normals) = parameters.points("N")? {
        check("N", normals.len())?;
        mesh.normals = normals.into_iter().map(unit).collect::<Option<_>>().unwrap_or_default();
    }
    let texcoords = ["uv", "st"].map(|name| parameters.points2(name));
    for (texcoords, name) in texcoords.into_iter().zip(["uv", "st"]) {
        if let Some(texcoords) = texcoords? {
            check(name, texcoords.len())?;
            mesh.texcoords = texcoords.into_iter().map(|it| Vec2::new(it.x, 1.0 - it.y)).collect();
        }
    }
    Ok(mesh)
}

/// `indices`, in groups of a number; with as many positions as one group has they may be left out.
fn indices(parameters: &Parameters, group: usize, count: usize) -> Result<Vec<u32>, SceneError> {
    let Some(indices) = parameters.integers("indices")? else {
        if count == group {
            return Ok((0..count as u32).collect());
        }
        let problem = format!("{} has no indices", parameters.of);
        return Err(parameters
            .at
            .error(problem, format!("write `\"integer indices\" [ ... ]`, {group} for each face")));
    };
    let at = parameters.get("indices").map_or(&parameters.at, |found| &found.at);
    if !indices.len().is_multiple_of(group) {
        let problem = format!("{} has {} indices", parameters.of, indices.len());
        return Err(at.error(problem, format!("write {group} for each face")));
    }
    let valid = |&index: &i32| u32::try_from(index).ok().filter(|&index| (index as usize) < count);
    let wrong = indices.iter().find(|index| valid(index).is_none());
    if let Some(wrong) = wrong {
        let problem = format!("{} has the index {wrong}, and {count} positions", parameters.of);
        return Err(at.error(problem, "count positions from 0"));
    }
    Ok(indices.iter().filter_map(valid).collect())
}

/// Adds a patch with the corners at (0, 0), (1, 0), (0, 1) and (1, 1).
fn add_patch(given: &Mesh, corners: [usize; 4], mesh: &mut Mesh) {
    const OWN: [Vec2; 4] = [Vec2::new(0.0, 1.0), Vec2::new(1.0, 1.0), Vec2::ZERO, Vec2::new(1.0, 0.0)];
    let positions = corners.map(|corner| given.positions[corner].as_dvec3());
    let texcoords = match given.texcoords.is_empty() {
        true => OWN,
        false => corners.map(|corner| given.texcoords[corner]),
    };
    let [a, b, c, d] = positions;
    let across = (b - a).cross(c - a);
    let is_flat = (d - a).dot(across).abs() <= 1e-6 * across.length() * (d - a).length();
    let steps = if is_flat { 1 } else { GRID };
    let first = mesh.positions.len() as u32;
    for (row, column) in (0..=steps).flat_map(|row| (0..=steps).map(move |column| (row, column))) {
        let [u, v] = [column, row].map(|step| f64::from(step) / f64::from(steps));
        let weights = [(1.0 - u) * (1.0 - v), u * (1.0 - v), (1.0 - u) * v, u * v];
        let mean = |of: [DVec3; 4]| of.into_iter().zip(weights).map(|(it, weight)| it * weight).sum::<DVec3>();
        mesh.positions.push(mean(positions).as_vec3());
        let texcoord = texcoords.into_iter().zip(weights).map(|(it, weight)| it.as_dvec2() * weight).sum::<DVec2>();
        mesh.texcoords.push(texcoord.as_vec2());
        if !given.normals.is_empty() {
            let normal = mean(corners.map(|corner| given.normals[corner].as_dvec3()));
            mesh.normals.push(normal.normalize_or(across.normalize_or_zero()).as_vec3());
        }
    }
    let at = |row: u32, column: u32| first + row * (steps + 1) + column;
    for (row, column) in (0..steps).flat_map(|row| (0..steps).map(move |column| (row, column))) {
        let [p, q] = [at(row, column), at(row, column + 1)];
        let [r, s] = [at(row + 1, column), at(row + 1, column + 1)];
        mesh.triangles.extend([[p, q, s], [p, s, r]]);
    }
}
