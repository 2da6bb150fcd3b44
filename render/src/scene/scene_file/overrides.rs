//! The options that a scene file and the command line may set: what they override, and how they combine.
//!
//! The command line overrides the scene file, the scene file the model, the model the defaults.

mod cached;
mod camera;
mod camera_keys;
mod conflict;
mod integrator;
mod light;
mod moment;
mod optics;
pub(crate) mod options;
mod pose;
mod sky;
#[cfg(test)]
mod tests;

use glam::Vec3;
use halfdome_kernel::Quality;
use halfdome_kernel::sampling::Pattern;

use super::value::{self, MatteKinds};
use crate::scene::nearest::suggestion;
use crate::scene::{Scene, Sharing};
use crate::settings::{Aov, Cryptomatte, Filter, Invalid, MAX_SIDE, Settings};

pub use cached::CachedOverrides;
pub use camera::CameraOverrides;
pub use conflict::Conflict;
use conflict::Group;
pub use integrator::IntegratorOverrides;
pub use light::LightOverrides;
pub use moment::MomentOverrides;
pub(crate) use optics::MM_PER_UNIT;
use options::{Or, Source, options};
pub use sky::SkyOverrides;

options! {
    /// Options that are set here; the others are `None` and leave things as they are.
    pub struct Overrides;
    options {
        /// Position of the camera, in the model's units
        #[arg(value_name = "X,Y,Z", help_heading = "Camera", allow_hyphen_values = true)]
        eye: Vec3 = value::point, in "camera";
        /// The point in the middle of the picture
        #[arg(value_name = "X,Y,Z", help_heading = "Camera", allow_hyphen_values = true)]
        target: Vec3 = value::point, in "camera";
        /// Up direction of the picture [default: 0,1,0 for a new camera, else the model's]
        #[arg(value_name = "X,Y,Z", help_heading = "Camera", allow_hyphen_values = true)]
        up: Vec3 = value::direction, in "camera";
        /// Vertical field of view in degrees [default: 40 for a new camera, else the model's]
        #[arg(value_name = "DEGREES", help_heading = "Camera", allow_hyphen_values = true)]
        vfov: f32 = value::vfov, in "camera";
        /// Width of the picture in pixels [default: 512, or by the aspect ratio of the model's camera]
        #[arg(value_name = "PIXELS", help_heading = "Film")]
        #[arg(allow_hyphen_values = true)]
        width: u32 = value::side, in "film";
        /// Height of the picture in pixels [default: 512, or by the aspect ratio of the model's camera]
        #[arg(value_name = "PIXELS", help_heading = "Film")]
        #[arg(allow_hyphen_values = true)]
        height: u32 = value::side, in "film";
        /// Pixel filter: box, tent, gaussian or mitchell; replaces the scene file's filter, width and sharpness
        /// [default: box]
        #[arg(value_name = "NAME", help_heading = "Film")]
        filter: String = value::filter, in "film";
        /// Full width of the filter in pixels [default: depends on the filter]
        #[arg(value_name = "PIXELS", help_heading = "Film")]
        #[arg(allow_hyphen_values = true)]
        filter_width: f32 = value::filter_width, in "film";
        /// Sharpness of the mitchell filter, from 0 (soft) to 1 (sharp)
        #[arg(value_name = "S", help_heading = "Film")]
        #[arg(allow_hyphen_values = true)]
        sharpness: f32 = value::sharpness, in "film";
        /// Samples per pixel [default: the model's, or 64]
        #[arg(value_name = "N", help_heading = "Render")]
        #[arg(allow_hyphen_values = true)]
        spp: u32 = value::count, in "render";
        /// Sequence of random numbers: random, sobol or r2 [default: sobol]
        #[arg(value_name = "NAME", help_heading = "Render")]
        sampler: Pattern = value::sampler, in "render";
        /// Seed of the random numbers [default: 0]
        #[arg(value_name = "N", help_heading = "Render")]
        #[arg(allow_hyphen_values = true)]
        seed: u64 = value::seed, in "render";
        /// Quality of the BVH: fast, medium or high; the picture is the same [default: high]
        #[arg(value_name = "QUALITY", help_heading = "Render")]
        build: Quality = value::quality, in "render";
        /// Add channels to the EXR: Albedo, P, N, Ns, u, v, Depth, Id of the first surface, Variance, Samples, HalfA
        /// and HalfB
        #[arg(help_heading = "Film", num_args = 0..=1, require_equals = true)]
        #[arg(value_name = "BOOL", default_missing_value = "true")]
        aov: bool = value::flag, in "film";
        /// With --aov: where the first surface is a mirror or clear glass, use the surfaces seen through it, as
        /// --denoise does
        #[arg(help_heading = "Film", num_args = 0..=1, require_equals = true)]
        #[arg(value_name = "BOOL", default_missing_value = "true")]
        aov_through: bool = value::flag, in "film";
        /// Add Cryptomatte 1.2 masks to the EXR: object, material or both, as object,material
        #[arg(value_name = "KINDS", help_heading = "Film")]
        cryptomatte: MatteKinds = value::matte_kinds, in "film";
        /// Most names of a pixel in a Cryptomatte [default: 6]
        #[arg(value_name = "N", help_heading = "Film")]
        cryptomatte_levels: u32 = value::matte_levels, in "film";
        /// Add an AOV of the light of each light group to the EXR: of lights by their names, or by their keys `group`
        #[arg(help_heading = "Film", num_args = 0..=1, require_equals = true)]
        #[arg(value_name = "BOOL", default_missing_value = "true")]
        light_groups: bool = value::flag, in "film";
        /// Camera of the model to use, by its name or its number from 1 (glTF) [default: the first]
        #[arg(value_name = "NAME", help_heading = "Camera")]
        model_camera: String = value::text, in "camera";
        /// Material variant of the model to use (glTF's KHR_materials_variants)
        #[arg(value_name = "NAME", help_heading = "Model")]
        variant: String = value::text, in "scene";
        /// Draw glTF's points and lines as spheres and cylinders of this radius, in the coordinates of their mesh
        /// [default: skip them]
        #[arg(value_name = "R", help_heading = "Model", allow_hyphen_values = true)]
        point_radius: f32 = value::length, in "scene";
        /// Store repeated meshes of the model once: always, never, or auto, where copies would have over a million
        /// triangles [default: auto]
        #[arg(value_name = "WHEN", help_heading = "Model")]
        instances: Sharing = value::sharing, in "scene";
    }
    others {
        /// The kind of camera and what it has.
        #[command(flatten)]
        camera: CameraOverrides;
        /// The integrator and its options.
        #[command(flatten)]
        integrator: IntegratorOverrides;
        /// Add an AOV of the light of some paths to the EXR, for example --lpe direct=CDL: a name, and a light path
        /// expression as in Open Shading Language; can be given several times
        #[arg(long = "lpe", value_name = "NAME=EXPR", help_heading = "Film", value_parser = Aov::parse)]
        aovs: Vec<Aov>;
        /// The lights and the sky.
        #[command(flatten)]
        light: LightOverrides;
        /// The moment of the model's animations.
        #[command(flatten)]
        moment: MomentOverrides;
    }
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
        self.or_each(fallback)
    }

    /// The keys that a section of a scene file may have.
    pub(crate) fn keys(section: &str) -> Vec<&'static str> {
        let groups = [
            Self::KEYS,
            CameraOverrides::KEYS,
            MomentOverrides::KEYS,
            IntegratorOverrides::KEYS,
            CachedOverrides::KEYS,
            LightOverrides::KEYS,
            SkyOverrides::KEYS,
        ];
        groups.concat().into_iter().filter(|(of, _)| *of == section).map(|(_, key)| key).collect()
    }

    /// Sets the option of a scene file's key; returns whether there is one.
    pub(crate) fn set_key<S: Source>(&mut self, section: &str, key: &str, source: &S) -> Result<bool, S::Error> {
        let Self { camera, moment, integrator, light, .. } = self;
        Ok(camera.set(section, key, source)?
            || moment.set(section, key, source)?
            || integrator.set(section, key, source)?
            || integrator.cached.set(section, key, source)?
            || light.set(section, key, source)?
            || light.sky_light.set(section, key, source)?
            || self.set(section, key, source)?)
    }

    /// Whether the camera at these options' eye and target is a new one, which has nothing of the model's.
    pub fn make_camera(&self) -> bool {
        self.is_new_camera()
    }

    /// Whether any option of a camera is set.
    pub fn set_camera(&self) -> bool {
        self.sets_any(Group::Camera)
    }

    /// Overrides `scene` and the default settings. Afterwards the scene has a valid camera; a warning reports an
    /// automatic one.
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

impl Or for Vec<Aov> {
    /// These AOVs, and of the others those with other names.
    fn or(self, others: Self) -> Self {
        let is_other = |other: &Aov| self.iter().all(|aov| aov.name != other.name);
        let mut joined: Self = others.into_iter().filter(is_other).collect();
        joined.extend(self);
        joined
    }
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
