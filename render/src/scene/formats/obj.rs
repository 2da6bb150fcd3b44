//! Wavefront OBJ: polygons (`v`, `vt`, `vn`, `f`), their groups (`o`, `g`) and materials (`usemtl`, `mtllib`).
//!
//! This reader is our own, because those on crates.io give no line numbers in their errors. Blocks of lines are read in
//! parallel (`obj/lines.rs`), after a pass that counts the vertices before each block; then faces become meshes in
//! order (`obj/weld.rs`).
//!
//! Every run of faces with one object, group and material becomes a mesh, or up to four: faces whose corners all have
//! normals, or texture coordinates, are separate from those where some are missing, which are flat or without texture
//! coordinates. Vertices are shared within a mesh. It has the name of its group, or of its object where there is no
//! group or it has no name; masks and light path expressions use that name.
//!
//! Polygons are cut into triangles (`meshes/polygon.rs`).
//!
//! Deviations: lines and points are skipped with a warning; smoothing groups, free-form surfaces and unknown statements
//! without one. A face can only refer to earlier vertices. A normal without a direction counts as missing.

mod lines;
mod weld;

use std::collections::BTreeSet;
use std::mem;
use std::path::{Path, PathBuf};

use glam::{Vec2, Vec3};
use rayon::prelude::*;

use super::blocks::{Block, blocks, read_in_order};
use super::load_options::Loading;
use super::mtl;
use super::statement::statements;
use crate::scene::error::count;
use crate::scene::meshes::polygon::Cutter;
use crate::scene::texture::TextureStore;
use crate::scene::{Files, LoadWatch, Material, Mesh, Scene, SceneError};
use lines::{Change, Counts, Lines};
use weld::{Run, Vertices};

/// The format's name in errors.
const FORMAT: &str = "an OBJ file";

/// Stands for an index that a corner leaves out. The file is too short for it to be a real one.
const NONE: u32 = u32::MAX;

/// Indices of a position, a texture coordinate and a normal; the latter two may be [`NONE`].
type Corner = [u32; 3];

/// Reads the OBJ file in `bytes`, and the MTL files that it names, which are sought relative to the folder of `path`.
pub(super) fn read(
    files: &dyn Files,
    path: &Path,
    bytes: &[u8],
    watch: Option<&dyn LoadWatch>,
) -> Result<Scene, SceneError> {
    let blocks = blocks(bytes, 1);
    let within: Vec<Counts> = blocks.par_iter().map(|block| Counts::of(*block)).collect();
    let mut before = Counts::default();
    let parts: Vec<_> = blocks
        .into_iter()
        .zip(within)
        .map(|(block, within)| {
            let sum = before.and(within);
            (block, mem::replace(&mut before, sum))
        })
        .collect();
    let mut reader = Reader::new(files, path, before);
    let mut loading = Loading::new(path, bytes.len(), watch);
    let read =
        |(block, before): &(Block, Counts)| Lines::read(path, *block, *before).map(|lines| (block.bytes.len(), lines));
    read_in_order(&parts, read, |(length, lines)| {
        loading.advance(length);
        reader.take(lines)
    })?;
    Ok(reader.finish())
}

/// The material libraries that the OBJ file in `bytes` names and that are there, each once.
///
/// # Errors
/// If it is not an OBJ file.
pub(crate) fn libraries(files: &dyn Files, path: &Path, bytes: &[u8]) -> Result<Vec<PathBuf>, SceneError> {
    let folder = path.parent().unwrap_or(Path::new(""));
    let mut libraries = Vec::new();
    for block in blocks(bytes, 1) {
        for statement in statements(path, block, FORMAT) {
            let statement = statement?;
            if statement.keyword() == b"mtllib" {
                let named = library_names(files, folder, &statement.name());
                libraries.extend(named.iter().map(|name| folder.join(name)).filter(|file| files.contains(file)));
            }
        }
    }
    let mut seen = BTreeSet::new();
    libraries.retain(|file| seen.insert(file.clone()));
    Ok(libraries)
}

struct Reader<'a> {
    files: &'a dyn Files,
    path: &'a Path,
    positions: Vec<Vec3>,
    texcoords: Vec<Vec2>,
    /// Unit normals, or zero for those without a direction.
    normals: Vec<Vec3>,
    /// The corners of the face at hand as vertices of its mesh, and their positions.
    vertices: Vec<u32>,
    places: Vec<Vec3>,
    cutter: Cutter,
    /// The names that `usemtl` gave, in order of appearance; a mesh's material indexes them until the end.
    material_names: Vec<String>,
    /// The name of the object at hand.
    object: String,
    run: Run,
    shared: Vertices,
    meshes: Vec<Mesh>,
    materials: Vec<Material>,
    textures: TextureStore<'a>,
    warnings: Vec<String>,
    lines_and_points: usize,
}

impl<'a> Reader<'a> {
    fn new(files: &'a dyn Files, path: &'a Path, counts: Counts) -> Self {
        let [positions, texcoords, normals] = counts.0;
        Self {
            files,
            path,
            positions: Vec::with_capacity(positions),
            texcoords: Vec::with_capacity(texcoords),
            normals: Vec::with_capacity(normals),
            vertices: Vec::new(),
            places: Vec::new(),
            cutter: Cutter::new(),
            material_names: Vec::new(),
            object: String::new(),
            run: Run::default(),
            shared: Vertices::new(positions),
            meshes: Vec::new(),
            materials: Vec::new(),
            textures: TextureStore::new(files, Vec::new()),
            warnings: Vec::new(),
            lines_and_points: 0,
        }
    }

    /// Adds what the next lines of the file say.
    fn take(&mut self, lines: Lines) -> Result<(), SceneError> {
        self.positions.extend(lines.positions);
        self.texcoords.extend(lines.texcoords);
        self.normals.extend(lines.normals);
        self.lines_and_points += lines.lines_and_points;
        let mut changes = lines.changes.into_iter().peekable();
        let mut rest = &lines.corners[..];
        for (face, &corners) in lines.faces.iter().enumerate() {
            while let Some((_, change)) = changes.next_if(|(before, _)| *before == face) {
                self.change(change)?;
            }
            let (corners, others) = rest.split_at(corners as usize);
            self.add_face(corners);
            rest = others;
        }
        changes.try_for_each(|(_, change)| self.change(change))
    }

    fn change(&mut self, change: Change) -> Result<(), SceneError> {
        match change {
            Change::Object(name) => {
                self.object.clone_from(&name);
                self.begin_run(name, self.run.material);
            }
            Change::Group(name) if name.is_empty() => self.begin_run(self.object.clone(), self.run.material),
            Change::Group(name) => self.begin_run(name, self.run.material),
            Change::Material(name) => {
                let known = self.material_names.iter().position(|known| *known == name);
                let material = known.unwrap_or_else(|| {
                    self.material_names.push(name);
                    self.material_names.len() - 1
                });
                self.begin_run(self.run.name.clone(), Some(material));
            }
            Change::Libraries { line, names } => self.read_libraries(line, &names)?,
        }
        Ok(())
    }

    fn begin_run(&mut self, name: String, material: Option<usize>) {
        if self.run.name != name || self.run.material != material {
            let finished = mem::replace(&mut self.run, Run { name, material, ..Run::default() });
            self.meshes.extend(finished.into_meshes());
            self.shared.forget();
        }
    }

    fn add_face(&mut self, face: &[Corner]) {
        let has_texcoords = face.iter().all(|&[_, texcoord, _]| texcoord != NONE);
        let has_normals =
            face.iter().all(|&[_, _, normal]| normal != NONE && self.normals[normal as usize] != Vec3::ZERO);
        let mesh = &mut self.run.meshes[usize::from(has_texcoords) + 2 * usize::from(has_normals)];
        self.vertices.clear();
        for &[position, texcoord, normal] in face {
            let corner =
                [position, if has_texcoords { texcoord } else { NONE }, if has_normals { normal } else { NONE }];
            let next = mesh.positions.len() as u32;
            let vertex = self.shared.find_or_add(corner, next);
            if vertex == next {
                mesh.positions.push(self.positions[position as usize]);
                if has_texcoords {
                    mesh.texcoords.push(self.texcoords[texcoord as usize]);
                }
                if has_normals {
                    mesh.normals.push(self.normals[normal as usize]);
                }
            }
            self.vertices.push(vertex);
        }
        if let [a, b, c] = self.vertices[..] {
            mesh.triangles.push([a, b, c]);
            return;
        }
        self.places.clear();
        self.places.extend(face.iter().map(|&[position, ..]| self.positions[position as usize]));
        let triangles = self.cutter.cut(&self.places).iter();
        mesh.triangles.extend(triangles.map(|triangle| triangle.map(|corner| self.vertices[corner as usize])));
    }

    /// Reads the MTL files of one `mtllib` line. A missing one is a warning: half the models of the world lack theirs.
    fn read_libraries(&mut self, line: usize, names: &str) -> Result<(), SceneError> {
        let folder = self.path.parent().unwrap_or(Path::new(""));
        for name in library_names(self.files, folder, names) {
            let file = folder.join(&name);
            match self.files.read(&file) {
                Ok(bytes) => mtl::read(&file, &bytes, &mut self.materials, &mut self.textures, &mut self.warnings)?,
                Err(error) => {
                    let problem = SceneError::unreadable(&file, &error).problem;
                    let path = self.path.display();
                    self.warnings.push(format!("{path}:{line}: material library {name:?}: {problem}"));
                }
            }
        }
        Ok(())
    }

    /// Completes the meshes, now that all materials are known.
    fn finish(mut self) -> Scene {
        self.meshes.extend(self.run.into_meshes());
        if self.lines_and_points > 0 {
            let skipped = count(
                self.lines_and_points,
                "statement with lines or points is",
                "statements with lines or points are",
            );
            self.warnings.push(format!("{}: {skipped} skipped", self.path.display()));
        }
        let defined: Vec<Option<usize>> = self
            .material_names
            .iter()
            .map(|name| self.materials.iter().position(|material| material.name == *name))
            .collect();
        let default = self.materials.len();
        for mesh in &mut self.meshes {
            mesh.material = defined.get(mesh.material).copied().flatten().unwrap_or(default);
        }
        if self.meshes.iter().any(|mesh| mesh.material == default) {
            self.materials.push(Material::default());
        }
        for (name, _) in self.material_names.iter().zip(&defined).filter(|(_, defined)| defined.is_none()) {
            self.warnings.push(format!("{}: material {name:?} is not defined; grey instead", self.path.display()));
        }
        Scene {
            meshes: self.meshes,
            materials: self.materials,
            textures: self.textures.list,
            warnings: self.warnings,
            ..Scene::default()
        }
    }
}

/// Splits the words of a `mtllib` line into file names. Names may hold spaces, so the longest run of words that is a
/// file in `folder` is one name; where none is, a single word is.
fn library_names(files: &dyn Files, folder: &Path, line: &str) -> Vec<String> {
    let mut names = Vec::new();
    // Exporters on Windows write backslashes.
    let line = line.replace('\\', "/");
    let mut rest = line.trim();
    while !rest.is_empty() {
        let ends = rest.match_indices(char::is_whitespace).map(|(end, _)| end).chain([rest.len()]);
        let (mut shortest, mut longest) = (None, None);
        for end in ends {
            shortest = shortest.or(Some(end));
            if files.contains(&folder.join(&rest[..end])) {
                longest = Some(end);
            }
        }
        let end = longest.or(shortest).unwrap_or(rest.len());
        names.push(rest[..end].to_owned());
        rest = rest[end..].trim_start();
    }
    names
}

#[cfg(test)]
mod tests;
