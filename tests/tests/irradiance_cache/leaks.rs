//! Light must not come through walls: black rooms on a plain under a sky of radiance 1, in which there is none, among
//! sensors that lie closely on both sides of their walls.

use std::f32::consts::PI;

use glam::{Vec3, vec3};
use halfdome::cache::Cache;
use halfdome::irradiance::{Part, Request, Sensor, by_cache};
use halfdome::scene::{CameraPose, Scene, Sky};
use halfdome::settings::{CachedOptions, GatherLayout, Metric};
use halfdome::world::World;
use halfdome_kernel::sampling::Stream;
use halfdome_tests::render::{NeverStops, material, mesh, quad};

/// Black rectangles on a plain of this half width.
fn plain(half: f32, walls: &[[Vec3; 4]]) -> World {
    let ground = [(-half, -half), (half, -half), (half, half), (-half, half)].map(|(x, y)| vec3(x, y, 0.0));
    let triangles: Vec<_> = std::iter::once(ground).chain(walls.iter().copied()).flat_map(quad).collect();
    World::new(Scene {
        meshes: vec![mesh(&triangles, 0)],
        materials: vec![material(Vec3::ZERO, Vec3::ZERO)],
        sky: Sky { radiance: Vec3::ONE, ..Sky::default() },
        camera: Some(CameraPose { eye: Vec3::Z, target: Vec3::ZERO, up: Vec3::Y, vfov: 60.0 }),
        ..Scene::default()
    })
    .unwrap()
}

/// A tent along all of the plain, from x = -1 to 1, as high as its sides are steep.
fn tent(half: f32, slope: f32) -> Vec<[Vec3; 4]> {
    let [front, back] = [-half, half].map(|y| vec3(0.0, y, slope));
    let side = |x: f32| [vec3(x, -half, 0.0), vec3(x, half, 0.0), back, front];
    let end = |y: f32, ridge: Vec3| [vec3(-1.0, y, 0.0), vec3(1.0, y, 0.0), ridge, ridge];
    vec![side(-1.0), side(1.0), end(-half, front), end(half, back)]
}

/// Sensors at random, and near x = ±1 on both sides.
fn sensors() -> Vec<Sensor> {
    let sensor = |x: f32, y: f32| Sensor { position: vec3(x, y, 0.0), normal: Vec3::Z };
    let random = (0..1500).map(|i| {
        let [x, y] = Stream::new(4, i, 0).uniform2(0).to_array();
        sensor(6.0 * x - 3.0, 4.0 * y - 2.0)
    });
    let near = (0..800).map(|i| {
        let [x, y] = Stream::new(5, i, 0).uniform2(0).to_array();
        // A millimetre to a third of the way to the ridge.
        let away = 0.001 * 300f32.powf(x);
        let [side, outwards] = [1, 2].map(|bit| if i & bit == 0 { 1.0 } else { -1.0 });
        sensor(side * (1.0 + outwards * away), 4.0 * y - 2.0)
    });
    random.chain(near).collect()
}

fn irradiance(world: &World, sensors: &[Sensor], options: CachedOptions) -> Vec<f32> {
    let cache = Cache::new(options, world.surroundings_hash());
    let found = by_cache(world, sensors, cache, &Request { spp: 1, seed: 0, part: Part::Indirect }, &NeverStops);
    found.values.iter().map(|value| value.x).collect()
}

#[test]
fn light_stays_outside() {
    let sensors = sensors();
    for slope in [0.5, 1.0, 8.0] {
        let world = plain(40.0, &tent(40.0, slope));
        for (metric, layout, rays, error) in [
            (Metric::Hessian, GatherLayout::Stratified, 1024, 0.3),
            (Metric::Hessian, GatherLayout::Hemicube, 768, 0.3),
            (Metric::SplitSphere, GatherLayout::Stratified, 1024, 0.3),
            (Metric::Bounded, GatherLayout::Stratified, 512, 0.6),
        ] {
            let options = CachedOptions { metric, layout, rays, error, ..CachedOptions::default() };
            let found = irradiance(&world, &sensors, options);
            let is_inside = |sensor: &Sensor| sensor.position.x.abs() < 1.0;
            let (inside, outside): (Vec<_>, Vec<_>) =
                sensors.iter().zip(found).partition(|(sensor, _)| is_inside(sensor));
            assert!(inside.len() > 800 && outside.len() > 800);
            let lit = inside.iter().filter(|(_, irradiance)| *irradiance > 0.01 * PI).count();
            // Few rays see so little of a flat slope that the nearest sensors may be lit.
            let most = if rays < 768 && slope < 1.0 { inside.len() / 50 } else { 0 };
            assert!(lit <= most, "slope {slope}, {metric:?}, {layout:?}: {lit} of {} inside", inside.len());
            // At least half of the sky; beside a foot gradients may promise more than all of it.
            for (sensor, irradiance) in &outside {
                let part = irradiance / PI;
                assert!((0.48..1.2).contains(&part), "slope {slope}, {metric:?}, {layout:?}: {part} at {sensor:?}");
            }
        }
    }
}

/// Sky beside and under the edge of a plate at a height of h that goes on to one side: at a distance of d from below
/// the edge, `E = π/2 (1 + d/√(d² + h²))`. Whoever stands outside hardly sees the gap, and must not light it.
#[test]
fn a_gap_stays_dark() {
    for height in [0.02f32, 0.1] {
        let plate =
            [vec3(0.0, -40.0, height), vec3(40.0, -40.0, height), vec3(40.0, 40.0, height), vec3(0.0, 40.0, height)];
        let world = plain(40.0, &[plate]);
        let sensors: Vec<Sensor> = (0..4000)
            .map(|i| {
                let [x, y] = Stream::new(7, i, 0).uniform2(0).to_array();
                Sensor { position: vec3(2.0 * x - 1.5, 2.0 * y - 1.0, 0.0), normal: Vec3::Z }
            })
            .collect();
        for metric in Metric::ALL {
            let options = CachedOptions { metric, rays: 2048, error: 0.4, ..CachedOptions::default() };
            let found = irradiance(&world, &sensors, options);
            let errors = sensors.iter().zip(found).map(|(sensor, found)| {
                let d = -sensor.position.x;
                0.5 + 0.5 * d / d.hypot(height) - found / PI
            });
            let rms = (errors.map(|error| error * error).sum::<f32>() / sensors.len() as f32).sqrt();
            println!("{height}, {metric:?}: {rms}");
            assert!(rms < 0.012, "{height}, {metric:?}: {rms}");
        }
    }
}

/// Sky over a black wall of height 2 at a distance of a, `E = π/2 (1 + a/√(a² + 4))`: however long the wall is and wide
/// the plain, records are as near to each other as someone asks for light.
#[test]
fn a_wide_world_is_no_rough_one() {
    for half in [50.0, 1000.0, 20_000.0] {
        let wall = [vec3(0.0, -half, 0.0), vec3(0.0, half, 0.0), vec3(0.0, half, 2.0), vec3(0.0, -half, 2.0)];
        let world = plain(half, &[wall]);
        let places: Vec<f32> = (0..20).map(|i| 0.3 + 0.1 * i as f32).collect();
        let sensors: Vec<Sensor> =
            places.iter().map(|&a| Sensor { position: vec3(a, 0.0, 0.0), normal: Vec3::Z }).collect();
        for metric in Metric::ALL {
            let options = CachedOptions { metric, rays: 4096, ..CachedOptions::default() };
            for (a, found) in places.iter().zip(irradiance(&world, &sensors, options)) {
                let exact = 0.5 * PI * (1.0 + a / (a * a + 4.0).sqrt());
                assert!((found / exact - 1.0).abs() < 0.03, "{half}, {metric:?}, {a}: {found}, not {exact}");
            }
        }
    }
}
