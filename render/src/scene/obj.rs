//! Wavefront OBJ: polygons (`v`, `vt`, `vn`, `f`), their groups (`o`, `g`) and materials (`usemtl`, `mtllib`).
//!
//! A reader of our own, because those on crates.io give no line numbers in their errors.
//!
//! Every run of faces with one object, group and material becomes a mesh, or up to four: faces whose corners all have
//! normals, or texture coordinates, stand apart from those where some are missing, which are flat or without texture
//! coordinates. Vertices are shared within a mesh.
//!
//! Polygons are cut into triangles (`polygon.rs`).
//!
//! Deviations: lines and points are skipped with a warning; smoothing groups, free-form surfaces and unknown statements
//! without one. A face can only name vertices that stand before it. A normal without a direction counts as missing.

use std::collections::HashMap;
use std::mem;
use std::path::Path;

use glam::{Vec2, Vec3};

use super::description::unit;
use super::error::count;
use super::polygon::Cutter;
use super::statement::{Statement, shown, statements};
use super::texture::TextureStore;
use super::{Files, Material, Mesh, Scene, SceneError, mtl};

/// Stands for an index that a corner leaves out. The file is too short for it to be a real one.
const NONE: u32 = u32::MAX;

/// Indices of a position, a texture coordinate and a normal; the latter two may be [`NONE`].
type Corner = [u32; 3];

/// Reads the OBJ file in `bytes`, and the MTL files that it names, which are sought relative to the folder of `path`.
pub(super) fn read(files: &dyn Files, path: &Path, bytes: &[u8]) -> Result<Scene, SceneError> {
    let mut reader = Reader::new(files, path);
    for statement in statements(path, bytes, "an OBJ file") {
        reader.take(&statement?)?;
    }
    Ok(reader.finish())
}

struct Reader<'a> {
    files: &'a dyn Files,
    path: &'a Path,
    positions: Vec<Vec3>,
    texcoords: Vec<Vec2>,
    /// Unit normals, or zero for those without a direction.
    normals: Vec<Vec3>,
    /// The corners of the face at hand.
    face: Vec<Corner>,
    /// Its corners as vertices of its mesh, and their positions.
    vertices: Vec<u32>,
    places: Vec<Vec3>,
    cutter: Cutter,
    /// The names that `usemtl` gave, in order of appearance; a mesh's material indexes them until the end.
    material_names: Vec<String>,
    run: Run,
    meshes: Vec<Mesh>,
    materials: Vec<Material>,
    textures: TextureStore<'a>,
    warnings: Vec<String>,
    lines_and_points: usize,
}

impl<'a> Reader<'a> {
    fn new(files: &'a dyn Files, path: &'a Path) -> Self {
        Self {
            files,
            path,
            positions: Vec::new(),
            texcoords: Vec::new(),
            normals: Vec::new(),
            face: Vec::new(),
            vertices: Vec::new(),
            places: Vec::new(),
            cutter: Cutter::new(),
            material_names: Vec::new(),
            run: Run::default(),
            meshes: Vec::new(),
            materials: Vec::new(),
            textures: TextureStore::new(files, Vec::new()),
            warnings: Vec::new(),
            lines_and_points: 0,
        }
    }

    fn take(&mut self, statement: &Statement) -> Result<(), SceneError> {
        match statement.keyword() {
            b"v" => self.positions.push(Vec3::from_array(statement.numbers()?)),
            b"vn" => self.normals.push(unit(Vec3::from_array(statement.numbers()?)).unwrap_or_default()),
            b"vt" => {
                // The second coordinate may be left out: it is 0 then.
                let one = statement.words().count() == 1;
                let texcoord = if one { [statement.numbers::<1>()?[0], 0.0] } else { statement.numbers()? };
                // OBJ counts from a picture's lower edge.
                self.texcoords.push(Vec2::new(texcoord[0], 1.0 - texcoord[1]));
            }
            b"f" => self.add_face(statement)?,
            b"o" | b"g" => self.begin_run(statement.name(), self.run.material),
            b"usemtl" => {
                let name = statement.name();
                let known = self.material_names.iter().position(|known| *known == name);
                let material = known.unwrap_or_else(|| {
                    self.material_names.push(name);
                    self.material_names.len() - 1
                });
                self.begin_run(self.run.name.clone(), Some(material));
            }
            b"mtllib" => self.read_libraries(statement)?,
            b"l" | b"p" => self.lines_and_points += 1,
            _ => {}
        }
        Ok(())
    }

    fn begin_run(&mut self, name: String, material: Option<usize>) {
        if self.run.name != name || self.run.material != material {
            let finished = mem::replace(&mut self.run, Run { name, material, ..Run::default() });
            self.meshes.extend(finished.into_meshes());
        }
    }

    fn add_face(&mut self, statement: &Statement) -> Result<(), SceneError> {
        self.face.clear();
        for word in statement.words() {
            let corner = self.corner(statement, word)?;
            self.face.push(corner);
        }
        if self.face.len() < 3 {
            let corners = count(self.face.len(), "corner", "corners");
            return Err(statement.error(format!("this face has {corners}"), "a face needs 3 corners or more"));
        }
        let has_texcoords = self.face.iter().all(|&[_, texcoord, _]| texcoord != NONE);
        let has_normals =
            self.face.iter().all(|&[_, _, normal]| normal != NONE && self.normals[normal as usize] != Vec3::ZERO);
        let builder = &mut self.run.builders[usize::from(has_texcoords) + 2 * usize::from(has_normals)];
        let mesh = &mut builder.mesh;
        self.vertices.clear();
        self.places.clear();
        for &[position, texcoord, normal] in &self.face {
            let corner =
                [position, if has_texcoords { texcoord } else { NONE }, if has_normals { normal } else { NONE }];
            let vertex = *builder.vertices.entry(corner).or_insert_with(|| {
                mesh.positions.push(self.positions[position as usize]);
                if has_texcoords {
                    mesh.texcoords.push(self.texcoords[texcoord as usize]);
                }
                if has_normals {
                    mesh.normals.push(self.normals[normal as usize]);
                }
                mesh.positions.len() as u32 - 1
            });
            self.vertices.push(vertex);
            self.places.push(self.positions[position as usize]);
        }
        let triangles = self.cutter.cut(&self.places).iter();
        mesh.triangles.extend(triangles.map(|triangle| triangle.map(|corner| self.vertices[corner as usize])));
        Ok(())
    }

    /// Reads `v`, `v/vt`, `v//vn` or `v/vt/vn`.
    fn corner(&self, statement: &Statement, word: &[u8]) -> Result<Corner, SceneError> {
        let kinds = [
            ("vertex", "vertices", self.positions.len()),
            ("texture coordinate", "texture coordinates", self.texcoords.len()),
            ("normal", "normals", self.normals.len()),
        ];
        let mut corner = [NONE; 3];
        for (slot, part) in word.split(|&byte| byte == b'/').enumerate() {
            if part.is_empty() && slot > 0 {
                continue;
            }
            let number = str::from_utf8(part).ok().and_then(|part| part.parse::<i64>().ok());
            let (Some(&(one, many, known)), Some(number)) = (kinds.get(slot), number) else {
                return Err(statement.error(
                    format!("`{}` is not a corner of a face", shown(word)),
                    "write corners as whole numbers: v, v/vt, v//vn or v/vt/vn",
                ));
            };
            // Positive numbers count from 1, negative ones back from the latest.
            let index = if number > 0 { number - 1 } else { known as i64 + number };
            if number == 0 || !(0..known as i64).contains(&index) {
                let known = count(known, one, many);
                return Err(statement.error(
                    format!("{one} {number} does not exist: the file has {known} up to this line"),
                    "define it before the face, and count from 1, or backwards from -1",
                ));
            }
            corner[slot] = index as u32;
        }
        Ok(corner)
    }

    /// Reads the MTL files of one `mtllib` line. A missing one is a warning: half the models of the world lack theirs.
    fn read_libraries(&mut self, statement: &Statement) -> Result<(), SceneError> {
        let folder = self.path.parent().unwrap_or(Path::new(""));
        for name in library_names(self.files, folder, &statement.name()) {
            let file = folder.join(&name);
            match self.files.read(&file) {
                Ok(bytes) => mtl::read(&file, &bytes, &mut self.materials, &mut self.textures, &mut self.warnings)?,
                Err(error) => {
                    let problem = SceneError::unreadable(&file, &error).problem;
                    self.warnings.push(statement.warning(format_args!("material library {name:?}: {problem}")));
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

/// Faces that follow each other with one name and material.
#[derive(Default)]
struct Run {
    name: String,
    material: Option<usize>,
    /// Without texture coordinates and normals; with texture coordinates; with normals; with both.
    builders: [Builder; 4],
}

#[derive(Default)]
struct Builder {
    mesh: Mesh,
    vertices: HashMap<Corner, u32>,
}

impl Run {
    fn into_meshes(self) -> impl Iterator<Item = Mesh> {
        let Self { name, material, builders } = self;
        let meshes = builders.into_iter().map(|builder| builder.mesh).filter(|mesh| !mesh.triangles.is_empty());
        // Faces before any `usemtl` have an index that names no material.
        meshes.map(move |mesh| Mesh { name: name.clone(), material: material.unwrap_or(usize::MAX), ..mesh })
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
