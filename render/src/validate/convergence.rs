//! Convergence of errors with the number of samples: the exponent `e` of `error ∝ n^e`.
//!
//! Independent samples have -1/2. Where the integrand is one inside of a smooth border and zero outside, as for
//! occlusion, `n` strata in two dimensions leave errors in the `√n` of them that the border crosses: -3/4, for jittered
//! strata as for a scrambled net. Smooth integrands give scrambled nets -3/2 (Owen, "Scrambled Net Variance for
//! Integrals of Smooth Functions", 1997). The map from the square to a triangle has a crease (Heitz 2019): in the `√n`
//! strata that it crosses, the integrand bends, and their errors, each of `n^{-3/2}`, add up to -5/4. A lattice in two
//! dimensions has -1, but for logarithms.

use std::f64::consts::PI;

use glam::{DVec3, Vec3, dvec3, vec3};
use halfdome_kernel::sampling::Pattern;

use super::lights::{beside_wall, on_ground};
use super::scenes::{grey, ground, meter, scene, world};
use super::statistics::{PowerLaw, Sample, root_mean_square_error};
use super::{Experiment, Family, Interrupted, Outcome, Runner, exact};
use crate::output::plot::{Axis, Figure, Point, Series};
use crate::scene::Scene;
use crate::settings::{
    AoOptions, AoWeighting, HemisphereSampling, Integrator, LightSampling, PathOptions, Settings, Stop,
};
use crate::world::World;

pub(super) const FAMILY: Family = Family {
    name: "convergence",
    about: "How fast errors fall with the number of samples",
    experiments: &[
        Experiment {
            name: "convergence-ao-random",
            about: "Exponent of the error of ambient occlusion with independent directions",
            run: |runner| ambient_occlusion(runner, "random", -0.5, 0.04, |n| many(Pattern::Random, n)),
        },
        Experiment {
            name: "convergence-ao-stratified",
            about: "Exponent of the error of ambient occlusion with stratified directions",
            run: |runner| {
                ambient_occlusion(runner, "stratified", -0.75, 0.08, |n| gather(HemisphereSampling::Stratified, n))
            },
        },
        Experiment {
            name: "convergence-ao-sobol",
            about: "Exponent of the error of ambient occlusion with Sobol' points",
            run: |runner| ambient_occlusion(runner, "Sobol'", -0.75, 0.08, |n| many(Pattern::Sobol, n)),
        },
        Experiment {
            name: "convergence-direct-random",
            about: "Exponent of the error of direct light with independent points on the lamp",
            run: |runner| direct(runner, "random", -0.5, 0.04, Pattern::Random),
        },
        Experiment {
            name: "convergence-direct-r2",
            about: "Exponent of the error of direct light with the R2 sequence on the lamp",
            run: |runner| direct(runner, "R2", -1.0, 0.2, Pattern::R2),
        },
        Experiment {
            name: "convergence-direct-sobol",
            about: "Exponent of the error of direct light with Sobol' points on the lamp",
            run: |runner| direct(runner, "Sobol'", -1.25, 0.12, Pattern::Sobol),
        },
        Experiment {
            name: "convergence-cosine",
            about: "Variance of one cosine-weighted occlusion ray, relative to its closed form",
            run: |runner| one_ray(runner, HemisphereSampling::Cosine, exact::openness_variance(PLACE, 1.0)),
        },
        Experiment {
            name: "convergence-uniform",
            about: "Variance of one uniform occlusion ray, relative to its closed form",
            run: |runner| one_ray(runner, HemisphereSampling::Uniform, exact::uniform_openness_variance(PLACE, 1.0)),
        },
        Experiment {
            name: "convergence-strata",
            about: "Variance of 256 stratified cosine-weighted rays, relative to that of as many random uniform ones",
            run: strata,
        },
    ],
};

/// Distance from the wall of height 1.
const PLACE: f64 = 0.7;

/// A light meter at distance `a` from the wall.
fn wall(a: f64) -> World {
    world(Scene { camera: Some(on_ground(a as f32)), ..beside_wall() })
}

fn openness() -> f64 {
    exact::sky_beside_wall(PLACE, 1.0) / PI
}

/// `n` rays of one sample of ambient occlusion.
fn gather(sampling: HemisphereSampling, rays: u32) -> Settings {
    let options = AoOptions { weighting: AoWeighting::CacheMisses, max_distance: None, rays, sampling };
    Settings { spp: 1, sampler: Pattern::Random, integrator: Integrator::Ao(options), ..Settings::default() }
}

/// `n` samples of ambient occlusion with one ray each.
fn many(sampler: Pattern, spp: u32) -> Settings {
    Settings { spp, sampler, ..gather(HemisphereSampling::Cosine, 1) }
}

fn ambient_occlusion(
    runner: &Runner,
    label: &str,
    expected: f64,
    tolerance: f64,
    settings: impl Fn(u32) -> Settings,
) -> Result<Outcome, Interrupted> {
    let errors = errors(runner, &wall(PLACE), openness(), settings)?;
    let figure = figure("convergence-ao", "Ambient occlusion beside a wall: error against rays", "rays n", (1e-3, 0.3));
    Ok(slope(label, expected, tolerance, &errors, figure))
}

/// A triangle that glows, face down: with one light, nothing is left to choose but the point on it.
fn direct(
    runner: &Runner,
    label: &str,
    expected: f64,
    tolerance: f64,
    sampler: Pattern,
) -> Result<Outcome, Interrupted> {
    const LAMP: [DVec3; 3] = [dvec3(-0.6, 1.0, -0.7), dvec3(0.9, 1.1, -0.4), dvec3(0.1, 1.3, 0.8)];
    let lamp = [LAMP.map(|corner| corner.as_vec3())];
    let place = meter(vec3(0.3, 0.0, 0.2), Vec3::Y);
    let lit = world(scene([(ground(20.0).as_slice(), grey(0.5, 0.0)), (lamp.as_slice(), grey(0.0, 1.0))], place));
    let options =
        PathOptions { max_depth: 2, lights: LightSampling::Direct, stop: Stop::Depth, ..PathOptions::default() };
    let settings =
        |spp| Settings { spp, sampler, integrator: Integrator::Path(options.clone()), ..Settings::default() };
    let radiance = 0.5 / PI * exact::polygon_irradiance(dvec3(0.3, 0.0, 0.2), DVec3::Y, &LAMP).abs();
    let errors = errors(runner, &lit, radiance, settings)?;
    let figure =
        figure("convergence-direct", "Direct light of a triangle: error against samples", "samples n", (1e-5, 0.1));
    Ok(slope(label, expected, tolerance, &errors, figure))
}

/// Relative errors, root mean square over the pixels, for some numbers of samples.
fn errors(
    runner: &Runner,
    world: &World,
    exact: f64,
    settings: impl Fn(u32) -> Settings,
) -> Result<Vec<Point>, Interrupted> {
    // Fewer samples have too few strata to show how their errors fall.
    let numbers = [16, 32, 64, 128, 256, 512, 1024, 2048];
    let mut points = Vec::new();
    for n in numbers {
        let side = runner.share(48).max(24);
        let runs = runner.render(world, Settings { width: side, height: side, ..settings(n) })?;
        let error = root_mean_square_error(&runs.values, exact) / exact;
        // The uncertainty of the root of a sum of squares of normal numbers.
        let uncertainty = error / (2.0 * runs.values.len() as f64).sqrt();
        points.push(Point { x: n.into(), y: error, error: uncertainty });
    }
    Ok(points)
}

fn figure(name: &'static str, title: &str, x: &str, (from, to): (f64, f64)) -> Figure {
    Figure {
        name,
        title: title.to_owned(),
        x: Axis::logarithmic(x, 12.0, 2800.0),
        y: Axis::logarithmic("relative error (root mean square)", from, to),
        series: Vec::new(),
    }
}

/// The fitted exponent, with the points and the line of the expected exponent through their middle.
fn slope(label: &str, expected: f64, tolerance: f64, errors: &[Point], mut figure: Figure) -> Outcome {
    let pairs: Vec<_> = errors.iter().map(|point| (point.x, point.y)).collect();
    let law = PowerLaw::fit(&pairs);
    let label = format!("{label}: n^{:.2} (line: n^{expected})", law.exponent);
    let middle = pairs.iter().map(|(x, y)| (y / x.powf(expected)).ln()).sum::<f64>() / pairs.len() as f64;
    let line = |n: f64| middle.exp() * n.powf(expected);
    figure.series = vec![
        Series::measured(&label, errors.to_vec()),
        Series::exact(&label, [errors[0].x, errors[errors.len() - 1].x], line),
    ];
    let quantity = format!("exponent, ± {:.3}", law.exponent_error);
    Outcome { quantity, measured: law.exponent, expected, tolerance, figure: Some(figure) }
}

fn one_ray(runner: &Runner, sampling: HemisphereSampling, exact: f64) -> Result<Outcome, Interrupted> {
    let side = runner.share(512).max(192);
    let settings = Settings { width: side, height: side, ..gather(sampling, 1) };
    let sample = Sample::of(&runner.render(&wall(PLACE), settings)?.values);
    let quantity = "ratio of variances".to_owned();
    Ok(Outcome { quantity, measured: sample.variance / exact, expected: 1.0, tolerance: 0.05, figure: None })
}

/// Driscoll's two pictures of 256 rays: random uniform, and stratified. Against the distance from the wall; the curves
/// are exact.
fn strata(runner: &Runner) -> Result<Outcome, Interrupted> {
    const RAYS: u32 = 256;
    let side = runner.share(64).max(24);
    let variance = |place: f64, sampling| {
        let settings = Settings { width: side, height: side, ..gather(sampling, RAYS) };
        Ok(Sample::of(&runner.render(&wall(place), settings)?.values))
    };
    let choices = [
        ("random uniform", HemisphereSampling::Uniform),
        ("random cosine", HemisphereSampling::Cosine),
        ("stratified cosine", HemisphereSampling::Stratified),
    ];
    let places = [0.1, 0.2, 0.4, 0.7, 1.0, 1.5, 2.0, 3.0, 4.0];
    let mut ratios = Vec::new();
    let mut series: Vec<Series> = choices.iter().map(|(label, _)| Series::measured(label, Vec::new())).collect();
    for place in places {
        let mut variances = Vec::new();
        for ((_, sampling), series) in choices.iter().zip(&mut series) {
            let sample = variance(place, *sampling)?;
            series.points.push(Point { x: place, y: sample.variance, error: sample.variance_error });
            variances.push(sample.variance);
        }
        ratios.push(variances[2] / variances[0]);
    }
    let of = |variance: fn(f64, f64) -> f64| move |a: f64| variance(a, 1.0) / f64::from(RAYS);
    let curve = || (0..=100).map(|i| 0.1 * 40f64.powf(f64::from(i) / 100.0));
    series.insert(1, Series::exact(choices[0].0, curve(), of(exact::uniform_openness_variance)));
    series.insert(3, Series::exact(choices[1].0, curve(), of(exact::openness_variance)));
    let figure = Figure {
        name: "convergence-strata",
        title: "Variance of ambient occlusion with 256 rays".to_owned(),
        x: Axis::logarithmic("distance from a wall of height 1", 0.09, 4.5),
        y: Axis::logarithmic("variance", 1e-6, 1e-2),
        series,
    };
    let quantity = "greatest ratio of variances".to_owned();
    let measured = super::worst(ratios);
    Ok(Outcome { quantity, measured, expected: 0.0, tolerance: 1.0 / 3.0, figure: Some(figure) })
}
