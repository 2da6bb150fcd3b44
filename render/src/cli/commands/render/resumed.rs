//! `halfdome render --resume`: the film that is there.

use std::path::Path;

use crate::cache::Cache;
use crate::cli::checkpoint::read_film;
use crate::cli::error::{CliError, invalid};
use crate::cli::messages::{Style, print_text};
use crate::driver;
use crate::film::Film;
use crate::scene::count;
use crate::settings::Settings;
use crate::world::World;

/// Refuses to write checkpoints over a film that is not gone on with: it may be the work of a night.
pub(super) fn refuse_to_replace(path: &Path, resumes: bool) -> Result<(), CliError> {
    if resumes || !path.exists() {
        return Ok(());
    }
    let problem = format!("{}: the film is there already, and checkpoints would replace it", path.display());
    Err(invalid(problem, "give --resume to go on with it, or remove it"))
}

/// The film that was begun, if there is one; refuses that of another picture.
pub(super) fn begun(
    path: &Path,
    world: &World,
    settings: &Settings,
    cache: Option<&Cache>,
    style: Style,
) -> Result<Option<Film>, CliError> {
    if !path.exists() {
        print_text(style, &format!("{} is not there yet: the render begins", path.display()));
        return Ok(None);
    }
    let film = read_film(path)?;
    let expected = driver::film_header(world, settings, cache);
    film.header().check(&expected).map_err(|error| CliError::input(error.naming(&path.display().to_string())))?;
    let samples = film.samples();
    print_text(
        style,
        &format!("going on with {}: {} to {} samples a pixel", path.display(), samples.start, samples.end),
    );
    Ok(Some(film))
}

/// The warning about a film that has more samples than are asked for: none can be taken out of its sums.
pub(super) fn more_samples(film: &Film, spp: u32) -> Option<String> {
    let most = film.samples().end;
    (most > spp).then(|| {
        let samples = count(most as usize, "sample", "samples");
        format!(
            "the film has {samples} a pixel already, more than --spp {spp}: the picture is written with all of them"
        )
    })
}
