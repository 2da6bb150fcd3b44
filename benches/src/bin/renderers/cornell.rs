//! The Cornell box: every renderer gets its triangles as numbers, and paths that end by roulette alone after eight
//! bounces, with the same samples.
//!
//! Errors are relative to one long render of ours; that a peer's pictures converge to it too is shown by `brighter`
//! and, for independent samples, from a variance ratio of one. There are two measures, for the mean squared error is
//! decided by the few pixels that the light's edge crosses, the relative one by the whole picture.

use std::error::Error;
use std::fs;

use halfdome::scene::cornell_box;
use halfdome::world::World;
use halfdome_kernel::sampling::Pattern;

use crate::error::Reference;
use crate::peer::Peer;
use crate::renderer::{self, Halfdome, Renderer};
use crate::report::{self, Line, Record, Task};
use crate::{Options, REFERENCE_SEEDS, scene};

/// Bounces that every path makes unless it leaves the scene; from the ninth on there is roulette.
const SURE_BOUNCES: u32 = 8;
/// Pixels along the picture's side.
const SIDE: u32 = 256;
/// Samples a pixel.
const SPP: u32 = 64;
/// Samples a pixel of each of the reference's two halves.
const REFERENCE: u32 = 4096;
/// Names and scripts of the peers.
const PEERS: [(&str, &str); 2] = [("mitsuba", "mitsuba_peer.py"), ("cycles", "cycles_peer.py")];

/// Compares all renderers by the box, and prints what they did.
pub(crate) fn compare(options: &Options) -> Result<(), Box<dyn Error>> {
    let (width, height) = options.size.unwrap_or((SIDE, SIDE));
    if width != height {
        return Err(format!("the Cornell box is square, and {width}x{height} is not: leave `cornell` out").into());
    }
    let spp = options.spp.unwrap_or(SPP);
    let reference_spp = options.reference.unwrap_or(REFERENCE);
    let scene = cornell_box();
    let directory = tempfile::tempdir()?;
    let file = directory.path().join("scene.json");
    fs::write(&file, scene::description(&scene, width, SURE_BOUNCES)?.to_string())?;
    let world = World::new(scene)?;
    let pixels = width * height;

    let ours = |name: &str, sampler, threads| {
        Halfdome::new(name, &world, renderer::settings(width, SURE_BOUNCES, sampler), threads)
    };
    let mut renderers: Vec<Box<dyn Renderer + '_>> =
        vec![Box::new(ours("halfdome", Pattern::Sobol, 1)?), Box::new(ours("halfdome random", Pattern::Random, 1)?)];
    for (name, script) in PEERS {
        match Peer::start(name, script, &[file.as_os_str()], directory.path(), 3 * pixels as usize) {
            Ok(peer) => renderers.push(Box::new(peer)),
            Err(error) => eprintln!("no {name}: {error}"),
        }
    }

    // All threads, as it is not timed.
    let mut ours = ours("reference", Pattern::Sobol, 0)?;
    let mut half = |seed| ours.render(reference_spp, seed).map(|rendering| rendering.pixels);
    let [first, second] = REFERENCE_SEEDS.map(&mut half);
    let reference = Reference::new(&first?, &second?);
    let task = Task { spp, pixels, reference_spp: 2 * reference_spp };

    let records = measure(&mut renderers, &reference, spp, options.rounds)?;
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
    spp: u32,
    rounds: u32,
) -> Result<Vec<Record>, String> {
    let render = |renderer: &mut Box<dyn Renderer + '_>, spp, seed| {
        renderer.render(spp, seed).map_err(|error| format!("{}: {error}", renderer.name()))
    };
    for renderer in renderers.iter_mut() {
        render(renderer, spp, 0)?;
    }
    let mut records: Vec<Record> = renderers.iter().map(|_| Record::default()).collect();
    for round in 1..=rounds {
        for (renderer, record) in renderers.iter_mut().zip(&mut records) {
            record.add(&render(renderer, spp, round)?, reference);
        }
    }
    for round in 1..=rounds {
        for (renderer, record) in renderers.iter_mut().zip(&mut records) {
            record.add_single(&render(renderer, 1, rounds + round)?, reference);
        }
    }
    Ok(records)
}
