//! The options that a scene file and the command line may set: what they override, and how they combine.
//!
//! The command line wins over the scene file, the scene file over the model, the model over the defaults.

mod cached;
mod camera;
mod camera_keys;
mod integrator;
mod light;
mod moment;
mod optics;
mod pose;
mod sky;

use std::fmt;
use std::path::{Path, PathBuf};

use clap::Args;
use glam::Vec3;
use halfdome_kernel::Quality;
use halfdome_kernel::sampling::Pattern;

use super::nearest::suggestion;
use super::value::{self, MatteKinds, argument};
use super::{Scene, Sharing};
use crate::settings::{Aov, Cryptomatte, Filter, Invalid, MAX_SIDE, Settings};

pub use cached::CachedOverrides;
pub use camera::CameraOverrides;
pub use integrator::IntegratorOverrides;
pub use light::LightOverrides;
pub use moment::MomentOverrides;
pub(crate) use optics::MM_PER_UNIT;
pub use sky::SkyOverrides;

/// Options that are set here; the others are `None` and leave things as they are.
#[derive(Args, Clone, Debug, Default, PartialEq)]
pub struct Overrides {
    /// Position of the camera, in the model's units
    #[arg(long, value_name = "X,Y,Z", help_heading = "Camera", allow_hyphen_values = true)]
    #[arg(value_parser = argument(value::point))]
    pub eye: Option<Vec3>,
    /// The point in the middle of the picture
    #[arg(long, value_name = "X,Y,Z", help_heading = "Camera", allow_hyphen_values = true)]
    #[arg(value_parser = argument(value::point))]
    pub target: Option<Vec3>,
    /// Up direction of the picture [default: 0,1,0 for a new camera, else the model's]
    #[arg(long, value_name = "X,Y,Z", help_heading = "Camera", allow_hyphen_values = true)]
    #[arg(value_parser = argument(value::direction))]
    pub up: Option<Vec3>,
    /// Vertical field of view in degrees [default: 40 for a new camera, else the model's]
    #[arg(long, value_name = "DEGREES", help_heading = "Camera", allow_hyphen_values = true)]
    #[arg(value_parser = argument(value::vfov))]
    pub vfov: Option<f32>,
    /// The kind of camera and what it has.
    #[command(flatten)]
    pub camera: CameraOverrides,

    /// Width of the picture in pixels [default: 512, or by the aspect ratio of the model's camera]
    #[arg(long, value_name = "PIXELS", help_heading = "Film")]
    #[arg(value_parser = argument(value::side), allow_negative_numbers = true)]
    pub width: Option<u32>,
    /// Height of the picture in pixels [default: 512, or by the aspect ratio of the model's camera]
    #[arg(long, value_name = "PIXELS", help_heading = "Film")]
    #[arg(value_parser = argument(value::side), allow_negative_numbers = true)]
    pub height: Option<u32>,
    /// Pixel filter: box, tent, gaussian or mitchell; replaces the scene file's filter, width and sharpness [default:
    /// box]
    #[arg(long, value_name = "NAME", help_heading = "Film", value_parser = argument(value::filter))]
    pub filter: Option<String>,
    /// Full width of the filter in pixels [default: depends on the filter]
    #[arg(long, value_name = "PIXELS", help_heading = "Film")]
    #[arg(value_parser = argument(value::filter_width), allow_negative_numbers = true)]
    pub filter_width: Option<f32>,
    /// Sharpness of the mitchell filter, from 0 (soft) to 1 (sharp)
    #[arg(long, value_name = "S", help_heading = "Film")]
    #[arg(value_parser = argument(value::sharpness), allow_negative_numbers = true)]
    pub sharpness: Option<f32>,

    /// The integrator and its options.
    #[command(flatten)]
    pub integrator: IntegratorOverrides,
    /// Samples per pixel [default: the model's, or 64]
    #[arg(long, value_name = "N", help_heading = "Render")]
    #[arg(value_parser = argument(value::count), allow_negative_numbers = true)]
    pub spp: Option<u32>,
    /// Sequence of random numbers: random, sobol or r2 [default: sobol]
    #[arg(long, value_name = "NAME", help_heading = "Render", value_parser = argument(value::sampler))]
    pub sampler: Option<Pattern>,
    /// Seed of the random numbers [default: 0]
    #[arg(long, value_name = "N", help_heading = "Render")]
    #[arg(value_parser = argument(value::seed), allow_negative_numbers = true)]
    pub seed: Option<u64>,
    /// Quality of the BVH: fast, medium or high; the picture is the same [default: high]
    #[arg(long, value_name = "QUALITY", help_heading = "Render", value_parser = argument(value::quality))]
    pub build: Option<Quality>,
    /// Add channels to the EXR: Albedo, P, N, Ns, u, v, Depth, Id of the first surface, Variance, Samples, HalfA and HalfB
    #[arg(long, help_heading = "Film", num_args = 0..=1, require_equals = true)]
    #[arg(value_name = "BOOL", default_missing_value = "true", value_parser = argument(value::flag))]
    pub aov: Option<bool>,
    /// With --aov: where the first surface is a mirror or clear glass, the channels are of what it shows, as --denoise has
    /// them
    #[arg(long, help_heading = "Film", num_args = 0..=1, require_equals = true)]
    #[arg(value_name = "BOOL", default_missing_value = "true", value_parser = argument(value::flag))]
    pub aov_through: Option<bool>,

    /// Add Cryptomatte 1.2 masks to the EXR: object, material or both, as object,material
    #[arg(long, value_name = "KINDS", help_heading = "Film", value_parser = argument(value::matte_kinds))]
    pub cryptomatte: Option<MatteKinds>,
    /// How many names a pixel has in a Cryptomatte at most [default: 6]
    #[arg(long, value_name = "N", help_heading = "Film", value_parser = argument(value::matte_levels))]
    pub cryptomatte_levels: Option<u32>,
    /// Add an AOV of the light of some paths to the EXR, for example --lpe direct=CDL: a name, and a light path
    /// expression as in Open Shading Language; can be given several times
    #[arg(long = "lpe", value_name = "NAME=EXPR", help_heading = "Film", value_parser = Aov::parse)]
    pub aovs: Vec<Aov>,
    /// Add an AOV of the light of each light group to the EXR: of lights by their names, or by their keys `group`
    #[arg(long, help_heading = "Film", num_args = 0..=1, require_equals = true)]
    #[arg(value_name = "BOOL", default_missing_value = "true", value_parser = argument(value::flag))]
    pub light_groups: Option<bool>,

    /// The lights and the sky.
    #[command(flatten)]
    pub light: LightOverrides,
    /// Material variant of the model to use (glTF's KHR_materials_variants)
    #[arg(long, value_name = "NAME", help_heading = "Model")]
    pub variant: Option<String>,
    /// Whether meshes that the model shows several times are kept once: always, never, or auto, where copies would have
    /// over a million triangles [default: auto]
    #[arg(long, value_name = "WHEN", help_heading = "Model", value_parser = argument(value::sharing))]
    pub instances: Option<Sharing>,
    /// The moment of the model's animations.
    #[command(flatten)]
    pub moment: MomentOverrides,
}

impl Overrides {
    /// These options, and those of `fallback` where these are not set. A filter's width and sharpness belong to it: if
    /// a filter is set here, those of the fallback's do not count.
    pub fn or(self, mut fallback: Self) -> Self {
        if self.filter.is_some() {
            (fallback.filter_width, fallback.sharpness) = (None, None);
        }
        if self.vfov.is_some() {
            fallback.camera.focal_length = None;
        }
        if self.camera.replaces_vfov() {
            fallback.vfov = None;
        }
        Self {
            eye: self.eye.or(fallback.eye),
            target: self.target.or(fallback.target),
            up: self.up.or(fallback.up),
            vfov: self.vfov.or(fallback.vfov),
            camera: self.camera.or(fallback.camera),
            width: self.width.or(fallback.width),
            height: self.height.or(fallback.height),
            filter: self.filter.or(fallback.filter),
            filter_width: self.filter_width.or(fallback.filter_width),
            sharpness: self.sharpness.or(fallback.sharpness),
            integrator: self.integrator.or(fallback.integrator),
            spp: self.spp.or(fallback.spp),
            sampler: self.sampler.or(fallback.sampler),
            seed: self.seed.or(fallback.seed),
            build: self.build.or(fallback.build),
            aov: self.aov.or(fallback.aov),
            aov_through: self.aov_through.or(fallback.aov_through),
            cryptomatte: self.cryptomatte.or(fallback.cryptomatte),
            cryptomatte_levels: self.cryptomatte_levels.or(fallback.cryptomatte_levels),
            aovs: join(self.aovs, fallback.aovs),
            light_groups: self.light_groups.or(fallback.light_groups),
            light: self.light.or(fallback.light),
            variant: self.variant.or(fallback.variant),
            instances: self.instances.or(fallback.instances),
            moment: self.moment.or(fallback.moment),
        }
    }

    /// Whether the camera at these options' eye and target is a new one, which has nothing of the model's.
    pub fn make_camera(&self) -> bool {
        self.is_new_camera()
    }

    /// Whether any option of a camera is set.
    pub fn set_camera(&self) -> bool {
        self.sets_any(Group::Camera)
    }

    /// Overrides `scene` and the default settings. Afterwards the scene has a valid camera; a warning tells of one that
    /// was made up.
    ///
    /// # Errors
    /// If options do not go together, or with the scene.
    pub fn apply(&self, scene: &mut Scene) -> Result<Settings, Conflict> {
        let settings = self.settings(scene)?;
        if let Some(name) = &self.variant {
            choose_variant(scene, name).map_err(|error| Conflict::new(Group::Variant, error))?;
        }
        self.moment.warn(scene);
        self.apply_camera(scene, (settings.width, settings.height))
            .map_err(|error| Conflict::new(Group::Camera, error))?;
        self.light.apply(scene).map_err(|error| Conflict::new(Group::Sky, error))?;
        Ok(settings)
    }

    /// Pixels across and down: what is not set follows from the kind of camera, or the size or aspect of the model's
    /// if that is used.
    fn size(&self, scene: &Scene, default: &Settings) -> (u32, u32) {
        let is_of_model = !self.is_new_camera() && scene.camera.is_some();
        let of_model = scene.camera_aspect.filter(|_| is_of_model).map(f64::from);
        let natural = self.natural_aspect(self.camera_kind(&scene.optics));
        let aspect = natural.or(of_model);
        let film = scene.film_size.filter(|_| is_of_model && natural.is_none());
        if let (None, None, Some(size)) = (self.width, self.height, film) {
            return size;
        }
        let scaled = |side: u32, by: f64| ((f64::from(side) * by).round() as u32).clamp(1, MAX_SIDE);
        match (self.width, self.height, aspect) {
            (None, None, Some(aspect)) => (scaled(default.height, aspect), default.height),
            (None, Some(height), Some(aspect)) => (scaled(height, aspect), height),
            (Some(width), None, Some(aspect)) => (width, scaled(width, aspect.recip())),
            (width, height, _) => (width.unwrap_or(default.width), height.unwrap_or(default.height)),
        }
    }

    fn settings(&self, scene: &Scene) -> Result<Settings, Conflict> {
        let default = Settings::default();
        let (width, height) = self.size(scene, &default);
        let settings = Settings {
            width,
            height,
            filter: self.film_filter().map_err(|error| Conflict::new(Group::Filter, error))?,
            integrator: self.integrator.integrator().map_err(|error| Conflict::new(Group::Integrator, error))?,
            spp: self.spp.or(scene.film_spp).unwrap_or(default.spp),
            sampler: self.sampler.unwrap_or(default.sampler),
            seed: self.seed.unwrap_or(default.seed),
            build: self.build.unwrap_or(default.build),
            aov: self.aov.unwrap_or(default.aov),
            aov_through: self.aov_through.unwrap_or(default.aov_through),
            halves: self.aov.unwrap_or(default.halves),
            cryptomatte: Cryptomatte {
                kinds: self.cryptomatte.clone().map_or(default.cryptomatte.kinds, |MatteKinds(kinds)| kinds),
                levels: self.cryptomatte_levels.unwrap_or(default.cryptomatte.levels),
            },
            aovs: self.aovs.clone(),
            light_groups: self.light_groups.unwrap_or(default.light_groups),
        };
        settings.check_light_paths().map_err(|error| Conflict::new(Group::Aovs, error))?;
        Settings::check_pixels(settings.width, settings.height).map_err(|error| Conflict::new(Group::Size, error))?;
        Ok(settings)
    }

    /// Whether any option is set that a conflict in `group` may be about.
    fn sets_any(&self, group: Group) -> bool {
        match group {
            Group::Camera => {
                let poses = [self.eye, self.target, self.up];
                poses.iter().any(Option::is_some) || self.vfov.is_some() || self.camera.sets_any()
            }
            Group::Size => self.width.is_some() || self.height.is_some(),
            Group::Filter => self.filter.is_some() || self.filter_width.is_some() || self.sharpness.is_some(),
            Group::Integrator => self.integrator.sets_any(),
            Group::Sky => self.light.sets_sky_light(),
            Group::Variant => self.variant.is_some(),
            Group::Aovs => !self.aovs.is_empty() || self.light_groups.is_some(),
        }
    }

    /// The pixel filter, `box` if none is named.
    fn film_filter(&self) -> Result<Filter, Invalid> {
        let name = self.filter.as_deref().unwrap_or("box");
        Filter::from_name(name, self.filter_width, self.sharpness)
            .map_err(|error| Invalid::new(error.problem, error.remedy))
    }
}

/// These AOVs, and of the others those with other names.
fn join(aovs: Vec<Aov>, others: Vec<Aov>) -> Vec<Aov> {
    let is_other = |other: &Aov| aovs.iter().all(|aov| aov.name != other.name);
    let mut joined: Vec<Aov> = others.into_iter().filter(is_other).collect();
    joined.extend(aovs);
    joined
}

/// Shows a variant of the model's materials.
fn choose_variant(scene: &mut Scene, name: &str) -> Result<(), Invalid> {
    if scene.choose_variant(name) {
        return Ok(());
    }
    let names: Vec<&str> = scene.variants.iter().map(|variant| variant.name.as_str()).collect();
    let remedy =
        if names.is_empty() { "the model has none: leave the option out".to_owned() } else { suggestion(name, &names) };
    Err(Invalid::new(format!("the model has no variant {name:?}"), remedy))
}

fn replace<T: Copy>(value: &mut T, with: Option<T>) {
    *value = with.unwrap_or(*value);
}

/// Options that do not go together, or with the scene.
///
/// Prints as [`Invalid`] does, after the scene file if that has a part in it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Conflict {
    group: Group,
    error: Invalid,
    file: Option<PathBuf>,
}

/// Options that can be in conflict with each other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Group {
    Camera,
    Size,
    Filter,
    Integrator,
    Sky,
    Variant,
    Aovs,
}

impl Conflict {
    fn new(group: Group, error: Invalid) -> Self {
        Self { group, error, file: None }
    }

    /// The conflict with the name of the scene at `path`, whose file sets `options`, if any of them are involved.
    pub fn naming(self, path: &Path, options: &Overrides) -> Self {
        let file = options.sets_any(self.group).then(|| path.to_owned());
        Self { file, ..self }
    }
}

impl fmt::Display for Conflict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(file) = &self.file {
            write!(f, "{}: ", file.display())?;
        }
        write!(f, "{}", self.error)
    }
}

impl std::error::Error for Conflict {}

#[cfg(test)]
mod tests;
