//! `halfdome cache`: irradiance caches on disk.

mod show;

use std::fmt::Write as _;
use std::io::{self, IsTerminal};
use std::path::{Path, PathBuf};

use clap::{Args, Subcommand};
use serde_json::json;

use crate::cache::{Cache, named};
use crate::cli::args::{CommonArguments, OverrideArguments};
use crate::cli::error::{CliError, EXIT_DONE, EXIT_INTERRUPTED};
use crate::cli::messages::Mode;
use crate::cli::prepare::prepare_world;
use crate::cli::print::print;
use crate::cli::progress::Progress;
use crate::cli::progress::job::{Job, Outcome};
use crate::cli::{inputs, interrupt, memory};
use crate::estimator::Gatherer;
use crate::integrator::fill_for_camera;
use crate::output::OutputFile;
use crate::scene::Overrides;
use crate::settings::{CachedOptions, Integrator, Invalid, Settings};
use crate::watch::Watch;
use crate::world::{LightQuery, World};

/// The arguments of `halfdome cache`.
#[derive(Subcommand, Clone, Debug)]
pub(crate) enum CacheCommand {
    /// Fill a cache for the camera's view, and write it
    Build(Box<BuildArguments>),
    /// Show the contents of a cache
    Info(InfoArguments),
    /// Merge caches of the same scene and options
    Merge(MergeArguments),
    /// Draw the records of a cache over the picture (.png), or write them as points (.ply)
    Show(Box<show::ShowArguments>),
}

/// A scene as the camera sees it, with the options of the cache.
#[derive(Args, Clone, Debug)]
pub(crate) struct BuildArguments {
    /// A scene file (.toml), a model (.glb, .gltf, .obj, .pbrt, .ply), or `cornell` for the built-in scene
    scene: PathBuf,

    /// Cache to write
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,

    /// Start from this cache of the same scene and options, and add missing records
    #[arg(long, value_name = "FILE")]
    cache: Option<PathBuf>,

    /// Overrides of the scene.
    #[command(flatten)]
    overriding: OverrideArguments,

    /// Threads and progress.
    #[command(flatten)]
    common: CommonArguments,
}

/// A cache, and how it is described.
#[derive(Args, Clone, Debug)]
pub(crate) struct InfoArguments {
    /// A cache
    cache: PathBuf,

    /// Print JSON instead of a table
    #[arg(long)]
    json: bool,
}

/// Caches to merge.
#[derive(Args, Clone, Debug)]
pub(crate) struct MergeArguments {
    /// Caches of the same scene and options, in any order
    #[arg(required = true)]
    caches: Vec<PathBuf>,

    /// Cache to write
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
}

impl CacheCommand {
    /// The display of progress.
    pub(crate) fn progress(&self) -> Mode {
        match self {
            Self::Build(arguments) => arguments.common.progress,
            Self::Show(arguments) => arguments.common.progress,
            Self::Info(_) | Self::Merge(_) => Mode::Auto,
        }
    }
}

/// Runs the command.
pub(crate) fn run(command: &CacheCommand) -> Result<u8, CliError> {
    match command {
        CacheCommand::Build(arguments) => build(arguments),
        CacheCommand::Info(arguments) => info(arguments),
        CacheCommand::Merge(arguments) => merge(arguments),
        CacheCommand::Show(arguments) => show::run(arguments),
    }
}

/// The cache at `path`, which must be of this world and these options; without a path an empty one.
pub(super) fn read_cache(path: Option<&Path>, options: &CachedOptions, world: &World) -> Result<Cache, CliError> {
    let hash = world.surroundings_hash();
    match path {
        Some(path) => Cache::read(path, Some((options, hash))).map_err(CliError::input),
        None => Ok(Cache::new(*options, hash)),
    }
}

/// The options of the cache with which these settings render.
pub(super) fn cached_options(settings: &Settings) -> Result<CachedOptions, Invalid> {
    match &settings.integrator {
        Integrator::Cached(options) => Ok(*options),
        other => Err(Invalid::new(
            format!("the integrator `{}` does not use an irradiance cache", other.name()),
            "leave --integrator out, or use `--integrator cached`",
        )),
    }
}

/// The overrides, with the cached integrator unless another is asked for.
pub(super) fn with_cache(mut overrides: Overrides) -> Overrides {
    let integrator = &mut overrides.integrator.integrator;
    *integrator = integrator.take().or_else(|| Some(Integrator::Cached(CachedOptions::default())));
    overrides
}

fn build(arguments: &BuildArguments) -> Result<u8, CliError> {
    let file = OutputFile::check(&arguments.output).map_err(CliError::input)?;
    let overrides = with_cache(arguments.overriding.overrides());
    let (world, settings, pool) =
        prepare_world(&arguments.scene, overrides, &arguments.common, &[&arguments.output], LightQuery::Camera)?;
    let options = cached_options(&settings)?;
    memory::check(&settings)?;
    let cache = read_cache(arguments.cache.as_deref(), &options, &world)?;
    interrupt::catch()?;
    let style = arguments.common.progress.style(io::stderr().is_terminal());
    let job = Job::start(
        style,
        format!("{}: {}x{}", arguments.scene.display(), settings.width, settings.height),
        json!({
            "scene": arguments.scene.display().to_string(),
            "width": settings.width,
            "height": settings.height,
            "seed": settings.seed,
            "threads": pool.current_num_threads(),
        }),
    );
    let progress = Progress::of_records(style, 0);
    let (frozen, rays) = pool.install(|| fill_for_camera(&world, &settings, cache, &progress));
    let finished = !progress.stop();
    drop(progress);
    let usage = frozen.usage();
    let note = match usage.records {
        0 => "no records yet, so nothing was written".to_owned(),
        records => format!("{records} records were written; continue with --cache {}", arguments.output.display()),
    };
    let file_written = finished || usage.records > 0;
    if file_written {
        file.write(&frozen.cache.encode()).map_err(CliError::system)?;
    }
    let file = file_written.then_some(arguments.output.as_path());
    let estimate = frozen.cache.estimate().filter(|_| finished);
    let accuracy = options.accuracy.zip(estimate.map(|estimate| estimate.root_mean_square));
    job.end(Outcome { finished, rays, cache: Some(usage), accuracy, note: &note, file });
    Ok(if finished { EXIT_DONE } else { EXIT_INTERRUPTED })
}

fn info(arguments: &InfoArguments) -> Result<u8, CliError> {
    let cache = Cache::read(&arguments.cache, None).map_err(CliError::input)?;
    let reach = cache.records().iter().map(|record| record.radii[1]);
    let (shortest, longest) =
        reach.fold((f32::INFINITY, 0f32), |(low, high), radius| (low.min(radius), high.max(radius)));
    let options = cache.options();
    let rays = Gatherer::new(options.layout, options.rays, false, 0).rays() as u64 * cache.records().len() as u64;
    let text = if arguments.json {
        let json = json!({
            "cache": arguments.cache.display().to_string(),
            "records": cache.records().len(),
            "gather_rays": options.accuracy.is_none().then_some(rays),
            "scene_hash": format!("{:016x}", cache.scene_hash()),
            "radius": { "shortest": shortest.min(longest), "longest": longest },
            "options": {
                "cache_error": decimal(options.error),
                "gradients": options.gradients.name(),
                "metric": options.metric.name(),
                "layout": options.layout.name(),
                "record_rays": options.rays,
                "cache_bounces": options.bounces,
                "accuracy": options.accuracy.map(decimal),
            },
            "error": cache.estimate().map(|estimate| decimal(estimate.root_mean_square)),
        });
        format!("{json:#}\n")
    } else {
        let mut text = format!("{}\n  records        {}\n", arguments.cache.display(), cache.records().len());
        if options.accuracy.is_none() {
            let _ = writeln!(text, "  gather rays    {rays}");
        }
        let _ = writeln!(text, "  scene hash     {:016x}", cache.scene_hash());
        let _ = writeln!(text, "  radii          {} to {longest}", shortest.min(longest));
        if let Some(estimate) = cache.estimate() {
            let _ = writeln!(text, "  error          {:.2}% of the mean light", 100.0 * estimate.root_mean_square);
        }
        for (name, value) in named(cache.options()) {
            let _ = writeln!(text, "  {name:14} {value}");
        }
        text
    };
    print(&text)?;
    Ok(EXIT_DONE)
}

/// The shortest decimal number that is read as this one.
fn decimal(number: f32) -> f64 {
    number.to_string().parse().unwrap_or(f64::from(number))
}

fn merge(arguments: &MergeArguments) -> Result<u8, CliError> {
    let file = OutputFile::check(&arguments.output).map_err(CliError::input)?;
    inputs::refuse(&[&arguments.output], &arguments.caches)?;
    let mut merged: Option<Cache> = None;
    for path in &arguments.caches {
        let cache = Cache::read(path, None).map_err(CliError::input)?;
        merged = Some(match merged {
            None => cache,
            Some(merged) => merged.merge(cache).map_err(|error| CliError::input(error.naming(path)))?,
        });
    }
    if let Some(merged) = merged {
        file.write(&merged.encode()).map_err(CliError::system)?;
    }
    Ok(EXIT_DONE)
}
