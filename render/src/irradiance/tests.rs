use std::sync::atomic::{AtomicU64, Ordering};

use glam::vec3;

use super::*;
use crate::scene::{CameraPose, Material, Mesh, PunctualLight, Scene, cornell_box};
use crate::settings::CachedOptions;

/// Counts samples, and says stop after so many.
struct Impatience {
    after: u64,
    samples: AtomicU64,
}

impl Impatience {
    fn new(after: u64) -> Self {
        Self { after, samples: AtomicU64::new(0) }
    }
}

impl Watch for Impatience {
    fn advance(&self, samples: u64, _: u64) {
        self.samples.fetch_add(samples, Ordering::Relaxed);
    }

    fn stop(&self) -> bool {
        self.samples.load(Ordering::Relaxed) >= self.after
    }
}

/// Sensors on the floor of the Cornell box, out of sight of the lamp's edges or not.
fn sensors() -> Vec<Sensor> {
    (0..64).map(|i| Sensor { position: vec3(0.03 + 0.008 * i as f32, 0.0, 0.02), normal: Vec3::Y }).collect()
}

fn mean(values: &[Vec3]) -> DVec3 {
    values.iter().map(|value| value.as_dvec3()).sum::<DVec3>() / values.len() as f64
}

/// Where there is no record a sensor has its own paths, with its own numbers, and they are counted.
#[test]
fn sensors_without_a_record_have_paths() {
    let world = World::new(cornell_box()).unwrap();
    let sensors = sensors();
    let patience = Impatience::new(u64::MAX);
    let request = Request { spp: 16, seed: 3, part: Part::Indirect };
    let empty = |options| FrozenCache::new(Cache::new(options, world.surroundings_hash()));
    let frozen = empty(CachedOptions::default());
    let all = own(&sensors, Shard::ALL);
    let found = look_up(&world, (&sensors, &all), &frozen, (&request, Effort::Samples(request.spp)), &patience).0;
    assert_eq!(frozen.usage().misses, 64);
    assert!(found.finished && found.rays > 64 * 16);
    assert_eq!(found.values, by_paths(&world, &sensors, &request, &patience).values);

    // As many reflections as light has on its way to a record, and direct light besides.
    let request = Request { spp: 512, seed: 3, part: Part::Total };
    let options = CachedOptions { bounces: Some(1), ..CachedOptions::default() };
    let lost = mean(
        &look_up(&world, (&sensors, &all), &empty(options), (&request, Effort::Samples(request.spp)), &patience)
            .0
            .values,
    );
    let cache = Cache::new(options, world.surroundings_hash());
    let covered = by_cache(&world, &sensors, cache, &request, &patience);
    assert_eq!(covered.cache.unwrap().1.misses, 0);
    let ratio = lost / mean(&covered.values);
    assert!((ratio - 1.0).abs().max_element() < 0.02, "{ratio}");
}

/// A spot light's patch of the ceiling sends most of the light: paths of pictures aim at it, gathers and sensors need not.
#[test]
fn gathers_leave_large_secondary_lights_to_chance() {
    let corner = |i: u32| vec3(4.0, 3.0, 4.0) * vec3((i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2) as f32);
    let walls = [[0, 1, 3, 2], [4, 5, 7, 6], [0, 1, 5, 4], [2, 3, 7, 6], [0, 2, 6, 4], [1, 3, 7, 5]];
    let room = Mesh {
        positions: (0..8).map(corner).collect(),
        triangles: walls.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect(),
        ..Mesh::default()
    };
    let spot = PunctualLight::Spot {
        position: vec3(1.5, 1.2, 2.5),
        direction: Vec3::Y,
        intensity: Vec3::splat(30.0),
        radius: 0.0,
        cos_inner: 0.95,
        cos_outer: 0.94,
        edge: Default::default(),
    };
    let [eye, target] = [vec3(3.8, 1.6, 0.4), vec3(0.0, 1.4, 2.6)];
    let scene = Scene {
        meshes: vec![room],
        materials: vec![Material::matte(vec3(0.7, 0.65, 0.6))],
        lights: vec![spot],
        camera: Some(CameraPose { eye, target, up: Vec3::Y, vfov: 60.0 }),
        ..Scene::default()
    };
    let sensors: Vec<_> =
        (0..64).map(|i| Sensor { position: vec3(0.05 * i as f32 + 0.3, 0.0, 1.0), normal: Vec3::Y }).collect();
    let mut world = World::new(scene).unwrap();
    assert!(world.lights.lit.has_any() && world.lights.lit.are_large());
    let values = |world: &World| {
        let cache = Cache::new(CachedOptions::default(), world.surroundings_hash());
        let request = Request { spp: 16, seed: 1, part: Part::Total };
        let patience = Impatience::new(u64::MAX);
        let cached = by_cache(world, &sensors, cache, &request, &patience).values;
        [cached, by_paths(world, &sensors, &request, &patience).values]
    };
    let beside = values(&world);
    world.forget_secondary_lights();
    assert_eq!(beside, values(&world));
}

/// Soon, whatever is under way: a sensor's samples, or the records for them.
#[test]
fn sensors_end_when_the_watcher_says_so() {
    let world = World::new(cornell_box()).unwrap();
    let sensors = sensors();
    let request = Request { spp: 1 << 20, seed: 0, part: Part::Total };
    let watch = Impatience::new(4096);
    let found = by_paths(&world, &sensors, &request, &watch);
    assert!(!found.finished);
    assert_eq!(found.values, [Vec3::ZERO; 64]);
    // A batch for each thread more.
    let samples = watch.samples.load(Ordering::Relaxed) as usize;
    assert!(samples <= 4096 + BATCH * rayon::current_num_threads(), "{samples} samples");

    let cache = Cache::new(CachedOptions::default(), world.surroundings_hash());
    for part in [Part::Total, Part::Indirect] {
        let found = by_cache(&world, &sensors, cache.clone(), &Request { part, ..request }, &Impatience::new(0));
        assert_eq!((found.finished, found.rays), (false, 0), "{part:?}");
        assert_eq!(found.cache.unwrap().0.records(), []);
        // With an accuracy among the first paths.
        let options = CachedOptions { accuracy: Some(0.01), ..CachedOptions::default() };
        let cache = Cache::new(options, world.surroundings_hash());
        let found = by_cache(&world, &sensors, cache, &Request { part, ..request }, &Impatience::new(0));
        assert!(!found.finished && found.cache.is_none() && found.error.is_none(), "{part:?}");
    }
}

/// The lamp of the Cornell box hangs just below its ceiling: between them it is dark, and no record of the ceiling around knows.
#[test]
fn what_is_hidden_has_records_of_its_own() {
    let world = World::new(cornell_box()).unwrap();
    let sensors: Vec<Sensor> = (0..32 * 32)
        .map(|i| [i % 32, i / 32].map(|k| 0.03 + (k as f32 + 0.5) * 0.0155))
        .map(|[x, z]| Sensor { position: vec3(x, 0.5488, z), normal: Vec3::NEG_Y })
        .collect();
    let above_lamp = |it: &Sensor| (0.216..0.34).contains(&it.position.x) && (0.23..0.329).contains(&it.position.z);
    let request = Request { spp: 256, seed: 1, part: Part::Total };
    let cache = Cache::new(CachedOptions { rays: 512, ..CachedOptions::default() }, world.surroundings_hash());
    let found = by_cache(&world, &sensors, cache, &request, &Impatience::new(u64::MAX));
    let all = mean(&found.values).element_sum();
    let (hidden, values): (Vec<Sensor>, Vec<Vec3>) =
        sensors.iter().copied().zip(found.values).filter(|(sensor, _)| above_lamp(sensor)).unzip();
    let paths = by_paths(&world, &hidden, &Request { spp: 4096, ..request }, &Impatience::new(u64::MAX)).values;
    let off = values.iter().zip(paths).map(|(value, path)| (*value - path).as_dvec3().element_sum() / all);
    let off: Vec<f64> = off.collect();
    // By the records around, sensors say 1.3 that are above the lamp and far from the few records there.
    assert!(off.len() > 30 && off.iter().all(|off| off.abs() < 0.02), "{off:.3?}");
    assert_eq!(found.cache.unwrap().1.misses, 0);
}
