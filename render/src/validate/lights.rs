//! Irradiance from lights of every kind against closed forms, by each estimator that can find them.

use std::f64::consts::PI;

use glam::{DVec3, Vec3, dvec3, vec3};

use super::scenes::{Corners, grey, ground, mesh, meter, moved, quad, scene, sphere, turned, view, world};
use super::statistics::Sample;
use super::{Experiment, Family, Interrupted, Outcome, Runner, exact};
use crate::output::plot::{Axis, Figure, Point, Series, span};
use crate::scene::{CameraPose, Mesh, PunctualLight, Scene, Sky};
use crate::settings::{
    AoOptions, AoWeighting, DirectOptions, HemisphereSampling, Integrator, LightSampling, PathOptions, Settings,
};

pub(super) const FAMILY: Family = Family {
    name: "lights",
    about: "Irradiance from lights of every kind, and form factors",
    experiments: &[
        Experiment {
            name: "lights-point",
            about: "Irradiance from a point light on the ground, against distance",
            run: |runner| POINT.run(runner),
        },
        Experiment {
            name: "lights-sphere",
            about: "Irradiance from a glowing sphere above the ground, against distance",
            run: |runner| SPHERE.run(runner),
        },
        Experiment {
            name: "lights-horizon",
            about: "Irradiance from a glowing sphere that the ground cuts, against distance",
            run: |runner| HORIZON.run(runner),
        },
        Experiment {
            name: "lights-polygon",
            about: "Irradiance from a glowing square, against distance, by Lambert's formula",
            run: |runner| POLYGON.run(runner),
        },
        Experiment {
            name: "lights-sky",
            about: "Irradiance from the sky beside an endless black wall, against the distance from it",
            run: |runner| SKY.run(runner),
        },
        Experiment {
            name: "lights-openness",
            about: "Ambient occlusion beside that wall, by each choice of directions",
            run: |runner| OPENNESS.run(runner),
        },
        Experiment {
            name: "lights-two-spheres",
            about: "Form factor between two equal spheres, against their distance",
            run: two_spheres,
        },
        Experiment {
            name: "lights-concentric-spheres",
            about: "Radiance of two concentric spheres that light each other, after all bounces",
            run: concentric_spheres,
        },
    ],
};

const REFLECTANCE: f32 = 0.5;

/// An estimator: its name and its integrator, with default options but for how it finds light.
type Estimator = (&'static str, fn() -> Integrator);

const MIS: Estimator = ("path", || paths(LightSampling::Mis));
const LIGHTS: Estimator = ("path, lights sampled", || paths(LightSampling::Direct));
const NAIVE: Estimator = ("path, naive", || paths(LightSampling::Naive));
const DIRECT: Estimator = ("direct", || Integrator::Direct(DirectOptions::default()));

fn paths(lights: LightSampling) -> Integrator {
    Integrator::Path(PathOptions { lights, ..PathOptions::default() })
}

fn ambient_occlusion(sampling: HemisphereSampling) -> Integrator {
    Integrator::Ao(AoOptions { weighting: AoWeighting::CacheMisses, max_distance: None, rays: 16, sampling })
}

/// A light meter that moves along the ground, in direction x.
struct Profile {
    figure: &'static str,
    title: &'static str,
    /// The horizontal axis' label, and the first and the last place.
    x: (&'static str, f64, f64),
    /// The vertical axis' label and its end.
    y: (&'static str, f64),
    scene: fn() -> Scene,
    /// The factor on radiance.
    factor: f64,
    estimators: &'static [Estimator],
    exact: fn(f64) -> f64,
    /// The relative uncertainty of the exact values: rounding, and facets of spheres.
    allowance: f64,
}

/// From the radiance of the ground to irradiance.
const TO_IRRADIANCE: f64 = PI / REFLECTANCE as f64;
/// 32-bit numbers, and the width of the meter's spot.
const ROUNDING: f64 = 1e-5;
/// A sphere of 20,480 triangles instead of a round one.
const FACETS: f64 = 5e-4;
const LEVEL: u32 = 5;

/// At (0, 1.5, 0), of intensity 10.
const POINT: Profile = Profile {
    figure: "lights-point",
    title: "Point light 1.5 above the ground",
    x: ("distance along the ground", 0.0, 5.0),
    y: ("irradiance (W/m²)", 5.0),
    scene: || {
        let position = POINT_POSITION.as_vec3();
        Scene {
            lights: vec![PunctualLight::Point { position, intensity: Vec3::splat(10.0), radius: 0.0 }],
            ..scene([(ground(20.0).as_slice(), grey(REFLECTANCE, 0.0))], on_ground(0.0))
        }
    },
    factor: TO_IRRADIANCE,
    estimators: &[MIS, DIRECT],
    exact: |x| 10.0 * exact::point_irradiance(POINT_POSITION - DVec3::X * x, DVec3::Y),
    allowance: ROUNDING,
};
const POINT_POSITION: DVec3 = dvec3(0.0, 1.5, 0.0);

/// Of radius 0.5, with its centre at (0, 1, 0).
const SPHERE: Profile = Profile {
    figure: "lights-sphere",
    title: "Glowing sphere of radius 0.5, its centre 1 above the ground",
    x: ("distance along the ground", 0.0, 4.0),
    y: ("irradiance (W/m²)", 1.0),
    scene: || above_ground(&moved(&sphere(LEVEL, 0.5), Vec3::Y)),
    factor: TO_IRRADIANCE,
    estimators: &[MIS, LIGHTS, NAIVE, DIRECT],
    exact: |x| exact::sphere_irradiance(dvec3(-x, 1.0, 0.0), DVec3::Y, 0.5),
    allowance: FACETS,
};

/// Of radius 0.5, with its centre at (0, 0.2, 0), so that a part is underground.
const HORIZON: Profile = Profile {
    figure: "lights-horizon",
    title: "Glowing sphere of radius 0.5, its centre 0.2 above the ground",
    x: ("distance along the ground", 0.8, 3.2),
    y: ("irradiance (W/m²)", 0.5),
    scene: || above_ground(&moved(&sphere(LEVEL, 0.5), Vec3::Y * 0.2)),
    factor: TO_IRRADIANCE,
    estimators: &[MIS, LIGHTS, NAIVE, DIRECT],
    exact: |x| exact::sphere_irradiance(dvec3(-x, 0.2, 0.0), DVec3::Y, 0.5),
    allowance: 2.0 * FACETS,
};

/// A square with a side of 1, face down, 1 above the ground.
const POLYGON: Profile = Profile {
    figure: "lights-polygon",
    title: "Glowing square of side 1, 1 above the ground",
    x: ("distance along the ground", 0.0, 4.0),
    y: ("irradiance (W/m²)", 0.9),
    scene: || above_ground(&quad(SQUARE.map(|corner| corner.as_vec3()))),
    factor: TO_IRRADIANCE,
    estimators: &[MIS, LIGHTS, NAIVE, DIRECT],
    exact: |x| exact::polygon_irradiance(DVec3::X * x, DVec3::Y, &SQUARE).abs(),
    allowance: ROUNDING,
};
const SQUARE: [DVec3; 4] = [dvec3(-0.5, 1.0, -0.5), dvec3(0.5, 1.0, -0.5), dvec3(0.5, 1.0, 0.5), dvec3(-0.5, 1.0, 0.5)];

const SKY: Profile = Profile {
    figure: "lights-sky",
    title: "Sky beside an endless black wall of height 1",
    x: ("distance from the wall", 0.1, 4.1),
    y: ("irradiance (W/m²)", 3.5),
    scene: beside_wall,
    factor: TO_IRRADIANCE,
    estimators: &[MIS, LIGHTS, NAIVE, DIRECT],
    exact: |a| exact::sky_beside_wall(a, 1.0),
    allowance: ROUNDING,
};

const OPENNESS: Profile = Profile {
    figure: "lights-openness",
    title: "Ambient occlusion beside an endless wall of height 1",
    x: ("distance from the wall", 0.1, 4.1),
    y: ("openness", 1.1),
    scene: beside_wall,
    factor: 1.0,
    estimators: &[
        ("ao, uniform", || ambient_occlusion(HemisphereSampling::Uniform)),
        ("ao, cosine", || ambient_occlusion(HemisphereSampling::Cosine)),
        ("ao, stratified", || ambient_occlusion(HemisphereSampling::Stratified)),
    ],
    exact: |a| exact::sky_beside_wall(a, 1.0) / PI,
    allowance: ROUNDING,
};

pub(super) fn on_ground(x: f32) -> CameraPose {
    meter(vec3(x, 0.0, 0.0), Vec3::Y)
}

/// A black light over the ground.
fn above_ground(light: &[Corners]) -> Scene {
    scene([(ground(20.0).as_slice(), grey(REFLECTANCE, 0.0)), (light, grey(0.0, 1.0))], on_ground(0.0))
}

/// Ground under a sky of radiance one beside a wall of height 1 at x = 0, as good as endless.
pub(super) fn beside_wall() -> Scene {
    const END: f32 = 1e3;
    let corners = [[0.0, END], [0.0, -END], [1.0, -END], [1.0, END]];
    let wall = quad(corners.map(|[y, z]| vec3(0.0, y, z)));
    let mut scene =
        scene([(ground(20.0).as_slice(), grey(REFLECTANCE, 0.0)), (wall.as_slice(), grey(0.0, 0.0))], on_ground(0.0));
    scene.sky = Sky::constant(Vec3::ONE);
    scene
}

impl Profile {
    fn run(&self, runner: &Runner) -> Result<Outcome, Interrupted> {
        const PLACES: u32 = 9;
        let (x_label, from, to) = self.x;
        let mut world = world((self.scene)());
        let mut z = Vec::new();
        let mut series = vec![Series::exact("exact", span(from, to, 200), self.exact)];
        for (label, integrator) in self.estimators {
            let mut points = Vec::new();
            for x in span(from, to, PLACES) {
                let settings = Settings {
                    width: 32,
                    height: 32,
                    spp: runner.share(64).max(16),
                    integrator: integrator(),
                    ..Settings::default()
                };
                world.camera = on_ground(x as f32);
                let runs = runner.render(&world, settings)?;
                let sample = Sample::of(&runs.values.iter().map(|value| value * self.factor).collect::<Vec<_>>());
                z.push(sample.z((self.exact)(x), self.allowance));
                points.push(Point { x, y: sample.mean, error: sample.standard_error() });
            }
            series.push(Series::measured(label, points));
        }
        let margin = 0.03 * (to - from);
        let figure = Figure {
            name: self.figure,
            title: self.title.to_owned(),
            x: Axis::linear(x_label, from - margin, to + margin),
            y: Axis::linear(self.y.0, 0.0, self.y.1),
            series,
        };
        Ok(Outcome::worst_z(z).with(figure))
    }
}

/// The form factor is π times less than the mean of the irradiance from one sphere over the other, by the midpoint rule
/// in `s` with `cos = 1 - 2 s²`, of which `2 s ds` is the share of the surface: so places are close where much arrives.
fn two_spheres(runner: &Runner) -> Result<Outcome, Interrupted> {
    const PLACES: u32 = 32;
    /// Facets, and as few places.
    const ALLOWANCE: f64 = 2e-3;
    let from = sphere(4, 1.0);
    // Vertex normals: irradiance then varies as it does on a round sphere.
    let normals: Vec<Vec3> = from.concat().into_iter().map(Vec3::normalize).collect();
    let (mut z, mut points) = (Vec::new(), Vec::new());
    for distance in [2.1, 2.5, 3.0, 4.0, 6.0] {
        let to = moved(&from, Vec3::Y * distance as f32);
        let mut scene = scene([(to.as_slice(), grey(0.0, 1.0))], on_ground(0.0));
        scene.meshes.push(Mesh { normals: normals.clone(), ..mesh(&from, 1) });
        scene.materials.push(grey(REFLECTANCE, 0.0));
        let mut world = world(scene);
        let (mut form_factor, mut variance) = (0.0, 0.0);
        for s in span(0.0, 1.0, 2 * PLACES + 1).skip(1).step_by(2) {
            let cos = 1.0 - 2.0 * s * s;
            let sin = (1.0 - cos * cos).sqrt();
            // About a skew meridian, where no edge of the sphere runs.
            let normal = dvec3(sin * 0.8, cos, sin * 0.6).as_vec3();
            world.camera = meter(normal, normal);
            let settings = Settings { width: 16, height: 16, spp: runner.share(64), ..Settings::default() };
            let sample = Sample::of(&runner.render(&world, settings)?.values);
            let share = 2.0 * s / f64::from(PLACES) * TO_IRRADIANCE / PI;
            form_factor += share * sample.mean;
            variance += (share * sample.standard_error()).powi(2);
        }
        let exact = exact::sphere_form_factor(1.0, 1.0, distance);
        z.push((form_factor - exact) / variance.sqrt().hypot(ALLOWANCE * exact));
        points.push(Point { x: distance, y: form_factor, error: variance.sqrt() });
    }
    let figure = Figure {
        name: "lights-two-spheres",
        title: "Form factor between two equal spheres".to_owned(),
        x: Axis::linear("distance of the centres (radii)", 1.8, 6.2),
        y: Axis::logarithmic("form factor", 0.005, 0.1),
        series: vec![
            Series::exact("exact", span(2.001, 6.2, 100), |d| exact::sphere_form_factor(1.0, 1.0, d)),
            Series::measured("path", points),
        ],
    };
    Ok(Outcome::worst_z(z).with(figure))
}

/// Radiance of both spheres, seen from between them.
fn concentric_spheres(runner: &Runner) -> Result<Outcome, Interrupted> {
    const INNER: f32 = 0.5;
    const EMISSION: [f64; 2] = [1.0, 0.25];
    const REFLECTED: [f64; 2] = [0.6, 0.8];
    let (inner, outer) = (sphere(4, INNER), turned(&sphere(4, 1.0)));
    let exact = exact::concentric_spheres(f64::from(INNER).powi(2), EMISSION, REFLECTED);
    let mut z = Vec::new();
    for (target, exact) in [(Vec3::ZERO, exact[0]), (vec3(3.0, 0.2, 0.3), exact[1])] {
        let mut camera = view(vec3(0.8, 0.05, 0.1), target);
        camera.vfov = 40.0;
        let material = |i: usize| grey(REFLECTED[i] as f32, EMISSION[i] as f32);
        let scene = scene([(inner.as_slice(), material(0)), (outer.as_slice(), material(1))], camera);
        let settings = Settings { width: 48, height: 48, spp: runner.share(128), ..Settings::default() };
        z.push(Sample::of(&runner.render(&world(scene), settings)?.values).z(exact, 2.0 * FACETS));
    }
    Ok(Outcome::worst_z(z))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The irradiance of the visible facets by Lambert's formula, relative to that of the sphere that they approximate.
    #[test]
    fn facets_are_worth_as_much_as_their_sphere() {
        let triangles = moved(&sphere(LEVEL, 0.5), Vec3::Y);
        let (_, from, to) = SPHERE.x;
        for x in span(from, to, 9) {
            let point = DVec3::X * x;
            let facets: f64 = triangles
                .iter()
                .map(|corners| corners.map(|corner| corner.as_dvec3()))
                .filter(|[a, b, c]| (b - a).cross(c - a).dot(point - a) > 0.0)
                .map(|corners| exact::polygon_irradiance(point, DVec3::Y, &corners).abs())
                .sum();
            let off = (facets / (SPHERE.exact)(x) - 1.0).abs();
            assert!(off < FACETS, "at {x}: {off}");
        }
    }
}
