//! `halfdome cubemap`: an environment, or the view from a point in a scene, as a prefiltered cube map.

mod files;

use std::io::IsTerminal;
use std::path::{Path, PathBuf};
use std::slice;

use clap::Args;
use glam::Vec3;
use serde_json::json;

use crate::cli::args::light::LightArguments;
use crate::cli::args::{CommonArguments, exposure, names};
use crate::cli::error::{CliError, EXIT_DONE, EXIT_INTERRUPTED, invalid};
use crate::cli::messages::{Style, print_line, print_text, warn};
use crate::cli::prepare::{prepare_world, thread_pool};
use crate::cli::print::print;
use crate::cli::progress::Progress;
use crate::cli::{inputs, interrupt};
use crate::cubemap::{self, Axes, CubeMap, Environment, Filter, Language, Mapping, Options, Paths, Seams, measure};
use crate::output::{ToneCurve, ToneMapping};
use crate::scene::scene_file::value;
use crate::scene::{PunctualLight, Scene, Sky};
use crate::world::LightQuery;
use files::Files;

/// The default standard error of a texel.
const ACCURACY: f32 = 0.05;
/// The name of the options' sky in place of a path.
const SKY: &str = "sky";

/// The arguments of `halfdome cubemap`.
#[derive(Args, Clone, Debug)]
pub(crate) struct CubemapArguments {
    /// An environment map (.hdr, .exr; equirectangular), `sky` for the sky of the options, or with --at a scene (.toml,
    /// .glb, .gltf, .obj, .pbrt, .ply, `cornell`)
    source: PathBuf,

    /// A point in the scene, in the scene's units
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, value_parser = value::argument(value::point))]
    at: Option<Vec3>,

    /// File to write; can be given several times: .ktx2 (RGBA16F, all levels), .exr (all levels, unfolded), .hdr (six
    /// files, NAME-px.hdr and so on, and more for each level) or .png (a preview that shows seams of lookups). A
    /// manifest NAME.json is written too
    #[arg(short, long = "output", value_name = "FILE", required = true)]
    outputs: Vec<PathBuf>,

    /// Width of a face of the first level in texels, a power of two
    #[arg(long, value_name = "TEXELS", allow_hyphen_values = true, default_value = "256", value_parser = side)]
    size: u32,

    /// Number of levels, each half as wide as the one before [default: down to 4 texels]
    #[arg(long, value_name = "N", allow_hyphen_values = true, value_parser = clap::value_parser!(u32).range(1..=12))]
    levels: Option<u32>,

    /// Standard error of a texel of the first level, in a scene: relative to its radiance, or to the mean radiance
    /// around it if that is more. Paths are traced until it is reached [default: 5%]
    #[arg(long, value_name = "ERROR", allow_hyphen_values = true, conflicts_with = "spp")]
    #[arg(value_parser = value::argument(value::accuracy))]
    accuracy: Option<f32>,

    /// Paths per texel of the first level, in a scene, instead of an accuracy
    #[arg(long, value_name = "N", allow_hyphen_values = true, value_parser = clap::value_parser!(u32).range(1..))]
    spp: Option<u32>,

    /// How to hide seams from filters that stay within a face: none (for hardware that filters across edges), stretch
    /// (faces scaled until their outermost texels meet), warp (bent near the edges) or lookup (scaled here, and scaled
    /// back by the shader)
    #[arg(long, value_name = "HOW", default_value = "none", value_parser = names(Seams::ALL, Seams::name))]
    seams: Seams,

    /// Lobe that levels are filtered by: ggx (by roughness) or phong (by a power of the cosine)
    #[arg(long, value_name = "LOBE", default_value = "ggx", value_parser = names(Filter::ALL, Filter::name))]
    filter: Filter,

    /// ggx: level that a shader looks up for a roughness: linear (roughness times the number of the last level: Bevy)
    /// or sqrt (its square root: Godot)
    #[arg(long, value_name = "HOW", default_value = "linear", value_parser = names(Mapping::ALL, Mapping::name))]
    mapping: Mapping,

    /// What is looked up for a direction (x, y, z) of the world: bevy (x, y, -z), three (-x, y, z) or world (x, y, z)
    #[arg(long, value_name = "WHOSE", default_value = "bevy", value_parser = names(Axes::ALL, Axes::name))]
    axes: Axes,

    /// Also make a map of irradiance over π (NAME-diffuse), with faces of SIDE texels [default: off; 32 without a SIDE]
    #[arg(long, value_name = "SIDE", num_args = 0..=1, require_equals = true, default_missing_value = "32")]
    #[arg(value_parser = side)]
    diffuse: Option<u32>,

    /// Print the shader code for lookups (wgsl, glsl) instead of the table of seams, and write it beside the map
    #[arg(long, value_name = "LANGUAGE", value_parser = names(Language::ALL, Language::name))]
    print_lookup: Option<Language>,

    /// Exposure of PNG pictures in stops: each doubles the brightness
    #[arg(long, value_name = "EV", default_value = "0", allow_hyphen_values = true, value_parser = exposure)]
    exposure: f32,

    #[command(flatten)]
    light: LightArguments,

    /// Threads and progress.
    #[command(flatten)]
    pub(crate) common: CommonArguments,
}

impl CubemapArguments {
    fn options(&self, seed: u64) -> Result<Options, CliError> {
        let (size, most) = (self.size, Options::max_levels(self.size));
        let levels = self.levels.unwrap_or(Options::default_levels(size));
        if levels > most {
            let problem = format!("faces of {size} texels cannot have {levels} levels");
            return Err(invalid(problem, format!("give --levels 1 to {most}, or a larger --size")));
        }
        let Self { seams, filter, mapping, axes, diffuse, .. } = *self;
        Ok(Options { size, levels, seams, filter, mapping, axes, diffuse, seed })
    }

    /// The sky that the source is, if it is no scene; and whether it has a sun besides.
    fn environment(&self, files: &Files) -> Result<Option<(Sky, bool)>, CliError> {
        let extension = self.source.extension().unwrap_or_default().to_ascii_lowercase();
        let is_picture = extension == "hdr" || extension == "exr";
        if !is_picture && self.source != Path::new(SKY) {
            return match self.at {
                Some(_) => Ok(None),
                None => Err(invalid(
                    format!("{} is a scene, and needs a point to look from", self.source.display()),
                    "add --at X,Y,Z, or give an environment map (.hdr, .exr) or `sky`",
                )),
            };
        }
        if self.at.is_some() {
            let problem = format!("{} is not a scene, so --at cannot be used", self.source.display());
            return Err(invalid(problem, "leave --at out, or give a scene"));
        }
        let mut overrides = self.light.overrides();
        if is_picture && overrides.light.sky_light.picture.replace(self.source.clone()).is_some() {
            let problem = format!("both {} and --sky-picture are given", self.source.display());
            return Err(invalid(problem, "leave one of them out"));
        }
        let mut scene = Scene::default();
        overrides.apply(&mut scene).map_err(CliError::input)?;
        inputs::refuse(&files.paths(), &scene.files)?;
        let sun = scene.lights.iter().any(|light| matches!(light, PunctualLight::Directional { .. }));
        Ok(Some((scene.sky, sun)))
    }
}

/// Makes a cube map and writes it.
pub(crate) fn run(arguments: &CubemapArguments) -> Result<u8, CliError> {
    let tone = ToneMapping { exposure: arguments.exposure, curve: ToneCurve::default() };
    let files = Files::new(&arguments.outputs, arguments.print_lookup, tone)?;
    let style = arguments.common.progress.style(std::io::stderr().is_terminal());
    match arguments.environment(&files)? {
        Some((sky, sun)) => {
            let options = arguments.options(arguments.light.seed.unwrap_or(0))?;
            if sun {
                let text = "the sun is a light of its own and is not in the map";
                warn(style, &mut vec![text.to_owned()]);
            }
            finish(arguments, &Environment::sky(sky), &options, &thread_pool(&arguments.common)?, &files, style)
        }
        None => {
            let options = arguments.options(0)?;
            let (place, light) = (arguments.at.unwrap_or_default(), arguments.light.overrides());
            let from = LightQuery::Places(slice::from_ref(&place));
            let (world, settings, pool) =
                prepare_world(&arguments.source, light, &arguments.common, &files.paths(), from)?;
            let options = Options { seed: settings.seed, ..options };
            let accuracy = Paths::Accuracy(arguments.accuracy.unwrap_or(ACCURACY));
            let paths = arguments.spp.map_or(accuracy, Paths::Count);
            let source = Environment::point(&world, place, paths, settings.seed);
            finish(arguments, &source, &options, &pool, &files, style)
        }
    }
}

fn finish(
    arguments: &CubemapArguments,
    source: &Environment,
    options: &Options,
    pool: &rayon::ThreadPool,
    files: &Files,
    style: Style,
) -> Result<u8, CliError> {
    interrupt::catch()?;
    let progress = Progress::start(style, cubemap::work(source, options));
    let map = pool.install(|| cubemap::make(source, options, &progress));
    drop(progress);
    let Some(map) = map else {
        print_text(style, "interrupted; nothing was written");
        return Ok(EXIT_INTERRUPTED);
    };
    if map.levels[0].texels.iter().all(|texel| *texel == Vec3::ZERO) {
        let text = "the map is black: nothing is visible from there, or nothing is lit";
        warn(style, &mut vec![text.to_owned()]);
    }
    let (written, mut warnings) = files.write(&map, &arguments.source.display().to_string())?;
    warn(style, &mut warnings);
    match style {
        Style::Silent => {}
        Style::Json => print_line(&json!({
            "event": "end",
            "size": options.size,
            "levels": options.levels,
            "rays": map.rays,
            "error": map.error,
            "files": written.iter().map(|path| path.display().to_string()).collect::<Vec<_>>(),
        })),
        Style::Bar => {
            if map.error > 0.0 {
                let error = 100.0 * map.error;
                print_text(style, &format!("{} rays; error of the first level: {error:.2}% of the mean", map.rays));
            }
            written.iter().for_each(|path| print_text(style, &format!("wrote {}", path.display())));
        }
    }
    match arguments.print_lookup {
        Some(language) => print(&cubemap::lookup(&map, language))?,
        None => print(&table(&map))?,
    }
    Ok(EXIT_DONE)
}

/// The seams of each level: the map's own, and those that each treatment leaves on a smooth function, with its error.
fn table(map: &CubeMap) -> String {
    let mut text =
        "seams between faces in % of the mean; then, for a smooth function and each --seams: seam, error\n".to_owned();
    text += "level   size   this map";
    Seams::ALL.iter().for_each(|seams| text += &format!("{:>19}", seams.name()));
    text += "\n";
    for (number, level) in map.levels.iter().enumerate() {
        let size = level.grid.size;
        text += &format!("{number:5} {size:6} {:10.4}", 100.0 * measure::seam(level));
        for error in measure::smooth(size) {
            text += &format!("{:10.4} {:8.4}", 100.0 * error.seam, 100.0 * error.error);
        }
        text += "\n";
    }
    text
}

/// The side of a face.
fn side(text: &str) -> Result<u32, String> {
    let sides = Options::MIN_SIZE..=Options::MAX_SIZE;
    let side = text.parse().ok().filter(|side: &u32| side.is_power_of_two() && sides.contains(side));
    side.ok_or_else(|| format!("expected a power of two from {} to {}", sides.start(), sides.end()))
}
