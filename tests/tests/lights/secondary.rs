//! A lamp's shade: its inside is lit so strongly that paths sample it as a light, which must not change the result.

use std::f32::consts::TAU;

use glam::{DVec3, Vec3};
use halfdome::cache::Cache;
use halfdome::irradiance::{Part, Request, Sensor, by_cache, by_paths};
use halfdome::material::Inputs;
use halfdome::probes::{self, Options};
use halfdome::scene::{CameraPose, Material, PunctualLight, Scene};
use halfdome::settings::{CachedOptions, GatherLayout, Integrator, LightSampling, PathOptions, Settings, Stop};
use halfdome::world::{LightQuery, World};
use halfdome_tests::render::{Estimate, NeverStops, material, mesh, pixels, quad, render, seeds};

const SIZE: u32 = 24;
const MIDDLE: Vec3 = Vec3::new(2.0, 1.2, 2.0);

/// The object in the middle of a room.
enum Bulb {
    Point,
    Triangles,
}

/// The sides of a box, which face outwards; inwards with the corners exchanged.
pub(crate) fn hollow(low: Vec3, high: Vec3) -> Vec<[Vec3; 3]> {
    let corners = [low.x, high.x].map(|x| [low.y, high.y].map(|y| [low.z, high.z].map(|z| Vec3::new(x, y, z))));
    let [[[a, b], [c, d]], [[e, f], [g, h]]] = corners;
    [[a, b, d, c], [e, g, h, f], [a, e, f, b], [c, d, h, g], [a, c, g, e], [b, f, h, d]].map(quad).concat()
}

/// A closed room of 4 by 3 by 4 metres, with a bulb in an open tube of 12 sides.
fn room(bulb: &Bulb, shade: Material) -> Scene {
    let walls = hollow(Vec3::ZERO, Vec3::new(4.0, 3.0, 4.0));
    let rim = |i: u32, y: f32| {
        let (sin, cos) = (TAU * i as f32 / 12.0).sin_cos();
        MIDDLE + Vec3::new(0.12 * cos, y, 0.12 * sin)
    };
    let tube: Vec<_> =
        (0..12).flat_map(|i| quad([rim(i, -0.1), rim(i, 0.1), rim(i + 1, 0.1), rim(i + 1, -0.1)])).collect();
    let [red, orange] = [Vec3::new(0.7, 0.6, 0.5), Vec3::new(30.0, 20.0, 10.0)];
    let mut scene = Scene {
        meshes: vec![mesh(&walls, 0), mesh(&tube, 1)],
        materials: vec![material(red, Vec3::ZERO), shade, material(Vec3::ZERO, 10.0 * orange)],
        camera: Some(CameraPose {
            eye: Vec3::new(0.3, 1.6, 0.4),
            target: Vec3::new(4.0, 1.0, 3.6),
            up: Vec3::Y,
            vfov: 60.0,
        }),
        ..Scene::default()
    };
    match bulb {
        Bulb::Point => {
            scene.lights.push(PunctualLight::Point { position: MIDDLE, intensity: 0.1 * orange, radius: 0.01 });
        }
        Bulb::Triangles => {
            let r = 0.02;
            let top = [Vec3::X, Vec3::Z, Vec3::NEG_X, Vec3::NEG_Z].map(|way| MIDDLE + r * way);
            let faces = (0..4).flat_map(|i| {
                let (a, b) = (top[i], top[(i + 1) % 4]);
                [[a, MIDDLE + r * Vec3::Y, b], [b, MIDDLE - r * Vec3::Y, a]]
            });
            scene.meshes.push(mesh(&faces.collect::<Vec<_>>(), 2));
        }
    }
    scene
}

/// The mean of the picture over seeds, and the mean over pixels of the variance of one pixel, relative to the squared
/// mean.
pub(crate) fn picture(scene: &Scene, lights: LightSampling, stop: &Stop, spp: u32) -> (Estimate, f64) {
    let options = PathOptions { lights, max_depth: 6, stop: *stop, ..PathOptions::default() };
    let integrator = Integrator::Path(options);
    let settings = Settings { width: SIZE, height: SIZE, spp, integrator, ..Settings::default() };
    let runs = seeds(scene, &settings, 16);
    let count = runs[0].len();
    let variance = |i: usize| {
        let estimate = Estimate::of(&runs.iter().map(|run| run[i]).collect::<Vec<_>>());
        (estimate.error.y * estimate.error.y, estimate.mean.y)
    };
    let (variances, values): (Vec<f64>, Vec<f64>) = (0..count).map(variance).unzip();
    let mean = values.iter().sum::<f64>() / count as f64;
    (Estimate::of_means(&runs), variances.iter().sum::<f64>() / count as f64 / (mean * mean))
}

/// `direct` samples lights and aims at nothing.
fn compare(bulb: &Bulb, shade: Material, quieter: f64) {
    compare_in(&room(bulb, shade), quieter);
}

pub(crate) fn compare_in(scene: &Scene, quieter: f64) {
    let (aimed, noise) = picture(scene, LightSampling::Mis, &Stop::Depth, 32);
    let (alone, noise_alone) = picture(scene, LightSampling::Direct, &Stop::Depth, 128);
    let z = aimed.z(&alone, 0.0);
    assert!(z.max_element() < 4.0, "{} and {}: {z}", aimed.mean, alone.mean);
    assert!(aimed.error.max_element() < 0.02 * aimed.mean.max_element(), "{} of {}", aimed.error, aimed.mean);
    let ratio = 4.0 * noise_alone / noise;
    assert!(ratio > quieter, "{ratio} times the variance without");
}

#[test]
fn aiming_at_a_matte_shade_makes_no_difference_but_for_noise() {
    compare(&Bulb::Point, material(Vec3::splat(0.8), Vec3::ZERO), 2.0);
}

#[test]
fn aiming_at_a_shade_around_a_lamp_that_rays_can_hit() {
    compare(&Bulb::Triangles, material(Vec3::splat(0.8), Vec3::ZERO), 2.0);
}

#[test]
fn aiming_at_a_glossy_shade_that_glows() {
    let inputs = Inputs {
        base_color: Vec3::new(0.9, 0.7, 0.4),
        specular_weight: 1.0,
        specular_roughness: 0.4,
        ..Inputs::default()
    };
    let shade = Material { inputs, emission: Vec3::new(0.3, 0.2, 0.1), emits_both_sides: true, ..Material::default() };
    compare(&Bulb::Point, shade, 1.5);
}

#[test]
fn aiming_at_a_shade_that_lets_light_through() {
    let inputs = Inputs {
        base_color: Vec3::splat(0.6),
        diffuse_transmission_weight: 0.5,
        diffuse_transmission_color: Vec3::new(0.9, 0.8, 0.6),
        ..Inputs::default()
    };
    compare(&Bulb::Point, Material { inputs, ..Material::default() }, 1.5);
}

/// Paths that are aimed know as well as others which solids they are in.
#[test]
fn aiming_beside_tinted_glass() {
    let mut scene = room(&Bulb::Point, material(Vec3::splat(0.8), Vec3::ZERO));
    let inputs = Inputs {
        specular_weight: 1.0,
        specular_roughness: 0.3,
        transmission_weight: 1.0,
        absorption: Vec3::new(0.5, 2.0, 4.0),
        ..Inputs::default()
    };
    let solid = hollow(Vec3::new(1.2, 0.8, 0.9), Vec3::new(1.8, 1.5, 1.5));
    scene.meshes.push(mesh(&solid, scene.materials.len()));
    scene.materials.push(Material { inputs, ..Material::default() });
    compare_in(&scene, 1.2);
}

/// Aimed paths and others to one point would end at different throughputs.
#[test]
fn a_threshold_ends_paths_as_without_aiming() {
    let scene = room(&Bulb::Triangles, material(Vec3::splat(0.8), Vec3::ZERO));
    let stop = Stop::Threshold { cutoff: 0.3, add_back: false };
    let [mis, direct] = [LightSampling::Mis, LightSampling::Direct].map(|lights| picture(&scene, lights, &stop, 128).0);
    let z = mis.z(&direct, 0.0);
    assert!(z.max_element() < 4.0, "{} and {}: {z}", mis.mean, direct.mean);
}

#[test]
fn pictures_with_aimed_paths_do_not_depend_on_threads() {
    let scene = room(&Bulb::Point, material(Vec3::splat(0.8), Vec3::ZERO));
    let settings = Settings { width: 40, height: 40, spp: 4, ..Settings::default() };
    let [one, four] = [1, 4].map(|threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| pixels(&render(&scene, &settings)))
    });
    assert_eq!(one, four);
}

/// Sensors on the ceiling, the floor and a wall.
const SENSORS: [([f32; 3], Vec3); 3] =
    [([2.6, 2.9, 1.5], Vec3::NEG_Y), ([1.0, 0.1, 3.0], Vec3::Y), ([0.1, 1.0, 2.0], Vec3::X)];

/// The mean at each sensor over seeds, by a world that looks for lit triangles from sensors or, from nowhere, finds
/// none.
fn sensed(from: LightQuery, seeds: u64, sense: impl Fn(&World, &Sensor, u64) -> Vec3) -> Vec<Estimate> {
    let world = World::for_light_query(room(&Bulb::Point, material(Vec3::splat(0.8), Vec3::ZERO)), from).unwrap();
    let at = |(position, normal): ([f32; 3], Vec3)| {
        let sensor = Sensor { position: position.into(), normal };
        let values: Vec<DVec3> = (0..seeds).map(|seed| sense(&world, &sensor, seed).as_dvec3()).collect();
        Estimate::of(&values)
    };
    SENSORS.map(at).to_vec()
}

/// Gathers of records and paths from sensors aim, too, and have much less noise than as many paths that do not.
#[test]
fn gathers_that_aim_find_what_others_do() {
    let request = |seed, spp| Request { spp, seed, part: Part::Indirect };
    let places = SENSORS.map(|(position, normal)| (Vec3::from(position), normal));
    let paths = |spp| {
        move |world: &World, sensor: &Sensor, seed| {
            by_paths(world, &[*sensor], &request(seed, spp), &NeverStops).values[0]
        }
    };
    let (rays, times) = (512, 64);
    let truth = sensed(LightQuery::Places(&[]), 32, paths(times * rays));
    let gathers = |layout| {
        move |world: &World, sensor: &Sensor, seed| {
            let options = CachedOptions { rays, layout, ..CachedOptions::default() };
            let cache = Cache::new(options, world.surroundings_hash());
            by_cache(world, &[*sensor], cache, &request(seed, 1), &NeverStops).values[0]
        }
    };
    let check = |name: &str, found: Vec<Estimate>| {
        let mut quieter = 0.0;
        for (i, (found, truth)) in found.iter().zip(&truth).enumerate() {
            let z = found.z(truth, 0.0).max_element();
            assert!(z < 4.0, "{name}, sensor {i}: {} and {}: {z}", found.mean, truth.mean);
            // Errors of means over seeds, of which the truth has half as many.
            let ratio = 0.5 * f64::from(times) * (truth.error.y / found.error.y).powi(2);
            println!("{name}, sensor {i}: {ratio} times quieter");
            quieter += ratio / 3.0;
        }
        assert!(quieter > 10.0, "{name}: {quieter} times the variance without");
    };
    check("paths", sensed(LightQuery::Sensors(&places), 64, paths(rays)));
    check("strata", sensed(LightQuery::Sensors(&places), 64, gathers(GatherLayout::Stratified)));
    check("hemicube", sensed(LightQuery::Sensors(&places), 64, gathers(GatherLayout::Hemicube)));
}

/// Probes likewise.
#[test]
fn probes_that_aim_find_what_others_do() {
    let places = SENSORS.map(|(position, _)| Vec3::from(position));
    let sense = |spp, rays| {
        move |world: &World, sensor: &Sensor, seed| {
            let options = Options { rays, spp, seed };
            probes::at_points(world, &[sensor.position], &options, &NeverStops).unwrap().probes[0].light.harmonics[0]
        }
    };
    let truth = sensed(LightQuery::Places(&[]), 16, sense(4096, 16384));
    let found = sensed(LightQuery::Places(&places), 64, sense(512, 512));
    for (i, (found, truth)) in found.iter().zip(&truth).enumerate() {
        let z = found.z(truth, 0.0).max_element();
        assert!(z < 4.0, "sensor {i}: {} and {}: {z}", found.mean, truth.mean);
    }
}
