//! Every integrator against known answers, and against each other where they must agree.

mod bumps;
mod filter_glossy;
mod heat;
mod lamps_in_glass;
mod lamps_in_mirrors;
mod openness;
mod stopping;

use std::sync::Mutex;

use glam::{DVec3, Vec3};
use halfdome::driver::{self, Watch};
use halfdome::film::Picture;
use halfdome::material::Inputs;
use halfdome::scene::{CameraPose, Material, PunctualLight, Scene, cornell_box};
use halfdome::settings::{
    AoOptions, AoWeighting, CachedOptions, DirectOptions, HemisphereSampling, Integrator, LightSampling,
    MonteCarloOptions, PathOptions, Settings, Stop, Survival,
};
use halfdome::world::World;
use halfdome_tests::render::{Estimate, material, mesh, pixels, quad, render, seeds};

const ALL_LIGHTS: [LightSampling; 3] = [LightSampling::Naive, LightSampling::Direct, LightSampling::Mis];
const ALL_SAMPLINGS: [HemisphereSampling; 4] = [
    HemisphereSampling::Uniform,
    HemisphereSampling::Cosine,
    HemisphereSampling::Stratified,
    HemisphereSampling::StratifiedUniform,
];

fn path(lights: LightSampling, stop: Stop) -> Integrator {
    Integrator::Path(PathOptions { lights, stop, ..PathOptions::default() })
}

/// A small picture by this integrator.
fn settings(integrator: Integrator, spp: u32) -> Settings {
    Settings { width: 8, height: 8, spp, integrator, ..Settings::default() }
}

/// A camera that sees little but `target`.
fn peephole(eye: Vec3, target: Vec3) -> Option<CameraPose> {
    Some(CameraPose { eye, target, up: Vec3::new(0.1, 0.2, 1.0), vfov: 0.01 })
}

/// A floor at z = 0 from -size to size, its front up.
fn floor(size: f32) -> [[Vec3; 3]; 2] {
    quad([(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(|(x, y)| Vec3::new(x, y, 0.0) * size))
}

/// The same at height `z`.
fn storey(size: f32, z: f32) -> [[Vec3; 3]; 2] {
    floor(size).map(|corners| corners.map(|p| p + Vec3::Z * z))
}

/// The box from -1 to 1 whose sides all have this material, seen from the inside.
fn room(reflectance: f32, emission: f32) -> Scene {
    let mut surface = material(Vec3::splat(reflectance), Vec3::splat(emission));
    surface.emits_both_sides = true;
    let side = |axis: usize, at: f32| {
        storey(1.0, at).map(|corners| corners.map(|p| Vec3::from_array([0, 1, 2].map(|i| p[(i + axis) % 3]))))
    };
    let sides: Vec<_> = (0..3).flat_map(|axis| [side(axis, -1.0), side(axis, 1.0)]).flatten().collect();
    let camera = CameraPose { eye: Vec3::new(0.1, 0.05, -0.2), target: Vec3::ONE * 0.5, up: Vec3::Y, vfov: 100.0 };
    Scene { meshes: vec![mesh(&sides, 0)], materials: vec![surface], camera: Some(camera), ..Scene::default() }
}

/// A sphere about the origin of `8 * 4^levels` triangles, fronts outside.
fn sphere(levels: u32) -> Vec<[Vec3; 3]> {
    let mut triangles = Vec::new();
    for signs in (0..8).map(|i| [0, 1, 2].map(|axis| if i >> axis & 1 == 1 { -1.0 } else { 1.0 })) {
        let [x, y, z] = [Vec3::X * signs[0], Vec3::Y * signs[1], Vec3::Z * signs[2]];
        triangles.push(if signs.iter().product::<f32>() > 0.0 { [x, y, z] } else { [x, z, y] });
    }
    for _ in 0..levels {
        let split = |[a, b, c]: [Vec3; 3]| {
            let [ab, bc, ca] = [a + b, b + c, c + a].map(Vec3::normalize);
            [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
        };
        triangles = triangles.into_iter().flat_map(split).collect();
    }
    triangles
}

/// Every pixel is `expected`, up to a relative error.
fn all_are(picture: &Picture, expected: Vec3, error: f64, what: &str) {
    let expected = expected.as_dvec3();
    for pixel in pixels(picture) {
        let off = (pixel - expected).abs();
        assert!(off.cmple(error * expected.abs()).all(), "{what}: {pixel}, not {expected}");
    }
}

/// The mean of the whole picture, and its error, by renders with different seeds.
fn mean(scene: &Scene, settings: &Settings, renders: u64) -> Estimate {
    Estimate::of_means(&seeds(scene, settings, renders))
}

/// The mean of all pixels, and its error by their differences.
fn estimate(scene: &Scene, integrator: Integrator, spp: u32) -> Estimate {
    let settings = Settings { width: 32, height: 32, spp, integrator, ..Settings::default() };
    Estimate::of(&pixels(&render(scene, &settings)))
}

/// The variance of pixels that are alike, by paths.
fn variance(scene: &Scene, lights: LightSampling) -> f64 {
    let settings = Settings { width: 32, height: 32, spp: 64, integrator: roulette(lights), ..Settings::default() };
    let values = pixels(&render(scene, &settings));
    let mean = values.iter().map(|value| value.x).sum::<f64>() / values.len() as f64;
    values.iter().map(|value| (value.x - mean).powi(2)).sum::<f64>() / values.len() as f64
}

/// What paths that aim find, relative to what bounces alone do.
fn aimed_by_unaimed(scene: &Scene) -> DVec3 {
    let [aimed, unaimed] = [(LightSampling::Mis, 512), (LightSampling::Naive, 4096)]
        .map(|(lights, spp)| estimate(scene, roulette(lights), spp).mean);
    aimed / unaimed
}

/// What a cache finds, relative to paths.
fn cached_by_paths(scene: &Scene) -> f64 {
    let paths = estimate(scene, roulette(LightSampling::Mis), 256).mean.x;
    estimate(scene, Integrator::Cached(CachedOptions::default()), 64).mean.x / paths
}

/// Paths that end by chance.
fn roulette(lights: LightSampling) -> Integrator {
    Integrator::Path(PathOptions { lights, ..PathOptions::default() })
}

#[test]
fn direct_light_is_a_path_of_two_surfaces() {
    let two = PathOptions { max_depth: 2, lights: LightSampling::Direct, ..PathOptions::default() };
    let [direct, path] = [Integrator::Direct(DirectOptions::default()), Integrator::Path(two)].map(|integrator| {
        let settings = Settings { width: 40, height: 40, ..settings(integrator, 64) };
        pixels(&render(&cornell_box(), &settings))
    });
    // They look at different points of the lamp.
    let differences: Vec<DVec3> = direct.iter().zip(&path).map(|(direct, path)| direct - path).collect();
    let Estimate { mean, error } = Estimate::of(&differences);
    assert!(error.max_element() < 1e-3 && (mean.abs() - 4.0 * error).max_element() <= 0.0, "{mean} +- {error}");
}

#[test]
fn all_ways_to_find_light_agree() {
    let mut scene = cornell_box();
    scene.sky.radiance = Vec3::new(0.1, 0.2, 0.3);
    let estimate = |integrator, spp| mean(&scene, &Settings { width: 16, height: 16, ..settings(integrator, spp) }, 12);
    let reference = estimate(path(LightSampling::Mis, Stop::default()), 64);
    // Driscoll's remedy for pictures that are too dark: paths from the second bounce on.
    let tail = Some(Survival::Constant(0.8));
    let options = MonteCarloOptions { rays: 8, tail, ..MonteCarloOptions::default() };
    let continued =
        ALL_SAMPLINGS.map(|sampling| (Integrator::MonteCarlo(MonteCarloOptions { sampling, ..options.clone() }), 16));
    let others = [
        (path(LightSampling::Naive, Stop::default()), 512),
        (path(LightSampling::Direct, Stop::default()), 64),
        (path(LightSampling::Mis, Stop::Depth), 16),
        (path(LightSampling::Direct, Stop::Roulette { after: 0, survival: Survival::Constant(0.7) }), 64),
    ];
    let others = others.map(|(integrator, spp)| match integrator {
        Integrator::Path(options) if options.stop == Stop::Depth => {
            (Integrator::Path(PathOptions { max_depth: 40, ..options }), spp)
        }
        other => (other, spp),
    });
    for (integrator, spp) in others.into_iter().chain(continued) {
        let what = format!("{integrator:?}");
        let estimate = estimate(integrator, spp);
        let z = estimate.z(&reference, 1e-5);
        assert!(z.max_element() < 4.0, "{what}: {estimate:?}, not {reference:?}");
        assert!((estimate.error / reference.mean).max_element() < 0.03, "{what}: too noisy to tell, {estimate:?}");
    }
}

#[test]
fn gathering_sees_as_many_bounces_as_it_may() {
    // With light sampled at every surface, n bounces are the series' terms 0 to n + 1.
    let scene = room(0.5, 1.0);
    for bounces in 0..4 {
        let options = MonteCarloOptions { bounces, rays: 4, ..MonteCarloOptions::default() };
        let estimate = mean(&scene, &settings(Integrator::MonteCarlo(options), 64), 8);
        let expected = DVec3::splat(2.0 - 0.5f64.powi(bounces as i32 + 1));
        let z = estimate.z(&expected.into(), 1e-5);
        assert!(z.max_element() < 4.0 && estimate.error.x < 0.01, "{bounces}: {estimate:?}, not {expected}");
    }
}

/// A ball of clear glass in a furnace cannot be seen, nor can a perfect mirror.
#[test]
fn glass_and_mirrors_lose_no_light() {
    let sky = Vec3::new(2.0, 1.0, 0.5);
    let ball = |material: &Material, smooth: bool| {
        let mut ball = mesh(&sphere(3), 0);
        if smooth {
            ball.normals = ball.positions.clone();
        }
        let camera = CameraPose { eye: Vec3::new(0.3, 0.2, 4.0), target: Vec3::ZERO, up: Vec3::Y, vfov: 24.0 };
        let mut scene =
            Scene { meshes: vec![ball], materials: vec![material.clone()], camera: Some(camera), ..Scene::default() };
        scene.sky.radiance = sky;
        scene
    };
    let (glass, mirror) = (Material::glass(1.5), Material::mirror(Vec3::ONE));
    let integrators = ALL_LIGHTS.map(|lights| path(lights, Stop::Depth)).into_iter().chain([
        Integrator::Direct(DirectOptions { max_depth: 1024 }),
        Integrator::MonteCarlo(MonteCarloOptions::default()),
    ]);
    for integrator in integrators {
        for smooth in [false, true] {
            let what = format!("{integrator:?}, smooth {smooth}");
            let settings = settings(integrator.clone(), 16);
            let through = pixels(&render(&ball(&glass, smooth), &settings));
            let lost = through.iter().filter(|pixel| !pixel.abs_diff_eq(sky.as_dvec3(), 1e-5)).count();
            // Shading normals may send a ray in at an angle that no real ray has, and total reflection keeps it.
            assert!(lost <= if smooth { 1 } else { 0 }, "{what}: {lost} pixels are dark");
            let inside = CameraPose { eye: Vec3::new(0.0, 0.0, 1.5), target: Vec3::ZERO, up: Vec3::Y, vfov: 20.0 };
            let mirror = Scene { camera: Some(inside), ..ball(&mirror, smooth) };
            all_are(&render(&mirror, &settings), sky, 1e-5, &what);
        }
    }
}

/// What needs a rule of its own elsewhere: a lamp in a mirror, and behind a pane. All techniques that find light show
/// it alike.
#[test]
fn lamps_are_seen_in_mirrors_and_through_panes() {
    let emission = Vec3::new(5.0, 4.0, 3.0);
    let lamp = storey(10.0, 3.0).map(|[a, b, c]| [a, c, b]);
    let (silver, gold) = (Vec3::splat(0.9), Vec3::new(1.0, 0.75, 0.5));
    // An index of 1 reflects nothing.
    let clear = Material::glass(1.0);
    let pane = Material::of(Inputs { transmission_color: gold, ..clear.inputs });
    let mirrors = Scene {
        meshes: vec![mesh(&floor(10.0), 0), mesh(&storey(10.0, 1.0), 1), mesh(&lamp, 2)],
        materials: vec![Material::mirror(silver), pane, material(Vec3::ZERO, emission)],
        camera: peephole(Vec3::new(0.1, 0.2, 2.0), Vec3::new(0.2, 0.1, 0.0)),
        ..Scene::default()
    };
    let direct = Integrator::Direct(DirectOptions::default());
    let gathered = Integrator::MonteCarlo(MonteCarloOptions { bounces: 0, ..MonteCarloOptions::default() });
    let paths = ALL_LIGHTS.map(|lights| path(lights, Stop::Depth));
    for integrator in [direct, gathered].into_iter().chain(paths) {
        let what = format!("{integrator:?}");
        // Down through the pane, to the mirror, up through the pane, to the lamp.
        all_are(&render(&mirrors, &settings(integrator, 4)), emission * silver * gold * gold, 1e-5, &what);
    }
}

/// Keeps the levels of a progressive render.
struct Levels(Mutex<Vec<(u32, Picture)>>);

impl Watch for Levels {
    fn advance(&self, _: u64, _: u64) {}
    fn stop(&self) -> bool {
        false
    }
    fn coarsest(&self) -> u32 {
        32
    }
    fn level(&self, side: u32, picture: &Picture) {
        self.0.lock().unwrap().push((side, picture.clone()));
    }
}

#[test]
fn coarse_to_fine_ends_in_the_plain_picture() {
    let scene = cornell_box();
    let world = World::new(scene.clone()).unwrap();
    for name in Integrator::NAMES {
        let integrator = Integrator::named(name).unwrap();
        let settings = Settings { width: 70, height: 41, spp: 3, integrator, aov: true, ..Settings::default() };
        let levels = Levels(Mutex::default());
        let progressive = driver::render(&world, &settings, &levels);
        let plain = render(&scene, &settings);
        assert!(progressive.finished);
        assert_eq!(progressive.picture.channels, plain.channels, "{name}");

        let levels = levels.0.into_inner().unwrap();
        assert_eq!(levels.iter().map(|(side, _)| *side).collect::<Vec<_>>(), [32, 16, 8, 4, 2, 1]);
        let once = pixels(&render(&scene, &Settings { spp: 1, ..settings }));
        for (side, picture) in levels {
            for (i, pixel) in pixels(&picture).into_iter().enumerate() {
                let (x, y) = (i as u32 % 70, i as u32 / 70);
                let corner = (y - y % side) * 70 + (x - x % side);
                assert_eq!(pixel, once[corner as usize], "{name}, block of {side} at {x}, {y}");
            }
        }
    }
}
