//! `halfdome merge`: the picture of films that are parts of it.

use std::path::PathBuf;

use clap::Args;

use super::args::{ToneArguments, is_film};
use super::checkpoint::read_film;
use super::error::{CliError, EXIT_DONE, invalid};
use super::inputs;
use super::messages::{Style, print_warning};
use super::render::{bad_samples, refuse_failures, write_all};
use crate::film::{Merger, Missing};
use crate::output::{self, OutputFile};

#[derive(Args, Clone, Debug)]
pub(super) struct MergeArguments {
    /// Films (.hdf) that `halfdome render` wrote
    #[arg(required = true, value_name = "FILM")]
    films: Vec<PathBuf>,

    /// File to write: a picture (.exr, .png) if no part is missing, or a film (.hdf); can be given several times
    #[arg(short, long = "output", value_name = "FILE", required = true)]
    outputs: Vec<PathBuf>,

    #[command(flatten)]
    tone: ToneArguments,
}

pub(super) fn run(arguments: &MergeArguments) -> Result<u8, CliError> {
    let (films, pictures): (Vec<PathBuf>, Vec<PathBuf>) =
        arguments.outputs.iter().cloned().partition(|path| is_film(path));
    for path in &pictures {
        output::check(path).map_err(CliError::input)?;
    }
    let files = films.iter().map(|path| OutputFile::check(path).map_err(CliError::input));
    let files = files.collect::<Result<Vec<_>, _>>()?;
    inputs::refuse(&arguments.outputs, &arguments.films)?;
    let mut merger = Merger::default();
    for path in &arguments.films {
        merger.add(path.display().to_string(), read_film(path)?).map_err(CliError::input)?;
    }
    let Some((film, missing)) = merger.finish() else { return Ok(EXIT_DONE) };
    if !pictures.is_empty() {
        whole(&missing)?;
    }
    for file in files {
        file.write(&film.encode()).map_err(CliError::system)?;
    }
    if let Some(warning) = bad_samples(&film) {
        print_warning(Style::Silent, &warning);
    }
    let (written, failures) = write_all(&pictures, &film.picture(), &arguments.tone.mapping());
    refuse_failures(&written, failures)?;
    Ok(EXIT_DONE)
}

/// Refuses to make a picture of a film with gaps.
fn whole(missing: &Missing) -> Result<(), CliError> {
    let Missing { tiles, of, first: Some((x, y)) } = missing else { return Ok(()) };
    Err(invalid(
        format!(
            "{tiles} of {of} tiles are missing or have gaps in their samples, the first at the pixels {}..{} by {}..{}",
            x.start, x.end, y.start, y.end
        ),
        "name all parts; to put some of them together, write a film (.hdf)",
    ))
}
