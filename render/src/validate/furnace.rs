//! Furnaces, closed rooms: all surfaces emit `L_e` and reflect `ρ`, so radiance is `L_e / (1 - ρ)` everywhere, whatever
//! the room's shape (a test from "Physically Based Rendering").

use glam::Vec3;
use halfdome_kernel::sampling::Pattern;

use super::scenes::{Corners, cube, grey, moved, scene, sphere, tetrahedron, turned, view, world};
use super::statistics::Sample;
use super::{Experiment, Family, Interrupted, Outcome, Runner, exact};
use crate::output::plot::{Axis, Figure, Point, Series, span};
use crate::scene::Sky;
use crate::settings::{
    AoOptions, AoWeighting, HemisphereSampling, Integrator, LightSampling, MonteCarloOptions, PathOptions, Settings,
    Stop, Survival,
};
use crate::world::World;

pub(super) const FAMILY: Family = Family {
    name: "furnace",
    about: "Closed rooms that glow: the rendering equation's simplest solution",
    experiments: &[
        Experiment {
            name: "furnace-sphere",
            about: "Radiance in a glowing sphere by path tracing",
            run: |runner| closed(runner, &sphere(3, 1.0)),
        },
        Experiment {
            name: "furnace-tetrahedron",
            about: "Radiance in a glowing tetrahedron by path tracing",
            run: |runner| closed(runner, &tetrahedron()),
        },
        Experiment {
            name: "furnace-box",
            about: "Radiance in a glowing box by path tracing",
            run: |runner| closed(runner, &cube()),
        },
        Experiment {
            name: "furnace-bounces",
            about: "What 0 to 16 bounces leave out, by montecarlo and by paths of fixed length, in all three rooms",
            run: bounces,
        },
        Experiment {
            name: "furnace-survival",
            about: "Means of 1000 paths against the probability of survival in Russian roulette",
            run: survival,
        },
        Experiment {
            name: "furnace-variance",
            about: "Variance of paths against the probability of survival, relative to its closed form",
            run: variance,
        },
        Experiment {
            name: "furnace-threshold",
            about: "Radiance by paths that end at an attenuation, with what they leave out added back and without",
            run: threshold,
        },
        Experiment {
            name: "furnace-escapes",
            about: "Rays that escape from closed spheres of any size, at any place, after many grazing bounces",
            run: escapes,
        },
    ],
};

/// Driscoll's values, for which radiance is 2.
const EMISSION: f32 = 1.0;
const REFLECTANCE: f32 = 0.5;
/// Sums of 32-bit numbers, and their ratios.
const ROUNDING: f64 = 1e-6;

fn radiance() -> f64 {
    exact::furnace(EMISSION.into(), REFLECTANCE.into())
}

/// The room from the inside.
fn room(solid: &[Corners]) -> World {
    let camera = view(Vec3::new(0.05, -0.1, 0.02), Vec3::new(0.4, 0.3, -0.5));
    world(scene([(turned(solid).as_slice(), grey(REFLECTANCE, EMISSION))], camera))
}

/// Paths that find light by bouncing alone, so that their variance has a closed form.
fn naive(max_depth: u32, stop: Stop) -> Integrator {
    Integrator::Path(PathOptions { max_depth, lights: LightSampling::Naive, stop, ..PathOptions::default() })
}

fn closed(runner: &Runner, solid: &[Corners]) -> Result<Outcome, Interrupted> {
    let runs = runner
        .render(&room(solid), Settings { width: 64, height: 64, spp: runner.share(64), ..Settings::default() })?;
    Ok(Outcome::mean("radiance", &Sample::of(&runs.values), radiance(), ROUNDING))
}

/// Driscoll's graph: the error in per cent when light has bounced `k` times, direct light being the first.
fn bounces(runner: &Runner) -> Result<Outcome, Interrupted> {
    const MAX_BOUNCES: u32 = 16;
    // Without any bounce, emitters alone are seen, which `montecarlo` does not offer.
    let gathered = |sampling| {
        move |bounces: u32| {
            let bounces = bounces.checked_sub(1)?;
            Some(Integrator::MonteCarlo(MonteCarloOptions { bounces, rays: 1, sampling, ..Default::default() }))
        }
    };
    let cosine = gathered(HemisphereSampling::Cosine);
    let uniform = gathered(HemisphereSampling::Uniform);
    let paths = |bounces| Some(naive(bounces + 1, Stop::Depth));
    // Light samples on a wall that meets one's own have a variance without bounds at the edge, and little of it where
    // the edge is all but flat: so `montecarlo`, which samples lights, is held to a fine sphere.
    let round = room(&sphere(5, 1.0));
    let (corners, square) = (room(&tetrahedron()), room(&cube()));
    type Bouncing<'a> = &'a dyn Fn(u32) -> Option<Integrator>;
    // The paths have no variance at all.
    let estimators: [(&str, &World, u32, Bouncing); 5] = [
        ("montecarlo, cosine, sphere", &round, 16, &cosine),
        ("montecarlo, uniform, sphere", &round, 16, &uniform),
        ("path of fixed length, sphere", &round, 1, &paths),
        ("path of fixed length, tetrahedron", &corners, 1, &paths),
        ("path of fixed length, box", &square, 1, &paths),
    ];
    let residual = |bounces: f64| 100.0 * exact::furnace_residual(REFLECTANCE.into(), bounces as u32);
    let mut series = vec![Series::exact("exact: ρᵏ⁺¹", span(0.0, MAX_BOUNCES.into(), MAX_BOUNCES + 1), residual)];
    let mut z = Vec::new();
    for (label, room, spp, integrator) in estimators {
        let mut points = Vec::new();
        for bounces in 0..=MAX_BOUNCES {
            let Some(integrator) = integrator(bounces) else { continue };
            let settings =
                Settings { width: 64, height: 64, spp: runner.share(spp), integrator, ..Settings::default() };
            let sample = Sample::of(&runner.render(room, settings)?.values);
            z.push(sample.z(exact::furnace_after(EMISSION.into(), REFLECTANCE.into(), bounces), ROUNDING));
            let missing = 100.0 * (1.0 - sample.mean / radiance()).abs();
            points.push(Point { x: bounces.into(), y: missing, error: 100.0 * sample.standard_error() / radiance() });
        }
        series.push(Series::measured(label, points));
    }
    let figure = Figure {
        name: "furnace-bounces",
        title: "What k bounces leave out in closed rooms that glow, ρ = 0.5".to_owned(),
        x: Axis::linear("bounces k", -0.5, f64::from(MAX_BOUNCES) + 0.5),
        y: Axis::logarithmic("error of the mean (% of the exact radiance)", 1e-4, 100.0),
        series,
    };
    Ok(Outcome::worst_z(z).with(figure))
}

/// The probabilities of survival: twentieths.
fn survivals() -> impl Iterator<Item = f64> {
    (1..20).map(|twentieths| f64::from(twentieths) / 20.0)
}

/// Single paths with independent random numbers and one probability of survival, `side`² of them or 1000.
fn roulette(runner: &Runner, room: &World, survival: f64, size: (u32, u32)) -> Result<Sample, Interrupted> {
    let stop = Stop::Roulette { after: 0, survival: Survival::Constant(survival as f32) };
    let settings = Settings {
        width: size.0,
        height: size.1,
        spp: 1,
        sampler: Pattern::Random,
        integrator: naive(1024, stop),
        ..Settings::default()
    };
    Ok(Sample::of(&runner.render(room, settings)?.values))
}

fn exact_variance(survival: f64) -> f64 {
    exact::roulette_variance(EMISSION.into(), REFLECTANCE.into(), survival)
}

/// Driscoll's other graph: the error of 1000 runs. Where variance is infinite, below ρ², the means of any number of
/// runs are too small but for a few that are far too great: there is nothing to hold them to.
fn survival(runner: &Runner) -> Result<Outcome, Interrupted> {
    const RUNS: (u32, u32) = (40, 25);
    let room = room(&sphere(3, 1.0));
    let runs = f64::from(RUNS.0 * RUNS.1);
    let error = |survival: f64| 100.0 * (exact_variance(survival) / runs).sqrt() / radiance();
    let (mut z, mut points) = (Vec::new(), Vec::new());
    for survival in survivals() {
        let sample = roulette(runner, &room, survival, RUNS)?;
        let off = 100.0 * (sample.mean / radiance() - 1.0);
        points.push(Point { x: survival, y: off, error: 100.0 * sample.standard_error() / radiance() });
        if exact_variance(survival).is_finite() {
            z.push(off / error(survival));
        }
    }
    let curve = || span(0.255, 0.999, 200);
    let figure = Figure {
        name: "furnace-survival",
        title: "Means of 1000 paths against survival, ρ = 0.5".to_owned(),
        x: Axis::linear("probability of survival p", 0.0, 1.0),
        y: Axis::linear("error of the mean (% of the exact radiance)", -40.0, 40.0),
        series: vec![
            Series::measured("measured, ± standard error", points),
            Series::exact("exact standard error; none up to p = ρ²", curve(), error),
            Series::exact("exact standard error; none up to p = ρ²", curve(), |p| -error(p)),
        ],
    };
    Ok(Outcome::worst_z(z).with(figure))
}

/// The largest distance of the variance from its closed form where paths' fourth moment, by which a measured variance
/// scatters, is moderate.
fn variance(runner: &Runner) -> Result<Outcome, Interrupted> {
    const MODERATE: f64 = 0.5;
    let side = runner.share(512).max(256);
    let room = room(&sphere(3, 1.0));
    let (mut off, mut points) = (Vec::new(), Vec::new());
    for survival in survivals() {
        let sample = roulette(runner, &room, survival, (side, side))?;
        points.push(Point { x: survival, y: sample.variance, error: sample.variance_error });
        if survival >= MODERATE {
            off.push((sample.variance / exact_variance(survival) - 1.0).abs());
        }
    }
    let figure = Figure {
        name: "furnace-variance",
        title: "Variance of a path against survival, ρ = 0.5".to_owned(),
        x: Axis::linear("probability of survival p", 0.0, 1.0),
        y: Axis::logarithmic("variance (in units of Le²)", 0.01, 1e5),
        series: vec![
            Series::exact("exact; infinite up to p = ρ²", span(0.2501, 0.999, 800), exact_variance),
            Series::measured(&format!("measured, {} paths each", side * side), points),
        ],
    };
    let quantity = format!("worst relative difference for p ≥ {MODERATE}");
    Ok(Outcome { quantity, measured: super::worst(off), expected: 0.0, tolerance: 0.05, figure: Some(figure) })
}

/// A path ends at the first surface behind which less than the cutoff would be left of its light, so after `k` bounces
/// with `ρ^{k+1}` below it. What it leaves out is known here, as the mean radiance is that of every place.
fn threshold(runner: &Runner) -> Result<Outcome, Interrupted> {
    let reflectance = f64::from(REFLECTANCE);
    let bounces = |cutoff: f64| (0..).find(|&k| exact::furnace_residual(reflectance, k) < cutoff).unwrap_or(u32::MAX);
    let left_out = |cutoff: f64| exact::furnace_after(EMISSION.into(), reflectance, bounces(cutoff));
    let cutoffs = [1e-4, 3e-4, 1e-3, 3e-3, 0.01, 0.03, 0.1, 0.2, 0.4, 0.8];
    type Exact<'a> = &'a dyn Fn(f64) -> f64;
    let rules: [(&str, bool, Exact); 2] = [("added back", true, &|_| radiance()), ("left out", false, &left_out)];
    let room = room(&cube());
    let (mut z, mut series) = (Vec::new(), Vec::new());
    for (label, add_back, exact) in rules {
        let mut points = Vec::new();
        for cutoff in cutoffs {
            let integrator = naive(1024, Stop::Threshold { cutoff: cutoff as f32, add_back });
            let settings = Settings { width: 32, height: 32, spp: runner.share(16), integrator, ..Settings::default() };
            let sample = Sample::of(&runner.render(&room, settings)?.values);
            z.push(sample.z(exact(cutoff), ROUNDING));
            points.push(Point { x: cutoff, y: sample.mean, error: sample.standard_error() });
        }
        let curve = span(-4.0, 0.0, 400).map(|exponent| 10f64.powf(exponent));
        series.extend([Series::exact(label, curve, exact), Series::measured(label, points)]);
    }
    let figure = Figure {
        name: "furnace-threshold",
        title: "Paths that end at an attenuation, ρ = 0.5".to_owned(),
        x: Axis::logarithmic("least attenuation of a path (cutoff)", 8e-5, 1.25),
        y: Axis::linear("radiance (in units of Le)", 0.0, 2.5),
        series,
    };
    Ok(Outcome::worst_z(z).with(figure))
}

/// Driscoll's rays escaped from his sphere near the horizon. Here the sky outside has radiance one and the walls send
/// on all that they get, so a pixel is black unless one of its rays has come out: of a path, of its shadow rays towards
/// the sky, or of ambient occlusion, which sends more of its uniform rays along the surface.
fn escapes(runner: &Runner) -> Result<Outcome, Interrupted> {
    let paths =
        |lights| Integrator::Path(PathOptions { max_depth: 32, lights, stop: Stop::Depth, ..PathOptions::default() });
    let occlusion = AoOptions {
        weighting: AoWeighting::CacheMisses,
        max_distance: None,
        rays: 16,
        sampling: HemisphereSampling::Uniform,
    };
    let integrators = [paths(LightSampling::Naive), paths(LightSampling::Direct), Integrator::Ao(occlusion)];
    let (mut escaped, mut rays) = (0, 0);
    for (level, radius, shift) in
        [(2, 1e-6, 0.0), (4, 1e-3, 0.0), (5, 1.0, 0.0), (4, 1e3, 0.0), (3, 1e6, 0.0), (4, 1.0, 1e3), (3, 1e3, -1e6)]
    {
        let centre = Vec3::new(shift, -0.5 * shift, 0.25 * shift);
        let walls = turned(&moved(&sphere(level, radius), centre));
        let camera = view(centre + radius * Vec3::new(0.1, 0.2, 0.3), centre + radius * Vec3::X);
        let mut room = scene([(walls.as_slice(), grey(1.0, 0.0))], camera);
        room.sky = Sky::constant(Vec3::ONE);
        let room = world(room);
        for integrator in integrators.clone() {
            let settings = Settings { width: 96, height: 96, spp: runner.share(8), integrator, ..Settings::default() };
            let runs = runner.render(&room, settings)?;
            escaped += runs.values.iter().filter(|value| **value != 0.0).count();
            rays += runs.rays;
        }
    }
    let quantity = format!("pixels with an escape, of {:.1} million rays", rays as f64 / 1e6);
    Ok(Outcome { quantity, measured: escaped as f64, expected: 0.0, tolerance: 0.0, figure: None })
}
