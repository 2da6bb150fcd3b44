//! Interpolation, filling and what records of neighbours change.

mod files;

use super::*;
use glam::{Vec3, vec3};
use halfdome_kernel::sampling::Stream;

const SCENE: u64 = 0x1234_5678_9abc_def0;

fn options() -> CachedOptions {
    CachedOptions::default()
}

fn point(position: Vec3, normal: Vec3) -> LookupPoint {
    LookupPoint { position, normal, clearance: None }
}

/// A record on the plane z = 0 with the irradiance 2 + x - 3y in red, and the like in the other channels.
fn record(key: u64, x: f32, y: f32, radius: f32) -> Record {
    let gradients = [vec3(1.0, -3.0, 0.0), vec3(-1.0, 0.5, 0.0), Vec3::ZERO];
    let position = vec3(x, y, 0.0);
    Record {
        key,
        position,
        normal: Vec3::Z,
        irradiance: vec3(20.0, 10.0, 1.0) + Vec3::from_array(gradients.map(|gradient| gradient.dot(position))),
        standard_error: 0.0,
        rotational: [Vec3::X, Vec3::Y, Vec3::Z],
        translational: gradients,
        mean_distance: radius,
        min_distance: 0.5 * radius,
        radii: [radius; 2],
        axis: Vec3::X,
        occluders: [f32::INFINITY; SECTORS],
        clearance: f32::INFINITY,
    }
}

/// Records of random places and radii with the keys `keys`.
fn cache(keys: std::ops::Range<u32>) -> Cache {
    let mut cache = Cache::new(options(), SCENE);
    let random = |key: u32| {
        let [x, y, r, _] = Stream::new(3, key, 0).uniform4(0);
        record(key.into(), x, y, 0.05 + 0.2 * r)
    };
    cache.commit(keys.map(random).collect());
    cache
}

#[test]
fn interpolation_is_exact_for_what_gradients_describe() {
    let cache = cache(0..160);
    for i in 0..200 {
        let [x, y, ..] = Stream::new(4, i, 0).uniform4(0);
        let Some(found) = cache.interpolate(vec3(x, y, 0.0), Vec3::Z) else { panic!("no record at {x}, {y}") };
        let expected = vec3(20.0 + x - 3.0 * y, 10.0 - x + 0.5 * y, 1.0);
        assert!((found.irradiance - expected).abs().max_element() < 1e-4, "{found:?}, not {expected}");
        assert_eq!(found.negative, 0);
    }
    assert_eq!(cache.interpolate(vec3(0.5, 0.5, 0.0), Vec3::X), None);
    assert_eq!(cache.interpolate(vec3(9.0, 0.5, 0.0), Vec3::Z), None);
}

#[test]
fn gradients_are_used_as_asked() {
    let mut one = record(0, 0.0, 0.0, 1.0);
    one.irradiance = Vec3::ONE;
    let (position, normal) = (vec3(0.25, 0.0, 0.0), vec3(0.0, 0.05, 1.0).normalize());
    // n_i × n = (-0.05, 0, 0) / |n|.
    let turned = -normal.y;
    for (gradients, expected) in [
        (Gradients::Off, Vec3::ONE),
        (Gradients::Rotation, vec3(1.0 + turned, 1.0, 1.0)),
        (Gradients::Both, vec3(1.25 + turned, 0.75, 1.0)),
    ] {
        let mut cache = Cache::new(CachedOptions { gradients, ..options() }, SCENE);
        cache.commit(vec![one]);
        let irradiance = cache.interpolate(position, normal).unwrap().irradiance;
        assert!((irradiance - expected).abs().max_element() < 1e-6, "{gradients:?}: {irradiance}, not {expected}");
    }
}

#[test]
fn negative_extrapolation_counts_as_nothing_and_is_counted() {
    let mut cache = Cache::new(options(), SCENE);
    let mut steep = record(0, 0.0, 0.0, 1.0);
    (steep.irradiance, steep.translational[0]) = (Vec3::ONE, Vec3::X * -100.0);
    cache.commit(vec![steep]);
    let found = cache.interpolate(vec3(0.5, 0.0, 0.0), Vec3::Z).unwrap();
    assert_eq!((found.irradiance.x, found.negative), (0.0, 1));
}

/// Records that disagree reach less far where gradients are in use, from their original radii again with every commit.
#[test]
fn disagreement_shortens_where_gradients_are_in_use() {
    let radii = |gradients, metric, is_rough| {
        let cache = Cache::new(CachedOptions { gradients, metric, ..options() }, SCENE);
        let mut cache = if is_rough { cache.rough() } else { cache };
        let mut other = record(1, 0.4, 0.0, 0.5);
        other.irradiance *= 3.0;
        cache.commit(vec![record(0, 0.0, 0.0, 0.5), other]);
        let once = cache.records.clone();
        cache.commit(Vec::new());
        assert_eq!(cache.records, once);
        once.iter().map(|record| record.radii[0]).collect::<Vec<_>>()
    };
    for metric in Metric::ALL {
        assert_eq!(radii(Gradients::Off, metric, false), [0.5; 2], "as published");
        assert_eq!(radii(Gradients::Rotation, metric, false), [0.5; 2], "as published");
        assert_eq!(radii(Gradients::Both, metric, true), [0.5; 2], "rough");
        assert_eq!(radii(Gradients::Both, metric, false), [0.25; 2]);
    }
}

/// Rounds stop when each place is covered, and what they make does not depend on the number of threads.
#[test]
fn filling_covers_every_place_in_one_order() {
    let places: Vec<Place> = (0..1600)
        .map(|i| {
            let position = vec3((i % 40) as f32, (i / 40) as f32, 0.0) / 40.0;
            Place { point: point(position, Vec3::Z), spacing: 1.0 / 40.0 }
        })
        .collect();
    let passes = [16.0, 8.0, 4.0, 2.0, 1.0].map(|separation| Pass { places: places.len(), separation });
    let fill = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let mut cache = Cache::new(options(), SCENE);
        pool.install(|| {
            cache.fill(&places, &passes, |picks, covered| {
                assert!(covered + picks.len() <= places.len());
                // Small radii at the left.
                let make = |&i: &usize| {
                    let Vec3 { x, y, .. } = places[i].point.position;
                    record(i as u64, x, y, 0.03 + 0.3 * x)
                };
                Some(picks.iter().map(make).collect())
            })
        });
        cache
    };
    let cache = fill(1);
    assert!(places.iter().all(|place| cache.covers(&place.point)));
    let left = cache.records().iter().filter(|record| record.position.x < 0.5).count();
    let right = cache.records().len() - left;
    assert!(left > 3 * right && left + right < 500, "{left} records at the left, {right} at the right");
    for threads in [2, 8] {
        assert_eq!(fill(threads).encode(), cache.encode());
    }
    let mut stopped = Cache::new(options(), SCENE);
    assert_eq!(stopped.fill(&places, &passes, |_, _| None), None);
    assert!(stopped.records().is_empty());
}

/// Light that is linear in the normal, `4 + b·n`, on a sphere: its gradient is `n × b`. What records know of it is
/// turned to where it is needed, by the record that is read as by the neighbours that it listens to.
#[test]
fn rotational_gradients_turn_what_neighbours_say() {
    let direction = vec3(1.0, 2.0, -1.5);
    let light = |normal: Vec3| Vec3::splat(4.0 + direction.dot(normal));
    let on_sphere = |key: u32| {
        let [x, y, ..] = Stream::new(6, key, 0).uniform4(0);
        // The half that looks up, evenly.
        let (sin, cos) = (std::f32::consts::TAU * x).sin_cos();
        vec3((1.0 - y * y).sqrt() * cos, (1.0 - y * y).sqrt() * sin, y)
    };
    let record = |key: u32| {
        let normal = on_sphere(key);
        Record {
            key: key.into(),
            position: normal,
            normal,
            irradiance: light(normal),
            rotational: [normal.cross(direction); 3],
            translational: [Vec3::ZERO; 3],
            axis: normal.any_orthonormal_vector(),
            ..record(0, 0.0, 0.0, 0.12)
        }
    };
    let error = |gradients| {
        let mut cache = Cache::new(CachedOptions { gradients, ..options() }, SCENE);
        cache.commit((0..1000).map(record).collect());
        let points = (1000..1400).map(on_sphere).filter(|normal| normal.z > 0.3);
        let difference = |normal: Vec3| (cache.interpolate(normal, normal).unwrap().irradiance - light(normal)).y;
        let squares: Vec<f32> = points.map(difference).map(|error| error * error).collect();
        (squares.iter().sum::<f32>() / squares.len() as f32).sqrt()
    };
    let [off, rotation, both] = [Gradients::Off, Gradients::Rotation, Gradients::Both].map(error);
    println!("off {off}, rotation {rotation}, both {both}");
    assert!(rotation < 0.3 * off && both < 0.5 * off, "off {off}, rotation {rotation}, both {both}");
}

/// A normal that a map tilts sees the horizon: of uniform light `(1 + cos) / 2` is left. The surface's own normal says
/// which records are valid.
#[test]
fn maps_tilt_what_records_say() {
    let mut cache = Cache::new(options(), SCENE);
    let flat = Record { rotational: [Vec3::ZERO; 3], translational: [Vec3::ZERO; 3], ..record(0, 0.0, 0.0, 1.0) };
    cache.commit(vec![flat]);
    let tilted = vec3(40f32.to_radians().sin(), 0.0, 40f32.to_radians().cos());
    let found = cache.interpolate_tilted(&point(vec3(0.1, 0.0, 0.0), Vec3::Z), tilted).unwrap().irradiance;
    let expected = vec3(20.0, 10.0, 1.0) * 0.5 * (1.0 + tilted.z);
    assert!((found - expected).abs().max_element() < 1e-4, "{found}, not {expected}");
    assert_eq!(
        cache.interpolate_tilted(&point(vec3(0.1, 0.0, 0.0), tilted), Vec3::Z),
        None,
        "a surface that turns away"
    );
    // The gradient's part: light from one side, E = 20 + 5 x in red.
    let sided = Record { rotational: [Vec3::Z.cross(Vec3::X) * 5.0; 3], ..flat };
    assert!((sided.tilt(Vec3::ZERO, Vec3::Z, tilted, true).x - 5.0 * tilted.x).abs() < 1e-5);
    assert_eq!(sided.tilt(Vec3::ZERO, Vec3::Z, tilted, false), Vec3::ZERO);
}

/// Records 20° apart around a thin column are valid nowhere between by the published angles, and say the right thing
/// anyway.
#[test]
fn thin_columns_are_read_between_their_records() {
    const RADIUS: f32 = 0.05;
    let direction = vec3(0.6, 0.0, 0.8);
    let light = |normal: Vec3| Vec3::splat(4.0 + 2.0 * direction.dot(normal));
    let normal_at = |degrees: f32| vec3(degrees.to_radians().cos(), degrees.to_radians().sin(), 0.0);
    let record = |key: u32| {
        let normal = normal_at(20.0 * key as f32);
        Record {
            key: key.into(),
            position: RADIUS * normal,
            normal,
            irradiance: light(normal),
            rotational: [2.0 * normal.cross(direction); 3],
            translational: [Vec3::ZERO; 3],
            axis: Vec3::Z,
            ..record(0, 0.0, 0.0, 0.05)
        }
    };
    let mut cache = Cache::new(options(), SCENE);
    cache.commit((0..18).filter(|key| key % 2 == 0).map(record).collect());
    for degrees in [20.0, 100.0, 179.0, 300.0] {
        let normal = normal_at(degrees);
        assert_eq!(cache.interpolate(RADIUS * normal, normal), None, "{degrees}");
        let found = cache.interpolate_wide(&point(RADIUS * normal, normal), normal).unwrap().irradiance;
        assert!((found / light(normal) - 1.0).abs().max_element() < 0.04, "{degrees}: {found}, not {}", light(normal));
    }
    assert_eq!(cache.interpolate_wide(&point(RADIUS * Vec3::X, Vec3::Z), Vec3::Z), None, "beyond 45°");
}

/// One record that a bright ray made is doubtful; once it is right, so are those beside it that had missed the light.
#[test]
fn records_that_cannot_be_right_are_doubtful() {
    let flat = |key: u64, light: f32, standard_error: f32| Record {
        irradiance: Vec3::splat(light),
        standard_error,
        rotational: [Vec3::ZERO; 3],
        translational: [Vec3::ZERO; 3],
        ..record(key, 0.1 * (key % 5) as f32, 0.1 * (key / 5) as f32, 0.2)
    };
    let doubtful = |records: Vec<Record>, again: &[u64]| {
        let mut cache = Cache::new(options(), SCENE);
        cache.commit(records);
        let mut keys = cache.doubtful(&again.iter().copied().collect());
        keys.sort_unstable();
        keys
    };
    let quiet = |key: u64| flat(key, 1.0, 0.01);
    assert_eq!(doubtful((0..25).map(quiet).collect(), &[]), [0u64; 0]);
    assert_eq!(doubtful((0..25).map(quiet).collect(), &[12]), [0u64; 0], "it agrees");
    let bright = |key: u64| if key == 12 { flat(12, 5.0, 4.0) } else { quiet(key) };
    assert_eq!(doubtful((0..25).map(bright).collect(), &[]), [12]);
    // Gathered again it says 2: the light is there, and its neighbours have missed it. It is not asked for once more.
    let right = |key: u64| if key == 12 { flat(12, 2.0, 0.1) } else { quiet(key) };
    let found = doubtful((0..25).map(right).collect(), &[12]);
    assert!([7, 11, 13, 17].iter().all(|key| found.contains(key)) && !found.contains(&12), "{found:?}");
    assert!(!found.contains(&0), "too far away");

    let mut cache = Cache::new(options(), SCENE);
    cache.commit((0..25).map(bright).collect());
    cache.replace(vec![flat(12, 1.0, 0.01)]);
    assert_eq!(cache.records().len(), 25);
    assert_eq!(cache.interpolate(vec3(0.2, 0.2, 0.0), Vec3::Z).unwrap().irradiance, Vec3::ONE);
}
