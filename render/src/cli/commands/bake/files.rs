//! The files of a bake: the model, its maps, a manifest and a report. Each is replaced atomically, the manifest last,
//! so that a manifest only names files that exist.

mod pages;
mod references;
mod summary;

use std::path::{Path, PathBuf};

use glam::Vec2;

use super::invalid;
use crate::bake::gltf::{self, Page, Part, Target};
use crate::bake::manifest::{Hash, Hashes, Manifest, Output, Unit};
use crate::bake::report;
use crate::bake::{self, Bake, BakeOptions, Directional, Mode, Preset};
use crate::cli::error::CliError;
use crate::cli::inputs;
use crate::output::OutputFile;
use crate::scene::Scene;
use references::References;

/// The output paths.
pub(super) struct Files {
    /// The model that is written.
    pub(super) model: PathBuf,
    /// The manifest.
    pub(super) manifest: PathBuf,
    preset: Preset,
    report: Option<PathBuf>,
    /// The model that is read, if it is a file.
    source: Option<PathBuf>,
    references: References,
}

/// A file that is ready to be written.
pub(super) struct Ready {
    path: PathBuf,
    bytes: Vec<u8>,
}

/// Hashes of what the files of a bake depend on.
pub(super) fn hashes(scene: &Scene, options: &BakeOptions, preset: Preset) -> Hashes {
    let mut hashes = bake::hashes(scene, options);
    // Whether there is a report changes no other file.
    let also = format!("{:016x} {}", hashes.options.0, preset.name());
    hashes.options = Hash::of(also.as_bytes());
    hashes
}

impl Files {
    /// Checks that everything can be written, and that the model can become what is asked for.
    pub(super) fn new(
        output: &Path,
        source: Option<&Path>,
        preset: Preset,
        report: Option<&Path>,
    ) -> Result<Self, CliError> {
        if let Some(folder) = source.filter(|source| source.is_dir()) {
            return Err(invalid(format!("{}: this is a folder", folder.display()), "name a model file in it"));
        }
        let extension = |path: &Path| path.extension().unwrap_or_default().to_string_lossy().to_ascii_lowercase();
        let from = source.map(extension).unwrap_or_default();
        match extension(output).as_str() {
            "obj" if preset == Preset::Raw => {}
            "obj" => {
                let problem = format!("--preset {} needs glTF: an .obj model cannot refer to lightmaps", preset.name());
                return Err(invalid(problem, "write a .glb, or use --preset raw"));
            }
            to @ ("glb" | "gltf") if to == from => {}
            to @ ("glb" | "gltf") => {
                let what = match source {
                    None => "the built-in scene".to_owned(),
                    Some(source) if from.is_empty() => source.display().to_string(),
                    Some(_) => format!("a .{from} model"),
                };
                let problem = format!("{what} cannot be written as .{to}");
                return Err(invalid(problem, "write the same format as the input, or .obj with --preset raw"));
            }
            _ => {
                let problem = format!("{}: models cannot be written in this format", output.display());
                return Err(invalid(problem, "give a name that ends in .glb, .gltf or .obj"));
            }
        }
        let files = Self {
            model: output.to_owned(),
            manifest: output.with_extension("json"),
            preset,
            report: report.map(Path::to_owned),
            source: source.map(Path::to_owned),
            references: References::default(),
        };
        if let Some(source) = &files.source
            && source
                .canonicalize()
                .ok()
                .is_some_and(|source| output.canonicalize().is_ok_and(|output| output == source))
        {
            let problem = format!("{} is the input model", output.display());
            return Err(invalid(problem, "give the output another name"));
        }
        let named = files.named();
        for (i, path) in named.iter().enumerate() {
            if named[..i].contains(path) {
                let problem = format!("{} would be written twice", path.display());
                return Err(invalid(problem, "give each file a name of its own"));
            }
            OutputFile::check(path).map_err(CliError::input)?;
        }
        Ok(files)
    }

    /// Finds what the model refers to, so that a bake that could not name it does not begin.
    pub(super) fn find_references(&mut self) -> Result<(), CliError> {
        if let Some(source) = &self.source {
            self.references = References::find(&self.model, source)?;
        }
        Ok(())
    }

    /// Output besides pages.
    pub(super) fn named(&self) -> Vec<&Path> {
        [Some(&self.model), Some(&self.manifest), self.report.as_ref()]
            .into_iter()
            .flatten()
            .map(PathBuf::as_path)
            .collect()
    }

    /// Checks that pages can be written, and are not among the input files.
    pub(super) fn check_pages(&self, pages: usize, options: &BakeOptions, inputs: &[PathBuf]) -> Result<(), CliError> {
        for page in 0..pages {
            let names = [Some(self.page(page, "exr")), self.map_name(page), self.directional_name(page, options)];
            for path in names.iter().flatten().map(|name| self.beside(name)) {
                OutputFile::check(&path).map_err(CliError::input)?;
                inputs::refuse(&[path], inputs)?;
            }
        }
        Ok(())
    }

    /// Hashes of what the files depend on.
    pub(super) fn hashes(&self, scene: &Scene, options: &BakeOptions) -> Hashes {
        hashes(scene, options, self.preset)
    }

    /// The reason to rewrite files although their inputs are unchanged: requested files that were not written, or have
    /// changed; `None` if there is none.
    pub(super) fn fault(&self, manifest: &Manifest) -> Option<String> {
        let asked = [Some(self.model.as_path()), self.report.as_deref()].into_iter().flatten();
        let is_new = |path: &&Path| manifest.outputs.iter().all(|output| output.file != self.relative(path));
        if let Some(new) = asked.into_iter().find(is_new) {
            return Some(format!("{} is missing", new.display()));
        }
        let changed = manifest.outputs.iter().find(|output| {
            std::fs::read(self.beside(&output.file)).map_or(true, |bytes| Hash::of(&bytes) != output.hash)
        });
        changed.map(|output| format!("{} was changed since it was written", self.beside(&output.file).display()))
    }

    /// A file in the folder of the model.
    fn beside(&self, name: &str) -> PathBuf {
        self.model.with_file_name(name)
    }

    /// The name of a page's file.
    fn page(&self, page: usize, extension: &str) -> String {
        format!("{}-{page}.{extension}", self.model.file_stem().unwrap_or_default().to_string_lossy())
    }

    /// The name of a page's file for engines; `None` if the preset has none beside the master.
    fn map_name(&self, page: usize) -> Option<String> {
        match self.preset {
            Preset::Raw => None,
            Preset::Bevy => Some(self.page(page, "ktx2")),
            Preset::Three => Some(self.page(page, "hdr")),
        }
    }

    /// The name of a page's file of where light comes from, if there is one.
    fn directional_name(&self, page: usize, options: &BakeOptions) -> Option<String> {
        let has_one = self.preset != Preset::Raw && options.directional != Directional::None;
        has_one.then(|| self.page(page, &format!("{}.ktx2", options.directional.name())))
    }

    /// Writes everything; gives the paths and warnings.
    pub(super) fn write(
        &self,
        scene: &Scene,
        bake: &Bake,
        options: &BakeOptions,
        hashes: Hashes,
    ) -> Result<(Vec<PathBuf>, Vec<String>), CliError> {
        let is_light = options.mode != Mode::Ao;
        let (unit, scale) = match (self.preset, is_light) {
            (_, false) => (Unit::Openness, 1.0),
            (Preset::Bevy, true) => (Unit::IrradianceOverPi, 1.0 / std::f32::consts::PI),
            (Preset::Three | Preset::Raw, true) => (Unit::Irradiance, 1.0),
        };
        let source =
            self.source.as_deref().and_then(Path::file_name).unwrap_or_default().to_string_lossy().into_owned();
        let mut manifest = Manifest::new(source, unit, options.seed, hashes);
        let (mut ready, mut warnings) = (Vec::new(), Vec::new());
        // The names of what the model shows, and their bytes.
        let mut maps: Vec<(String, Vec<u8>)> = Vec::new();
        for index in 0..bake.maps.len() {
            let page = self.encode(bake, index, options, scale, &mut warnings)?;
            maps.push((page.entry.file.clone(), page.map));
            manifest.pages.push(page.entry);
            ready.extend(page.files);
        }
        manifest.surfaces = pages::surfaces(scene, bake);
        let model = self.model(scene, bake, &maps, &mut warnings)?;
        ready.push(Ready { path: self.model.clone(), bytes: model });
        if let Some(path) = &self.report {
            let html = report::html(&self.report(scene, bake, &warnings)).map_err(CliError::system)?;
            ready.push(Ready { path: path.clone(), bytes: html.into_bytes() });
        }
        for Ready { path, bytes } in &ready {
            OutputFile::check(path).and_then(|file| file.write(bytes)).map_err(CliError::system)?;
            let file = self.relative(path);
            manifest.outputs.push(Output { file, hash: Hash::of(bytes) });
        }
        let json = manifest.to_json();
        OutputFile::check(&self.manifest).and_then(|file| file.write(json.as_bytes())).map_err(CliError::system)?;
        let mut written: Vec<PathBuf> = ready.into_iter().map(|ready| ready.path).collect();
        written.push(self.manifest.clone());
        Ok((written, warnings))
    }

    /// A path as the manifest names it: from the folder of the model if it is there, else in full.
    fn relative(&self, path: &Path) -> String {
        let full = std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
        let folder = std::path::absolute(&self.model).unwrap_or_else(|_| self.model.clone());
        let name = full.strip_prefix(folder.parent().unwrap_or(Path::new(""))).unwrap_or(&full);
        name.to_string_lossy().into_owned()
    }

    /// The bytes of the model.
    fn model(
        &self,
        scene: &Scene,
        bake: &Bake,
        maps: &[(String, Vec<u8>)],
        warnings: &mut Vec<String>,
    ) -> Result<Vec<u8>, CliError> {
        let is_obj = self.model.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("obj"));
        let Some(source) = self.source.as_ref().filter(|_| !is_obj) else {
            return Ok(bake::obj::write(scene, &bake.atlas, &self.references.libraries).into_bytes());
        };
        let original =
            std::fs::read(source).map_err(|error| CliError::Input(format!("{}: {error}", source.display())))?;
        let lists: Vec<(Vec<u32>, Vec<Vec2>)> = bake
            .atlas
            .parts
            .iter()
            .map(|part| part.vertices.iter().map(|vertex| (vertex.source, vertex.uv)).unzip())
            .collect();
        let parts = bake.atlas.parts.iter().zip(&lists).map(|(part, (sources, uvs))| Part {
            mesh: &scene.meshes[part.mesh],
            page: part.page,
            sources,
            uvs,
            triangles: &part.triangles,
        });
        let parts: Vec<Part> = parts.collect();
        let embed = self.preset == Preset::Three && self.model.extension().is_some_and(|extension| extension == "glb");
        let pages = maps.iter().map(|(file, bytes)| Page { file, embedded: embed.then_some(&bytes[..]) });
        let target = if self.preset == Preset::Three { Target::Three } else { Target::Bevy };
        let patched =
            gltf::patch(source, &original, &parts, &pages.collect::<Vec<_>>(), (target, &self.references.folders))?;
        warnings.extend(patched.warnings);
        Ok(patched.bytes)
    }
}
