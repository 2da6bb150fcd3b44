//! Experiments on the irradiance cache: its error against path tracing, by rays and records.
//!
//! Unlike other experiments these have no closed form. Their references are long runs of path tracing, whose own error
//! is stated in the figures' titles and subtracted.

mod curves;
mod study;
mod walls;

use super::room::furnished_room;
use super::scenes::world;
use super::{Experiment, Family, Interrupted, Outcome, Runner};
use crate::cache::Reading;
use crate::output::plot::Figure;
use crate::scene::{Scene, cornell_box};
use crate::settings::{CachedOptions, Gradients, Metric};
use crate::world::World;
use curves::{GRADIENTS, HESSIAN, NO_GRADIENTS, error_of, rays_for, records_for};

pub use curves::{Cost, Curves, KINDS, Kind, Plan};
pub use study::{Places, Reference, RelativeError, Run, Study};
pub use walls::Walls;

pub(super) const FAMILY: Family = Family {
    name: "cache",
    about: "What the irradiance cache is worth, against path tracing",
    experiments: &[
        Experiment {
            name: "cache-cornell",
            about: "Records with gradients, relative to those without for the same error, in the Cornell box",
            run: gradients,
        },
        Experiment {
            name: "cache-room",
            about: "Rays of a cache, relative to those of path tracing for the same error, in a furnished room",
            run: paths,
        },
        Experiment {
            name: "cache-hessian",
            about: "Error of 1700 records by the Hessian, relative to that by the bounded split-sphere as published",
            run: hessian,
        },
        Experiment {
            name: "cache-walls",
            about: "Greatest relative error of 96 x 96 sensors on a wall of the Cornell box, by cache",
            run: walls::experiment,
        },
    ],
};

/// Records that both metrics have when they are compared, as many as Schwarzhaupt et al. (2012) compare, of 4096 rays
/// each.
const RECORDS: f64 = 1700.0;

/// A study of a scene, with so many paths for each half of its reference. A quick one looks at as many surfaces, as few
/// of them decide: one in a corner can be half of all.
fn study<'a>(runner: &Runner<'a>, world: &'a World, paths: u32, seed: u64) -> Result<Study<'a>, Interrupted> {
    let study = Study::new(world, Places::Candidates, 32, paths, seed, runner.watch());
    if runner.watch().stop() { Err(Interrupted) } else { Ok(study) }
}

/// The curves of a scene, and their figure; a quick one has those of `metric` alone, which are compared.
fn curves(
    runner: &Runner,
    name: &'static str,
    title: &str,
    scene: Scene,
    metric: Metric,
) -> Result<(Curves, Figure), Interrupted> {
    let world = world(scene);
    // However quick: of a reference that is known no better than a cache's value the difference would be noise.
    let study = study(runner, &world, 8192, runner.seed())?;
    let plan = match runner.share(8) {
        8 => Plan {
            paths: &[16, 64, 256, 1024],
            errors: &[0.8, 0.57, 0.4, 0.28, 0.2],
            rays: 2048,
            metrics: &Metric::ALL,
        },
        _ => Plan { paths: &[64, 256], errors: &[0.57, 0.4], rays: 2048, metrics: &[metric] },
    };
    let curves =
        Curves::measure(&study, &plan, |_, _, _| (!runner.watch().stop()).then_some(0.0)).ok_or(Interrupted)?;
    let reference = format!("reference: {:.1}%", 100.0 * study.reference_error());
    let figure = curves.figure(name, &format!("{title}: indirect light ({reference})"), Cost::Rays);
    Ok((curves, figure))
}

fn gradients(runner: &Runner) -> Result<Outcome, Interrupted> {
    let (curves, figure) = curves(runner, "cache-cornell", "Cornell box", cornell_box(), Metric::SplitSphere)?;
    // The least error without gradients is one that coarser caches have with them.
    let without = finest(curves.of(NO_GRADIENTS));
    let relative = |error| records_for(curves.of(GRADIENTS), error) / without.records as f64;
    Ok(comparison("records", without, relative, 0.5, figure))
}

fn paths(runner: &Runner) -> Result<Outcome, Interrupted> {
    let (curves, figure) = curves(runner, "cache-room", "Furnished room", furnished_room(), Metric::Hessian)?;
    let finest = finest(curves.of(HESSIAN));
    let relative = |error| finest.rays / rays_for(curves.by_paths(), error);
    Ok(comparison("rays", finest, relative, 0.1, figure))
}

/// The run with the least error.
fn finest(runs: &[Run]) -> &Run {
    runs.iter().min_by(|a, b| a.error.of_all.total_cmp(&b.error.of_all)).expect("each kind has runs")
}

/// How much of `what` the error of a run takes, relative to another way. An error that is lost in the reference's own
/// shows no advantage.
fn comparison(what: &str, run: &Run, relative: impl Fn(f64) -> f64, tolerance: f64, figure: Figure) -> Outcome {
    let error = run.error.of_all;
    let measured = if error > 0.0 { relative(error) } else { 1.0 };
    let quantity = format!("{what} for an error of {:.1}%", 100.0 * error);
    Outcome { quantity, measured, expected: 0.0, tolerance, figure: Some(figure) }
}

/// Paths for each half of the reference, however quick: the Hessian's error is 0.6%, and of a reference that is known
/// to 2% the difference would be noise.
const HESSIAN_REFERENCE: u32 = 32_768;

fn hessian(runner: &Runner) -> Result<Outcome, Interrupted> {
    let world = world(cornell_box());
    let mut study = study(runner, &world, HESSIAN_REFERENCE, runner.seed())?;
    let mut squares = [0.0; 2];
    let seeds = [runner.seed(), !runner.seed()];
    let seeds = &seeds[..runner.share(2) as usize];
    for &seed in seeds {
        let study = study.with_seed(seed);
        let error = |metric, reading, errors: [f32; 2]| {
            let runs = errors.map(|error| {
                let options = CachedOptions { metric, error, rays: 4096, ..CachedOptions::default() };
                study.cache(options, &[reading])[0]
            });
            if runner.watch().stop() { Err(Interrupted) } else { Ok(error_of(&runs, RECORDS)) }
        };
        squares[0] += error(Metric::Bounded, Reading::Alone(Gradients::Both), [0.34, 0.28])?.powi(2);
        squares[1] += error(Metric::Hessian, Reading::Together, [0.41, 0.36])?.powi(2);
    }
    let [bounded, hessian] = squares.map(|sum| (sum / seeds.len() as f64).sqrt());
    let quantity = format!("error, relative to {:.1}%", 100.0 * bounded);
    Ok(Outcome { quantity, measured: hessian / bounded, expected: 0.0, tolerance: 1.0 / 3.0, figure: None })
}
