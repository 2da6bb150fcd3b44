//! Records in a black room that is open to the sky: nothing is reflected, so irradiance and its gradients are those of
//! the opening as a polygon light, and no path adds noise to them.

use glam::{DMat3, DVec3, Vec3, dvec3};
use halfdome::cache::{Cache, Record};
use halfdome::irradiance::{Part, Request, Sensor, by_cache};
use halfdome::scene::{CameraPose, Scene, Sky};
use halfdome::settings::{CachedOptions, GatherLayout, Metric};
use halfdome::world::World;
use halfdome_tests::polygon_light::polygon;
use halfdome_tests::render::{NeverStops, material, mesh, quad};

/// The lid's height.
const LID: f64 = 2.0;
/// Where the walls are.
const WALL: f64 = 4.0;

/// A black room with walls at ±4, its lid at z = 2 open between two corners, under a sky of radiance 1; `more` are
/// black rectangles inside. All of it is turned about the z axis.
fn room(lower: [f64; 2], upper: [f64; 2], more: &[[DVec3; 4]], turns: f64) -> World {
    let rectangle =
        |x0: f64, y0: f64, x1: f64, y1: f64| [(x0, y0), (x1, y0), (x1, y1), (x0, y1)].map(|(x, y)| dvec3(x, y, LID));
    let wall = |angle: f64| {
        let turn = DMat3::from_rotation_z(angle.to_radians());
        [(-WALL, -1.0), (WALL, -1.0), (WALL, LID), (-WALL, LID)].map(|(y, z)| turn * dvec3(WALL, y, z))
    };
    let lid = [
        rectangle(-WALL, -WALL, lower[0], WALL),
        rectangle(upper[0], -WALL, WALL, WALL),
        rectangle(lower[0], -WALL, upper[0], lower[1]),
        rectangle(lower[0], upper[1], upper[0], WALL),
    ];
    let turn = DMat3::from_rotation_z(turns * std::f64::consts::TAU);
    let all = lid.into_iter().chain([0.0, 90.0, 180.0, 270.0].map(wall)).chain(more.iter().copied());
    let triangles: Vec<_> = all.flat_map(|corners| quad(corners.map(|corner| (turn * corner).as_vec3()))).collect();
    let camera = CameraPose { eye: Vec3::Z, target: Vec3::ZERO, up: Vec3::Y, vfov: 60.0 };
    World::new(Scene {
        meshes: vec![mesh(&triangles, 0)],
        materials: vec![material(Vec3::ZERO, Vec3::ZERO)],
        sky: Sky { radiance: Vec3::ONE, ..Sky::default() },
        camera: Some(camera),
        ..Scene::default()
    })
    .unwrap()
}

/// The one record at a point that looks up.
fn record(world: &World, position: DVec3, layout: GatherLayout, rays: u32, seed: u64) -> Record {
    // A record that reaches this far has no clamp that weakens its gradient.
    let metric = Metric::SplitSphere;
    let options = CachedOptions { layout, rays, error: 0.5, metric, ..CachedOptions::default() };
    let cache = Cache::new(options, world.surroundings_hash());
    let sensor = Sensor { position: position.as_vec3(), normal: Vec3::Z };
    let found = by_cache(world, &[sensor], cache, &Request { spp: 1, seed, part: Part::Indirect }, &NeverStops);
    let records = found.cache.unwrap().0.records().to_vec();
    assert_eq!(records.len(), 1);
    let own = (records[0].irradiance - found.values[0]).abs().max_element();
    assert!(own <= 1e-6 * records[0].irradiance.max_element(), "a record is worth itself where it is: {own}");
    records[0]
}

/// The means of irradiance and of the translational gradient over records of some seeds.
fn mean(world: &World, position: DVec3, layout: GatherLayout, rays: u32, seeds: u64) -> (f64, DVec3) {
    let records = (0..seeds).map(|seed| record(world, position, layout, rays, seed));
    let sum = records.fold((0.0, DVec3::ZERO), |(irradiance, gradient), record| {
        (irradiance + f64::from(record.irradiance.y), gradient + record.translational[1].as_dvec3())
    });
    (sum.0 / seeds as f64, sum.1 / seeds as f64)
}

/// The half-plane x < 0 at z = 1 under an opening [-1, 1]²: as the point moves, so does the shadow's edge, twice as
/// fast.
#[test]
fn an_occluder_before_the_opening() {
    let half_plane = [(-3.9, -3.9), (0.0, -3.9), (0.0, 3.9), (-3.9, 3.9)].map(|(x, y)| dvec3(x, y, 1.0));
    let world = room([-1.0; 2], [1.0; 2], &[half_plane], 0.0);
    for (layout, rays, seeds) in [(GatherLayout::Stratified, 20_000, 8), (GatherLayout::Hemicube, 49_152, 1)] {
        let (irradiance, gradient) = mean(&world, dvec3(0.3, 0.0, 0.0), layout, rays, seeds);
        assert!((irradiance / 0.52692 - 1.0).abs() < 0.015, "{layout:?}: {irradiance}");
        assert!((gradient.x / 0.38715 - 1.0).abs() < 0.03, "{layout:?}: {gradient}");
        assert!(gradient.y.abs() < 0.01 * gradient.x, "{layout:?}: {gradient}");
    }
}

/// A record's gradient is what finite differences of the exact irradiance tend to.
#[test]
fn gradients_are_those_of_finite_differences() {
    let (lower, upper) = ([0.2, -0.7], [1.7, 0.9]);
    let world = room(lower, upper, &[], 0.0);
    let corners = [(lower[0], lower[1]), (lower[0], upper[1]), (upper[0], upper[1]), (upper[0], lower[1])];
    let exact = |x: DVec3| polygon(&corners.map(|(x, y)| dvec3(x, y, LID)), x, DVec3::Z);
    let centre = exact(DVec3::ZERO);
    for (layout, rays, seeds) in [(GatherLayout::Stratified, 20_000, 8), (GatherLayout::Hemicube, 49_152, 1)] {
        let (irradiance, gradient) = mean(&world, DVec3::ZERO, layout, rays, seeds);
        assert!((irradiance / centre.irradiance.abs() - 1.0).abs() < 0.01, "{layout:?}: {irradiance}");
        for axis in [DVec3::X, DVec3::Y] {
            // A sweep of steps: the quotient is level where the steps are neither too long nor too short.
            for step in [0.01, 0.03, 0.1] {
                let ends = [step, -step].map(|step| exact(axis * step).irradiance.abs());
                let quotient = (ends[0] - ends[1]) / (2.0 * step);
                let size = centre.gradient.truncate().length();
                assert!(
                    (gradient.dot(axis) - quotient).abs() < 0.02 * size,
                    "{layout:?}, {step}: {gradient} {quotient}"
                );
            }
        }
    }
}

/// A texel's direction has no chance in it: where the room turns by a quarter, so does the gradient, to the last
/// digits. One edge of the opening stands over φ = 0, where the last sector meets the first.
#[test]
fn a_turned_room_has_turned_gradients() {
    let gradients = [0.0, 0.25, 0.5, 0.75].map(|turns| {
        let world = room([0.2, 0.0], [1.3, 1.1], &[], turns);
        let record = record(&world, DVec3::ZERO, GatherLayout::Hemicube, 12_288, 0);
        let back = DMat3::from_rotation_z(-turns * std::f64::consts::TAU);
        (record.irradiance.y, [record.rotational[1], record.translational[1]].map(|g| back * g.as_dvec3()))
    });
    let (irradiance, still) = gradients[0];
    assert!(still.iter().all(|gradient| gradient.length() > 0.05), "{still:?}");
    for (turned_irradiance, turned) in &gradients[1..] {
        assert!((turned_irradiance - irradiance).abs() < 1e-5);
        for (turned, still) in turned.iter().zip(&still) {
            assert!((*turned - *still).length() < 1e-5, "{turned} {still}");
        }
    }
}
