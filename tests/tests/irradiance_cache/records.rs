//! Which records a cache gets.

use glam::Vec3;
use halfdome::cache::{Cache, Record};
use halfdome::driver;
use halfdome::scene::{Scene, cornell_box};
use halfdome::settings::{CachedOptions, Integrator, Metric, Settings};
use halfdome::world::World;
use halfdome_tests::render::Patience;

fn fill(scene: &Scene, options: CachedOptions) -> Vec<Record> {
    let world = World::new(scene.clone()).unwrap();
    let integrator = Integrator::Cached(options);
    let settings = Settings { width: 48, height: 48, integrator, ..Settings::default() };
    let cache = Cache::new(options, world.surroundings_hash());
    driver::fill_cache(&world, &settings, cache, &Patience).records().to_vec()
}

/// The Cornell box with all lengths multiplied by `length` and radiance by `light`.
fn scaled(length: f32, light: f32) -> Scene {
    let mut scene = cornell_box();
    for position in scene.meshes.iter_mut().flat_map(|mesh| &mut mesh.positions) {
        *position *= length;
    }
    scene.materials.iter_mut().for_each(|material| material.emission *= light);
    let camera = scene.camera.as_mut().unwrap();
    camera.eye *= length;
    camera.target *= length;
    scene
}

/// No length or radiance is built in.
#[test]
fn a_scaled_scene_has_the_same_records() {
    for metric in Metric::ALL {
        let options = CachedOptions { rays: 256, metric, ..CachedOptions::default() };
        let plain = fill(&cornell_box(), options);
        assert!(plain.len() > 50, "{metric:?}: {} records", plain.len());
        for (length, light) in [(1e3, 1e6), (1e-3, 1e-6), (1e3, 1e-6)] {
            let scaled = fill(&scaled(length, light), options);
            assert_eq!(scaled.len(), plain.len(), "{metric:?}, {length}");
            let mut far = 0;
            for (scaled, plain) in scaled.iter().zip(&plain) {
                assert_eq!(scaled.key, plain.key, "{metric:?}, {length}");
                let same = |a: Vec3, b: Vec3| (a - b).length() <= 1e-3 * b.length();
                assert!(same(scaled.position, plain.position * length));
                // A ray that passes an edge on the other side changes a record a little.
                let alike = same(scaled.irradiance, plain.irradiance * light)
                    && (scaled.radii[0] / (plain.radii[0] * length) - 1.0).abs() < 1e-3;
                far += usize::from(!alike);
            }
            assert!(far * 20 <= plain.len(), "{metric:?}, {length}: {far} of {} records differ", plain.len());
        }
    }
}

/// A smaller error means more records, by about the inverse of its square.
#[test]
fn records_are_as_dense_as_the_error_demands() {
    let count = |error| {
        let options = CachedOptions { rays: 64, error, metric: Metric::SplitSphere, ..CachedOptions::default() };
        fill(&cornell_box(), options).len()
    };
    let (fine, coarse) = (count(0.2), count(0.8));
    assert!(fine > 4 * coarse, "{fine} and {coarse} records");
}
