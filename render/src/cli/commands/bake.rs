//! `halfdome bake`: a level's lightmaps, from a model to a model.

mod check;
mod files;
mod inside;
mod part;

use std::io::IsTerminal;
use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use clap::Args;
use glam::Vec3;

use crate::bake::atlas::Atlas;
use crate::bake::manifest::Manifest;
use crate::bake::{self, BakeOptions, Checkpoint, Coordinates, Directional, Mode, Preset, Sampling};
use crate::cli::args::light::LightArguments;
use crate::cli::args::{CommonArguments, names, shard};
use crate::cli::error::{CliError, EXIT_DONE, EXIT_INTERRUPTED, invalid};
use crate::cli::lock::Lock;
use crate::cli::messages::{Style, print_text, print_warning, warn};
use crate::cli::prepare::{CORNELL, Prepared, prepare_from, thread_pool};
use crate::cli::progress::Progress;
use crate::cli::{inputs, interrupt, memory};
use crate::output::OutputFile;
use crate::scene::{CachedOverrides, Overrides, Scene, SceneFile, Sharing};
use crate::settings::Shard;
use crate::world::{LightQuery, World};
use files::Files;
use inside::Inside;
pub(super) use part::is_state;

/// How often the state of a bake is written.
const STATE_INTERVAL: Duration = Duration::from_secs(30);

/// Bytes that a bake takes for each texel of its pages, as measured, ...
const BYTES: u64 = 150;
/// ... and those with a cache.
const CACHED_BYTES: u64 = 270;

/// Sizes of pages.
const SIZES: RangeInclusive<i64> = BakeOptions::MIN_SIZE as i64..=BakeOptions::MAX_SIZE as i64;

/// The arguments of `halfdome bake`.
#[derive(Args, Clone, Debug)]
pub(crate) struct BakeArguments {
    /// A model (.glb, .gltf, .obj, .ply), a scene file (.toml), or `cornell` for the built-in scene
    scene: PathBuf,

    /// Model to write, with lightmap coordinates: .glb or .gltf like the input, or .obj. Maps and a manifest (.json)
    /// are named after it
    #[arg(short, long, value_name = "FILE", required_unless_present = "check_uv")]
    output: Option<PathBuf>,

    /// Target: bevy (E/π as KTX2), three (E as .hdr, MOZ_lightmap) or raw; EXR maps of E are always written
    #[arg(long, value_name = "NAME", default_value = "raw", value_parser = names(Preset::ALL, Preset::name))]
    preset: Preset,

    /// Light to bake: full, indirect (light reflected by surfaces, and the sky), direct (emitters, lights and the sun
    /// of an environment map) or ao (ambient occlusion)
    #[arg(long, value_name = "WHAT", default_value = "full", value_parser = names(Mode::ALL, Mode::name))]
    mode: Mode,

    /// Directional layers: none, hl2 (irradiance for three normals) or sh1 (spherical harmonics of radiance, first
    /// order); in the EXR maps and, for bevy and three, in a KTX2 array (.hl2.ktx2, .sh1.ktx2)
    #[arg(long, value_name = "BASIS", default_value = "none")]
    #[arg(value_parser = names(Directional::ALL, Directional::name))]
    directional: Directional,

    /// Samples of direct light per texel; with --mode ao, rays per texel
    #[arg(long, value_name = "N", allow_hyphen_values = true, conflicts_with = "accuracy")]
    #[arg(default_value_t = BakeOptions::default().spp, value_parser = clap::value_parser!(u32).range(1..))]
    spp: u32,

    /// Gather at every texel, without an irradiance cache, with the rays of a record
    #[arg(long, conflicts_with_all = ["accuracy", "cache_error", "gradients", "metric"])]
    brute: bool,

    /// --mode ao: hits farther away than this do not occlude [default: unlimited]
    #[arg(long, value_name = "D", allow_hyphen_values = true, value_parser = positive)]
    ao_distance: Option<f32>,

    /// Denoise the maps, each chart on its own
    #[arg(long)]
    denoise: bool,

    /// Largest width and height of a page in texels
    #[arg(long, value_name = "TEXELS", allow_hyphen_values = true, help_heading = "Layout")]
    #[arg(default_value_t = BakeOptions::default().size, value_parser = clap::value_parser!(u32).range(SIZES))]
    size: u32,

    /// Texels per unit of length, on as many pages as that takes [default: what fits on one page]
    #[arg(long, value_name = "TEXELS_PER_UNIT", allow_hyphen_values = true, help_heading = "Layout")]
    #[arg(value_parser = positive)]
    density: Option<f32>,

    /// How the engine will filter the maps: bilinear or bicubic
    #[arg(long, value_name = "HOW", default_value = "bilinear", help_heading = "Layout")]
    #[arg(value_parser = names(Sampling::ALL, Sampling::name))]
    sampling: Sampling,

    /// Least distance between charts in texels [default: 2; 4 with --sampling bicubic]
    #[arg(long, value_name = "TEXELS", allow_hyphen_values = true, help_heading = "Layout")]
    #[arg(value_parser = clap::value_parser!(u32).range(1..=i64::from(BakeOptions::MAX_GUTTER)))]
    gutter: Option<u32>,

    /// The model's second texture coordinates (UV2): auto (use them if they are valid), keep (fail if they are not) or
    /// new (ignore them)
    #[arg(long, value_name = "WHICH", default_value = "auto", help_heading = "Layout")]
    #[arg(value_parser = names(Coordinates::ALL, Coordinates::name))]
    uv: Coordinates,

    /// Check UV2 instead of baking, or new coordinates if the model has none: overlaps, lost and stretched charts,
    /// fill; draw them if a picture (.png) is named
    #[arg(long, value_name = "PICTURE", num_args = 0..=1, require_equals = true, help_heading = "Layout")]
    check_uv: Option<Option<PathBuf>>,

    /// Skip surfaces that cannot be seen from inside, such as a house's outer walls: no light, and no texels in new
    /// layouts. Inside is where four of five rays hit something; or what can be reached from the camera (=camera) or
    /// from a position (=X,Y,Z), which may be given several times
    #[arg(long, value_name = "FROM", num_args = 0..=1, require_equals = true, default_missing_value = "auto")]
    #[arg(help_heading = "Layout", value_parser = Inside::parse)]
    skip_outside: Vec<Inside>,

    #[command(flatten)]
    cache: CachedOverrides,

    #[command(flatten)]
    light: LightArguments,

    /// Continue a bake that was stopped or killed, from the state beside the output
    #[arg(long)]
    resume: bool,

    /// Bake shard K of N, 1 to N, of the texels without an irradiance cache, and write a state (-o PART.state): direct
    /// light, ambient occlusion, all light with --brute. `halfdome merge` joins the states; with the result beside the
    /// output, --resume does the rest
    #[arg(long, value_name = "K/N", allow_hyphen_values = true, value_parser = shard)]
    #[arg(conflicts_with_all = ["report", "check_uv"])]
    shard: Option<Shard>,

    /// Write an HTML report: charts, density, records and errors
    #[arg(long, value_name = "FILE")]
    report: Option<PathBuf>,

    /// Threads and progress.
    #[command(flatten)]
    pub(crate) common: CommonArguments,
}

impl BakeArguments {
    /// The bake's options; `eye` is the position of the file's camera, `seed` the scene file's.
    fn options(&self, eye: Option<Vec3>, seed: u64) -> Result<BakeOptions, CliError> {
        Ok(BakeOptions {
            mode: self.mode,
            directional: self.directional,
            sampling: self.sampling,
            coordinates: self.uv,
            size: self.size,
            density: self.density,
            gutter: self.gutter,
            spp: self.spp,
            brute: self.brute,
            cache: self.cache.options(),
            ao_distance: self.ao_distance,
            skip_outside: Inside::places(&self.skip_outside, eye)?,
            denoise: self.denoise,
            seed,
        })
    }

    /// The model's file; `None` for the built-in scene.
    fn model(&self) -> Result<Option<PathBuf>, CliError> {
        if self.scene == Path::new(CORNELL) {
            return Ok(None);
        }
        let is_toml = self.scene.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("toml"));
        if !is_toml {
            return Ok(Some(self.scene.clone()));
        }
        let model = SceneFile::read(&self.scene)?.model;
        model.map(Some).ok_or_else(|| {
            let problem = format!("{} names no model to bake, and objects get no lightmap", self.scene.display());
            invalid(
                problem,
                "put what is baked into a model, and name it: [scene] on a line, then file = \"level.glb\"",
            )
        })
    }
}

/// Bakes a level, or checks its coordinates.
pub(crate) fn run(arguments: &BakeArguments) -> Result<u8, CliError> {
    if arguments.ao_distance.is_some() && arguments.mode != Mode::Ao {
        let problem = format!("--ao-distance is for --mode ao, and not for --mode {}", arguments.mode.name());
        return Err(invalid(problem, "leave --ao-distance out, or use --mode ao"));
    }
    let style = arguments.common.progress.style(std::io::stderr().is_terminal());
    // Each copy has texels of its own.
    let overrides = Overrides { instances: Some(Sharing::Never), ..arguments.light.overrides() };
    let pool = thread_pool(&arguments.common)?;
    if let Some(picture) = &arguments.check_uv {
        check::check_name(picture.as_deref())?;
        let named = picture.as_slice();
        let Prepared { scene, settings, eye, .. } =
            pool.install(|| prepare_from(&arguments.scene, overrides, named, style))?;
        let options = arguments.options(eye, settings.seed)?;
        return pool.install(|| check::run(&scene, &options, picture.as_deref(), style));
    }
    let Some(output) = &arguments.output else { unreachable!("required without --check-uv") };
    inputs::check_report(arguments.report.as_deref())?;
    if arguments.mode == Mode::Ao && arguments.directional != Directional::None {
        let problem = format!("--mode ao cannot be directional (--directional {})", arguments.directional.name());
        return Err(invalid(problem, "leave --directional out, or use another --mode"));
    }
    if arguments.mode == Mode::Ao && arguments.cache.accuracy.is_some() {
        return Err(invalid("--mode ao knows no --accuracy".to_owned(), "give --spp, its rays per texel"));
    }
    if let Some(shard) = arguments.shard {
        return run_shard(arguments, (output, overrides), shard, (&pool, style));
    }
    let mut files = Files::new(output, arguments.model()?.as_deref(), arguments.preset, arguments.report.as_deref())?;
    // Two bakes would replace each other's state and maps. These and the manifest are named alike for .glb, .gltf and
    // .obj.
    let _lock = Lock::new(&files.manifest, "baking to files of this name")?;
    let named = files.named();
    let Prepared { mut scene, settings, eye, .. } =
        pool.install(|| prepare_from(&arguments.scene, overrides, &named, style))?;
    files.find_references()?;
    let options = arguments.options(eye, settings.seed)?;
    warn(style, &mut scene.warnings);
    pool.install(|| bake(arguments, scene, &options, &files, style))
}

/// Bakes a shard.
fn run_shard(
    arguments: &BakeArguments,
    (output, overrides): (&PathBuf, Overrides),
    shard: Shard,
    (pool, style): (&rayon::ThreadPool, Style),
) -> Result<u8, CliError> {
    arguments.model()?;
    let named = std::slice::from_ref(output);
    let Prepared { mut scene, settings, eye, .. } =
        pool.install(|| prepare_from(&arguments.scene, overrides, named, style))?;
    let options = arguments.options(eye, settings.seed)?;
    part::check(arguments, &options, output)?;
    warn(style, &mut scene.warnings);
    let hash = bake::combined(&files::hashes(&scene, &options, arguments.preset));
    pool.install(|| part::run(&scene, (&options, hash), (output, arguments.resume), shard, style))
}

fn bake(
    arguments: &BakeArguments,
    scene: Scene,
    options: &BakeOptions,
    files: &Files,
    style: Style,
) -> Result<u8, CliError> {
    let hashes = files.hashes(&scene, options);
    if let Ok(old) = Manifest::read(&files.manifest) {
        let mut changes = hashes.changes_since(&old.made_from);
        if old.generator != Manifest::GENERATOR {
            // Another version may find other light, and lay charts out in another way.
            changes.insert(0, format!("the maps are by {:?}, and this is {}", old.generator, Manifest::GENERATOR));
        }
        if !changes.is_empty() {
            // Any surface may reflect light to any other.
            print_text(
                style,
                &format!(
                    "{}: light may have changed everywhere, so the whole level is baked again",
                    changes.join(", ")
                ),
            );
        } else if let Some(fault) = files.fault(&old) {
            print_text(style, &format!("{fault}, so the whole level is baked again"));
        } else {
            print_text(style, &format!("{} is up to date", files.model.display()));
            return Ok(EXIT_DONE);
        }
    }
    let state = Checkpoint::path(&files.model);
    let hash = bake::combined(&hashes);
    let checkpoint = if arguments.resume { Checkpoint::read(&state, hash)? } else { None };
    let state_file = OutputFile::check(&state).map_err(CliError::input)?;
    let checkpoint = checkpoint.unwrap_or_else(|| Checkpoint::new(hash)).keep(state_file, STATE_INTERVAL);

    let world = World::for_light_query(scene.clone(), LightQuery::Surfaces).map_err(CliError::input)?;
    warn(style, &mut bake::model_warnings(&scene, &world));
    let left_out = inside::left_out(&scene, &world, options, style)?;
    let begin = Instant::now();
    let layout = Progress::of_layout(style, begin);
    let atlas = Atlas::watched(&scene, &left_out, options, &|step| layout.layout(step));
    drop(layout);
    let mut atlas = atlas?;
    files.check_pages(atlas.pages.len(), options, &scene.files)?;
    warn(style, &mut atlas.warnings);
    let texels = atlas.pages.iter().map(|page| page.texels() as u64).sum::<u64>();
    let bytes = texels * if options.has_cache() { CACHED_BYTES } else { BYTES };
    memory::require(&format!("a bake of {texels} texels"), bytes, "use a lower --density or a smaller --size")?;
    interrupt::catch()?;
    let progress = texel_progress(style, bake::work(&scene, &atlas, options), begin, options);
    let baked = bake::bake(&scene, &world, atlas, options, &checkpoint, &progress);
    drop(progress);
    drop(world);
    let Some(mut baked) = baked else {
        checkpoint.save().map_err(CliError::system)?;
        print_text(style, &format!("interrupted; continue with --resume from {}", state.display()));
        return Ok(EXIT_INTERRUPTED);
    };
    warn(style, &mut baked.warnings);
    if let Some(failure) = checkpoint.failure() {
        print_warning(style, &format!("the state for --resume could not be written: {failure}"));
    }
    let (written, mut warnings) = files.write(&scene, &baked, options, hashes)?;
    warn(style, &mut warnings);
    checkpoint.remove().map_err(CliError::system)?;
    files.print(style, &baked, options.cache.accuracy, &written);
    Ok(EXIT_DONE)
}

/// Shows how far a bake is whose layout was begun at `begin`.
fn texel_progress(style: Style, work: u64, begin: Instant, options: &BakeOptions) -> Progress {
    let caches = match (options.has_cache(), options.cache.bounces) {
        (false, _) => 0,
        (true, None) => 2,
        (true, Some(_)) => 1,
    };
    // With an accuracy caches are tried out; with a number of bounces each has one.
    let again = options.cache.accuracy.is_some() || options.cache.bounces.is_some_and(|bounces| bounces > 1);
    Progress::of_texels(style, work, begin, caches, again)
}

fn positive(text: &str) -> Result<f32, String> {
    let number = text.parse().ok().filter(|number: &f32| number.is_finite() && *number > 0.0);
    number.ok_or_else(|| "expected a number greater than 0".to_owned())
}

#[cfg(test)]
mod tests {
    use clap::{Command, FromArgMatches};

    use super::*;

    #[test]
    fn defaults_are_those_of_the_library() {
        let command = BakeArguments::augment_args(Command::new("bake"));
        let matches = command.get_matches_from(["bake", "level.glb", "-o", "baked.glb"]);
        let arguments = BakeArguments::from_arg_matches(&matches).unwrap();
        assert_eq!(arguments.options(None, 0).unwrap(), BakeOptions::default());
    }
}
