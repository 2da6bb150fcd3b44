//! `halfdome merge`: joins parts: films to a picture, states of a bake to one, sensors' irradiance to a table.

use std::path::{Path, PathBuf};

use clap::Args;

use super::bake::is_state;
use super::render::{bad_samples, refuse_failures, write_all};
use crate::bake::Checkpoint;
use crate::cli::args::{ToneArguments, is_film};
use crate::cli::checkpoint::read_film;
use crate::cli::error::{CliError, EXIT_DONE, invalid};
use crate::cli::inputs;
use crate::cli::messages::{Style, print_warning};
use crate::film::{Merger, Missing};
use crate::irradiance::{self, SensorPart};
use crate::output::{self, OutputFile};
use crate::settings::Invalid;

#[derive(Args, Clone, Debug)]
pub(crate) struct MergeArguments {
    /// Films (.hdf) that `halfdome render` wrote, or shards of `halfdome bake` (.state) or of `halfdome irradiance`
    #[arg(required = true, value_name = "PART")]
    parts: Vec<PathBuf>,

    /// File to write: for films a picture (.exr, .png) if no part is missing, or a film (.hdf), can be given several
    /// times; for bakes a state (.state); for irradiance a text
    #[arg(short, long = "output", value_name = "FILE", required = true)]
    outputs: Vec<PathBuf>,

    #[command(flatten)]
    tone: ToneArguments,
}

pub(crate) fn run(arguments: &MergeArguments) -> Result<u8, CliError> {
    inputs::refuse(&arguments.outputs, &arguments.parts)?;
    let first = read(&arguments.parts[0])?;
    if Checkpoint::is_checkpoint(&first) {
        return write_one(arguments, is_state, "a name that ends in .state", |parts| Checkpoint::merge(&parts));
    }
    if SensorPart::is_part(&first) {
        let is_text = |path: &Path| !is_film(path) && !is_state(path) && output::check(path).is_err();
        return write_one(arguments, is_text, "the name of a text file", |parts| {
            let decoded = parts.into_iter().map(|(name, bytes)| match SensorPart::decode(&bytes) {
                Ok(part) => Ok((name, part)),
                Err(Invalid { problem, remedy }) => Err(Invalid::new(format!("{name} {problem}"), remedy)),
            });
            irradiance::join(&decoded.collect::<Result<Vec<_>, _>>()?).map(String::into_bytes)
        });
    }
    drop(first);
    merge_films(arguments)
}

/// Writes what `merge` makes of the parts with their names to the only output.
fn write_one(
    arguments: &MergeArguments,
    is_right: impl Fn(&Path) -> bool,
    right: &str,
    merge: impl FnOnce(Vec<(String, Vec<u8>)>) -> Result<Vec<u8>, Invalid>,
) -> Result<u8, CliError> {
    let [output] = &arguments.outputs[..] else {
        return Err(invalid("these parts make one file, and there are several outputs", "give one output (-o)"));
    };
    if !is_right(output) {
        let problem = format!("{}: these parts make no such file", output.display());
        return Err(invalid(problem, format!("give {right}")));
    }
    let file = OutputFile::check(output).map_err(CliError::input)?;
    let parts = arguments.parts.iter().map(|path| Ok((path.display().to_string(), read(path)?)));
    let merged = merge(parts.collect::<Result<Vec<_>, CliError>>()?)?;
    file.write(&merged).map_err(CliError::system)?;
    Ok(EXIT_DONE)
}

fn read(path: &Path) -> Result<Vec<u8>, CliError> {
    std::fs::read(path).map_err(|error| {
        invalid(
            format!("{}: cannot be read: {error}", path.display()),
            "name films (.hdf), or what `halfdome bake --shard` or `halfdome irradiance --shard` wrote",
        )
    })
}

fn merge_films(arguments: &MergeArguments) -> Result<u8, CliError> {
    let (films, pictures): (Vec<PathBuf>, Vec<PathBuf>) =
        arguments.outputs.iter().cloned().partition(|path| is_film(path));
    for path in &pictures {
        output::check(path).map_err(CliError::input)?;
    }
    let files = films.iter().map(|path| OutputFile::check(path).map_err(CliError::input));
    let files = files.collect::<Result<Vec<_>, _>>()?;
    let mut merger = Merger::default();
    for path in &arguments.parts {
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
