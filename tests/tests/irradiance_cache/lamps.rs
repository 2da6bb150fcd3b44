//! Sensors near lamps, where light samples alone are unbounded.

use glam::{DVec3, Vec3, dvec3, vec3};
use halfdome::cache::Cache;
use halfdome::irradiance::{Part, Request, Sensor, by_cache, by_paths};
use halfdome::scene::{CameraPose, Scene};
use halfdome::settings::CachedOptions;
use halfdome::world::World;
use halfdome_tests::polygon_light::polygon;
use halfdome_tests::render::{NeverStops, material, mesh, quad};

use super::light::furnace;

/// The lamp's corners, clockwise as seen from below: it shines down.
const LAMP: [DVec3; 4] =
    [dvec3(-0.6, 0.0, -0.45), dvec3(0.6, 0.0, -0.45), dvec3(0.6, 0.0, 0.45), dvec3(-0.6, 0.0, 0.45)];

/// A lamp of 1.2 by 0.9 and radiance 1 at y = 0, and nothing else.
fn lamp() -> World {
    let camera = CameraPose { eye: vec3(0.0, -3.0, 0.1), target: Vec3::ZERO, up: Vec3::Z, vfov: 60.0 };
    World::new(Scene {
        meshes: vec![mesh(&quad(LAMP.map(DVec3::as_vec3)), 0)],
        materials: vec![material(Vec3::ZERO, Vec3::ONE)],
        camera: Some(camera),
        ..Scene::default()
    })
    .unwrap()
}

/// Total irradiance at sensors with 64 samples, by the cache or by paths.
fn measure(world: &World, sensors: &[Sensor], seed: u64, has_cache: bool) -> Vec<f64> {
    let request = Request { spp: 64, seed, part: Part::Total };
    let cache = Cache::new(CachedOptions { rays: 256, ..CachedOptions::default() }, world.surroundings_hash());
    let found = match has_cache {
        true => by_cache(world, sensors, cache, &request, &NeverStops),
        false => by_paths(world, sensors, &request, &NeverStops),
    };
    assert!(found.finished);
    found.values.iter().map(|value| f64::from(value.y)).collect()
}

/// The mean error of some measurements in parts of what is right, its standard error, and the root of the mean square.
fn statistics(errors: &[f64]) -> (f64, f64, f64) {
    let count = errors.len() as f64;
    let mean = errors.iter().sum::<f64>() / count;
    let square = errors.iter().map(|error| error * error).sum::<f64>() / count;
    (mean, ((square - mean * mean).max(0.0) / count).sqrt(), square.sqrt())
}

/// The exact irradiance of a rectangle, at places below it and, which makes the most noise, beside it.
#[test]
fn sensors_below_a_lamp_measure_its_form_factor() {
    let world = lamp();
    let places = [(0.0, 0.0), (0.31, -0.2), (-0.55, 0.4), (0.62, 0.1), (0.05, -0.44)];
    for (distance, limit) in [(1.0, 0.02), (0.1, 0.05), (0.03, 0.06), (0.01, 0.2)] {
        let sensors: Vec<Sensor> =
            places.iter().map(|&(x, z)| Sensor { position: vec3(x, -distance, z), normal: Vec3::Y }).collect();
        let exact = |sensor: &Sensor| polygon(&LAMP, sensor.position.as_dvec3(), DVec3::Y).irradiance.abs();
        for has_cache in [true, false] {
            let errors: Vec<f64> = (0..64)
                .flat_map(|seed| measure(&world, &sensors, seed, has_cache).into_iter().zip(&sensors))
                .map(|(found, sensor)| found / exact(sensor) - 1.0)
                .collect();
            let (mean, error, rms) = statistics(&errors);
            assert!(mean.abs() < 4.0 * error + 1e-4, "{distance} away, cache {has_cache}: {mean}, not ± {error}");
            assert!(rms < limit, "{distance} away, cache {has_cache}: rms {rms}");
        }
    }
}

/// `E = π Le / (1 - ρ)` everywhere on walls that all are lamps.
#[test]
fn a_furnace_has_its_exact_total() {
    let world = World::new(furnace()).unwrap();
    let sensors: Vec<Sensor> = (0..250)
        .map(|i| Sensor { position: vec3(0.3 * (i % 17) as f32, -2.9 + 0.3 * (i / 17) as f32, 0.0), normal: Vec3::Z })
        .collect();
    for has_cache in [true, false] {
        let found = measure(&world, &sensors, 1, has_cache);
        let errors: Vec<f64> = found.iter().map(|value| value / std::f64::consts::TAU - 1.0).collect();
        let (mean, error, rms) = statistics(&errors);
        assert!(mean.abs() < 0.01, "cache {has_cache}: {mean} ± {error}");
        assert!(rms < 0.06, "cache {has_cache}: rms {rms}");
    }
}
