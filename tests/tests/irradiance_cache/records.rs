//! The records of a cache.

use glam::{DVec3, Vec3, vec3};
use halfdome::cache::{Cache, Record};
use halfdome::driver;
use halfdome::irradiance::{Part, Request, Sensor, by_cache};
use halfdome::scene::{Scene, cornell_box};
use halfdome::settings::{CachedOptions, GatherLayout, Integrator, Metric, Settings};
use halfdome::world::World;
use halfdome_tests::render::NeverStops;

fn fill(scene: &Scene, options: CachedOptions) -> Vec<Record> {
    fill_for(48, scene, options)
}

/// The records for a picture of `side` pixels a side.
fn fill_for(side: u32, scene: &Scene, options: CachedOptions) -> Vec<Record> {
    let world = World::new(scene.clone()).unwrap();
    let integrator = Integrator::Cached(options);
    let settings = Settings { width: side, height: side, integrator, ..Settings::default() };
    let cache = Cache::new(options, world.surroundings_hash());
    driver::fill_cache(&world, &settings, cache, &NeverStops).records().to_vec()
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

/// No length or radiance is built in: powers of two scale every number of every record exactly.
#[test]
fn a_scaled_scene_has_the_same_records() {
    let stratified = Metric::ALL.map(|metric| (metric, GatherLayout::Stratified));
    for (metric, layout) in stratified.into_iter().chain([(Metric::Hessian, GatherLayout::Hemicube)]) {
        let options = CachedOptions { rays: 256, metric, layout, ..CachedOptions::default() };
        let plain = fill(&cornell_box(), options);
        assert!(plain.len() > 50, "{metric:?}, {layout:?}: {} records", plain.len());
        for (length, light) in [(1024.0, 1_048_576.0), (1.0 / 1024.0, 1.0 / 1_048_576.0)] {
            let records = fill(&scaled(length, light), options);
            assert_eq!(records.len(), plain.len(), "{metric:?}, {length}");
            for (record, plain) in records.iter().zip(&plain) {
                let expected = Record {
                    position: plain.position * length,
                    irradiance: plain.irradiance * light,
                    standard_error: plain.standard_error * light,
                    rotational: plain.rotational.map(|gradient| gradient * light),
                    translational: plain.translational.map(|gradient| gradient * (light / length)),
                    mean_distance: plain.mean_distance * length,
                    min_distance: plain.min_distance * length,
                    radii: plain.radii.map(|radius| radius * length),
                    occluders: plain.occluders.map(|distance| distance * length),
                    clearance: plain.clearance * length,
                    ..*plain
                };
                assert_eq!(*record, expected, "{metric:?}, {length}");
            }
        }
    }
}

/// Other factors round; then a point that was barely covered may need a record, but not more than a few will.
#[test]
fn rounding_changes_few_records() {
    let options = CachedOptions { rays: 256, ..CachedOptions::default() };
    let plain = fill(&cornell_box(), options);
    for (length, light) in [(1e3, 1e6), (1e-3, 1e-6)] {
        let records = fill(&scaled(length, light), options);
        let difference = records.len().abs_diff(plain.len());
        assert!(difference * 50 <= plain.len(), "{} records, not {}", records.len(), plain.len());
        let same = |a: Vec3, b: Vec3| (a - b).length() <= 0.01 * b.length();
        let find = |key| plain.iter().find(|record| record.key == key);
        let common: Vec<_> = records.iter().filter_map(|record| Some((record, find(record.key)?))).collect();
        let alike = common.iter().filter(|(record, plain)| same(record.irradiance, plain.irradiance * light)).count();
        assert!(common.len() * 10 >= plain.len() * 9, "{} records of {} are common", common.len(), plain.len());
        assert!(alike * 20 >= common.len() * 19, "{alike} of {} are alike", common.len());
    }
}

/// How far records reach is proportional to the error, so that half of it takes up to four times as many; fewer where
/// pixels or edges of the room bound how far they reach.
#[test]
fn records_are_as_dense_as_the_error_demands() {
    let count = |error| {
        let options = CachedOptions { rays: 768, error, metric: Metric::Hessian, ..CachedOptions::default() };
        fill_for(192, &cornell_box(), options).len()
    };
    let (fine, coarse) = (count(0.3), count(0.6));
    assert!(fine > 2 * coarse && fine < 5 * coarse, "{fine} and {coarse} records");
}

/// The deviation that records tell is that of irradiance over seeds; cells beside an edge see different things, so it
/// may be too much.
#[test]
fn records_know_their_noise() {
    const SEEDS: u64 = 48;
    let world = World::new(cornell_box()).unwrap();
    for layout in GatherLayout::ALL {
        let options = CachedOptions { layout, rays: 768, ..CachedOptions::default() };
        let sensor = Sensor { position: vec3(0.43, 0.0, 0.12), normal: Vec3::Y };
        let record = |seed| {
            let cache = Cache::new(options, world.surroundings_hash());
            let request = Request { spp: 1, seed, part: Part::Indirect };
            by_cache(&world, &[sensor], cache, &request, &NeverStops).cache.unwrap().0.records()[0]
        };
        let records: Vec<Record> = (0..SEEDS).map(record).collect();
        let mean = records.iter().map(|record| record.irradiance.as_dvec3()).sum::<DVec3>() / SEEDS as f64;
        let squares = records.iter().map(|record| (record.irradiance.as_dvec3() - mean).powf(2.0)).sum::<DVec3>();
        let standard_error = (squares / (SEEDS - 1) as f64).max_element().sqrt();
        let told = records.iter().map(|record| f64::from(record.standard_error)).sum::<f64>() / SEEDS as f64;
        println!("{layout:?}: {told} told, {standard_error} found, of {mean}");
        assert!((0.75..1.75).contains(&(told / standard_error)), "{layout:?}: {told}, not {standard_error}");
    }
}
