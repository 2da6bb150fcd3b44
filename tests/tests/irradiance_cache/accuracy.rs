//! The requested accuracy is reached, and its estimate is right.

use glam::{DVec3, Vec3, dvec3, vec3};
use halfdome::cache::Cache;
use halfdome::irradiance::{Irradiance, Part, Request, Sensor, by_cache, by_paths};
use halfdome::scene::{CameraPose, Scene, cornell_box};
use halfdome::settings::CachedOptions;
use halfdome::world::World;
use halfdome_tests::polygon_light::polygon;
use halfdome_tests::render::{NeverStops, material, mesh, quad};

use super::light::furnace;

fn to_accuracy(world: &World, sensors: &[Sensor], accuracy: f32, seed: u64) -> Irradiance {
    let options = CachedOptions { accuracy: Some(accuracy), ..CachedOptions::default() };
    let request = Request { spp: 1, seed, part: Part::Total };
    by_cache(world, sensors, Cache::new(options, world.surroundings_hash()), &request, &NeverStops)
}

fn mean(values: &[Vec3]) -> f64 {
    values.iter().map(|value| f64::from(value.element_sum())).sum::<f64>() / (3 * values.len()) as f64
}

/// The root mean square error relative to the mean of what is expected, which has independent noise of its own if there
/// are two of it.
fn error(found: &[Vec3], expected: [&[Vec3]; 2]) -> f64 {
    let squares = found.iter().zip(expected[0]).zip(expected[1]);
    let squares = squares.map(|((x, a), b)| f64::from((*x - *a).dot(*x - *b)) / 3.0);
    (squares.sum::<f64>() / found.len() as f64).max(0.0).sqrt() / mean(expected[0])
}

/// Whether an estimate is within a factor of 1.5 of the truth, or both are far below what was asked for.
fn is_true(estimate: f32, error: f64, accuracy: f32) -> bool {
    let (estimate, accuracy) = (f64::from(estimate), f64::from(accuracy));
    estimate.max(error) < 0.2 * accuracy || (1.0 / 1.5..1.5).contains(&(estimate / error))
}

/// All walls shine alike: `E = π Le / (1 - ρ)`.
#[test]
fn a_furnace_is_as_right_as_asked() {
    let world = World::new(furnace()).unwrap();
    let sensors: Vec<Sensor> = (0..600)
        .map(|i| Sensor { position: vec3(0.17 * (i % 30) as f32, -2.9 + 0.23 * (i / 30) as f32, 0.0), normal: Vec3::Z })
        .collect();
    let exact = vec![Vec3::splat(std::f32::consts::TAU); sensors.len()];
    for accuracy in [0.03, 0.01] {
        let found = to_accuracy(&world, &sensors, accuracy, 1);
        let (error, estimate) = (error(&found.values, [&exact, &exact]), found.error.unwrap());
        println!("{accuracy}: error {error:.5}, estimated {estimate:.5}");
        assert!(
            error < 1.2 * f64::from(accuracy) && is_true(estimate, error, accuracy),
            "{error}, said to be {estimate}"
        );
    }
}

/// A lamp over nothing, half of it behind a screen: direct light alone, which is known exactly in the open.
#[test]
fn direct_light_is_as_right_as_asked() {
    let lamp = [dvec3(-0.6, 0.0, -0.45), dvec3(0.6, 0.0, -0.45), dvec3(0.6, 0.0, 0.45), dvec3(-0.6, 0.0, 0.45)];
    let camera = CameraPose { eye: vec3(0.0, -3.0, 0.1), target: Vec3::ZERO, up: Vec3::Z, vfov: 60.0 };
    let world = World::new(Scene {
        meshes: vec![mesh(&quad(lamp.map(DVec3::as_vec3)), 0)],
        materials: vec![material(Vec3::ZERO, Vec3::ONE)],
        camera: Some(camera),
        ..Scene::default()
    })
    .unwrap();
    let sensors: Vec<Sensor> = (0..900)
        .map(|i| Sensor {
            position: vec3(-1.5 + 0.1 * (i % 30) as f32, -0.3, -1.5 + 0.1 * (i / 30) as f32),
            normal: Vec3::Y,
        })
        .collect();
    let exact = |sensor: &Sensor| polygon(&lamp, sensor.position.as_dvec3(), DVec3::Y).irradiance.abs() as f32;
    let exact: Vec<Vec3> = sensors.iter().map(|sensor| Vec3::splat(exact(sensor))).collect();
    for accuracy in [0.03, 0.005] {
        let found = to_accuracy(&world, &sensors, accuracy, 1);
        let (error, estimate) = (error(&found.values, [&exact, &exact]), found.error.unwrap());
        println!("{accuracy}: error {error:.5}, estimated {estimate:.5}, {} rays", found.rays);
        assert!(
            error < 1.2 * f64::from(accuracy) && is_true(estimate, error, accuracy),
            "{error}, said to be {estimate}"
        );
    }
}

/// Sensors all over the floor, the back wall and a side wall of the Cornell box.
fn cornell_sensors() -> Vec<Sensor> {
    let place = |i: u32| (0.01 + 0.53 * ((i % 24) as f32 + 0.5) / 24.0, 0.01 + 0.53 * ((i / 24) as f32 + 0.5) / 24.0);
    (0..3 * 576)
        .map(|i| match ((i / 576), place(i % 576)) {
            (0, (x, z)) => Sensor { position: vec3(x, 0.0, z), normal: Vec3::Y },
            (1, (x, y)) => Sensor { position: vec3(x, y, 0.5592), normal: Vec3::NEG_Z },
            (_, (y, z)) => Sensor { position: vec3(0.0, y, z), normal: Vec3::X },
        })
        .collect()
}

/// The error against paths, free of their noise, with fewer rays, by paths at 3% and by a cache at 1.5%; and the same for any
/// number of threads.
#[test]
fn the_cornell_box_is_as_right_as_asked() {
    let world = World::new(cornell_box()).unwrap();
    let sensors = cornell_sensors();
    let paths = |seed| by_paths(&world, &sensors, &Request { spp: 2048, seed, part: Part::Total }, &NeverStops);
    let paths = [paths(11), paths(12)];
    let [a, b] = paths.each_ref().map(|paths| paths.values.as_slice());
    for accuracy in [0.03, 0.015] {
        let found = to_accuracy(&world, &sensors, accuracy, 2);
        let (error, estimate) = (error(&found.values, [a, b]), found.error.unwrap());
        println!("{accuracy}: error {error:.4}, estimated {estimate:.4}, {} rays of {}", found.rays, paths[0].rays);
        assert!(
            error < 1.2 * f64::from(accuracy) && is_true(estimate, error, accuracy),
            "{error}, said to be {estimate}"
        );
        assert!(found.rays < paths[0].rays);
        assert_eq!(found.cache.is_some(), accuracy < 0.02);
    }
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| to_accuracy(&world, &sensors, 0.015, 3))
    };
    let (one, three) = (with(1), with(3));
    assert!(one.values == three.values && one.error == three.error && one.rays == three.rays);
    assert_eq!(one.cache.unwrap().0.encode(), three.cache.unwrap().0.encode());
}
