//! The files of a bake: the model, its maps, a manifest and a report. Each is replaced atomically, the manifest last,
//! so that a manifest only names files that exist.

mod pages;

use std::path::{Path, PathBuf};

use glam::Vec2;
use serde_json::json;

use super::{invalid, print_text};
use crate::bake::atlas::NO_CHART;
use crate::bake::gltf::{self, Page, Part, Target};
use crate::bake::manifest::{Hash, Hashes, Manifest, Output, Unit};
use crate::bake::report::{self, Report, ReportPage};
use crate::bake::{self, Bake, BakeOptions, Directional, Mode, Preset};
use crate::cli::error::CliError;
use crate::cli::inputs;
use crate::cli::messages::{Style, print_line};
use crate::cli::progress::job::accuracy_text;
use crate::output::OutputFile;
use crate::scene::{Scene, count};

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
            return Ok(bake::obj::write(scene, &bake.atlas).into_bytes());
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
        let patched = gltf::patch(source, &original, &parts, &pages.collect::<Vec<_>>(), target)?;
        warnings.extend(patched.warnings);
        Ok(patched.bytes)
    }

    /// The summary as text.
    fn report(&self, scene: &Scene, bake: &Bake, warnings: &[String]) -> Report {
        let s = &bake.statistics;
        // No rays: a bake that was resumed counts its own alone, and its report is that of one that was not.
        let figures: [(&str, u64); 7] = [
            ("meshes", scene.meshes.len() as u64),
            ("charts", bake.atlas.charts.len() as u64),
            ("texels on surfaces", s.texels),
            ("hemispheres gathered", s.gathers),
            ("texels moved out from under other objects", s.moved),
            ("texels covered as a whole", s.covered),
            ("points matched at seams", s.seams),
        ];
        let page = |page: usize| {
            let (size, map) = (bake.atlas.pages[page], &bake.maps[page]);
            let chart = |&owner: &u32| (owner != NO_CHART).then_some(owner);
            let density =
                |&owner: &u32| chart(&owner).map_or(f32::NAN, |owner| bake.atlas.charts[owner as usize].density());
            let known = |(&error, &source): (&f32, &bake::TexelSource)| {
                if source == bake::TexelSource::Light { error } else { f32::NAN }
            };
            ReportPage {
                name: self.page(page, "exr"),
                width: size.width,
                height: size.height,
                charts: map.owners.iter().map(chart).collect(),
                density: map.owners.iter().map(density).collect(),
                map: map.layers[0].texels.clone(),
                records: bake
                    .record_places
                    .iter()
                    .filter(|place| place.0 == page)
                    .map(|place| place.1.to_array())
                    .collect(),
                error: Some(map.errors.iter().zip(&map.sources).map(known).collect()),
            }
        };
        Report {
            title: self.model.file_name().unwrap_or_default().to_string_lossy().into_owned(),
            statistics: figures
                .iter()
                .map(|(name, number)| ((*name).to_owned(), number.to_string()))
                .chain([("relative error, estimated".to_owned(), bake.error().text())])
                .collect(),
            warnings: bake.warnings.iter().chain(warnings).cloned().collect(),
            pages: (0..bake.maps.len()).map(page).collect(),
        }
    }

    /// Says how it went.
    pub(super) fn print(&self, style: Style, bake: &Bake, asked: Option<f32>, written: &[PathBuf]) {
        let (s, error) = (&bake.statistics, bake.error());
        let share = 100.0 * s.gathers as f64 / s.texels.max(1) as f64;
        match style {
            Style::Silent => {}
            Style::Json => print_line(&json!({
                "event": "end",
                "accuracy": bake.accuracy,
                "pages": bake.maps.len(),
                "charts": bake.atlas.charts.len(),
                "texels": s.texels,
                "gathers": s.gathers,
                "rays": s.rays,
                "moved": s.moved,
                "covered": s.covered,
                "seams": s.seams,
                "misses": s.misses,
                "error": {
                    "root_mean_square": error.root_mean_square,
                    "median": error.median,
                    "percentile_95": error.percentile_95,
                    "above_5_percent": error.above_5_percent,
                },
                "files": written.iter().map(|path| path.display().to_string()).collect::<Vec<_>>(),
            })),
            Style::Bar => {
                let pages = count(bake.maps.len(), "page", "pages");
                let texels = format!("{pages}, {} texels, {} gathers ({share:.1}%)", s.texels, s.gathers);
                let covered =
                    format!("{} texels moved out from under other objects, {} covered completely", s.moved, s.covered);
                print_text(style, &format!("{texels}, {} rays\n{covered}", s.rays));
                if let (Some(asked), Some(estimated)) = (asked, bake.accuracy) {
                    print_text(style, &accuracy_text(asked, estimated));
                }
                print_text(style, &format!("relative error, estimated: {}", error.text()));
                written.iter().for_each(|path| print_text(style, &format!("wrote {}", path.display())));
            }
        }
    }
}
