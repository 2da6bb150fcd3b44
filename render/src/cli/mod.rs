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

use std::ffi::OsString;
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
            suggest(&mut error, &std::env::args_os().skip(1).collect::<Vec<_>>());
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

/// Suggests the option that is meant by the name that other renderers have for it, if the subcommand of these arguments
/// has it: the nearest spelling may be another.
fn suggest(error: &mut clap::Error, arguments: &[OsString]) {
    const NAMES: [(&str, &str); 2] = [("--samples", "spp"), ("--resolution", "size")];
    let Some(ContextValue::String(given)) = error.get(ContextKind::InvalidArg) else { return };
    let Some((_, meant)) = NAMES.iter().find(|(name, _)| name == given) else { return };
    let root = Arguments::command();
    let mut subcommand = &root;
    for argument in arguments {
        subcommand = subcommand.find_subcommand(argument).unwrap_or(subcommand);
    }
    let is_known = subcommand.get_arguments().any(|argument| argument.get_long() == Some(meant));
    if error.kind() == ErrorKind::UnknownArgument && is_known {
        error.insert(ContextKind::SuggestedArg, ContextValue::String(format!("--{meant}")));
        // It shows the option that was suggested by its spelling.
        error.remove(ContextKind::Usage);
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

#[cfg(test)]
mod tests {
    use super::*;

    fn told(line: &str) -> String {
        let arguments: Vec<OsString> = line.split(' ').map(OsString::from).collect();
        let mut error = Arguments::try_parse_from(&arguments).unwrap_err();
        suggest(&mut error, &arguments[1..]);
        error.to_string()
    }

    #[test]
    fn options_are_suggested_by_the_names_of_other_renderers_where_there_are_such() {
        for (line, option) in [
            ("halfdome render cornell --samples 3", "--spp"),
            ("halfdome bake a.glb -o b.glb --samples 3", "--spp"),
            ("halfdome render cornell --resolution 640x480", "--size"),
        ] {
            let told = told(line);
            assert!(told.contains(&format!("similar argument exists: '{option}'")), "{told}");
            assert!(!told.contains("Usage:"), "{told}");
        }
        let without = told("halfdome denoise a.exr -o b.exr --samples 3");
        assert!(without.contains("unexpected argument '--samples'") && !without.contains("--spp"), "{without}");
    }
}
