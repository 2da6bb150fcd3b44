//! Times the kernel's entry points on scenes and rays of several kinds, one thread, and checks that all results are
//! equal; and batches on two threads, relative to one.
//!
//! `cargo bench -p halfdome-benches -- [--scene NAME]… [--rounds N]`. With `--test`, or without the `--bench` that
//! `cargo bench` passes (so under `cargo test --benches`), each entry point traces a few rays once, untimed.

use std::process::ExitCode;
use std::time::Instant;

use clap::Parser;
use halfdome_benches::measure::{self, Timing};
use halfdome_benches::rays::{self, RayCounts, RaySet};
use halfdome_benches::rounds::Rounds;
use halfdome_benches::scenes::{self, Scene};
use halfdome_benches::tracer::{Entry, Threads, Tracer};
use halfdome_kernel::{BuildOptions, Bvh, BvhView};

/// Small enough to be built and traced within a minute, all of them together.
const DEFAULT_SCENES: [&str; 6] = ["cornell", "city", "kitchen", "blob", "forest", "terrain:300"];

/// Times the kernel's entry points against each other.
#[derive(Parser)]
struct Options {
    /// A scene to trace, several if repeated
    #[arg(long = "scene", value_name = "NAME", default_values = DEFAULT_SCENES)]
    scenes: Vec<String>,
    #[command(flatten)]
    rounds: Rounds,
}

fn main() -> ExitCode {
    let options = Options::parse();
    scenes::for_each(&options.scenes, |scene| bench(scene, options.rounds.timed()))
}

/// Traces a scene's rays in `rounds` rounds, a few rays if that is none, and prints a line for each kind.
fn bench(scene: &Scene, rounds: u16) -> Result<(), Box<dyn std::error::Error>> {
    let start = Instant::now();
    let (bvh, _) = Bvh::build(&scene.triangles, &BuildOptions::default())?;
    let (seconds, statistics) = (start.elapsed().as_secs_f64(), bvh.statistics());
    println!(
        "{}: {} triangles, built in {seconds:.2} s, {:.1} MiB, expected cost {:.1}",
        scene.name,
        scene.triangles.len(),
        statistics.memory_bytes as f64 / (1 << 20) as f64,
        statistics.cost
    );
    print!("{:10}{:>9}{:>9}{:>18}", "Mrays/s", "rays", "hits", "checksum");
    println!("{}{:>12}", Entry::ALL.map(|entry| format!("{:>9}", entry.name())).concat(), "2 threads");
    let counts = if rounds == 0 { RayCounts::TINY } else { RayCounts::FULL };
    for set in rays::generate(scene, &bvh.view(), counts) {
        let (timings, scaling) = time(bvh.view(), &set, rounds);
        let answers = &timings[0].answers;
        let rates: String = timings.iter().map(rate).collect();
        let (kind, checksum) = (set.kind.name(), answers.checksum());
        println!("{kind:10}{:9}{:9}  {checksum:016x}{rates}{scaling:>12}", set.rays.len(), answers.hits());
        for (entry, timing) in Entry::ALL.iter().zip(&timings) {
            if timing.answers.checksum() != checksum {
                let (scene, name, first) = (&scene.name, entry.name(), Entry::ALL[0].name());
                let found = timing.answers.checksum();
                return Err(format!("{scene}, {kind}: {name} has the checksum {found:016x}, unlike {first}").into());
            }
        }
    }
    println!();
    Ok(())
}

/// A column of the table: nothing was timed without rounds.
fn rate(timing: &Timing) -> String {
    if timing.rates.is_empty() { format!("{:>9}", "-") } else { format!("{:9.2}", timing.rate()) }
}

/// One timing for each of [`Entry::ALL`], and how many times as fast two threads trace batches as one.
fn time(tree: BvhView, set: &RaySet, rounds: u16) -> (Vec<Timing>, String) {
    let tracers = Entry::ALL.map(|entry| entry.tracer(tree));
    let two = rayon::ThreadPoolBuilder::new().num_threads(2).build().expect("two threads can be had");
    let (batch, two) = (Entry::Batch.tracer(tree), Threads(tree, two));
    let mut all: Vec<&dyn Tracer> = vec![&two, &*batch];
    all.extend(tracers.iter().map(|tracer| &**tracer));
    let mut timings = measure::interleaved(&all, set, rounds.into());
    let entries = timings.split_off(2);
    let scaling = if rounds == 0 { "-".into() } else { format!("{:.2}", timings[0].ratio(&timings[1])) };
    (entries, scaling)
}
