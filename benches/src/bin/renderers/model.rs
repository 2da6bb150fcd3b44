//! Scenes made in Blender: Cycles' script makes the model, which all render.
//!
//! The reference is Cycles' too, so that errors include differences of models; `brighter` shows how far ours and
//! Mitsuba's agree with it. Errors and noise are the mean of `(a - r)² / (r² + 0.01)` over all values but the worst
//! thousandth, where a few paths would decide; an error is less the reference's own.

use std::error::Error;
use std::ffi::OsStr;
use std::path::Path;

use clap::Parser;
use halfdome::scene::{Overrides, open};
use halfdome::settings::Settings;
use halfdome::world::World;

use crate::error::Reference;
use crate::peer::Peer;
use crate::renderer::{Halfdome, Renderer};
use crate::table::{self, Record};
use crate::{Options, REFERENCE_SEEDS, reference_cache, side_by_side};

/// Pixels across and down.
const SIZE: (u32, u32) = (320, 240);
/// Samples a pixel.
const SPP: u32 = 16;
/// Samples a pixel of each of the reference's two halves.
const REFERENCE: u32 = 512;

/// Options of `halfdome render` that are about the scene.
#[derive(Parser)]
#[command(no_binary_name = true)]
struct Ours {
    #[command(flatten)]
    overrides: Overrides,
}

/// Compares all renderers by the scene called `name`, and prints what they did; without Cycles it is left out.
pub(crate) fn compare(name: &str, options: &Options) -> Result<(), Box<dyn Error>> {
    let (width, height) = options.size.unwrap_or(SIZE);
    let spp = options.spp.unwrap_or(SPP);
    let length = 3 * width as usize * height as usize;
    let directory = tempfile::tempdir()?;
    let [across, down] = [width, height].map(|side| side.to_string());
    let arguments: [&OsStr; 4] = [name.as_ref(), directory.path().as_os_str(), across.as_ref(), down.as_ref()];
    let mut cycles = match Peer::start("cycles", "cycles_scenes.py", &arguments, directory.path(), length) {
        Ok(cycles) => cycles,
        Err(error) => {
            eprintln!("no {name}, as no cycles: {error}");
            return Ok(());
        }
    };
    let model = directory.path().join("scene.glb");
    let samples = options.reference.unwrap_or(REFERENCE);
    let [first, second] = reference_cache::load_or_render(name, &model, [width, height, samples], || {
        let mut half = |seed| cycles.render(samples, seed).map(|rendering| rendering.pixels);
        Ok([half(REFERENCE_SEEDS[0])?, half(REFERENCE_SEEDS[1])?])
    })?;
    let reference = Reference::new(&first, &second);

    let entries = options.ours.iter().map(|text| world(directory.path(), text, (width, height)));
    let entries: Vec<(World, Settings)> = entries.collect::<Result<_, _>>()?;
    let mut renderers: Vec<Box<dyn Renderer + '_>> = Vec::new();
    for (text, (world, settings)) in options.ours.iter().zip(&entries) {
        renderers.push(Box::new(Halfdome::new(format!("halfdome {text}").trim(), world, settings.clone(), 1)?));
    }
    let ours = renderers.len();
    renderers.push(Box::new(cycles));
    let description = directory.path().join("scene.json");
    match Peer::start("mitsuba", "mitsuba_scenes.py", &[description.as_os_str()], directory.path(), length) {
        Ok(mitsuba) => renderers.push(Box::new(mitsuba)),
        Err(error) => eprintln!("no mitsuba: {error}"),
    }

    let records = measure(&mut renderers, spp, options.rounds)?;
    let names: Vec<&str> = renderers.iter().map(|renderer| renderer.name()).collect();
    let lines = table::Lines { names: &names, records: &records, ours, reference: &reference };
    if options.json {
        lines.json(name, spp).iter().for_each(|line| println!("{line}"));
    } else {
        println!("{}", lines.text(name, spp, 2 * samples));
    }
    if let Some(pictures) = &options.pictures {
        side_by_side::write(
            &pictures.join(name).with_extension("png"),
            &mut renderers,
            &records,
            &reference,
            width,
            spp,
        )?;
    }
    Ok(())
}

/// What the scene file in `directory` describes, with `text` from the command line.
fn world(directory: &Path, text: &str, (width, height): (u32, u32)) -> Result<(World, Settings), Box<dyn Error>> {
    let words = text.split_whitespace();
    let mut overrides = Ours::try_parse_from(words).map_err(|error| format!("--ours: {error}"))?.overrides;
    (overrides.width, overrides.height) = (Some(width), Some(height));
    overrides.filter.get_or_insert_with(|| "box".to_owned());
    let file = directory.join("scene.toml");
    let (mut scene, from_file) = open(&file)?;
    let settings = overrides.or(from_file.clone()).apply(&mut scene);
    let settings = settings.map_err(|conflict| conflict.naming(&file, &from_file))?;
    for warning in scene.warnings.drain(..) {
        eprintln!("warning: {warning}");
    }
    Ok((World::new(scene)?, settings))
}

/// Lets all render in turns: a picture that does not count, for compilers and caches, then one a round, each with
/// another seed.
fn measure(renderers: &mut [Box<dyn Renderer + '_>], spp: u32, rounds: u32) -> Result<Vec<Record>, String> {
    let mut records: Vec<Record> = renderers.iter().map(|_| Record::default()).collect();
    for round in 0..=rounds {
        for (renderer, record) in renderers.iter_mut().zip(&mut records) {
            let rendering = renderer.render(spp, round).map_err(|error| format!("{}: {error}", renderer.name()))?;
            if round > 0 {
                record.add(rendering);
            }
        }
    }
    Ok(records)
}
