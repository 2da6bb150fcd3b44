//! `halfdome bake --shard`: light of a part of the texels without an irradiance cache, as a state of the bake.

use std::path::Path;
use std::time::Instant;

use super::inside::left_out;
use super::{BYTES, BakeArguments, STATE_INTERVAL, invalid, memory, print_text, warn};
use crate::bake::atlas::Atlas;
use crate::bake::{self, BakeOptions, Checkpoint, Mode, STATE_EXTENSION};
use crate::cli::error::{CliError, EXIT_DONE, EXIT_INTERRUPTED};
use crate::cli::inputs;
use crate::cli::interrupt;
use crate::cli::lock::Lock;
use crate::cli::messages::Style;
use crate::cli::progress::Progress;
use crate::output::OutputFile;
use crate::scene::Scene;
use crate::settings::Shard;
use crate::world::{LightQuery, World};

/// Whether a path is that of a bake's state.
pub(in crate::cli) fn is_state(path: &Path) -> bool {
    path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case(STATE_EXTENSION))
}

/// Checks that a shard can be written to `output`, and that it would have anything to do.
pub(super) fn check(arguments: &BakeArguments, options: &BakeOptions, output: &Path) -> Result<(), CliError> {
    if !is_state(output) {
        return Err(invalid(
            format!("{}: a shard is no model", output.display()),
            "write its state (-o part.state), put all together with `halfdome merge`, and bake with --resume",
        ));
    }
    if options.mode == Mode::Indirect && options.has_cache() && options.cache.bounces.is_some() {
        return Err(invalid(
            "all light of this bake (--mode indirect --cache-bounces) comes from irradiance caches, which no machines can share",
            "leave --shard out",
        ));
    }
    inputs::refuse(&[output], &[&arguments.scene])
}

/// Finds a shard's light.
pub(super) fn run(
    scene: &Scene,
    (options, hash): (&BakeOptions, u64),
    (output, resume): (&Path, bool),
    shard: Shard,
    style: Style,
) -> Result<u8, CliError> {
    let file = OutputFile::check(output).map_err(CliError::input)?;
    let _lock = Lock::new(output, "baking this shard")?;
    let checkpoint = if resume { Checkpoint::read(output, hash)? } else { None };
    if let Some(other) = checkpoint.as_ref().and_then(Checkpoint::shard).filter(|other| *other != shard) {
        let problem = format!("{} is of the shard {}/{}", output.display(), other.number() + 1, other.count());
        return Err(invalid(problem, "give each shard a file of its own"));
    }
    let checkpoint = checkpoint.unwrap_or_else(|| Checkpoint::new(hash)).keep(file, STATE_INTERVAL);
    let world = World::for_light_query(scene.clone(), LightQuery::Surfaces).map_err(CliError::input)?;
    warn(style, &mut bake::model_warnings(scene, &world));
    let left_out = left_out(scene, &world, options, style)?;
    let begin = Instant::now();
    let layout = Progress::of_layout(style, begin);
    let atlas = Atlas::watched(scene, &left_out, options, &|step| layout.layout(step));
    drop(layout);
    let mut atlas = atlas?;
    warn(style, &mut atlas.warnings);
    let texels = atlas.pages.iter().map(|page| page.texels() as u64).sum::<u64>();
    memory::require(
        &format!("a bake of {texels} texels"),
        texels * BYTES,
        "use a lower --density or a smaller --size",
    )?;
    interrupt::catch()?;
    let progress = Progress::of_texels(style, bake::shard_work(scene, &atlas, shard), begin, 0, false);
    let is_whole = bake::bake_shard(scene, &world, &atlas, options, &checkpoint, shard, &progress);
    drop(progress);
    checkpoint.save().map_err(CliError::system)?;
    if !is_whole {
        print_text(style, &format!("interrupted; continue with --resume from {}", output.display()));
        return Ok(EXIT_INTERRUPTED);
    }
    print_text(style, &format!("shard {}/{} is in {}", shard.number() + 1, shard.count(), output.display()));
    Ok(EXIT_DONE)
}
