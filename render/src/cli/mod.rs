//! The command line: arguments, progress, summaries, exit codes.

mod args;
mod checkpoint;
mod command;
mod commands;
mod denoiser;
mod error;
mod inputs;
mod interrupt;
mod lock;
mod memory;
mod messages;
mod prepare;
mod print;
mod progress;
mod tev;
mod usage;

use std::process::ExitCode;

use halfdome_kernel::{Isa, Level};

use clap::error::{ContextKind, ContextValue, ErrorKind};
use clap::{CommandFactory, Parser};

use command::{Arguments, Command};
use commands::{
    bake, cache, cubemap, denoise, info, irradiance, manual, materials, merge, probes, render, tree, validate, view,
};
use error::{CliError, EXIT_DONE, EXIT_INPUT};
use messages::Mode;

/// Runs the program with the process's arguments.
pub fn main() -> ExitCode {
    let arguments = match Arguments::try_parse() {
        Ok(arguments) => arguments,
        Err(mut error) => {
            suggest(&mut error);
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
        Command::View(arguments) => (view::run(&arguments), arguments.common.progress),
        Command::Merge(arguments) => (merge::run(&arguments), Mode::Auto),
        Command::Info(arguments) => (info::run(&arguments), Mode::Auto),
        Command::Materials(arguments) => (materials::run(&arguments), Mode::Auto),
        Command::Irradiance(arguments) => (irradiance::run(&arguments), arguments.common.progress),
        Command::Cache(command) => (cache::run(&command), command.progress()),
        Command::Tree(arguments) => (tree::run(&arguments), arguments.common.progress),
        Command::Bake(arguments) => (bake::run(&arguments), arguments.common.progress),
        Command::Cubemap(arguments) => (cubemap::run(&arguments), arguments.common.progress),
        Command::Denoise(arguments) => (denoise::run(&arguments), arguments.common.progress),
        Command::Probes(arguments) => (probes::run(&arguments), arguments.common.progress),
        Command::Validate(arguments) => (validate::run(&arguments), Mode::Auto),
        Command::Man(arguments) => (manual::man(&arguments, Arguments::command()), Mode::Auto),
        Command::Completions(arguments) => (manual::completions(&arguments, Arguments::command()), Mode::Auto),
    };
    ExitCode::from(outcome.unwrap_or_else(|error| {
        error.print(mode);
        error.exit_code()
    }))
}

/// Suggests the option that is meant by the name that other renderers have for it: the nearest spelling may be another.
fn suggest(error: &mut clap::Error) {
    const NAMES: [(&str, &str); 2] = [("--samples", "--spp"), ("--resolution", "--size")];
    let Some(ContextValue::String(given)) = error.get(ContextKind::InvalidArg) else { return };
    let meant = NAMES.iter().find(|(name, _)| name == given);
    if let (ErrorKind::UnknownArgument, Some((_, meant))) = (error.kind(), meant) {
        error.insert(ContextKind::SuggestedArg, ContextValue::String((*meant).to_owned()));
        // The usage shows the option that was suggested by its spelling.
        if let Some(ContextValue::StyledStr(usage)) = error.get(ContextKind::Usage) {
            let usage = usage.to_string().replace("--sampler <NAME>", "--spp <N>");
            error.insert(ContextKind::Usage, ContextValue::StyledStr(usage.into()));
        }
    }
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
        "HALFDOME_ISA is {wanted:?}, which this machine does not support\n  help: unset it, or use one of {}",
        known.join(", ")
    )))
}
