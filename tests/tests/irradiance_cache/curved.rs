//! Curved surfaces, where irradiance changes with the normal.

use std::f64::consts::PI;

use glam::{Vec3, vec3};
use halfdome::cache::Cache;
use halfdome::irradiance::{Part, Request, Sensor, by_cache};
use halfdome::scene::{CameraPose, Scene, Sky};
use halfdome::settings::{CachedOptions, GatherLayout, Gradients, Metric};
use halfdome::world::World;
use halfdome_tests::render::{NeverStops, material, mesh, quad};

/// A black floor, far larger than it is below the sphere, under a sky of radiance 1.
fn plain() -> World {
    let floor = [(-500.0, -500.0), (500.0, -500.0), (500.0, 500.0), (-500.0, 500.0)].map(|(x, y)| vec3(x, y, 0.0));
    World::new(Scene {
        meshes: vec![mesh(&quad(floor), 0)],
        materials: vec![material(Vec3::ZERO, Vec3::ZERO)],
        sky: Sky { radiance: Vec3::ONE, ..Sky::default() },
        camera: Some(CameraPose { eye: Vec3::Z, target: Vec3::X, up: Vec3::Z, vfov: 60.0 }),
        ..Scene::default()
    })
    .unwrap()
}

/// All over a sphere of radius 0.5 at height 1, where `E = π (1 + n_z) / 2`.
fn sphere() -> Vec<Sensor> {
    let sensor = |i: u32| {
        // A spiral with golden steps.
        let z = 1.0 - (2 * i + 1) as f32 / 1500.0;
        let (sin, cos) = (2.399_963 * i as f32).sin_cos();
        let normal = vec3((1.0 - z * z).sqrt() * cos, (1.0 - z * z).sqrt() * sin, z).normalize();
        Sensor { position: Vec3::Z + 0.5 * normal, normal }
    };
    (0..1500).map(sensor).collect()
}

/// Records on a sphere, each of which knows how irradiance changes as its normal turns, are worth several that do not.
#[test]
fn rotational_gradients_help_on_a_sphere() {
    let (world, sensors) = (plain(), sphere());
    for layout in GatherLayout::ALL {
        let errors = Gradients::ALL.map(|gradients| {
            let metric = Metric::SplitSphere;
            let options =
                CachedOptions { layout, metric, gradients, rays: 1024, error: 1.0, ..CachedOptions::default() };
            let cache = Cache::new(options, world.surroundings_hash());
            let request = Request { spp: 1, seed: 1, part: Part::Indirect };
            let found = by_cache(&world, &sensors, cache, &request, &NeverStops);
            let squares = found.values.iter().zip(&sensors).map(|(value, sensor)| {
                let exact = 0.5 * PI * (1.0 + f64::from(sensor.normal.z));
                ((f64::from(value.y) - exact) / PI).powi(2)
            });
            (squares.sum::<f64>() / sensors.len() as f64).sqrt()
        });
        let [off, rotation, both] = errors;
        assert!(rotation < 0.4 * off && both < 0.4 * off, "{layout:?}: {off} without, {rotation} with, both {both}");
    }
}
