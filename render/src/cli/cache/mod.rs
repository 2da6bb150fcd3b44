//! `halfdome cache`: irradiance caches on disk.

mod show;

use std::fmt::Write as _;
use std::io::{self, IsTerminal, Write as _};
use std::path::{Path, PathBuf};

use clap::{Args, Subcommand};
use serde_json::json;

use super::args::{CommonArguments, OverrideArguments};
use super::progress::Progress;
use super::{CliError, EXIT_DONE, EXIT_INTERRUPTED, interrupt, memory, prepare_world};
use crate::cache::{Cache, named};
use crate::driver::{self, Watch};
use crate::output::OutputFile;
use crate::scene::Overrides;
use crate::settings::{CachedOptions, Integrator, Invalid, Settings};
use crate::world::World;

/// What `halfdome cache` takes.
#[derive(Subcommand, Clone, Debug)]
pub(super) enum CacheCommand {
    /// Fill a cache for what the camera sees, and write it
    Build(Box<BuildArguments>),
    /// Say what is in a cache
    Info(InfoArguments),
    /// Make one cache of several of the same scene and options
    Merge(MergeArguments),
    /// Draw the records of a cache over the picture (.png), or write them as points (.ply)
    Show(Box<show::ShowArguments>),
}

/// A scene as the camera sees it, with the options of the cache.
#[derive(Args, Clone, Debug)]
pub(super) struct BuildArguments {
    /// A scene file (.toml), a model (.obj, .ply, .gltf, .glb), or `cornell` for the built-in scene
    scene: PathBuf,

    /// Cache to write
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,

    /// Start with the records of this cache, of the same scene and options, and add what is missing
    #[arg(long, value_name = "FILE")]
    cache: Option<PathBuf>,

    /// What overrides the scene.
    #[command(flatten)]
    overriding: OverrideArguments,

    /// How it runs.
    #[command(flatten)]
    common: CommonArguments,
}

/// A cache, and how it is described.
#[derive(Args, Clone, Debug)]
pub(super) struct InfoArguments {
    /// A cache
    cache: PathBuf,

    /// Print JSON instead of a table
    #[arg(long)]
    json: bool,
}

/// Caches to merge.
#[derive(Args, Clone, Debug)]
pub(super) struct MergeArguments {
    /// Caches of the same scene and options, in any order
    #[arg(required = true)]
    caches: Vec<PathBuf>,

    /// Cache to write
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
}

/// Runs the command.
pub(super) fn run(command: &CacheCommand) -> Result<u8, CliError> {
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
            format!("the integrator `{}` has no irradiance cache", other.name()),
            "leave --integrator out, or give `--integrator cached`",
        )),
    }
}

/// The overrides, with the cached integrator unless another is asked for.
fn with_cache(mut overrides: Overrides) -> Overrides {
    let integrator = &mut overrides.integrator.integrator;
    *integrator = integrator.take().or_else(|| Some(Integrator::Cached(CachedOptions::default())));
    overrides
}

fn build(arguments: &BuildArguments) -> Result<u8, CliError> {
    let file = OutputFile::check(&arguments.output).map_err(CliError::input)?;
    let overrides = with_cache(arguments.overriding.overrides());
    let (world, settings, pool) = prepare_world(&arguments.scene, overrides, &arguments.common)?;
    let options = cached_options(&settings)?;
    memory::check(&settings)?;
    let cache = read_cache(arguments.cache.as_deref(), &options, &world)?;
    interrupt::catch()?;
    let progress = Progress::start(arguments.common.progress.style(io::stderr().is_terminal()), 0);
    let cache = pool.install(|| driver::fill_cache(&world, &settings, cache, &progress));
    let stopped = progress.stop();
    drop(progress);
    file.write(&cache.encode()).map_err(CliError::system)?;
    Ok(if stopped { EXIT_INTERRUPTED } else { EXIT_DONE })
}

fn info(arguments: &InfoArguments) -> Result<u8, CliError> {
    let cache = Cache::read(&arguments.cache, None).map_err(CliError::input)?;
    let reach = cache.records().iter().map(|record| record.radii[1]);
    let (shortest, longest) =
        reach.fold((f32::INFINITY, 0f32), |(low, high), radius| (low.min(radius), high.max(radius)));
    let rays = u64::from(cache.options().rays) * cache.records().len() as u64;
    let text = if arguments.json {
        let options: serde_json::Map<_, _> =
            named(cache.options()).into_iter().map(|(name, value)| (name.replace('-', "_"), value.into())).collect();
        let json = json!({
            "cache": arguments.cache.display().to_string(),
            "records": cache.records().len(),
            "gather_rays": rays,
            "scene_hash": format!("{:016x}", cache.scene_hash()),
            "radius": { "shortest": shortest.min(longest), "longest": longest },
            "options": options,
        });
        format!("{json:#}\n")
    } else {
        let mut text = format!("{}\n  records        {}\n", arguments.cache.display(), cache.records().len());
        let _ = writeln!(text, "  gather rays    {rays}");
        let _ = writeln!(text, "  scene hash     {:016x}", cache.scene_hash());
        let _ = writeln!(text, "  radii          {} to {longest}", shortest.min(longest));
        for (name, value) in named(cache.options()) {
            let _ = writeln!(text, "  {name:14} {value}");
        }
        text
    };
    print(&text)?;
    Ok(EXIT_DONE)
}

fn merge(arguments: &MergeArguments) -> Result<u8, CliError> {
    let file = OutputFile::check(&arguments.output).map_err(CliError::input)?;
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

/// Prints to standard output. Who closes the pipe has seen enough.
pub(super) fn print(text: &str) -> Result<(), CliError> {
    let mut stdout = io::stdout().lock();
    match stdout.write_all(text.as_bytes()).and_then(|()| stdout.flush()) {
        Err(error) if error.kind() != io::ErrorKind::BrokenPipe => {
            Err(CliError::System(format!("standard output cannot be written: {error}")))
        }
        _ => Ok(()),
    }
}
