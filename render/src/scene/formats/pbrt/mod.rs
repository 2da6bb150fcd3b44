//! pbrt-v4 scenes (Pharr, Jakob and Humphreys, "Physically Based Rendering", 4th edition; pbrt.org/fileformat-v4).
//!
//! The reader takes transforms and attributes (`directives.rs`, `state.rs`), shapes (`shapes.rs`), materials and
//! textures, lights, the camera, the film's shape and the number of samples; integrator, filter and output file are
//! ignored, as they are options here. Content that is not read is a warning with its lines; invalid content is an
//! error.
//!
//! Deviations: spectra become colours (`spectrum.rs`); media are not read; transforms do not move: those of the
//! shutter's opening are used. Coordinates are mirrored where needed to make them right-handed (`camera.rs`).

mod arguments;
mod camera;
mod directives;
mod lights;
mod materials;
mod mix;
mod parameters;
mod placed;
mod round;
mod shapes;
mod sky;
mod spectrum;
mod state;
mod textures;
mod tokens;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::rc::Rc;

use glam::{DAffine3, DVec3};

use super::notes::Notes;
use crate::scene::texture::TextureStore;
use crate::scene::{Files, Scene, SceneError, Sharing};
use parameters::Parameters;
use placed::{Definition, Look, Objects};
use state::{Saved, State};
use tokens::At;

/// A scene while it is read.
struct Reader<'f> {
    files: &'f dyn Files,
    main: Rc<Path>,
    /// The folder of the main file, to which file names are relative.
    folder: PathBuf,
    scene: Scene,
    textures: TextureStore<'f>,
    notes: Notes,
    named_textures: textures::NamedTextures,
    state: State,
    saved: Vec<Saved>,
    /// Named coordinate systems: from the world to them.
    systems: BTreeMap<String, DAffine3>,
    /// Whether the x of the world is negated.
    is_mirrored: bool,
    file_camera: Option<camera::Camera>,
    film_size: Option<(u32, u32)>,
    /// Materials by their indices, and the indices of those that have names.
    materials: Vec<Definition>,
    material_names: BTreeMap<String, usize>,
    /// What meshes look like, by the number that they have for a material until all is read.
    looks: Vec<Look>,
    objects: Objects,
    /// Files that are being read, the main file first.
    open: Vec<Rc<Path>>,
}

/// Reads the scene in `text`.
pub(super) fn read(files: &dyn Files, path: &Path, text: &[u8], sharing: Sharing) -> Result<Scene, SceneError> {
    let main: Rc<Path> = path.into();
    let mut reader = Reader {
        files,
        main: main.clone(),
        folder: path.parent().unwrap_or(Path::new("")).to_owned(),
        scene: Scene::default(),
        textures: TextureStore::new(files, Vec::new()),
        notes: Notes::default(),
        named_textures: textures::NamedTextures::default(),
        state: State::default(),
        saved: Vec::new(),
        systems: BTreeMap::new(),
        is_mirrored: true,
        file_camera: None,
        film_size: None,
        materials: Vec::new(),
        material_names: BTreeMap::new(),
        looks: Vec::new(),
        objects: Objects::default(),
        open: Vec::new(),
    };
    reader.run(main, text)?;
    if let Some(Saved { what, at, .. }) = reader.saved.last() {
        return Err(at.error(format!("`{what}Begin` has no `{what}End`"), format!("end it with `{what}End`")));
    }
    reader.finish(sharing)
}

impl Reader<'_> {
    /// Warns that `what` is so at a place.
    fn note(&mut self, at: &At, what: &str) {
        let place = match *at.path == *self.main {
            true => format!("line {}", at.line),
            false => format!("{}:{}", at.path.display(), at.line),
        };
        self.notes.add(what, place);
    }

    /// Warns of parameters that were not read.
    fn warn_of_unused(&mut self, parameters: &Parameters) {
        for unused in parameters.unused() {
            let what = format!("`{}` of {} is not read", unused.name, parameters.of);
            self.note(&unused.at, &what);
        }
    }

    /// The path of a file that a scene names: relative to the main file, or to the one that names it.
    fn resolve(&self, name: &str, at: &At) -> PathBuf {
        let path = self.folder.join(name);
        let beside = at.path.parent().unwrap_or(Path::new("")).join(name);
        if !self.files.contains(&path) && self.files.contains(&beside) { beside } else { path }
    }

    /// Takes pbrt's world to ours.
    fn mirror(&self) -> DAffine3 {
        DAffine3::from_scale(if self.is_mirrored { DVec3::new(-1.0, 1.0, 1.0) } else { DVec3::ONE })
    }

    /// Takes what is given in the current coordinates to our world.
    fn to_world(&self) -> DAffine3 {
        self.mirror() * self.state.transform
    }

    /// Makes the scene of what was read.
    fn finish(mut self, sharing: Sharing) -> Result<Scene, SceneError> {
        self.finish_camera();
        self.finish_objects(sharing)?;
        self.finish_materials()?;
        let Self { mut scene, textures, notes, main, .. } = self;
        scene.textures = textures.list;
        scene.warnings.extend(notes.warnings(&main));
        Ok(scene)
    }
}

/// A thing that pbrt-v3 had and pbrt-v4 has not.
fn of_v3(at: &At, what: &str) -> SceneError {
    let remedy = "convert the file with pbrt-v4: `pbrt --upgrade old.pbrt > new.pbrt`";
    at.error(format!("{what} belongs to pbrt-v3; only pbrt-v4 is supported"), remedy)
}

#[cfg(test)]
mod tests;
