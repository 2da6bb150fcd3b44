//! The arguments.

use std::ffi::OsStr;
use std::path::{Path, PathBuf};

use clap::builder::{PossibleValuesParser, TypedValueParser};
use clap::{Args, Parser, Subcommand};

use super::CORNELL;
use super::bake::BakeArguments;
use super::cache::CacheCommand;
use super::cubemap::CubemapArguments;
use super::help::{
    BAKE_EXAMPLES, CUBEMAP_EXAMPLES, EXAMPLES, EXIT_CODES, PROBES_EXAMPLES, RENDER_EXAMPLES, VALIDATE_EXAMPLES,
};
use super::irradiance::IrradianceArguments;
use super::probes::ProbesArguments;
use super::progress::Mode;
use super::tree::TreeArguments;
use super::validate::ValidateArguments;
use crate::driver::MAX_BLOCK;
use crate::output::{ToneCurve, ToneMapping};
use crate::scene::Overrides;
use crate::settings::{Invalid, MAX_SIDE};

/// Renders scenes with global illumination
///
/// Without a command, the built-in Cornell box is rendered with 32 samples per pixel, to cornell.exr and cornell.png in
/// the current folder.
#[derive(Parser, Debug)]
#[command(version, after_help = format!("{EXAMPLES}\n\n{EXIT_CODES}"))]
pub(super) struct Arguments {
    /// What to do; without one, the built-in Cornell box is rendered.
    #[command(subcommand)]
    pub(super) command: Option<Command>,
}

#[derive(Subcommand, Debug)]
pub(super) enum Command {
    /// Render a scene to pictures
    #[command(after_help = format!("{RENDER_EXAMPLES}\n\n{EXIT_CODES}"))]
    Render(Box<RenderArguments>),
    /// Say what is in a scene, without rendering it, or in a tree that `halfdome tree` has written
    #[command(after_help = EXIT_CODES)]
    Info(InfoArguments),
    /// Bake lightmaps or ambient occlusion for a level
    #[command(after_help = format!("{BAKE_EXAMPLES}\n\n{EXIT_CODES}"))]
    Bake(Box<BakeArguments>),
    /// Find the irradiance at given points
    #[command(after_help = EXIT_CODES)]
    Irradiance(Box<IrradianceArguments>),
    /// Build, inspect, merge and draw irradiance caches
    #[command(subcommand, after_help = EXIT_CODES)]
    Cache(CacheCommand),
    /// Build the tree of a scene's triangles, and write it for programs that embed the kernel
    #[command(after_help = EXIT_CODES)]
    Tree(TreeArguments),
    /// Make a prefiltered cube map of an environment, or of what a point in a scene sees
    #[command(after_help = format!("{CUBEMAP_EXAMPLES}\n\n{EXIT_CODES}"))]
    Cubemap(Box<CubemapArguments>),
    /// Find the light around points in a scene: spherical harmonics, and volumes of them for Bevy
    #[command(after_help = format!("{PROBES_EXAMPLES}\n\n{EXIT_CODES}"))]
    Probes(Box<ProbesArguments>),
    /// Render scenes whose answer is known exactly, and compare
    #[command(after_help = format!("{VALIDATE_EXAMPLES}\n\n{EXIT_CODES}"))]
    Validate(ValidateArguments),
}

/// What overrides the scene, with the picture's size in one word.
#[derive(Args, Clone, Debug)]
pub(super) struct OverrideArguments {
    /// Pixels across and down, for example 1280x720 [default: 512x512]
    #[arg(long, value_name = "WxH", help_heading = "Film", conflicts_with_all = ["width", "height"])]
    #[arg(value_parser = size)]
    size: Option<(u32, u32)>,

    #[command(flatten)]
    overrides: Overrides,
}

impl OverrideArguments {
    /// The options that are given.
    pub(super) fn overrides(&self) -> Overrides {
        let mut overrides = self.overrides.clone();
        if let Some((width, height)) = self.size {
            (overrides.width, overrides.height) = (Some(width), Some(height));
        }
        overrides
    }
}

#[derive(Args, Clone, Debug)]
pub(super) struct RenderArguments {
    /// A scene file (.toml), a model (.obj, .ply, .gltf, .glb), or `cornell` for the built-in scene
    pub(super) scene: PathBuf,

    /// Picture to write, .exr (linear radiance) or .png (tone mapped); may be given several times
    /// [default: the scene's name with .exr and .png, in the current folder]
    #[arg(short, long = "output", value_name = "FILE")]
    outputs: Vec<PathBuf>,

    /// What overrides the scene.
    #[command(flatten)]
    pub(super) overriding: OverrideArguments,

    /// How it runs.
    #[command(flatten)]
    pub(super) common: CommonArguments,

    /// cached: use the records of this cache, which `halfdome cache build` made with the same options; it is not changed
    #[arg(long, value_name = "FILE", help_heading = "Irradiance cache")]
    pub(super) cache: Option<PathBuf>,

    /// Write the pictures early: when a ray for each block of SIDE pixels is traced, then for blocks of half the side,
    /// and so on; the pictures in the end do not depend on it [default: off; 32 without a SIDE]
    #[arg(long, value_name = "SIDE", num_args = 0..=1, require_equals = true, default_missing_value = "32")]
    #[arg(value_parser = block)]
    pub(super) progressive: Option<u32>,

    /// Exposure of PNG pictures in stops: each doubles the brightness
    #[arg(long, value_name = "EV", default_value = "0", help_heading = "PNG", allow_hyphen_values = true)]
    #[arg(value_parser = exposure)]
    exposure: f32,

    /// Tone curve of PNG pictures
    #[arg(long, value_name = "CURVE", default_value = "linear", help_heading = "PNG", value_parser = tone_curve())]
    tone: ToneCurve,
}

/// How a command runs, whatever it does.
#[derive(Args, Clone, Debug)]
pub(super) struct CommonArguments {
    /// Threads; results do not depend on them [default: one for each core]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub(super) threads: Option<u16>,

    /// How progress is shown on stderr; auto is a bar on a terminal, lines of JSON elsewhere
    #[arg(long, value_name = "MODE", default_value = "auto")]
    pub(super) progress: Mode,
}

#[derive(Args, Clone, Debug)]
pub(super) struct InfoArguments {
    /// A scene file (.toml), a model (.obj, .ply, .gltf, .glb), `cornell` for the built-in scene, or a tree (.bvh)
    pub(super) scene: PathBuf,

    /// Print JSON instead of a table
    #[arg(long)]
    pub(super) json: bool,
}

impl Command {
    /// What the program does without arguments.
    pub(super) fn cornell() -> Self {
        // A few seconds on two cores.
        let arguments = Arguments::parse_from(["halfdome", "render", CORNELL, "--spp", "32"]);
        arguments.command.expect("`render` is a command")
    }
}

impl RenderArguments {
    /// The pictures to write, each once.
    pub(super) fn outputs(&self) -> Result<Vec<PathBuf>, Invalid> {
        if self.outputs.is_empty() {
            let stem = self.scene.file_stem().unwrap_or(OsStr::new("picture"));
            return Ok(["exr", "png"].map(|extension| with_extension(stem, extension)).to_vec());
        }
        let places: Vec<_> = self.outputs.iter().map(|path| place(path)).collect();
        for (i, path) in self.outputs.iter().enumerate() {
            if places[..i].contains(&places[i]) {
                return Err(Invalid::new(
                    format!("{} would be written twice", path.display()),
                    "give each picture a name of its own",
                ));
            }
        }
        Ok(self.outputs.clone())
    }

    /// How PNG pictures are made.
    pub(super) fn tone_mapping(&self) -> ToneMapping {
        ToneMapping { exposure: self.exposure, curve: self.tone }
    }
}

/// `path` with its folder as the system calls it, if there is such a folder: the same for all spellings of a path.
fn place(path: &Path) -> PathBuf {
    let folder = path.parent().filter(|folder| *folder != Path::new("")).unwrap_or(Path::new("."));
    let folder = folder.canonicalize().unwrap_or_else(|_| folder.to_owned());
    folder.join(path.file_name().unwrap_or_default())
}

/// `stem.extension`, even if the stem has dots.
fn with_extension(stem: &OsStr, extension: &str) -> PathBuf {
    let mut name = stem.to_owned();
    name.push(".");
    name.push(extension);
    Path::new(&name).to_owned()
}

fn size(text: &str) -> Result<(u32, u32), String> {
    let side = |text: &str| text.parse().ok().filter(|side| (1..=MAX_SIDE).contains(side));
    let sides = text.split_once(['x', 'X', '×']);
    sides
        .and_then(|(width, height)| Some((side(width)?, side(height)?)))
        .ok_or_else(|| format!("expected two whole numbers from 1 to {MAX_SIDE}, for example 1280x720"))
}

fn block(text: &str) -> Result<u32, String> {
    let side = text.parse().ok().filter(|side: &u32| (2..=MAX_BLOCK).contains(side) && side.is_power_of_two());
    side.ok_or_else(|| format!("expected a power of two from 2 to {MAX_BLOCK}"))
}

fn tone_curve() -> impl TypedValueParser<Value = ToneCurve> {
    PossibleValuesParser::new(ToneCurve::NAMES)
        .map(|name| ToneCurve::from_name(&name).expect("only names of curves are possible"))
}

pub(super) fn exposure(text: &str) -> Result<f32, String> {
    let stops = text.parse().ok().filter(|stops: &f32| stops.abs() <= 64.0);
    stops.ok_or_else(|| "expected stops from -64 to 64".to_owned())
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory;
    use halfdome_kernel::sampling::Pattern;

    use super::*;
    use crate::scene::{CachedOverrides, Daylight, IntegratorOverrides, SkyOverrides};
    use crate::settings::{
        AoWeighting, GatherLayout, Gradients, HemisphereSampling, Integrator, LightSampling, Metric, Stop, Survival,
    };

    fn render(arguments: &[&str]) -> Result<RenderArguments, clap::Error> {
        let all = ["halfdome", "render"].iter().chain(arguments);
        match Arguments::try_parse_from(all)?.command {
            Some(Command::Render(arguments)) => Ok(*arguments),
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn the_definition_is_consistent() {
        Arguments::command().debug_assert();
        let Command::Render(arguments) = Command::cornell() else { panic!("not a render") };
        assert_eq!(arguments.outputs().unwrap(), [Path::new("cornell.exr"), Path::new("cornell.png")]);
    }

    #[test]
    fn every_override_can_be_given() {
        let arguments = "s.glb --eye -1,2,3 --target 0,-0.5,0 --up 0,0,1 --vfov 30 --width 10 --height 20 --filter tent \
                         --filter-width 2 --sharpness .5 --integrator direct --spp 7 --max-depth 3 \
                         --sampler random --lights direct --stop depth --cutoff .5 --add-back --roulette-after 0 \
                         --survival throughput --bounces 0 --rays 1 --sampling cosine --ao-weighting misses \
                         --ao-distance 3 --cache-error .25 --gradients off --metric bounded --layout hemicube \
                         --record-rays 300 --cache-bounces 4 \
                         --seed 18446744073709551615 --build medium --sky 1,2,3 --emission both \
                         --sky-picture a.hdr --sky-rotation -90 --sky-scale 2 --daylight 30,-90,4 --threads 2 --exposure -1.5";
        let arguments = render(&arguments.split_whitespace().collect::<Vec<_>>()).unwrap();
        let expected = Overrides {
            eye: Some([-1.0, 2.0, 3.0].into()),
            target: Some([0.0, -0.5, 0.0].into()),
            up: Some([0.0, 0.0, 1.0].into()),
            vfov: Some(30.0),
            width: Some(10),
            height: Some(20),
            filter: Some("tent".into()),
            filter_width: Some(2.0),
            sharpness: Some(0.5),
            integrator: IntegratorOverrides {
                integrator: Integrator::named("direct"),
                max_depth: Some(3),
                lights: Some(LightSampling::Direct),
                stop: Stop::named("depth"),
                cutoff: Some(0.5),
                add_back: Some(true),
                roulette_after: Some(0),
                survival: Some(Survival::default()),
                bounces: Some(0),
                rays: Some(1),
                sampling: Some(HemisphereSampling::Cosine),
                ao_weighting: Some(AoWeighting::Misses),
                ao_distance: Some(3.0),
                cached: CachedOverrides {
                    cache_error: Some(0.25),
                    gradients: Some(Gradients::Off),
                    metric: Some(Metric::Bounded),
                    layout: Some(GatherLayout::Hemicube),
                    record_rays: Some(300),
                    cache_bounces: Some(4),
                },
            },
            spp: Some(7),
            sampler: Some(Pattern::Random),
            seed: Some(u64::MAX),
            build: Some(halfdome_kernel::Quality::Medium),
            aov: None,
            sky: Some([1.0, 2.0, 3.0].into()),
            sky_light: SkyOverrides {
                picture: Some("a.hdr".into()),
                rotation: Some(-90.0),
                scale: Some(2.0),
                daylight: Some(Daylight { elevation: 30.0, azimuth: -90.0, turbidity: 4.0 }),
            },
            emits_both_sides: Some(true),
        };
        assert_eq!(arguments.overriding.overrides(), expected);
        assert_eq!(arguments.tone_mapping().exposure, -1.5);
    }

    #[test]
    fn a_size_is_two_sides_and_excludes_single_ones() {
        let arguments = render(&["s.glb", "--size", "1280x720"]).unwrap().overriding.overrides();
        assert_eq!((arguments.width, arguments.height), (Some(1280), Some(720)));
        for wrong in ["1280", "0x720", "1280x65537", "x", "axb", "1280x720x3", "-1x5"] {
            assert!(render(&["s.glb", &format!("--size={wrong}")]).is_err(), "{wrong}");
        }
        assert!(render(&["s.glb", "--size", "1x1", "--width", "3"]).is_err());
    }

    #[test]
    fn blocks_are_powers_of_two() {
        let side = |arguments: &[&str]| render(arguments).map(|arguments| arguments.progressive);
        assert_eq!(side(&["s.glb"]).unwrap(), None);
        assert_eq!(side(&["--progressive", "s.glb"]).unwrap(), Some(32));
        assert_eq!(side(&["s.glb", "--progressive=8"]).unwrap(), Some(8));
        for wrong in ["1", "12", "512", "x"] {
            assert!(side(&["s.glb", &format!("--progressive={wrong}")]).is_err(), "{wrong}");
        }
    }

    #[test]
    fn errors_name_the_option_and_what_would_be_right() {
        let text = render(&["s.glb", "--vfov", "200"]).unwrap_err().to_string();
        assert!(text.contains("--vfov <DEGREES>") && text.contains("more than 0 and less than 180"), "{text}");
        for wrong in ["--exposure=nan", "--exposure=65", "--threads=0", "--tone=blue", "--progress=loud", "--spp=0"] {
            assert!(render(&["s.glb", wrong]).is_err(), "{wrong}");
        }
    }

    #[test]
    fn outputs_are_named_after_the_scene_unless_given() {
        let names = |arguments: &[&str]| render(arguments).unwrap().outputs();
        assert_eq!(names(&["a/b.v2.toml"]).unwrap(), [Path::new("b.v2.exr"), Path::new("b.v2.png")]);
        assert_eq!(names(&["s.glb", "-o", "x.png", "-o", "y.exr"]).unwrap(), [Path::new("x.png"), Path::new("y.exr")]);
        assert!(names(&["s.glb", "-o", "x.png", "-o", "x.png"]).is_err());
        assert!(names(&["s.glb", "-o", "x.png", "-o", "./x.png"]).is_err());
        assert!(names(&["s.glb", "-o", "no/x.png", "-o", "./x.png"]).is_ok());
    }
}
