//! `halfdome irradiance`: light at given points.

use std::fs::File;
use std::io::{self, BufRead, BufReader, IsTerminal};
use std::path::{Path, PathBuf};

use clap::Args;
use glam::Vec3;
use serde_json::json;

use super::cache::{cached_options, read_cache, with_cache};
use crate::cli::args::light::LightArguments;
use crate::cli::args::{CommonArguments, shard};
use crate::cli::error::{CliError, EXIT_DONE, EXIT_INTERRUPTED};
use crate::cli::messages::print_warning;
use crate::cli::prepare::prepare_world;
use crate::cli::print::print;
use crate::cli::progress::Progress;
use crate::cli::progress::job::{Job, Outcome};
use crate::cli::{inputs, interrupt};
use crate::irradiance::{self, Part, Request, Sensor, SensorPart};
use crate::output::OutputFile;
use crate::scene::{CachedOverrides, IntegratorOverrides, Overrides, count};
use crate::settings::Shard;
use crate::world::LightQuery;

/// The arguments of `halfdome irradiance`.
#[derive(Args, Clone, Debug)]
pub(crate) struct IrradianceArguments {
    /// A scene file (.toml), a model (.glb, .gltf, .obj, .pbrt, .ply), or `cornell` for the built-in scene
    scene: PathBuf,

    /// Sensors: one line `x y z nx ny nz` each; blank lines and # comments are skipped; - is standard input. Records
    /// depend on their order, so another order changes values, within the cache's error
    #[arg(long, value_name = "FILE")]
    points: PathBuf,

    /// File to write instead of standard output
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,

    /// Trace paths only, without a cache
    #[arg(long, conflicts_with = "cache", conflicts_with_all = CachedOverrides::NAMES)]
    brute: bool,

    /// Samples of direct light per sensor [default: 64]; with --brute, paths per sensor [default: 1024]
    #[arg(long, value_name = "N", allow_hyphen_values = true, conflicts_with = "accuracy")]
    #[arg(value_parser = clap::value_parser!(u32).range(1..))]
    spp: Option<u32>,

    /// Leave direct light out: only light reflected by surfaces, and the sky without the sun of its environment map
    #[arg(long)]
    indirect: bool,

    /// Read the records of this cache, which `halfdome cache build` made with the same options; the file is not changed
    #[arg(long, value_name = "FILE")]
    cache: Option<PathBuf>,

    /// Compute only shard K of N, 1 to N: every N-th sensor. `halfdome merge` joins the files of all shards (-o). Each
    /// shard fills a cache for all sensors; --cache avoids that
    #[arg(long, value_name = "K/N", allow_hyphen_values = true, value_parser = shard, requires = "output")]
    shard: Option<Shard>,

    #[command(flatten)]
    options: CachedOverrides,

    #[command(flatten)]
    light: LightArguments,

    /// Threads and progress.
    #[command(flatten)]
    pub(crate) common: CommonArguments,
}

/// Reads sensors, finds their irradiance, and writes it.
pub(crate) fn run(arguments: &IrradianceArguments) -> Result<u8, CliError> {
    let output = arguments.output.as_deref().map(OutputFile::check).transpose().map_err(CliError::input)?;
    let inputs = [Some(&arguments.points), arguments.cache.as_ref()].into_iter().flatten().collect::<Vec<_>>();
    inputs::refuse(arguments.output.as_slice(), &inputs)?;
    let sensors = read_sensors(&arguments.points)?;
    let style = arguments.common.progress.style(io::stderr().is_terminal());
    if sensors.is_empty() {
        let warning = format!("{}: the file has no sensors", arguments.points.display());
        print_warning(style, &warning);
    }
    let overrides = with_cache(arguments.overrides());
    let places: Vec<(Vec3, Vec3)> = sensors.iter().map(|sensor| (sensor.position, sensor.normal)).collect();
    let from = LightQuery::Sensors(&places);
    let (world, settings, pool) =
        prepare_world(&arguments.scene, overrides, &arguments.common, arguments.output.as_slice(), from)?;
    let options = cached_options(&settings)?;
    let cache = read_cache(arguments.cache.as_deref(), &options, &world)?;

    let part = if arguments.indirect { Part::Indirect } else { Part::Total };
    let spp = arguments.spp.unwrap_or(if arguments.brute { 1024 } else { 64 });
    let shard = arguments.shard.unwrap_or(Shard::ALL);
    let request = Request { spp, seed: settings.seed, part };
    let method = match arguments.brute {
        true => "paths".to_owned(),
        false => format!("{options:?} {:016x}", cache.hash()),
    };
    let key = irradiance::key(world.hash(), &sensors, &request, &method);
    interrupt::catch()?;
    let job = Job::start(
        style,
        format!("{}: {}", arguments.scene.display(), count(sensors.len(), "sensor", "sensors")),
        json!({
            "scene": arguments.scene.display().to_string(),
            "sensors": sensors.len(),
            "spp": spp,
            "seed": settings.seed,
            "threads": pool.current_num_threads(),
        }),
    );
    let own = shard.items(sensors.len());
    // The number of records is not known beforehand.
    let is_fixed = arguments.brute || part == Part::Total && options.accuracy.is_none();
    let samples = if is_fixed { own as u64 * u64::from(spp) } else { 0 };
    let progress = if arguments.brute { Progress::start(style, samples) } else { Progress::of_records(style, samples) };
    let found = pool.install(|| match arguments.brute {
        true => irradiance::shard_by_paths(&world, &sensors, shard, &request, &progress),
        false => irradiance::shard_by_cache(&world, &sensors, shard, cache, &request, &progress),
    });
    drop(progress);

    let usage = found.cache.as_ref().map(|(_, usage)| *usage);
    if !found.finished {
        job.end(Outcome {
            finished: false,
            rays: found.rays,
            cache: usage,
            accuracy: None,
            note: "nothing was written",
            file: None,
        });
        return Ok(EXIT_INTERRUPTED);
    }
    let text = match arguments.shard {
        Some(shard) => SensorPart::new(shard, key, &found.values).encode(),
        None => irradiance::lines(&found.values),
    };
    match &output {
        Some(file) => file.write(text.as_bytes()).map_err(CliError::system)?,
        None => print(&text)?,
    }
    let file = arguments.output.as_deref();
    let accuracy = options.accuracy.zip(found.error);
    let note = match accuracy.is_some() && usage.is_none() {
        true => "by paths at each sensor: an irradiance cache takes no fewer rays here",
        false => "",
    };
    job.end(Outcome { finished: true, rays: found.rays, cache: usage, accuracy, note, file });
    Ok(EXIT_DONE)
}

impl IrradianceArguments {
    /// The overrides of the scene and the cache by these arguments.
    fn overrides(&self) -> Overrides {
        let integrator = IntegratorOverrides { cached: self.options.clone(), ..IntegratorOverrides::default() };
        Overrides { integrator, ..self.light.overrides() }
    }
}

/// The sensors in a file, or on standard input if it is called `-`.
fn read_sensors(path: &Path) -> Result<Vec<Sensor>, CliError> {
    let reader: Box<dyn BufRead> = if path == Path::new("-") {
        Box::new(io::stdin().lock())
    } else {
        let file = File::open(path).map_err(|error| {
            CliError::Input(format!(
                "{}: cannot be read: {error}\n  help: give a file with a line `x y z nx ny nz` for each sensor",
                path.display()
            ))
        })?;
        Box::new(BufReader::new(file))
    };
    irradiance::read_points(reader).map_err(|error| CliError::Input(format!("{}: {error}", path.display())))
}
