//! The command line: arguments, progress, summaries, exit codes.

mod args;
mod bake;
mod build_progress;
mod cache;
mod cubemap;
mod error;
mod help;
mod info;
mod interrupt;
mod irradiance;
mod job;
mod light;
mod memory;
mod preview;
mod probes;
mod progress;
mod render;
mod summary;
mod tree;
mod validate;

use std::io::{ErrorKind, IsTerminal};
use std::path::Path;
use std::process::ExitCode;

use halfdome_kernel::{Isa, Level};

use clap::Parser;

use args::{Arguments, Command, CommonArguments};
use error::CliError;
use progress::Mode;

use crate::scene::{self, Overrides, Place, Scene, SceneError};
use crate::settings::Settings;
use crate::world::World;

/// Done.
const EXIT_DONE: u8 = 0;
/// Bad input or usage, found before the render.
const EXIT_INPUT: u8 = 1;
/// The system failed, for example while a picture was written.
const EXIT_SYSTEM: u8 = 2;
/// Interrupted, with a valid partial picture.
const EXIT_INTERRUPTED: u8 = 3;
/// An experiment failed.
const EXIT_FAILED: u8 = 5;

/// The built-in scene's name in place of a path.
const CORNELL: &str = "cornell";

/// Runs the program with the process's arguments.
pub fn main() -> ExitCode {
    let arguments = match Arguments::try_parse() {
        Ok(arguments) => arguments,
        Err(error) => {
            // Help and version are "errors" that go to stdout; nothing is left to do if even printing fails.
            let _ = error.print();
            return ExitCode::from(if error.use_stderr() { EXIT_INPUT } else { EXIT_DONE });
        }
    };
    if let Err(error) = check_isa() {
        error.print(Mode::Auto);
        return ExitCode::from(error.exit_code());
    }
    let (outcome, mode) = match arguments.command.unwrap_or_else(Command::cornell) {
        Command::Render(arguments) => (render::run(&arguments), arguments.common.progress),
        Command::Info(arguments) => (info::run(&arguments), Mode::Auto),
        Command::Irradiance(arguments) => (irradiance::run(&arguments), arguments.common.progress),
        Command::Cache(command) => (cache::run(&command), command.progress()),
        Command::Tree(arguments) => (tree::run(&arguments), arguments.common.progress),
        Command::Bake(arguments) => (bake::run(&arguments), arguments.common.progress),
        Command::Cubemap(arguments) => (cubemap::run(&arguments), arguments.common.progress),
        Command::Probes(arguments) => (probes::run(&arguments), arguments.common.progress),
        Command::Validate(arguments) => (validate::run(&arguments), Mode::Auto),
    };
    ExitCode::from(outcome.unwrap_or_else(|error| {
        error.print(mode);
        error.exit_code()
    }))
}

/// Refuses a `HALFDOME_ISA` that this machine does not have: the kernel would pass over it in silence.
fn check_isa() -> Result<(), CliError> {
    let Some(wanted) = std::env::var_os("HALFDOME_ISA") else { return Ok(()) };
    let level = wanted.to_str().and_then(|name| name.parse::<Level>().ok());
    if level.and_then(Isa::new).is_some() {
        return Ok(());
    }
    let known: Vec<_> = Level::ALL.into_iter().filter(|&level| Isa::new(level).is_some()).map(Level::name).collect();
    Err(CliError::Input(format!(
        "HALFDOME_ISA is {wanted:?}, which this machine does not have\n  help: unset it, or choose one of {}",
        known.join(", ")
    )))
}

/// The scene called `name` with the options of its file, if it has one, below those of `arguments`.
fn prepare(name: &Path, arguments: Overrides) -> Result<(Scene, Settings), CliError> {
    let (mut scene, from_file) = open(name)?;
    let settings = arguments.or(from_file.clone()).apply(&mut scene);
    let settings = settings.map_err(|conflict| CliError::input(conflict.naming(name, &from_file)))?;
    Ok((scene, settings))
}

/// The world of the scene called `name` with its settings, and the threads to work with; warnings are printed.
fn prepare_world(
    name: &Path,
    overrides: Overrides,
    arguments: &CommonArguments,
) -> Result<(World, Settings, rayon::ThreadPool), CliError> {
    let (mut scene, settings) = prepare(name, overrides)?;
    let style = arguments.progress.style(std::io::stderr().is_terminal());
    scene.warnings.iter().for_each(|warning| summary::print_warning(style, warning));
    scene.warnings.clear();
    let pool = thread_pool(arguments)?;
    let world = pool.install(|| World::new(scene)).map_err(CliError::input)?;
    Ok((world, settings, pool))
}

/// As many threads as asked for.
fn thread_pool(arguments: &CommonArguments) -> Result<rayon::ThreadPool, CliError> {
    let threads = arguments.threads.map_or(0, usize::from);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    pool.map_err(|error| CliError::System(format!("threads cannot be started: {error}")))
}

/// The scene called `name`: the built-in one, a model, or a scene file with the options that it sets.
fn open(name: &Path) -> Result<(Scene, Overrides), SceneError> {
    if name == Path::new(CORNELL) {
        return Ok((scene::cornell_box(), Overrides::default()));
    }
    match name.metadata() {
        Ok(_) => scene::open(name),
        Err(error) if error.kind() == ErrorKind::NotFound => {
            let remedy =
                "name a scene file (.toml), a model (.obj, .ply, .gltf, .glb), or `cornell` for the built-in scene";
            Err(SceneError::new(name, Place::File, "no such file", remedy))
        }
        Err(error) => Err(SceneError::unreadable(name, &error)),
    }
}
