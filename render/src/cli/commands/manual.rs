//! `halfdome man` and `halfdome completions`: manual pages and shell completions, made from the options themselves.

use std::path::{Path, PathBuf};

use clap::{Args, Command};
use clap_complete::Shell;

use crate::cli::error::{CliError, EXIT_DONE};
use crate::cli::print::print;
use crate::output::OutputFile;

#[derive(Args, Debug)]
pub(crate) struct ManArguments {
    /// A folder, which must exist, for a page of each command (halfdome-render.1 and so on); without it the program's
    /// own page is printed
    folder: Option<PathBuf>,
}

#[derive(Args, Debug)]
pub(crate) struct CompletionsArguments {
    /// The shell
    shell: Shell,
}

/// Prints or writes manual pages of the program.
pub(crate) fn man(arguments: &ManArguments, mut program: Command) -> Result<u8, CliError> {
    program.build();
    let Some(folder) = &arguments.folder else {
        print(&page(program)?)?;
        return Ok(EXIT_DONE);
    };
    write(folder, program)?;
    Ok(EXIT_DONE)
}

/// Writes the page of a command and those of its own commands.
fn write(folder: &Path, command: Command) -> Result<(), CliError> {
    for inner in command.get_subcommands().filter(|inner| !inner.is_hide_set() && inner.get_name() != "help") {
        write(folder, inner.clone())?;
    }
    let name = command.get_display_name().unwrap_or_else(|| command.get_name()).to_owned();
    let file = OutputFile::check(&folder.join(format!("{name}.1"))).map_err(CliError::input)?;
    file.write(page(command)?.as_bytes()).map_err(CliError::system)
}

fn page(command: Command) -> Result<String, CliError> {
    let mut text = Vec::new();
    clap_mangen::Man::new(command).render(&mut text).map_err(CliError::system)?;
    String::from_utf8(text).map_err(CliError::system)
}

/// Prints what a shell completes.
pub(crate) fn completions(arguments: &CompletionsArguments, mut program: Command) -> Result<u8, CliError> {
    let mut text = Vec::new();
    clap_complete::generate(arguments.shell, &mut program, "halfdome", &mut text);
    print(&String::from_utf8(text).map_err(CliError::system)?)?;
    Ok(EXIT_DONE)
}
