//! Compares the qualities of trees: build time, memory, expected cost and tracing speed, in turns.
//!
//! The nodes and blocks that a ray visits are counted too: a figure without noise. Embree and the other ray tracers are
//! in the binary `peers`.

use std::error::Error;
use std::process::ExitCode;
use std::time::Instant;

use clap::Parser;
use halfdome::RayonExecutor;
use halfdome_benches::measure::{self, Timing};
use halfdome_benches::rays::{self, RayCounts, RaySet};
use halfdome_benches::scenes::{self, Scene};
use halfdome_benches::tracer::{Entry, Tracer};
use halfdome_benches::visits::Visits;
use halfdome_kernel::{Bvh, Quality, Serial};

/// Compares the qualities of trees.
#[derive(Parser)]
struct Options {
    /// Scenes to trace; terrain:N is one of 2 N² triangles
    #[arg(value_name = "SCENE", default_values = scenes::NAMES)]
    scenes: Vec<String>,
    /// How often each tree is built and traced
    #[arg(long, value_name = "N", default_value_t = 3, value_parser = clap::value_parser!(u16).range(1..))]
    rounds: u16,
    /// Build on all threads instead of one
    #[arg(long)]
    parallel: bool,
}

/// A tree and the least time that it took to build.
struct Built {
    quality: Quality,
    seconds: f64,
    bvh: Bvh,
}

fn main() -> ExitCode {
    let options = Options::parse();
    scenes::for_each(&options.scenes, |scene| compare(scene, &options))
}

/// Builds the trees of a scene in turns, traces rays through them in turns, and prints what came out.
fn compare(scene: &Scene, options: &Options) -> Result<(), Box<dyn Error>> {
    let mut built: Vec<Built> = Vec::new();
    for round in 0..options.rounds {
        for (i, quality) in Quality::ALL.into_iter().enumerate() {
            let start = Instant::now();
            let (bvh, _) = if options.parallel {
                Bvh::build_on(&RayonExecutor::UNWATCHED, &scene.triangles, &quality.into())?
            } else {
                Bvh::build_on(&Serial, &scene.triangles, &quality.into())?
            };
            let seconds = start.elapsed().as_secs_f64();
            match round {
                0 => built.push(Built { quality, seconds, bvh }),
                _ => built[i].seconds = built[i].seconds.min(seconds),
            }
        }
    }
    println!("{}: {} triangles", scene.name, scene.triangles.len());
    println!(
        "{:8}{:>9}{:>9}{:>9}{:>7}{:>8}{:>9}{:>7}",
        "quality", "seconds", "nodes", "blocks", "fill", "MiB", "B/tri", "cost"
    );
    for Built { quality, seconds, bvh } in &built {
        let tree = bvh.statistics();
        println!(
            "{:8}{seconds:9.3}{:9}{:9}{:7.2}{:8.1}{:9.1}{:7.2}",
            quality.name(),
            tree.nodes,
            tree.blocks,
            tree.triangles as f64 / tree.blocks as f64,
            tree.memory_bytes as f64 / f64::from(1 << 20),
            tree.memory_bytes as f64 / tree.triangles as f64,
            tree.cost,
        );
    }
    println!("{:8}{:8}{:>10}{:>8}{:>9}{:>9}", "rays", "quality", "Mrays/s", "ratio", "nodes", "blocks");
    for set in rays::generate(scene, &built[0].bvh.view(), RayCounts::QUICK) {
        compare_kind(&built, &set, options.rounds.into())?;
    }
    println!();
    Ok(())
}

/// Traces rays of one kind through all trees, and prints a line for each; ratios are to the last.
fn compare_kind(built: &[Built], set: &RaySet, rounds: usize) -> Result<(), Box<dyn Error>> {
    let tracers: Vec<_> = built.iter().map(|built| Entry::Batch.tracer(built.bvh.view())).collect();
    let tracers: Vec<&dyn Tracer> = tracers.iter().map(|tracer| &**tracer).collect();
    let timings = measure::interleaved(&tracers, set, rounds);
    let Some(last) = timings.last() else { return Ok(()) };
    let fastest = |timing: &Timing| timing.rates.iter().copied().fold(0.0, f64::max);
    for (Built { quality, bvh, .. }, timing) in built.iter().zip(&timings) {
        if timing.answers != last.answers {
            return Err(format!("{}: other hits in the {quality} tree", set.kind.name()).into());
        }
        let visits = Visits::of(&bvh.view(), set);
        println!(
            "{:8}{:8}{:10.2}{:8.2}{:9.2}{:9.2}",
            set.kind.name(),
            quality.name(),
            fastest(timing),
            timing.ratio(last),
            visits.nodes,
            visits.blocks
        );
    }
    Ok(())
}
