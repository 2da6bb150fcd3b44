//! Probes in worlds whose light has a closed form.

use std::f32::consts::PI;

use super::*;
use crate::scene::{CameraPose, Material, Mesh, PunctualLight, Scene, Sky, SkyPicture};
use crate::watch::NeverStops;

const OPTIONS: Options = Options { rays: 512, spp: 64, seed: 3 };

fn scene() -> Scene {
    let camera = Some(CameraPose { eye: Vec3::ZERO, target: Vec3::X, up: Vec3::Y, vfov: 90.0 });
    Scene { camera, ..Scene::default() }
}

/// Adds a sphere about `middle` whose front is inside or outside.
fn with_sphere(mut scene: Scene, middle: Vec3, radius: f32, inwards: bool, material: Material) -> Scene {
    let (rings, steps) = (24_u32, 48_u32);
    let point = |ring: u32, step: u32| {
        let (theta, phi) = (PI * ring as f32 / rings as f32, 2.0 * PI * (step % steps) as f32 / steps as f32);
        middle + radius * Vec3::new(theta.sin() * phi.cos(), theta.cos(), theta.sin() * phi.sin())
    };
    let mut mesh = Mesh { material: scene.materials.len(), ..Mesh::default() };
    for (ring, step) in (0..rings).flat_map(|ring| (0..steps).map(move |step| (ring, step))) {
        let first = mesh.positions.len() as u32;
        mesh.positions.extend([
            point(ring, step),
            point(ring, step + 1),
            point(ring + 1, step + 1),
            point(ring + 1, step),
        ]);
        let corners = [[0, 1, 2], [0, 2, 3]].map(|[a, b, c]| if inwards { [a, c, b] } else { [a, b, c] });
        mesh.triangles.extend(corners.map(|corners| corners.map(|corner| first + corner)));
    }
    scene.meshes.push(mesh);
    scene.materials.push(material);
    scene
}

fn at(world: &World, points: &[Vec3]) -> Vec<Probe> {
    at_points(world, points, &OPTIONS, &NeverStops).unwrap().probes
}

#[test]
fn a_constant_sky_has_the_zeroth_coefficient_alone() {
    let radiance = Vec3::new(0.5, 1.0, 3.0);
    let world = World::new(Scene { sky: Sky::constant(radiance), ..scene() }).unwrap();
    let [probe] = at(&world, &[Vec3::new(3.0, -1.0, 0.5)])[..] else { panic!("one") };
    let expected = radiance * (4.0 * PI).sqrt();
    assert!((probe.light.harmonics[0] / expected - 1.0).abs().max_element() < 1e-6);
    assert!(probe.light.harmonics[1..].iter().all(|value| value.abs().max_element() < 1e-5), "{probe:?}");
    // The clamped cosine has an edge, which no quadrature hits.
    assert!(probe.light.axes.iter().all(|value| (*value / (PI * radiance) - 1.0).abs().max_element() < 2e-2));
    assert_eq!((probe.state, probe.backs), (State::Free, 0.0));
}

/// A picture of a polynomial of the second degree, but for its texels' steps.
#[test]
fn a_quadratic_sky_has_its_own_coefficients() {
    let radiance = |d: glam::DVec3| 2.0 + 0.5 * d.x - 0.7 * d.y + 0.3 * d.z + 0.8 * d.x * d.y + 0.6 * d.z * d.z;
    let (width, height) = (1024, 512);
    let texel = |i: u32| {
        let theta = std::f64::consts::PI * (f64::from(i / width) + 0.5) / f64::from(height);
        let phi = std::f64::consts::TAU * ((f64::from(i % width) + 0.5) / f64::from(width) - 0.5);
        let direction = glam::DVec3::new(theta.sin() * phi.sin(), theta.cos(), -theta.sin() * phi.cos());
        Vec3::splat(radiance(direction) as f32)
    };
    let picture = SkyPicture::new(width, height, (0..width * height).map(texel).collect());
    let world = World::new(Scene { sky: Sky { radiance: Vec3::ZERO, picture: Some(picture) }, ..scene() }).unwrap();
    let [probe] = at(&world, &[Vec3::ZERO])[..] else { panic!("one") };
    // x² + y² + z² = 1 leaves z² = 1/3 + 2/3 of (3z² - 1)/2.
    let root = |x: f64| x.sqrt() as f32;
    let pi = std::f64::consts::PI;
    let first = root(4.0 * pi / 3.0);
    let expected = [
        2.2 * root(4.0 * pi),
        -0.7 * first,
        0.3 * first,
        0.5 * first,
        0.8 * root(4.0 * pi / 15.0),
        0.0,
        0.2 * root(16.0 * pi / 5.0),
        0.0,
        0.0,
    ];
    for (name, (found, expected)) in harmonics::NAMES.iter().zip(probe.light.harmonics.iter().zip(expected)) {
        assert!((found.x - expected).abs() < 3e-3, "{name}: {found}, not {expected}");
    }
}

/// Radiance in a closed room that emits `E` and reflects `ρ` is `E/(1 - ρ)`, from everywhere.
#[test]
fn a_glowing_room_has_the_radiance_of_its_series() {
    let material = Material { emission: Vec3::new(1.0, 0.5, 0.25), ..Material::matte(Vec3::splat(0.5)) };
    let expected = 2.0 * material.emission;
    let world = World::new(with_sphere(scene(), Vec3::ZERO, 2.0, true, material)).unwrap();
    let options = Options { rays: 4096, spp: 4096, seed: 1 };
    let points = [Vec3::ZERO, Vec3::new(0.8, -0.5, 0.9)];
    for probe in at_points(&world, &points, &options, &NeverStops).unwrap().probes {
        let light = &probe.light;
        assert!((light.harmonics[0] / (expected * (4.0 * PI).sqrt()) - 1.0).abs().max_element() < 0.01, "{light:?}");
        assert!(light.harmonics[1..].iter().all(|value| (*value / expected).abs().max_element() < 0.06), "{light:?}");
        for normal in [Vec3::X, Vec3::new(-0.6, 0.0, 0.8), Vec3::NEG_Y] {
            let irradiance = harmonics::irradiance(&light.harmonics, normal);
            assert!((irradiance / (PI * expected) - 1.0).abs().max_element() < 0.03, "{normal}: {irradiance}");
        }
        assert_eq!((probe.state, probe.backs), (State::Free, 0.0));
    }
}

/// Far from the origin rays start and end far from where light is received, in units of the room.
#[test]
fn a_glowing_room_far_away_is_as_bright() {
    let material = Material { emission: Vec3::ONE, ..Material::matte(Vec3::ZERO) };
    let middle = Vec3::new(20_000.0, 0.0, 20_000.0);
    let world = World::new(with_sphere(scene(), middle, 1.0, true, material)).unwrap();
    let points: Vec<Vec3> = (0..50).map(|i| middle + Vec3::Y * (0.01 * i as f32 - 0.25)).collect();
    let up: Vec<f32> = at(&world, &points).iter().map(|probe| probe.light.axes[2].x / PI).collect();
    let mean = up.iter().sum::<f32>() / up.len() as f32;
    let most = up.iter().fold(0.0, |most: f32, it| most.max((it - 1.0).abs()));
    assert!((mean - 1.0).abs() < 0.015 && most < 0.25, "{mean}, {most}");
}

#[test]
fn a_directional_light_is_its_harmonics_and_casts_shadows() {
    let direction = Vec3::new(-1.0, -2.0, 2.0) / 3.0;
    let irradiance = Vec3::new(3.0, 2.0, 1.0);
    let lights = vec![PunctualLight::Directional { direction, irradiance, half_angle: 0.0 }];
    let black = Material::matte(Vec3::ZERO);
    let middle = Vec3::new(10.0, 0.0, 0.0);
    let world = World::new(with_sphere(Scene { lights, ..scene() }, middle, 1.0, false, black)).unwrap();
    let shadow = middle + 3.0 * direction;
    let [lit, dark] = at(&world, &[Vec3::ZERO, shadow])[..] else { panic!("two") };
    for (found, y) in lit.light.harmonics.iter().zip(harmonics::basis(-direction.as_dvec3())) {
        assert!((*found - irradiance * y as f32).abs().max_element() < 1e-5, "{found}");
    }
    let expected = [1.0, 0.0, 2.0, 0.0, 0.0, 2.0].map(|cosine: f32| irradiance * cosine / 3.0);
    let found = lit.light.axes.iter().zip(expected).map(|(a, b)| (*a - b).abs().max_element()).fold(0.0, f32::max);
    assert!(found < 1e-5, "{:?}", lit.light.axes);
    assert_eq!(dark.light, ProbeLight::default());
}

/// A ball that fills several cells of a lit room, and hides a part of others.
#[test]
fn probes_inside_of_bodies_are_moved_or_filled() {
    let white = Material::matte(Vec3::ONE);
    let scene = Scene { sky: Sky::constant(Vec3::ONE), ..scene() };
    let radius = 0.9;
    let world = World::new(with_sphere(scene, Vec3::ZERO, radius, false, white)).unwrap();
    let grid = ProbeGrid { min: Vec3::splat(-2.0), max: Vec3::splat(2.0), count: [8, 8, 8] };
    let found = on_grid(&world, &grid, &OPTIONS, &NeverStops).unwrap().probes;
    let mut counts = [0; 4];
    for (probe, middle) in found.iter().zip(grid.positions()) {
        counts[probe.state as usize] += 1;
        let inside = |point: Vec3| point.length() < radius - 0.01;
        match probe.state {
            State::Free => assert!(probe.position == middle && !inside(middle), "{probe:?}"),
            State::Moved => {
                assert!(inside(middle) && !inside(probe.position), "{probe:?}");
                assert!((probe.position - middle).abs().max_element() <= 0.5 * 0.5, "it stays in its cell");
            }
            State::Filled => assert!(inside(middle), "{probe:?}"),
            State::Covered => panic!("a neighbour is free: {probe:?}"),
        }
        // A white ball in even light is as bright as the sky: only what is inside is dark.
        let mean = probe.light.harmonics[0] / (4.0 * PI).sqrt();
        assert!((mean - 1.0).abs().max_element() < 0.03, "{probe:?}");
    }
    assert!(counts[1] > 8 && counts[2] >= 8, "{counts:?}");
    let [inside] = at(&world, &[Vec3::ZERO])[..] else { panic!("one") };
    assert_eq!(inside.state, State::Covered, "a listed point is marked");
    assert!((inside.backs - 1.0).abs() < 1e-5);
}

#[test]
fn threads_leave_no_trace_and_an_interruption_leaves_nothing() {
    struct StopsAtOnce;
    impl Watch for StopsAtOnce {
        fn advance(&self, _: u64, _: u64) {}
        fn stop(&self) -> bool {
            true
        }
    }
    let world = World::new(crate::scene::cornell_box()).unwrap();
    let bounds = world.bounds();
    let grid = ProbeGrid { min: bounds.min, max: bounds.max, count: [3, 2, 3] };
    let on = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| on_grid(&world, &grid, &OPTIONS, &NeverStops)).unwrap()
    };
    let one = on(1);
    assert!(one == on(3) && one.rays > 18 * 512);
    assert!(one.probes.iter().all(|probe| probe.light.harmonics[0].min_element() > 0.0));
    assert_eq!(on_grid(&world, &grid, &OPTIONS, &StopsAtOnce), None);
    assert_ne!(on_grid(&world, &grid, &Options { seed: 4, ..OPTIONS }, &NeverStops).unwrap(), one);
}
