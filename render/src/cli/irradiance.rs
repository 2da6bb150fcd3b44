//! `halfdome irradiance`: light at given points.

use std::fmt::Write as _;
use std::fs::File;
use std::io::{self, BufRead, BufReader, IsTerminal};
use std::path::{Path, PathBuf};

use clap::Args;
use glam::Vec3;

use super::args::CommonArguments;
use super::cache::{print, read_cache};
use super::light::LightArguments;
use super::progress::Progress;
use super::{CliError, EXIT_DONE, EXIT_INTERRUPTED, interrupt, prepare_world};
use crate::driver::Watch;
use crate::irradiance::{self, Part, Request, Sensor};
use crate::output::OutputFile;
use crate::scene::CachedOverrides;

/// What `halfdome irradiance` takes.
#[derive(Args, Clone, Debug)]
pub(super) struct IrradianceArguments {
    /// A scene file (.toml), a model (.obj, .ply, .gltf, .glb), or `cornell` for the built-in scene
    scene: PathBuf,

    /// The sensors: a line `x y z nx ny nz` for each, blank lines and # comments aside; - is standard input
    #[arg(long, value_name = "FILE")]
    points: PathBuf,

    /// Write to a file instead of standard output
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,

    /// By path tracing alone, without a cache
    #[arg(long, conflicts_with = "cache")]
    brute: bool,

    /// Samples of direct light at each sensor; with --brute paths [default: 64; with --brute 1024]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    spp: Option<u32>,

    /// Leave direct light out: what surfaces reflect, and the sky without the sun of its picture
    #[arg(long)]
    indirect: bool,

    /// Use the records of this cache, which `halfdome cache build` made with the same options; it is not changed
    #[arg(long, value_name = "FILE")]
    cache: Option<PathBuf>,

    #[command(flatten)]
    options: CachedOverrides,

    #[command(flatten)]
    light: LightArguments,

    /// How it runs.
    #[command(flatten)]
    pub(super) common: CommonArguments,
}

/// Reads sensors, finds their irradiance, and writes it.
pub(super) fn run(arguments: &IrradianceArguments) -> Result<u8, CliError> {
    let output = arguments.output.as_deref().map(OutputFile::check).transpose().map_err(CliError::input)?;
    let sensors = read_sensors(&arguments.points)?;
    let overrides = arguments.light.overrides();
    let (world, settings, pool) = prepare_world(&arguments.scene, overrides, &arguments.common)?;
    let options = arguments.options.options();
    let cache = read_cache(arguments.cache.as_deref(), &options, &world)?;

    let part = if arguments.indirect { Part::Indirect } else { Part::Total };
    let spp = arguments.spp.unwrap_or(if arguments.brute { 1024 } else { 64 });
    let request = Request { spp, seed: settings.seed, part };
    interrupt::catch()?;
    let style = arguments.common.progress.style(io::stderr().is_terminal());
    let progress = Progress::start(style, sensors.len() as u64 * u64::from(spp));
    let found = pool.install(|| match arguments.brute {
        true => irradiance::by_paths(&world, &sensors, &request, &progress),
        false => irradiance::by_cache(&world, &sensors, cache, &request, &progress),
    });
    let stopped = progress.stop();
    drop(progress);

    let text = lines(&found.values);
    match &output {
        Some(file) => file.write(text.as_bytes()).map_err(CliError::system)?,
        None => print(&text)?,
    }
    Ok(if stopped { EXIT_INTERRUPTED } else { EXIT_DONE })
}

/// The sensors in a file, or on standard input if it is called `-`.
fn read_sensors(path: &Path) -> Result<Vec<Sensor>, CliError> {
    let reader: Box<dyn BufRead> = if path == Path::new("-") {
        Box::new(io::stdin().lock())
    } else {
        let file = File::open(path).map_err(|error| {
            CliError::Input(format!("{}: cannot be read: {error}\n  help: name a file of sensors", path.display()))
        })?;
        Box::new(BufReader::new(file))
    };
    irradiance::read_points(reader).map_err(|error| CliError::Input(format!("{}: {error}", path.display())))
}

/// A line for each value, with as many digits as tell 32-bit floats apart.
fn lines(values: &[Vec3]) -> String {
    values.iter().fold(String::new(), |mut text, Vec3 { x, y, z }| {
        let _ = writeln!(text, "{x} {y} {z}");
        text
    })
}
