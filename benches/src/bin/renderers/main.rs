//! Renders the Cornell box with our path tracer, Mitsuba 3 and Blender's Cycles, one thread each, in turns, and compares
//! time and error at the same number of samples.
//!
//! `setup-renderers.sh` installs the peers, which scripts in `benches/renderers` run; without one its line is missing.
//! All have the same scene, camera, box filter, direct light by multiple importance sampling, and paths that end by
//! roulette alone after eight bounces.
//!
//! Errors are held against one long render of ours; that a peer's pictures tend to it too is seen from `brighter` and,
//! for independent samples, from a variance ratio of one. There are two measures, for the mean squared error is decided
//! by the few pixels that the light's edge crosses, the relative one by the whole picture.

mod error;
mod peer;
mod renderer;
mod report;
mod scene;

use std::error::Error;
use std::fs;
use std::process::ExitCode;

use clap::Parser;
use halfdome::scene::cornell_box;
use halfdome::world::World;
use halfdome_kernel::sampling::Pattern;

use crate::error::Reference;
use crate::peer::Peer;
use crate::renderer::{Halfdome, Renderer};
use crate::report::{Line, Record, Task};

/// Bounces that every path makes unless it leaves the scene; from the ninth on there is roulette.
const SURE_BOUNCES: u32 = 8;
/// Names and scripts of the peers.
const PEERS: [(&str, &str); 2] = [("mitsuba", "mitsuba_peer.py"), ("cycles", "cycles_peer.py")];
/// Seeds of the reference's halves, which no round has.
const REFERENCE_SEEDS: [u32; 2] = [1 << 20, 2 << 20];

/// Compares our path tracer with other renderers.
#[derive(Parser)]
struct Options {
    /// Samples a pixel
    #[arg(long, value_name = "N", default_value_t = 64, value_parser = clap::value_parser!(u32).range(1..))]
    spp: u32,
    /// Pixels along the picture's side
    #[arg(long, value_name = "N", default_value_t = 256, value_parser = clap::value_parser!(u32).range(1..=4096))]
    side: u32,
    /// How often each renderer renders
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = clap::value_parser!(u32).range(1..1 << 19))]
    rounds: u32,
    /// Samples a pixel of each of the reference's two halves
    #[arg(long, value_name = "N", default_value_t = 4096, value_parser = clap::value_parser!(u32).range(1..1 << 30))]
    reference: u32,
    /// Print one JSON object a line
    #[arg(long)]
    json: bool,
}

fn main() -> ExitCode {
    match compare(&Options::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}

fn compare(options: &Options) -> Result<(), Box<dyn Error>> {
    let scene = cornell_box();
    let directory = tempfile::tempdir()?;
    let file = directory.path().join("scene.json");
    fs::write(&file, scene::description(&scene, options.side, SURE_BOUNCES)?.to_string())?;
    let world = World::new(scene)?;
    let pixels = options.side * options.side;

    let ours = |name, sampler, threads| {
        Halfdome::new(name, &world, renderer::settings(options.side, SURE_BOUNCES, sampler), threads)
    };
    let mut renderers: Vec<Box<dyn Renderer + '_>> =
        vec![Box::new(ours("halfdome", Pattern::Sobol, 1)?), Box::new(ours("halfdome random", Pattern::Random, 1)?)];
    for (name, script) in PEERS {
        match Peer::start(name, script, &file, directory.path(), 3 * pixels as usize) {
            Ok(peer) => renderers.push(Box::new(peer)),
            Err(error) => eprintln!("no {name}: {error}"),
        }
    }

    // As many threads as there are, since nobody times it.
    let mut ours = ours("reference", Pattern::Sobol, 0)?;
    let mut half = |seed| ours.render(options.reference, seed).map(|rendering| rendering.pixels);
    let [first, second] = REFERENCE_SEEDS.map(&mut half);
    let reference = Reference::new(&first?, &second?);
    let task = Task { spp: options.spp, pixels, reference_spp: 2 * options.reference };

    let records = measure(&mut renderers, &reference, options)?;
    if options.json {
        println!("{}", report::reference_json(&reference, &task));
    } else {
        println!("{}\n{}", report::reference_text(&reference, &task), report::heading());
    }
    for (renderer, record) in renderers.iter().zip(&records) {
        let line = Line { name: renderer.name(), about: renderer.about(), record, ours: &records[0] };
        if options.json {
            println!("{}", line.json(&task));
        } else {
            println!("{}", line.text(&task));
        }
    }
    Ok(())
}

/// Lets all render in turns: a picture that does not count, for compilers and caches, then one a round, each with
/// another seed, then as many of a single sample a pixel.
fn measure(
    renderers: &mut [Box<dyn Renderer + '_>],
    reference: &Reference,
    options: &Options,
) -> Result<Vec<Record>, String> {
    let render = |renderer: &mut Box<dyn Renderer + '_>, spp, seed| {
        renderer.render(spp, seed).map_err(|error| format!("{}: {error}", renderer.name()))
    };
    for renderer in renderers.iter_mut() {
        render(renderer, options.spp, 0)?;
    }
    let mut records: Vec<Record> = renderers.iter().map(|_| Record::default()).collect();
    for round in 1..=options.rounds {
        for (renderer, record) in renderers.iter_mut().zip(&mut records) {
            record.add(&render(renderer, options.spp, round)?, reference);
        }
    }
    for round in 1..=options.rounds {
        for (renderer, record) in renderers.iter_mut().zip(&mut records) {
            record.add_single(&render(renderer, 1, options.rounds + round)?, reference);
        }
    }
    Ok(records)
}
