//! Scene files: TOML that names a model and adds what model formats lack.
//!
//! ```toml
//! [scene]
//! file = "hall.glb"      # relative to the folder of this file
//! emission = "both"      # which sides of emitters emit: "front" or "both"
//! lights = "photometric" # the units of its light sources: "photometric" or "radiometric"
//! light_radius = 0.1     # of its point and spot lights, for soft shadows
//! sun_angle = 0.53       # that its directional lights subtend, degrees
//! variant = "oak"        # of its materials
//! point_radius = 0.01    # of its points and lines, which are left out otherwise
//! instances = "auto"     # whether meshes that it shows several times are kept once: "auto", "always" or "never"
//! frame = 12             # of its animations: frame / fps seconds
//! fps = 24
//! animation = "Walk"     # the one to play; or several: ["Walk", "Camera"]
//!
//! [camera]
//! eye = [1.0, 1.7, 4.0]
//! target = [0.0, 1.0, 0.0]
//! up = [0.0, 1.0, 0.0]
//! vfov = 40.0            # degrees
//! # or type = "orthographic", "panorama", "fisheye", "cube", "rays"; these and lenses: see docs/render.md
//!
//! [film]
//! width = 1280
//! height = 720
//! filter = "mitchell"
//! filter_width = 4.0     # pixels
//! sharpness = 0.67
//! aov = false
//! aov_through = false
//! cryptomatte = "object,material"
//! cryptomatte_levels = 6
//! light_groups = false
//!
//! [render]
//! spp = 256
//! sampler = "sobol"
//! seed = 1
//! build = "high"         # of the tree: "fast", "medium" or "high"
//! integrator = "path"    # and its options, which are called as on the command line
//! max_depth = 16
//! roulette_after = 4
//!
//! [sky]
//! radiance = [0.3, 0.4, 0.6]
//! picture = "sunset.hdr" # or .exr, equirectangular: added to the radiance
//! rotation = 90          # of the picture, degrees
//! scale = 2              # of the picture or the daylight
//! # or, without a picture: daylight = [40, 120, 3], the sun's elevation and azimuth, and turbidity
//! # with daylight_model = "hosek" (or "preetham") and daylight_albedo = 0.3, of the ground
//! ```
//!
//! Everything except `scene.file` is optional, and that too if there are objects. `[[material]]` tables change
//! materials: see `material_table.rs`. `[[light]]` tables add lights: see `light_table.rs`. `[[object]]` and
//! `[[instance]]` place models many times: see `objects.rs`. `[[aov]]` tables add AOVs: see `aov_table.rs`. The keys
//! `lights`, `light_radius`, `sun_angle` and `emission` apply to the model's lights, not to these. Each value is
//! checked here; conflicts between options are left to [`Overrides::apply`], since the command line may still change
//! it.

use std::path::{Path, PathBuf};

use toml::de::{DeTable, DeValue};

use super::aov_table;
use super::light_table;
use super::material_table::{self, MaterialTable};
use super::moving::add_motion;
use super::objects::{InstanceTable, ObjectTable, Objects, read_instances, read_objects};
use super::overrides::options::Source;
use super::toml_text::{Entry, entries, line_of, shortened, value_of};
use super::value::{self, Expected, Value};
use crate::scene::formats::load_options::{LoadOptions, LoadWatch};
use crate::scene::nearest::suggestion;
use crate::scene::{Overrides, Place, Scene, SceneError, Sharing, load_with};

/// The contents of a scene file.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneFile {
    /// The model, relative to the current folder or absolute; `None` if there are only objects.
    pub model: Option<PathBuf>,
    /// The options that the file sets.
    pub overrides: Overrides,
    /// The materials that it changes or adds.
    pub materials: Vec<MaterialTable>,
    /// Models that are shown where instances are.
    pub objects: Vec<ObjectTable>,
    /// Their instances.
    pub instances: Vec<InstanceTable>,
}

/// The sections of a scene file that hold options.
const SECTIONS: [&str; 5] = ["scene", "camera", "film", "render", "sky"];

/// Tables of which there may be many.
const TABLES: [&str; 5] = ["light", "material", "object", "instance", "aov"];

/// Reads a scene: the model at `path`, or the scene file (`.toml`) and the model that it names.
pub fn open(path: &Path) -> Result<(Scene, Overrides), SceneError> {
    open_with(path, &Overrides::default())
}

/// Reads a scene as [`open`] does, at the moment and with the sharing of `overrides`, or those of the scene file where
/// they set none. [`Sharing::Never`] means that all meshes are in world space.
pub fn open_with(path: &Path, overrides: &Overrides) -> Result<(Scene, Overrides), SceneError> {
    open_watched(path, overrides, None)
}

/// Reads a scene like [`open_with`], and reports progress.
pub fn open_watched(
    path: &Path,
    overrides: &Overrides,
    watch: Option<&dyn LoadWatch>,
) -> Result<(Scene, Overrides), SceneError> {
    let is_toml = path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("toml"));
    let file = if is_toml { Some(SceneFile::read(path)?) } else { None };
    let of_file = file.as_ref().map(|file| file.overrides.clone()).unwrap_or_default();
    let moments = overrides.moment.clone().or(of_file.moment.clone());
    let sharing = overrides.instances.or(of_file.instances).unwrap_or_default();
    let point_radius = overrides.point_radius.or(of_file.point_radius);
    let camera = overrides.model_camera.as_deref().or(of_file.model_camera.as_deref());
    let options = LoadOptions { sharing, point_radius, camera, watch, ..LoadOptions::default() };
    let read = |options: &LoadOptions| match &file {
        Some(file) => assemble(path, file, options),
        None => load_with(path, options),
    };
    let mut scene = read(&LoadOptions { moment: moments.moment(), ..options.clone() })?;
    if let Some(keys) = moments.shutter_moments().filter(|_| !scene.animations.is_empty()) {
        let ramp = moments.shutter_ramp.unwrap_or(0.0);
        let read = |moment| read(&LoadOptions { moment: Some(moment), without_pictures: true, ..options.clone() });
        add_motion(&mut scene, keys, ramp, read)?;
    }
    Ok((scene, of_file))
}

/// The scene of the scene file at `path`.
fn assemble(path: &Path, file: &SceneFile, options: &LoadOptions) -> Result<Scene, SceneError> {
    let mut scene = match &file.model {
        Some(model) => load_with(model, options)?,
        None => Scene::default(),
    };
    let objects = Objects::load(&file.objects, path, &mut scene, options)?;
    let used: Vec<&str> = file.instances.iter().flat_map(InstanceTable::new_materials).collect();
    material_table::apply(&file.materials, &used, path, &mut scene)?;
    objects.place(&file.instances, &mut scene)?;
    if options.sharing == Sharing::Never {
        scene.place_instances();
    }
    scene.files.push(path.to_owned());
    Ok(scene)
}

impl SceneFile {
    /// Reads the scene file at `path`.
    pub fn read(path: &Path) -> Result<Self, SceneError> {
        let bytes = std::fs::read(path).map_err(|error| SceneError::unreadable(path, &error))?;
        let text = String::from_utf8(bytes).map_err(|error| {
            let valid = error.utf8_error().valid_up_to();
            let line = line_of(error.as_bytes(), valid);
            SceneError::new(path, Place::Line(line), "this is not UTF-8", "save the file as UTF-8")
        })?;
        Self::parse(path, &text)
    }

    /// Parses `text`, the contents of the scene file at `path`. The model that it names must exist.
    pub fn parse(path: &Path, text: &str) -> Result<Self, SceneError> {
        Parser { path, text }.parse()
    }
}

struct Parser<'a> {
    path: &'a Path,
    text: &'a str,
}

/// An entry of a section.
struct EntryOf<'a> {
    parser: &'a Parser<'a>,
    section: &'a str,
    entry: &'a Entry<'a>,
}

impl Source for EntryOf<'_> {
    type Error = SceneError;

    fn read<T>(&self, reading: fn(&Value) -> Result<T, Expected>) -> Result<T, SceneError> {
        self.parser.read(reading, self.section, self.entry)
    }
}

impl Parser<'_> {
    fn parse(&self) -> Result<SceneFile, SceneError> {
        let document = DeTable::parse(self.text).map_err(|error| {
            let problem = error.message().lines().next().unwrap_or("not TOML");
            let at = error.span().unwrap_or(0..0).start;
            // What `.5` and `5.` lack, as the parser calls it.
            let remedy = match problem.contains("mantissa") || problem.contains("fraction") {
                true => "numbers have digits before and after the point: 0.5, 1.0",
                false => "see https://toml.io for how TOML is written",
            };
            self.error(at, problem.to_owned(), remedy)
        })?;
        let mut model = None;
        let mut overrides = Overrides::default();
        let (mut materials, mut objects, mut instances) = (Vec::new(), Vec::new(), Vec::new());
        for section in entries(document.get_ref()) {
            if section.name == "material" {
                materials = material_table::read(self.path, self.text, section.value, section.at.start)?;
                continue;
            }
            if section.name == "aov" {
                overrides.aovs = aov_table::read(self.path, self.text, section.value, section.at.start)?;
                continue;
            }
            if section.name == "object" {
                objects = read_objects(self.path, self.text, section.value, section.at.start)?;
                continue;
            }
            if section.name == "instance" {
                instances = read_instances(self.path, self.text, section.value, section.at.start)?;
                continue;
            }
            if section.name == "light" {
                overrides.light.added = light_table::read(self.path, self.text, section.value, section.at.start)?;
                continue;
            }
            if !SECTIONS.contains(&section.name) {
                return Err(self.unknown(&section));
            }
            let DeValue::Table(table) = section.value else {
                let problem = format!("`{}` is not a section", section.name);
                let written = self.text.get(section.value_at.clone()).unwrap_or_default();
                let remedy = match (section.name, section.value) {
                    ("scene", DeValue::String(_)) => {
                        format!("write [scene] on a line, then file = {}", shortened(written))
                    }
                    (name, _) => format!("write [{name}] on a line"),
                };
                return Err(self.error(section.at.start, problem, remedy));
            };
            for entry in entries(table) {
                if (section.name, entry.name) == ("scene", "file") {
                    model = Some(self.file("scene", "a model", &entry)?);
                } else if !self.set(&mut overrides, section.name, &entry)? {
                    let problem = format!("unknown key {:?} in [{}]", entry.name, section.name);
                    let mut keys = Overrides::keys(section.name);
                    keys.extend((section.name == "scene").then_some("file"));
                    // Far from `file` in spelling, but nothing else can be meant.
                    let name = if (section.name, entry.name) == ("scene", "model") { "file" } else { entry.name };
                    return Err(self.error(entry.at.start, problem, suggestion(name, &keys)));
                }
            }
        }
        let remedy = "name one: [scene] on a line, then file = \"model.glb\"";
        if model.is_none() && objects.is_empty() {
            return Err(SceneError::new(self.path, Place::File, "no model is named", remedy));
        }
        Ok(SceneFile { model, overrides, materials, objects, instances })
    }

    /// Sets the option of `entry` in `section`; returns whether there is one.
    fn set(&self, to: &mut Overrides, section: &str, entry: &Entry<'_>) -> Result<bool, SceneError> {
        match (section, entry.name) {
            ("scene", "animation") => to.moment.animations = Some(self.read(value::names, section, entry)?),
            ("camera", "rays") => to.camera.rays = Some(self.file(section, "a file of rays", entry)?),
            ("sky", "picture") => to.light.sky_light.picture = Some(self.file(section, "a picture", entry)?),
            (section, key) => return to.set_key(section, key, &EntryOf { parser: self, section, entry }),
        }
        Ok(true)
    }

    fn read<T>(
        &self,
        reading: fn(&Value) -> Result<T, Expected>,
        section: &str,
        entry: &Entry<'_>,
    ) -> Result<T, SceneError> {
        reading(&value_of(entry.value)).map_err(|expected| {
            let written = self.text.get(entry.value_at.clone()).unwrap_or_default();
            let problem = format!("{section}.{} is {}", entry.name, shortened(written));
            self.error(entry.value_at.start, problem, expected.to_string())
        })
    }

    /// The path of a file, which must exist.
    fn file(&self, section: &str, what: &str, entry: &Entry<'_>) -> Result<PathBuf, SceneError> {
        let folder = self.path.parent().unwrap_or(Path::new(""));
        let file = folder.join(self.read(value::text, section, entry)?);
        if file.is_file() {
            return Ok(file);
        }
        let (problem, remedy) = (
            format!("there is no file {}", file.display()),
            format!("name {what}, relative to the folder of this scene file"),
        );
        Err(self.error(entry.value_at.start, problem, remedy))
    }

    fn error(&self, offset: usize, problem: impl Into<String>, remedy: impl Into<String>) -> SceneError {
        SceneError::new(self.path, Place::Line(line_of(self.text.as_bytes(), offset)), problem, remedy)
    }
}

#[cfg(test)]
mod tests;
mod unknown;
