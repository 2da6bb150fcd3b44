//! Arguments that commands share, and those of `render` and `info`.

mod film;
pub(super) mod help;
pub(super) mod light;
mod sequence;

use std::ffi::OsStr;
use std::path::{Path, PathBuf};

use clap::Args;
use clap::builder::{PossibleValuesParser, TypedValueParser};

use super::denoiser::Denoiser;
use super::messages::Mode;
use super::tev;
use crate::output::{ToneCurve, ToneMapping};
use crate::scene::Overrides;
use crate::settings::{Invalid, MAX_SIDE};
use crate::watch::MAX_PREVIEW_SIDE;
pub(super) use film::{FilmArguments, is_film, shard};
pub(super) use sequence::SequenceArguments;
use sequence::numbered;

/// Overrides of the scene, with the picture's size in one word.
#[derive(Args, Clone, Debug)]
pub(crate) struct OverrideArguments {
    /// Pixels across and down, for example 1280x720 [default: 512x512]
    #[arg(long, value_name = "WxH", allow_hyphen_values = true, help_heading = "Film")]
    #[arg(conflicts_with_all = ["width", "height"])]
    #[arg(value_parser = size)]
    size: Option<(u32, u32)>,

    #[command(flatten)]
    overrides: Overrides,
}

impl OverrideArguments {
    /// The options that are given.
    pub(crate) fn overrides(&self) -> Overrides {
        let mut overrides = self.overrides.clone();
        if let Some((width, height)) = self.size {
            (overrides.width, overrides.height) = (Some(width), Some(height));
        }
        overrides
    }
}

#[derive(Args, Clone, Debug)]
pub(crate) struct RenderArguments {
    /// A scene file (.toml), a model (.glb, .gltf, .obj, .pbrt, .ply), or `cornell` for the built-in scene
    pub(crate) scene: PathBuf,

    /// Picture to write: .exr (linear radiance), .png (tone mapped) or .hdf (a film: sums of samples, to resume or to
    /// merge); can be given several times [default: the scene's name with .exr and .png, in the current folder]
    #[arg(short, long = "output", value_name = "FILE")]
    outputs: Vec<PathBuf>,

    /// Overrides of the scene.
    #[command(flatten)]
    pub(crate) overriding: OverrideArguments,

    /// Threads and progress.
    #[command(flatten)]
    pub(crate) common: CommonArguments,

    /// cached: read the records of this cache, which `halfdome cache build` made with the same options; the file is not
    /// changed
    #[arg(long, value_name = "FILE", help_heading = "Irradiance cache")]
    pub(crate) cache: Option<PathBuf>,

    /// Write previews early: one sample for each square of SIDE pixels, then for squares of half the side, and so on;
    /// the final picture is the same [default: off; 32 without a SIDE]
    #[arg(long, value_name = "SIDE", num_args = 0..=1, require_equals = true, default_missing_value = "32")]
    #[arg(value_parser = square)]
    pub(crate) progressive: Option<u32>,

    /// Denoise the picture by oidn (Intel's Open Image Denoise 2, which must be installed) or nlm (built in); the EXR
    /// keeps the noisy colours as Noisy.R, Noisy.G and Noisy.B
    #[arg(long, value_name = "METHOD", value_parser = denoiser())]
    pub(crate) denoise: Option<Denoiser>,

    /// Write statistics as JSON: scene, options, times, rays, errors
    #[arg(long, value_name = "FILE", help_heading = "Statistics")]
    pub(crate) stats_json: Option<PathBuf>,

    /// Write an HTML report: the same statistics, the picture, its error against time and over the picture
    #[arg(long, value_name = "FILE", help_heading = "Statistics")]
    pub(crate) report: Option<PathBuf>,

    /// Show the growing picture in tev, a viewer that must be running, here or elsewhere [default: off; without an
    /// address on this machine]
    #[arg(long, value_name = "HOST:PORT", num_args = 0..=1, require_equals = true)]
    #[arg(default_missing_value = tev::ADDRESS)]
    pub(crate) tev: Option<String>,

    /// Options of PNG pictures.
    #[command(flatten)]
    pub(crate) tone: ToneArguments,

    /// The frames, if there are several.
    #[command(flatten)]
    pub(crate) sequence: SequenceArguments,

    /// Limits, checkpoints and shards.
    #[command(flatten)]
    pub(crate) film: FilmArguments,
}

/// Options of PNG pictures.
#[derive(Args, Clone, Copy, Debug)]
pub(crate) struct ToneArguments {
    /// Exposure of PNG pictures in stops: each doubles the brightness
    #[arg(long, value_name = "EV", default_value = "0", help_heading = "PNG", allow_hyphen_values = true)]
    #[arg(value_parser = exposure)]
    exposure: f32,

    /// Tone curve of PNG pictures
    #[arg(long, value_name = "CURVE", default_value = "linear", help_heading = "PNG", value_parser = tone_curve())]
    tone: ToneCurve,
}

/// Options of all commands: threads and progress.
#[derive(Args, Clone, Debug)]
pub(crate) struct CommonArguments {
    /// Number of threads; results are the same for any number [default: one per core]
    #[arg(long, value_name = "N", allow_hyphen_values = true, value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub(crate) threads: Option<u16>,

    /// How to show progress on stderr; auto is a bar on a terminal, lines of JSON elsewhere
    #[arg(long, value_name = "MODE", default_value = "auto")]
    pub(crate) progress: Mode,
}

#[derive(Args, Clone, Debug)]
pub(crate) struct InfoArguments {
    /// A scene file (.toml), a model (.glb, .gltf, .obj, .pbrt, .ply), `cornell` for the built-in scene, or a tree
    /// (.bvh)
    pub(crate) scene: PathBuf,

    /// Print JSON instead of a table
    #[arg(long)]
    pub(crate) json: bool,

    /// Overrides of the scene.
    #[command(flatten)]
    pub(crate) overriding: OverrideArguments,
}

#[derive(Args, Clone, Debug)]
pub(crate) struct MaterialsArguments {
    /// A scene file (.toml), a model (.glb, .gltf, .obj, .pbrt, .ply), or `cornell` for the built-in scene
    pub(crate) scene: PathBuf,
}

impl RenderArguments {
    /// The pictures to write, each once, and none that a report has the name of.
    pub(crate) fn outputs(&self) -> Result<Vec<PathBuf>, Invalid> {
        let outputs = match &self.outputs[..] {
            [] => {
                let mut stem = self.scene.file_stem().unwrap_or(OsStr::new("picture")).to_owned();
                stem.push(if self.sequence.frames.is_some() { ".####" } else { "" });
                ["exr", "png"].map(|extension| with_extension(&stem, extension)).to_vec()
            }
            given => given.to_vec(),
        };
        let all: Vec<&PathBuf> = outputs.iter().chain(self.reports()).collect();
        let places: Vec<_> = all.iter().map(|path| place(path)).collect();
        for (i, path) in all.iter().enumerate() {
            if places[..i].contains(&places[i]) {
                let problem = format!("{} is given twice", path.display());
                return Err(Invalid::new(problem, "give each file its own name"));
            }
        }
        Ok(outputs)
    }

    /// The arguments of one frame of a sequence, with its number in the names of all files.
    pub(crate) fn of_frame(&self, frame: i32) -> Result<Self, Invalid> {
        let numbered = |path: &PathBuf| numbered(path, frame);
        let mut one = Self {
            outputs: self.outputs()?.iter().map(numbered).collect::<Result<_, _>>()?,
            stats_json: self.stats_json.as_ref().map(numbered).transpose()?,
            report: self.report.as_ref().map(numbered).transpose()?,
            ..self.clone()
        };
        one.overriding.overrides.moment.frame = Some(frame.into());
        Ok(one)
    }

    /// Refuses `--skip-existing` where frames that are there may be unfinished.
    pub(crate) fn check_skipping(&self) -> Result<(), Invalid> {
        if !self.sequence.skip_existing || self.film.interval().is_none() {
            return Ok(());
        }
        let (option, remedy) = match self.film.resume {
            true => ("--resume", "leave --skip-existing out: --resume goes on with the film of each frame"),
            false => ("--checkpoint", "leave --skip-existing out and give --resume, which goes on with each frame"),
        };
        let problem = format!(
            "--skip-existing does not go with {option}: an interrupted frame has a picture, and would be taken for a whole one"
        );
        Err(Invalid::new(problem, remedy))
    }

    /// The report and statistics files.
    pub(crate) fn reports(&self) -> impl Iterator<Item = &PathBuf> {
        self.stats_json.iter().chain(&self.report)
    }
}

impl ToneArguments {
    pub(crate) fn mapping(&self) -> ToneMapping {
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

fn square(text: &str) -> Result<u32, String> {
    let side = text.parse().ok().filter(|side: &u32| (2..=MAX_PREVIEW_SIDE).contains(side) && side.is_power_of_two());
    side.ok_or_else(|| format!("expected a power of two from 2 to {MAX_PREVIEW_SIDE}"))
}

/// A denoiser.
pub(crate) fn denoiser() -> impl TypedValueParser<Value = Denoiser> {
    names(Denoiser::ALL, Denoiser::name)
}

fn tone_curve() -> impl TypedValueParser<Value = ToneCurve> {
    PossibleValuesParser::new(ToneCurve::NAMES)
        .map(|name| ToneCurve::from_name(&name).expect("only names of curves are possible"))
}

pub(crate) fn exposure(text: &str) -> Result<f32, String> {
    let stops = text.parse().ok().filter(|stops: &f32| stops.abs() <= 64.0);
    stops.ok_or_else(|| "expected stops from -64 to 64".to_owned())
}

/// One of the values of a type, by its name.
pub(crate) fn names<T: Copy + Send + Sync + 'static, const N: usize>(
    all: [T; N],
    name: fn(T) -> &'static str,
) -> impl TypedValueParser<Value = T> {
    PossibleValuesParser::new(all.map(name))
        .map(move |given| all.into_iter().find(|&value| name(value) == given).unwrap_or(all[0]))
}

#[cfg(test)]
mod tests;
