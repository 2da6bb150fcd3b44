//! Light through panes, against Fresnel's equations in double precision.

use glam::vec3;

use super::*;
use crate::driver;
use crate::fixtures::{self, IOR, reflectance, sloping_square, square, sun};
use crate::material::Inputs;
use crate::scene::{CameraPose, Material, Mesh, PunctualLight, Scene};
use crate::settings::{CachedOptions, DirectOptions, Integrator, MonteCarloOptions, PathOptions, Settings};
use crate::watch::NeverStops;

const TINT: Vec3 = Vec3::new(0.9, 0.6, 0.3);
const ABSORPTION: Vec3 = Vec3::new(0.5, 1.0, 2.0);
/// To the sun, 40° from the normals of panes across z.
const TO_SUN: Vec3 = Vec3::new(0.642_787_6, 0.0, 0.766_044_4);

fn glass(thin_walled: bool, roughness: f32, absorption: Vec3) -> Material {
    let clear = fixtures::glass();
    let inputs = Inputs { specular_roughness: roughness, transmission_color: TINT, thin_walled, absorption, ..clear };
    Material { inputs, ..Material::default() }
}

/// Meshes above a dark floor under the sun.
fn world(meshes: Vec<Mesh>) -> World {
    lit_by(vec![sun(TO_SUN)], meshes)
}

/// Meshes above a dark floor. Materials: 0 clear glass, 1 absorbs, 2 is a thin wall, 3 is dark, 4 emits, 5 is rough glass.
fn lit_by(lights: Vec<PunctualLight>, meshes: Vec<Mesh>) -> World {
    World::new(Scene {
        meshes: meshes.into_iter().chain([square(0.0, true, 3)]).collect(),
        materials: vec![
            glass(false, 0.0, Vec3::ZERO),
            glass(false, 0.0, ABSORPTION),
            glass(true, 0.0, Vec3::ZERO),
            Material::matte(Vec3::splat(0.01)),
            Material { emission: Vec3::ONE, ..Material::matte(Vec3::ZERO) },
            glass(false, 0.3, Vec3::ZERO),
        ],
        lights,
        camera: Some(CameraPose { eye: Vec3::Z * 0.5, target: Vec3::ZERO, up: Vec3::Y, vfov: 0.01 }),
        ..Scene::default()
    })
    .unwrap()
}

/// What a pane of glass number 1 lets through that is so thick.
fn through_pane(absorption: Vec3, thickness: f64) -> Vec3 {
    let (f, n) = (reflectance(f64::from(TO_SUN.z)), f64::from(IOR));
    let inside = (1.0 - (1.0 - f64::from(TO_SUN.z).powi(2)) / (n * n)).sqrt();
    let channel = |channel: usize| {
        let a = (-f64::from(absorption[channel]) * thickness / inside).exp();
        f64::from(TINT[channel]).powi(2) * (1.0 - f).powi(2) * a / (1.0 - f * f * a * a)
    };
    vec3(channel(0) as f32, channel(1) as f32, channel(2) as f32)
}

/// What is left of a shadow ray, and of its light.
fn beyond_panes(world: &World, shadow: Ray) -> (Ray, Vec3) {
    match world.glass_between(&shadow, MIDDLE) {
        Between::Panes { rest, transmittance, .. } => (rest, transmittance),
        Between::NoGlass => (shadow, Vec3::ONE),
        Between::Bends => panic!("{shadow:?} is bent"),
    }
}

fn ray_to_sun() -> Ray {
    Ray::new(Vec3::Z * 0.1, TO_SUN)
}

fn assert_left(world: &World, least_height: f32, expected: Vec3) {
    let (rest, left) = beyond_panes(world, ray_to_sun());
    assert!((left - expected).abs().max_element() < 1e-5, "{left}, not {expected}");
    assert!(rest.origin.z > least_height && !world.occluded(&rest), "{rest:?}");
}

#[test]
fn panes_keep_what_their_faces_reflect_and_the_glass_absorbs() {
    let pane = |material| vec![square(1.0, false, material), square(1.2, true, material)];
    assert_left(&world(pane(0)), 1.19, through_pane(Vec3::ZERO, 0.2));
    assert_left(&world(pane(1)), 1.19, through_pane(ABSORPTION, 0.2));
    // Two of them, as of double glazing.
    let both = pane(0).into_iter().chain([square(2.0, false, 1), square(2.1, true, 1)]).collect();
    assert_left(&world(both), 2.09, through_pane(Vec3::ZERO, 0.2) * through_pane(ABSORPTION, 0.1));
}

#[test]
fn thin_walls_have_one_face() {
    let f = reflectance(f64::from(TO_SUN.z)) as f32;
    for is_up in [true, false] {
        assert_left(&world(vec![square(1.0, is_up, 2)]), 0.99, TINT * ((1.0 - f) / (1.0 + f)));
    }
}

#[test]
fn wedges_and_single_faces_bend_light_and_walls_throw_shadows() {
    let wedge = vec![square(1.0, false, 0), sloping_square(2.0, true, 0.1, 9.0, 0)];
    let wall = vec![square(1.0, false, 0), square(1.1, true, 3), square(1.2, true, 0)];
    for meshes in [wedge, wall, vec![square(1.0, true, 0)], vec![square(1.0, false, 0)]] {
        assert!(matches!(world(meshes).glass_between(&ray_to_sun(), MIDDLE), Between::Bends));
    }
    let behind = world(vec![square(1.0, false, 0), square(1.2, true, 0), square(2.0, true, 3)]);
    assert!(behind.occluded(&beyond_panes(&behind, ray_to_sun()).0));
    // Nothing is asked of rays where glass cannot be: the floor is none.
    let none = world(Vec::new());
    assert!(matches!(none.glass_between(&ray_to_sun(), MIDDLE), Between::NoGlass));
}

#[test]
fn lights_in_front_of_a_pane_are_not_dimmed() {
    let world = world(vec![square(1.0, false, 0), square(1.2, true, 0)]);
    for (height, expected) in [(0.9, Vec3::ONE), (3.0, through_pane(Vec3::ZERO, 0.2))] {
        let end = TO_SUN * (height / TO_SUN.z);
        let (rest, left) = beyond_panes(&world, Ray::between(TO_SUN * 0.1, end));
        assert!((left - expected).abs().max_element() < 1e-5, "{left}, not {expected}");
        assert!((rest.at(rest.t_max) - end).length() < 1e-4, "{rest:?}");
    }
}

/// The mean of a picture with so many pixels a side and samples.
fn color(world: &World, integrator: Integrator, (side, spp): (u32, u32)) -> Vec3 {
    let settings = Settings { width: side, height: side, spp, integrator, ..Settings::default() };
    let picture = driver::render(world, &settings, &NeverStops).picture;
    let channel = |name: &str| picture.channel(name).unwrap().values.iter().sum::<f32>() / (side * side) as f32;
    vec3(channel("R"), channel("G"), channel("B"))
}

/// A lamp that bounces find is as bright through glass as a point in its place, whether shadow rays or bounces find that one.
#[test]
fn points_light_through_glass_as_lamps_with_a_surface_do() {
    let (height, side) = (20.0, 6.0);
    let mut lamp = square(height, false, 4);
    lamp.positions.iter_mut().for_each(|corner| *corner *= vec3(side / 18.0, side / 18.0, 1.0));
    let intensity = Vec3::splat(side * side);
    let point = PunctualLight::Point { position: Vec3::Z * height, intensity, radius: 0.0 };
    let path = || Integrator::Path(PathOptions::default());
    for glass in [
        vec![],
        vec![square(1.0, false, 0), square(1.2, true, 0)],
        vec![square(1.0, true, 0)],
        vec![square(1.0, false, 0)],
        vec![square(1.0, false, 2)],
        vec![square(1.0, false, 5), square(1.2, true, 5)],
        vec![square(1.0, false, 0), square(1.2, true, 5)],
    ] {
        let of_lamp =
            color(&lit_by(Vec::new(), glass.iter().cloned().chain([lamp.clone()]).collect()), path(), (16, 512));
        let of_point = color(&lit_by(vec![point.clone()], glass.clone()), path(), (16, 512));
        let ratio = of_point / of_lamp;
        assert!((ratio - 1.0).abs().max_element() < 0.15, "{ratio} with {} faces of {:?}", glass.len(), glass.first());
    }
}

#[test]
fn all_integrators_see_the_sun_through_a_window() {
    let world = world(vec![square(1.0, false, 1), square(1.2, true, 1)]);
    let expected = through_pane(ABSORPTION, 0.2) * (0.01 * TO_SUN.z / std::f32::consts::PI);
    for integrator in [
        Integrator::Path(PathOptions::default()),
        Integrator::MonteCarlo(MonteCarloOptions::default()),
        Integrator::Direct(DirectOptions::default()),
        Integrator::Cached(CachedOptions { rays: 64, ..CachedOptions::default() }),
    ] {
        let found = color(&world, integrator.clone(), (2, 4));
        assert!((found / expected - 1.0).abs().max_element() < 0.01, "{integrator:?}: {found}, not {expected}");
    }
}
