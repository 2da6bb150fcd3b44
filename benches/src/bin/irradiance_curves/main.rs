//! The irradiance cache against path tracing, and against Radiance: error, rays and processor time.
//!
//! `irradiance_curves [cornell] [room] [walls] [SCENE FILE] [--plots DIR]`. Scenes give the error of indirect light at
//! what the camera sees, by paths and by caches of several kinds and errors; `walls` that of 96 x 96 sensors on each of
//! three walls of the Cornell box, for which its lamp reflects nothing, as Radiance's do not. Times are of the process
//! and of its children in user mode, on one thread; references, which do not count, take all threads.

mod radiance;

use std::error::Error;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::Parser;
use glam::Vec3;
use halfdome::driver::Watch;
use halfdome::irradiance::{Part, Request, by_paths};
use halfdome::scene::{Scene, cornell_box, open};
use halfdome::settings::Metric;
use halfdome::validate::{Cost, Curves, Places, Plan, Study, Walls, furnished_room};
use halfdome::world::World;
use nix::sys::resource::{UsageWho, getrusage};
use nix::sys::time::TimeValLike as _;
use radiance::Radiance;
use rayon::{ThreadPool, ThreadPoolBuilder};

/// Measures the irradiance cache.
#[derive(Parser)]
struct Options {
    /// `cornell`, `room`, `walls` or scene files [default: the first three]
    #[arg(value_name = "SCENE")]
    scenes: Vec<String>,
    /// Write the curves of each scene as SVG into this folder
    #[arg(long, value_name = "DIR")]
    plots: Option<PathBuf>,
    /// Paths for each half of a reference, at each sensor
    #[arg(long, value_name = "N", default_value_t = 16_384, value_parser = clap::value_parser!(u32).range(1..))]
    reference: u32,
    /// Rays of a record in the curves
    #[arg(long, value_name = "N", default_value_t = 4096, value_parser = clap::value_parser!(u32).range(12..1 << 20))]
    record_rays: u32,
}

/// Nobody watches.
struct NeverStops;

impl Watch for NeverStops {
    fn advance(&self, _: u64, _: u64) {}
    fn stop(&self) -> bool {
        false
    }
}

fn main() -> ExitCode {
    let mut options = Options::parse();
    if options.scenes.is_empty() {
        options.scenes = ["cornell", "room", "walls"].map(str::to_owned).to_vec();
    }
    match measure(&options) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}

fn measure(options: &Options) -> Result<(), Box<dyn Error>> {
    let pool = ThreadPoolBuilder::new().num_threads(1).build()?;
    for name in &options.scenes {
        match name.as_str() {
            "walls" => walls(options, &pool)?,
            "cornell" => curves("cornell", "Cornell box", cornell_box(), options, &pool)?,
            "room" => curves("room", "Furnished room", furnished_room(), options, &pool)?,
            file => {
                let path = Path::new(file);
                let (mut scene, overrides) = open(path)?;
                overrides.apply(&mut scene).map_err(|conflict| conflict.naming(path, &overrides).to_string())?;
                let stem = path.file_stem().map_or_else(|| file.to_owned(), |stem| stem.to_string_lossy().into_owned());
                curves(&stem, &stem, scene, options, &pool)?;
            }
        }
    }
    Ok(())
}

/// Seconds in user mode so far.
fn seconds(who: UsageWho) -> f64 {
    getrusage(who).map_or(f64::NAN, |usage| usage.user_time().num_microseconds() as f64 * 1e-6)
}

fn curves(name: &str, title: &str, scene: Scene, options: &Options, pool: &ThreadPool) -> Result<(), Box<dyn Error>> {
    let world = World::new(scene)?;
    let study = Study::new(&world, Places::Anywhere, 64, options.reference, 0, &NeverStops);
    let reference = format!("reference: {:.1}%", 100.0 * study.reference_error());
    println!("{title}: indirect light of 256 x 256 pixels, {} rays a record; {reference}", options.record_rays);
    println!("{:26}{:>8}{:>9}{:>9}{:>9}{:>8}{:>8}", "", "setting", "records", "Mrays", "seconds", "error", "of 99%");
    let plan = Plan {
        paths: &[16, 64, 256, 1024, 4096],
        errors: &[0.8, 0.57, 0.4, 0.28, 0.2],
        rays: options.record_rays,
        metrics: &Metric::ALL,
    };
    let measured = pool.install(|| {
        let mut before = seconds(UsageWho::RUSAGE_SELF);
        Curves::measure(&study, &plan, |kinds, setting, runs| {
            let taken = seconds(UsageWho::RUSAGE_SELF) - before;
            // Paths are traced for the sensors alone.
            let scale = if kinds.is_empty() { study.pixels() } else { 1.0 };
            let labels = kinds.iter().map(|kind| kind.label).chain(kinds.is_empty().then_some("path tracing"));
            for (label, run) in labels.zip(runs) {
                let (mrays, seconds) = (run.rays * 1e-6, taken * scale);
                let [all, most] = [run.error.of_all, run.error.of_most].map(|error| 100.0 * error);
                println!("{label:26}{setting:>8}{:>9}{mrays:>9.2}{seconds:>9.2}{all:>7.2}%{most:>7.2}%", run.records);
            }
            before = seconds(UsageWho::RUSAGE_SELF);
            Some(taken * scale)
        })
    });
    if let (Some(folder), Some(curves)) = (&options.plots, measured) {
        fs::create_dir_all(folder)?;
        let title = format!("{title}: indirect light ({reference})");
        for (cost, suffix) in [(Cost::Rays, ""), (Cost::Seconds, "-time")] {
            fs::write(folder.join(format!("cache-{name}{suffix}.svg")), curves.svg(&title, cost))?;
        }
    }
    Ok(())
}

fn walls(options: &Options, pool: &ThreadPool) -> Result<(), Box<dyn Error>> {
    let mut scene = cornell_box();
    for material in scene.materials.iter_mut().filter(|material| material.emission != Vec3::ZERO) {
        material.inputs.base_color = Vec3::ZERO;
    }
    let world = World::new(scene.clone())?;
    let walls = Walls::new(&world, options.reference, 1, &NeverStops);
    let percent = |errors: Vec<f64>| errors.iter().map(|error| format!("{:>7.2}%", 100.0 * error)).collect::<String>();
    println!(
        "Three walls of the Cornell box, 96 x 96 sensors each: relative errors of the back, the red and the green wall"
    );
    println!("{:34}{:>9}{:>24}", "", "seconds", "errors");
    println!("{:43}{}", "reference", percent(walls.reference_errors()));
    let row = |name: &str, seconds: f64, values: &[Vec3]| {
        println!("{name:34}{seconds:>9.2}{}", percent(walls.errors(values)));
    };
    let ours = |name: &str, estimate: &(dyn Fn() -> Vec<Vec3> + Sync)| {
        let before = seconds(UsageWho::RUSAGE_SELF);
        let values = pool.install(estimate);
        row(name, seconds(UsageWho::RUSAGE_SELF) - before, &values);
    };
    for (spp, rays, error) in [(8, 192, 0.8), (16, 384, 0.7), (64, 1024, 0.6), (128, 2048, 0.55), (256, 3072, 0.5)] {
        let name = format!("cache, {spp} samples, {rays} rays, {error}");
        ours(&name, &|| walls.by_cache(&world, (spp, rays, error), 0, &NeverStops).values);
    }
    for spp in [64, 256] {
        let request = Request { spp, seed: 0, part: Part::Total };
        ours(&format!("path tracing, {spp} paths"), &|| {
            by_paths(&world, walls.sensors(), &request, &NeverStops).values
        });
    }
    match Radiance::find() {
        Ok(radiance) => {
            for accuracy in radiance::ACCURACIES {
                let before = seconds(UsageWho::RUSAGE_CHILDREN);
                let values = radiance.irradiance(&scene, walls.sensors(), accuracy)?;
                let name = format!("rtrace -I {}", accuracy.join(" "));
                row(&name, seconds(UsageWho::RUSAGE_CHILDREN) - before, &values);
            }
        }
        Err(missing) => eprintln!("skipped: {missing}"),
    }
    Ok(())
}
