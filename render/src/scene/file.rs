//! Scene files: TOML that names a model and says what model formats cannot.
//!
//! ```toml
//! [scene]
//! file = "hall.glb"      # relative to the folder of this file
//! emission = "both"      # which sides of emitters emit: "front" or "both"
//! lights = "photometric" # the units of its light sources: "photometric" or "radiometric"
//! light_radius = 0.1     # of its point and spot lights, for soft shadows
//! sun_angle = 0.53       # that its directional lights subtend, degrees
//! variant = "oak"        # of its materials
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
//! All but `scene.file` may be left out, and that where there are objects. `[[material]]` tables change materials: see
//! `material_table.rs`. `[[light]]` tables add lights: see `light_table.rs`. `[[object]]` and `[[instance]]` show models
//! at many places: see `objects.rs`. `[[aov]]` tables add AOVs: see `aov_table.rs`. The keys `lights`, `light_radius`,
//! `sun_angle` and `emission` are about the model's lights, and leave these as they are. Each value is checked here; what
//! only several options together can get wrong is left to [`Overrides::apply`], since the command line may still change it.

use std::path::{Path, PathBuf};

use toml::de::{DeTable, DeValue};

use super::aov_table;
use super::light_table;
use super::load_options::{LoadOptions, LoadWatch};
use super::load_with;
use super::material_table::{self, MaterialTable};
use super::moving::add_motion;
use super::nearest::suggestion;
use super::objects::{InstanceTable, ObjectTable, Objects, read_instances, read_objects};
use super::toml_text::{Entry, entries, line_of, shortened, value_of};
use super::value::{self, Expected, Value};
use super::{IntegratorOverrides, Overrides, Place, Scene, SceneError, Sharing};

/// What a scene file says.
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
    /// Where they are shown.
    pub instances: Vec<InstanceTable>,
}

/// The sections of a scene file with their keys.
const SECTIONS: [(&str, &[&str]); 5] = [
    (
        "scene",
        &[
            "file",
            "emission",
            "lights",
            "light_radius",
            "sun_angle",
            "variant",
            "instances",
            "frame",
            "fps",
            "animation",
        ],
    ),
    (
        "camera",
        &[
            "type",
            "eye",
            "target",
            "up",
            "vfov",
            "focal_length",
            "sensor",
            "sensor_fit",
            "shift",
            "aperture",
            "f_number",
            "focus",
            "focus_at",
            "blades",
            "blade_rotation",
            "anamorphic",
            "mm_per_unit",
            "ortho_height",
            "ortho_width",
            "ipd",
            "fisheye",
            "fov",
            "near",
            "far",
            "model_clip",
            "rays",
            "shutter",
            "shutter_ramp",
            "shutter_keys",
        ],
    ),
    (
        "film",
        &[
            "width",
            "height",
            "filter",
            "filter_width",
            "sharpness",
            "aov",
            "aov_through",
            "cryptomatte",
            "cryptomatte_levels",
            "light_groups",
        ],
    ),
    (
        "render",
        &[
            "spp",
            "sampler",
            "seed",
            "build",
            "integrator",
            "max_depth",
            "lights",
            "stop",
            "cutoff",
            "add_back",
            "roulette_after",
            "survival",
            "clamp_indirect",
            "guide",
            "bounces",
            "rays",
            "sampling",
            "ao_weighting",
            "ao_distance",
            "cache_error",
            "gradients",
            "metric",
            "layout",
            "record_rays",
            "cache_bounces",
            "accuracy",
        ],
    ),
    ("sky", &["radiance", "picture", "rotation", "scale", "daylight", "daylight_model", "daylight_albedo"]),
];

/// Reads a scene: the model at `path`, or the scene file (`.toml`) and the model that it names.
pub fn open(path: &Path) -> Result<(Scene, Overrides), SceneError> {
    open_with(path, &Overrides::default())
}

/// Reads a scene as [`open`] does, at the moment and with the sharing of `overrides`, or those of the scene file where they set
/// none. [`Sharing::Never`] means that all meshes are in world space.
pub fn open_with(path: &Path, overrides: &Overrides) -> Result<(Scene, Overrides), SceneError> {
    open_watched(path, overrides, None)
}

/// Reads a scene as [`open_with`] does, while somebody watches.
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
    let read = |options: &LoadOptions| match &file {
        Some(file) => assemble(path, file, options),
        None => load_with(path, options),
    };
    let mut scene = read(&LoadOptions { sharing, moment: moments.moment(), watch, ..LoadOptions::default() })?;
    if let Some(keys) = moments.shutter_moments().filter(|_| !scene.animations.is_empty()) {
        let ramp = moments.shutter_ramp.unwrap_or(0.0);
        let read = |moment| read(&LoadOptions { sharing, moment: Some(moment), without_pictures: true, watch });
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

impl Parser<'_> {
    fn parse(&self) -> Result<SceneFile, SceneError> {
        let document = DeTable::parse(self.text).map_err(|error| {
            let message = error.message().lines().next().unwrap_or("not TOML").to_owned();
            self.error(error.span().unwrap_or(0..0).start, message, "see https://toml.io for how TOML is written")
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
            let sections: Vec<&str> = SECTIONS
                .iter()
                .map(|&(name, _)| name)
                .chain(["light", "material", "object", "instance", "aov"])
                .collect();
            let Some((_, keys)) = SECTIONS.iter().find(|(name, _)| *name == section.name) else {
                let problem = format!("unknown section {:?}", section.name);
                return Err(self.error(section.at.start, problem, suggestion(section.name, &sections)));
            };
            let DeValue::Table(table) = section.value else {
                let problem = format!("`{}` is not a section", section.name);
                return Err(self.error(section.at.start, problem, format!("write [{}] on a line", section.name)));
            };
            for entry in entries(table) {
                if (section.name, entry.name) == ("scene", "file") {
                    model = Some(self.file("scene", "a model", &entry)?);
                } else if keys.contains(&entry.name) {
                    self.set(&mut overrides, section.name, &entry)?;
                } else {
                    let problem = format!("unknown key {:?} in [{}]", entry.name, section.name);
                    return Err(self.error(entry.at.start, problem, suggestion(entry.name, keys)));
                }
            }
        }
        let remedy = "name one: [scene] on a line, then file = \"model.glb\"";
        if model.is_none() && objects.is_empty() {
            return Err(SceneError::new(self.path, Place::File, "no model is named", remedy));
        }
        Ok(SceneFile { model, overrides, materials, objects, instances })
    }

    /// Sets the option that `entry` of `section` stands for; it is one of `SECTIONS`.
    fn set(&self, to: &mut Overrides, section: &str, entry: &Entry<'_>) -> Result<(), SceneError> {
        match entry.name {
            _ if section == "camera" && !entry.name.starts_with("shutter") => self.set_camera(to, section, entry)?,
            "lights" if section == "scene" => {
                to.light.light_units = Some(self.read(value::light_units, section, entry)?)
            }
            "light_radius" => to.light.light_radius = Some(self.read(value::light_radius, section, entry)?),
            "sun_angle" => to.light.sun_angle = Some(self.read(value::sun_angle, section, entry)?),
            "variant" => to.variant = Some(self.read(value::text, section, entry)?),
            "instances" => to.instances = Some(self.read(value::sharing, section, entry)?),
            "frame" => to.moment.frame = Some(self.read(value::frame, section, entry)?),
            "fps" => to.moment.fps = Some(self.read(value::fps, section, entry)?),
            "animation" => to.moment.animations = Some(self.read(value::names, section, entry)?),
            "shutter" => to.moment.shutter = Some(self.read(value::shutter, section, entry)?),
            "shutter_ramp" => to.moment.shutter_ramp = Some(self.read(value::shutter_ramp, section, entry)?),
            "shutter_keys" => to.moment.shutter_keys = Some(self.read(value::shutter_keys, section, entry)?),
            "emission" => to.light.emits_both_sides = Some(self.read(value::emission, section, entry)?),
            "width" => to.width = Some(self.read(value::side, section, entry)?),
            "height" => to.height = Some(self.read(value::side, section, entry)?),
            "filter" => to.filter = Some(self.read(value::filter, section, entry)?),
            "filter_width" => to.filter_width = Some(self.read(value::filter_width, section, entry)?),
            "sharpness" => to.sharpness = Some(self.read(value::sharpness, section, entry)?),
            "aov" => to.aov = Some(self.read(value::flag, section, entry)?),
            "aov_through" => to.aov_through = Some(self.read(value::flag, section, entry)?),
            "cryptomatte" => to.cryptomatte = Some(self.read(value::matte_kinds, section, entry)?),
            "cryptomatte_levels" => to.cryptomatte_levels = Some(self.read(value::matte_levels, section, entry)?),
            "light_groups" => to.light_groups = Some(self.read(value::flag, section, entry)?),
            "spp" => to.spp = Some(self.read(value::count, section, entry)?),
            "sampler" => to.sampler = Some(self.read(value::sampler, section, entry)?),
            "seed" => to.seed = Some(self.read(value::seed, section, entry)?),
            "build" => to.build = Some(self.read(value::quality, section, entry)?),
            "radiance" => to.light.sky = Some(self.read(value::radiance, section, entry)?),
            "picture" => to.light.sky_light.picture = Some(self.file(section, "a picture", entry)?),
            "rotation" => to.light.sky_light.rotation = Some(self.read(value::degrees, section, entry)?),
            "scale" => to.light.sky_light.scale = Some(self.read(value::scale, section, entry)?),
            "daylight" => to.light.sky_light.daylight = Some(self.read(value::daylight, section, entry)?),
            "daylight_model" => {
                to.light.sky_light.daylight_model = Some(self.read(value::daylight_model, section, entry)?)
            }
            "daylight_albedo" => to.light.sky_light.daylight_albedo = Some(self.read(value::albedo, section, entry)?),
            _ => self.set_integrator(&mut to.integrator, section, entry)?,
        }
        Ok(())
    }

    /// Sets an option of the camera.
    fn set_camera(&self, to: &mut Overrides, section: &str, entry: &Entry<'_>) -> Result<(), SceneError> {
        let camera = &mut to.camera;
        match entry.name {
            "eye" => to.eye = Some(self.read(value::point, section, entry)?),
            "target" => to.target = Some(self.read(value::point, section, entry)?),
            "up" => to.up = Some(self.read(value::direction, section, entry)?),
            "vfov" => to.vfov = Some(self.read(value::vfov, section, entry)?),
            "type" => camera.kind = Some(self.read(value::camera_kind, section, entry)?),
            "focal_length" => camera.focal_length = Some(self.read(value::length, section, entry)?),
            "sensor" => camera.sensor = Some(self.read(value::sensor, section, entry)?),
            "sensor_fit" => camera.sensor_fit = Some(self.read(value::sensor_fit, section, entry)?),
            "shift" => camera.shift = Some(self.read(value::shift, section, entry)?),
            "aperture" => camera.aperture = Some(self.read(value::aperture, section, entry)?),
            "f_number" => camera.f_number = Some(self.read(value::length, section, entry)?),
            "focus" => camera.focus = Some(self.read(value::length, section, entry)?),
            "focus_at" => camera.focus_at = Some(self.read(value::point, section, entry)?),
            "blades" => camera.blades = Some(self.read(value::blades, section, entry)?),
            "blade_rotation" => camera.blade_rotation = Some(self.read(value::degrees, section, entry)?),
            "anamorphic" => camera.anamorphic = Some(self.read(value::anamorphic, section, entry)?),
            "mm_per_unit" => camera.mm_per_unit = Some(self.read(value::length, section, entry)?),
            "ortho_height" => camera.ortho_height = Some(self.read(value::length, section, entry)?),
            "ortho_width" => camera.ortho_width = Some(self.read(value::length, section, entry)?),
            "ipd" => camera.ipd = Some(self.read(value::aperture, section, entry)?),
            "fisheye" => camera.fisheye = Some(self.read(value::fisheye, section, entry)?),
            "fov" => camera.fov = Some(self.read(value::fisheye_fov, section, entry)?),
            "near" => camera.near = Some(self.read(value::near, section, entry)?),
            "far" => camera.far = Some(self.read(value::length, section, entry)?),
            "model_clip" => camera.model_clip = Some(self.read(value::flag, section, entry)?),
            "rays" => camera.rays = Some(self.file(section, "a file of rays", entry)?),
            name => unreachable!("[{section}] {name} is listed, but sets nothing"),
        }
        Ok(())
    }

    /// Sets an option that belongs to an integrator.
    fn set_integrator(&self, to: &mut IntegratorOverrides, section: &str, entry: &Entry<'_>) -> Result<(), SceneError> {
        match entry.name {
            "integrator" => to.integrator = Some(self.read(value::integrator, section, entry)?),
            "max_depth" => to.max_depth = Some(self.read(value::count, section, entry)?),
            "lights" => to.lights = Some(self.read(value::lights, section, entry)?),
            "stop" => to.stop = Some(self.read(value::stop, section, entry)?),
            "cutoff" => to.cutoff = Some(self.read(value::fraction, section, entry)?),
            "add_back" => to.add_back = Some(self.read(value::flag, section, entry)?),
            "roulette_after" => to.roulette_after = Some(self.read(value::number, section, entry)?),
            "survival" => to.survival = Some(self.read(value::survival, section, entry)?),
            "clamp_indirect" => to.clamp_indirect = Some(self.read(value::clamp, section, entry)?),
            "guide" => to.guide = Some(self.read(value::guide, section, entry)?),
            "bounces" => to.bounces = Some(self.read(value::number, section, entry)?),
            "rays" => to.rays = Some(self.read(value::count, section, entry)?),
            "sampling" => to.sampling = Some(self.read(value::hemisphere_sampling, section, entry)?),
            "ao_weighting" => to.ao_weighting = Some(self.read(value::ao_weighting, section, entry)?),
            "ao_distance" => to.ao_distance = Some(self.read(value::distance, section, entry)?),
            "cache_error" => to.cached.cache_error = Some(self.read(value::cache_error, section, entry)?),
            "gradients" => to.cached.gradients = Some(self.read(value::gradients, section, entry)?),
            "metric" => to.cached.metric = Some(self.read(value::metric, section, entry)?),
            "layout" => to.cached.layout = Some(self.read(value::gather_layout, section, entry)?),
            "record_rays" => to.cached.record_rays = Some(self.read(value::record_rays, section, entry)?),
            "accuracy" => to.cached.accuracy = Some(self.read(value::accuracy, section, entry)?),
            "cache_bounces" => to.cached.cache_bounces = Some(self.read(value::cache_bounces, section, entry)?),
            name => unreachable!("[{section}] {name} is listed, but sets nothing"),
        }
        Ok(())
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
