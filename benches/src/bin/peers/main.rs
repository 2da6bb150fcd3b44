//! Traces the same rays through this kernel and through other ray tracers, one thread, in turns, and compares the hits.
//!
//! Embree 4.4 is loaded at run time (`setup-peers.sh` installs it); tinybvh and obvhs come with the feature `peers`.
//! Without a peer its column stays empty. For meaningful figures, build for the machine: `RUSTFLAGS="-C
//! target-cpu=native" cargo run --release -p halfdome-benches --features peers --bin peers`.

mod embree;
mod instances;
mod judge;
mod layout;
mod locate;
#[cfg(feature = "peers")]
mod obvhs;
mod report;
#[cfg(all(feature = "peers", target_feature = "avx2"))]
mod tinybvh;
mod trees;

use std::error::Error;
use std::process::ExitCode;
use std::time::Instant;

use clap::Parser;
use halfdome_benches::measure;
use halfdome_benches::rays::{self, RayCounts, RayKind, RaySet};
use halfdome_benches::scenes::{self, Scene};
use halfdome_benches::tracer::{Entry, Tracer};
use halfdome_kernel::{BuildOptions, Bvh, BvhView};

use crate::embree::Embree;
use crate::judge::Tally;
use crate::report::{Build, Comparison};
use crate::trees::Tree;

/// Compares the kernel with other ray tracers.
#[derive(Parser)]
struct Options {
    /// Scenes to trace; terrain:N is one of 2 N² triangles
    #[arg(value_name = "SCENE", default_values = scenes::NAMES)]
    scenes: Vec<String>,
    /// Trace N instances of a mesh of 100,000 triangles instead, and move them
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    instances: Option<u32>,
    /// How often each tracer traces all rays
    #[arg(long, value_name = "N", default_value_t = 7, value_parser = clap::value_parser!(u16).range(1..))]
    rounds: u16,
    /// Trace an eighth of a million rays of each kind instead of half a million
    #[arg(long)]
    quick: bool,
    /// Print one JSON object a line
    #[arg(long)]
    json: bool,
}

fn main() -> ExitCode {
    let options = Options::parse();
    let embree =
        locate::embree().and_then(|path| Embree::load(&path)).inspect_err(|error| eprintln!("no Embree: {error}")).ok();
    if let Some(missing) = trees::missing() {
        eprintln!("{missing}");
    }
    if let Some(count) = options.instances {
        return match instances::compare(count, embree.as_ref(), &options) {
            Ok(()) => ExitCode::SUCCESS,
            Err(error) => {
                eprintln!("error: {error}");
                ExitCode::FAILURE
            }
        };
    }
    scenes::for_each(&options.scenes, |scene| compare(scene, embree.as_ref(), &options))
}

/// Builds all trees over a scene, traces its rays, and prints what came out.
fn compare(scene: &Scene, embree: Option<&Embree>, options: &Options) -> Result<(), Box<dyn Error>> {
    let start = Instant::now();
    let (bvh, _) = Bvh::build(&scene.triangles, &BuildOptions::default())?;
    let seconds = start.elapsed().as_secs_f64();
    let mut builds = vec![Build { name: "halfdome", seconds, bytes: Some(bvh.statistics().memory_bytes) }];
    let trees = trees::build(&scene.triangles, embree)?;
    builds.extend(trees.iter().map(|tree| Build { name: tree.name, seconds: tree.seconds, bytes: tree.peer.bytes() }));
    if options.json {
        println!("{}", report::builds_json(&scene.name, scene.triangles.len(), &builds));
    } else {
        println!("{}\n{}", report::builds_text(&scene.name, scene.triangles.len(), &builds), report::heading());
    }
    let counts = if options.quick { RayCounts::QUICK } else { RayCounts::FULL };
    for set in rays::generate(scene, &bvh.view(), counts) {
        compare_kind(scene, &set, bvh.view(), &trees, options)?;
    }
    if !options.json {
        println!();
    }
    Ok(())
}

/// Traces rays of one kind with everything there is, and prints a line.
fn compare_kind(
    scene: &Scene,
    set: &RaySet,
    tree: BvhView,
    trees: &[Tree],
    options: &Options,
) -> Result<(), Box<dyn Error>> {
    let ours = Entry::ALL.map(|entry| (entry.name(), entry.tracer(tree)));
    let peers = trees.iter().flat_map(|tree| tree.peer.tracers(set.kind == RayKind::Primary));
    let (names, tracers): (Vec<_>, Vec<_>) = ours.into_iter().chain(peers).unzip();
    let tracers: Vec<&dyn Tracer> = tracers.iter().map(|tracer| &**tracer).collect();
    let timings = measure::interleaved(&tracers, set, options.rounds.into());
    let timings: Vec<_> = names.into_iter().zip(timings).collect();
    let (ours, peers) = timings.split_at(Entry::ALL.len());
    let kind = set.kind.name();
    for (name, timing) in ours {
        if timing.answers.checksum() != ours[0].1.answers.checksum() {
            return Err(format!("{}, {kind}: {name} finds other hits than {}", scene.name, ours[0].0).into());
        }
    }
    let mut comparison = Comparison { scene: &scene.name, kind, ours, peers, judged: Tally::default() };
    if let Some(embree) = comparison.embree() {
        comparison.judged = judge::tally(&scene.triangles, set, &ours[0].1.answers, embree);
    }
    if options.json {
        println!("{}", comparison.json());
    } else {
        println!("{}", comparison.text());
    }
    Ok(())
}
