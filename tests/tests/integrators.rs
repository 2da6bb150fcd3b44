//! Every integrator against known answers, and against each other where they must agree.

use std::sync::Mutex;

use glam::{DVec3, Vec3};
use halfdome::driver::{self, Watch};
use halfdome::film::Picture;
use halfdome::material::Inputs;
use halfdome::scene::{CameraPose, Material, PunctualLight, Scene, cornell_box};
use halfdome::settings::{
    AoOptions, AoWeighting, DirectOptions, HemisphereSampling, Integrator, LightSampling, MonteCarloOptions,
    PathOptions, Settings, Stop, Survival,
};
use halfdome::world::World;
use halfdome_tests::render::{Estimate, material, mesh, pixels, quad, render};

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
    let means = (0..renders).map(|seed| {
        let pixels = pixels(&render(scene, &Settings { seed, ..settings.clone() }));
        pixels.iter().sum::<DVec3>() / pixels.len() as f64
    });
    Estimate::of(&means.collect::<Vec<_>>())
}

#[test]
fn a_lamp_over_a_floor_lights_it_by_cosine_and_distance() {
    let intensity = Vec3::new(9.0, 6.0, 3.0);
    let lamp = PunctualLight::Point { position: Vec3::new(0.0, 0.0, 2.0), intensity, radius: 0.0 };
    let reflectance = Vec3::new(0.5, 0.25, 1.0);
    for distance in [0.0, 1.0, 3.0] {
        let at = Vec3::new(distance, 0.0, 0.0);
        let scene = Scene {
            meshes: vec![mesh(&floor(10.0), 0)],
            materials: vec![material(reflectance, Vec3::ZERO)],
            lights: vec![lamp.clone()],
            camera: peephole(at + Vec3::new(0.5, 0.7, 3.0), at),
            ..Scene::default()
        };
        let squared = 4.0 + distance * distance;
        let expected = reflectance * intensity * (2.0 / squared.sqrt() / squared / std::f32::consts::PI);
        let direct = Integrator::Direct(DirectOptions::default());
        let gathered = Integrator::MonteCarlo(MonteCarloOptions { bounces: 2, ..MonteCarloOptions::default() });
        let paths = ALL_LIGHTS.map(|lights| path(lights, Stop::default()));
        for integrator in [direct, gathered].into_iter().chain(paths) {
            let what = format!("{integrator:?} at {distance}");
            all_are(&render(&scene, &settings(integrator, 4)), expected, 1e-3, &what);
        }
    }
}

#[test]
fn an_open_floor_sends_back_its_share_of_the_sky() {
    let (reflectance, sky) = (Vec3::new(0.5, 0.25, 0.9), Vec3::new(1.0, 2.0, 4.0));
    let mut scene = Scene {
        meshes: vec![mesh(&floor(1.0), 0)],
        materials: vec![material(reflectance, Vec3::ZERO)],
        camera: peephole(Vec3::new(0.3, 0.2, 1.0), Vec3::new(0.25, 0.1, 0.0)),
        ..Scene::default()
    };
    scene.sky.radiance = sky;
    let direct = Integrator::Direct(DirectOptions::default());
    let gathered = Integrator::MonteCarlo(MonteCarloOptions::default());
    let paths = ALL_LIGHTS.map(|lights| path(lights, Stop::default()));
    for integrator in [direct, gathered].into_iter().chain(paths) {
        let what = format!("{integrator:?}");
        // Both of Mis's ways have the same density here: each finds half of the light, in every sample.
        all_are(&render(&scene, &settings(integrator, 4)), reflectance * sky, 1e-5, &what);
    }
    scene.camera = peephole(Vec3::Z, Vec3::Z * 2.0);
    all_are(&render(&scene, &settings(Integrator::Flat, 1)), sky, 0.0, "sky");
    scene.camera = peephole(Vec3::Z, Vec3::ZERO);
    all_are(&render(&scene, &settings(Integrator::Flat, 1)), reflectance, 1e-6, "floor");
}

#[test]
fn openness_beside_a_wall_and_under_a_ceiling() {
    let scene = |walls: &[[[Vec3; 3]; 2]]| Scene {
        meshes: vec![mesh(&[&[floor(1.0)], walls].concat().concat(), 0)],
        materials: vec![Material::default()],
        camera: peephole(Vec3::new(0.3, 0.2, 0.5), Vec3::ZERO),
        ..Scene::default()
    };
    let check = |scene: &Scene, options: AoOptions, expected: f64| {
        let estimate = Estimate::of(&pixels(&render(scene, &settings(Integrator::Ao(options.clone()), 64))));
        let off = (estimate.mean.x - expected).abs();
        assert!(off < 0.003 && off <= 4.0 * estimate.error.x + 1e-5, "{options:?}: {estimate:?}, not {expected}");
    };
    // A wall as high as it is far away, and much wider: 1 - (1 - cos 45°) / 2 of the cosine is left.
    let wall = quad([(-1e4, 0.0), (1e4, 0.0), (1e4, 1.0), (-1e4, 1.0)].map(|(y, z)| Vec3::new(1.0, y, z)));
    for sampling in ALL_SAMPLINGS {
        let options = AoOptions { sampling, rays: 64, ..AoOptions::default() };
        check(&scene(&[]), options.clone(), 1.0);
        check(&scene(&[wall]), options, 0.5 + 0.5 * 0.5f64.sqrt());
    }
    // A ceiling at half of the greatest distance: rays of cos θ < 1/2 end before it, which are 1/4 by the cosine; the
    // others have the length 1 / cos θ of 2: 2 ∫ μ / 2μ dμ from 1/2 to 1.
    let ceiling = storey(1000.0, 1.0);
    let options = AoOptions { max_distance: Some(2.0), rays: 64, ..AoOptions::default() };
    check(&scene(&[ceiling]), options.clone(), 0.25);
    check(&scene(&[ceiling]), AoOptions { weighting: AoWeighting::HitLength, ..options.clone() }, 0.75);
    check(&scene(&[]), AoOptions { weighting: AoWeighting::HitLength, ..options }, 1.0);
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

/// Shirley's test: naive paths in a closed room have no noise at all, for there is no geometry in the series.
#[test]
fn each_stopping_rule_leaves_out_what_it_should() {
    let scene = room(0.5, 0.5);
    // The first terms of 1/2 + 1/4 + 1/8 + …
    let series = |terms: i32| Vec3::splat(1.0 - 0.5f32.powi(terms));
    for depth in [1, 2, 3, 7] {
        let by_depth =
            PathOptions { max_depth: depth, lights: LightSampling::Naive, stop: Stop::Depth, ..PathOptions::default() };
        let picture = render(&scene, &settings(Integrator::Path(by_depth), 2));
        all_are(&picture, series(depth as i32), 1e-6, &format!("depth {depth}"));
    }
    // 1/8 of the light would go on from the third surface, 1/16 from the fourth: there the path ends.
    let threshold = |add_back| path(LightSampling::Naive, Stop::Threshold { cutoff: 0.1, add_back });
    all_are(&render(&scene, &settings(threshold(false), 2)), series(4), 1e-6, "threshold");
    all_are(&render(&scene, &settings(threshold(true), 2)), Vec3::ONE, 1e-6, "threshold with the error added back");
    // Without bias, if not without noise.
    for survival in [Survival::Constant(0.8), Survival::Throughput { max: 0.95 }] {
        for after in [0, 3] {
            let roulette = path(LightSampling::Naive, Stop::Roulette { after, survival });
            let estimate = mean(&scene, &settings(roulette, 64), 12);
            let z = estimate.z(&DVec3::ONE.into(), 1e-5);
            assert!(z.max_element() < 4.0 && estimate.error.x < 0.02, "{survival:?} after {after}: {estimate:?}");
        }
    }
}

#[test]
fn what_is_added_back_helps_where_it_is_no_more_than_an_estimate() {
    let scene = cornell_box();
    let estimate =
        |stop| mean(&scene, &Settings { width: 16, height: 16, ..settings(path(LightSampling::Mis, stop), 64) }, 6);
    let truth = estimate(Stop::default()).mean;
    let error = |add_back| (estimate(Stop::Threshold { cutoff: 0.3, add_back }).mean - truth).abs() / truth;
    let (without, with) = (error(false), error(true));
    assert!(without.min_element() > 0.02 && (with / without).max_element() < 0.6, "{without} {with}");
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

/// What needs a rule of its own elsewhere: a lamp in a mirror, and behind a pane. All ways to find light show it alike.
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

#[test]
fn heat_counts_visits() {
    let camera = peephole(Vec3::new(0.3, 0.2, 1.0), Vec3::ZERO);
    let mut scene =
        Scene { meshes: vec![mesh(&floor(1.0), 0)], materials: vec![Material::default()], camera, ..Scene::default() };
    let heat = |max_depth| Integrator::Heat(PathOptions { max_depth, ..PathOptions::default() });
    // The root, and its one block.
    all_are(&render(&scene, &settings(heat(1), 3)), Vec3::splat(2.0), 0.0, "camera rays");
    // The bounce starts on the block's box, leaves upwards, and meets the root alone or the block as well.
    for pixel in pixels(&render(&scene, &settings(heat(2), 3))) {
        assert!((3.0..=4.0).contains(&pixel.x), "{pixel}");
    }
    scene.camera = peephole(Vec3::Z, Vec3::Z * 2.0);
    all_are(&render(&scene, &settings(heat(9), 3)), Vec3::ONE, 0.0, "the root alone");
}

#[test]
fn heat_lights_mixes_the_colours_of_lights_as_they_are_chosen() {
    let with_lights = |intensities: [f32; 2], height: f32, translucency: f32| {
        let mut floor_material = Material::default();
        floor_material.inputs.diffuse_transmission_weight = translucency;
        let lights = intensities.map(|intensity| PunctualLight::Point {
            position: Vec3::new(0.0, 0.0, height),
            intensity: Vec3::splat(intensity),
            radius: 0.0,
        });
        let scene = Scene {
            meshes: vec![mesh(&floor(1.0), 0)],
            materials: vec![floor_material],
            lights: lights.into(),
            camera: peephole(Vec3::new(0.3, 0.2, 1.0), Vec3::ZERO),
            ..Scene::default()
        };
        let all = pixels(&render(&scene, &settings(Integrator::HeatLights, 64)));
        all.iter().sum::<DVec3>() / all.len() as f64
    };
    let [first, second] = [with_lights([1.0, 0.0], 1.0, 0.0), with_lights([0.0, 1.0], 1.0, 0.0)];
    assert!(first.distance(second) > 0.5, "{first} {second}");
    let mixed = with_lights([1.0, 3.0], 1.0, 0.0);
    assert!(mixed.distance((first + 3.0 * second) / 4.0) < 0.01, "{mixed} {first} {second}");
    // A leaf receives light from behind, and a board does not.
    assert_eq!([0.0, 0.5].map(|translucency| with_lights([1.0, 0.0], -1.0, translucency)), [DVec3::ZERO, first]);
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

/// By a small lamp on a shelf, and under a sky: light is found by bounces and by samples of every kind.
#[test]
fn a_clamp_dims_indirect_light_alone() {
    let mut scene = cornell_box();
    let intensity = Vec3::splat(0.02);
    scene.lights.push(PunctualLight::Point { position: Vec3::new(0.1, 0.1, 0.1), intensity, radius: 0.01 });
    scene.sky.radiance = Vec3::new(0.1, 0.2, 0.3);
    let clamped = |clamp_indirect, max_depth| {
        let integrator = Integrator::Path(PathOptions { clamp_indirect, max_depth, ..PathOptions::default() });
        pixels(&render(&scene, &Settings { width: 24, height: 24, ..settings(integrator, 8) }))
    };
    assert_eq!(clamped(Some(1e-4), 2), clamped(None, 2), "direct light");
    let whole = clamped(None, 8);
    assert_eq!(clamped(Some(1e6), 8), whole, "a clamp that nothing reaches");
    let direct = clamped(None, 2);
    let none = clamped(Some(1e-6), 8);
    let some = clamped(Some(0.5), 8);
    let mut dimmed = 0;
    for i in 0..whole.len() {
        assert!((none[i] - direct[i]).abs().max_element() < 1e-4 * (1.0 + direct[i].max_element()), "pixel {i}");
        assert!(some[i].cmple(whole[i] + 1e-6).all() && some[i].cmpge(direct[i] - 1e-6).all(), "pixel {i}");
        dimmed += u32::from(some[i] != whole[i]);
    }
    assert!(dimmed > 20, "{dimmed}");
}
