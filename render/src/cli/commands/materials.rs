//! `halfdome materials`: a scene's materials as they were read, as tables for a scene file.

use std::io::IsTerminal;

use crate::cli::args::MaterialsArguments;
use crate::cli::error::{CliError, EXIT_DONE};
use crate::cli::messages::{Mode, Style, print_warning};
use crate::cli::prepare::open;
use crate::cli::print::print;
use crate::scene::Overrides;

/// Prints a `[[material]]` table for each material to stdout, and warnings to stderr.
pub(crate) fn run(arguments: &MaterialsArguments) -> Result<u8, CliError> {
    let (scene, _) = open(&arguments.scene, &Overrides::default(), Style::for_people()).map_err(CliError::input)?;
    let style = Mode::Auto.style(std::io::stderr().is_terminal());
    scene.warnings.iter().for_each(|warning| print_warning(style, warning));
    let tables: Vec<String> = scene.materials.iter().map(|material| material.to_toml(&scene.textures)).collect();
    print(&tables.join("\n"))?;
    Ok(EXIT_DONE)
}
