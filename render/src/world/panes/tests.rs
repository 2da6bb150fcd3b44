//! Light through panes, against Fresnel's equations in double precision.

use glam::vec3;

use super::*;
use crate::driver;
use crate::scene::{CameraPose, Mesh, PunctualLight, Scene};
use crate::settings::{CachedOptions, DirectOptions, Integrator, MonteCarloOptions, PathOptions, Settings};
use crate::watch::Watch;

struct NeverStops;

impl Watch for NeverStops {
    fn advance(&self, _: u64, _: u64) {}

    fn stop(&self) -> bool {
        false
    }
}

const IOR: f32 = 1.5;
const TINT: Vec3 = Vec3::new(0.9, 0.6, 0.3);
const ABSORPTION: Vec3 = Vec3::new(0.5, 1.0, 2.0);
/// To the sun, 40° from the normals of panes across z.
const TO_SUN: Vec3 = Vec3::new(0.642_787_6, 0.0, 0.766_044_4);

fn glass(thin_walled: bool, absorption: Vec3) -> Material {
    let inputs = Inputs {
        specular_weight: 1.0,
        specular_roughness: 0.0,
        specular_ior: IOR,
        transmission_weight: 1.0,
        transmission_color: TINT,
        thin_walled,
        absorption,
        ..Inputs::default()
    };
    Material { inputs, ..Material::default() }
}

/// A square at this height, its front up or down, which rises by `slope` along x.
fn square(z: f32, is_up: bool, slope: f32, material: usize) -> Mesh {
    let corner = |(x, y): (f32, f32)| vec3(x, y, z + slope * x);
    let positions = [(-9.0, -9.0), (9.0, -9.0), (9.0, 9.0), (-9.0, 9.0)].map(corner).to_vec();
    let triangles = if is_up { vec![[0, 1, 2], [0, 2, 3]] } else { vec![[0, 2, 1], [0, 3, 2]] };
    Mesh { positions, triangles, material, ..Mesh::default() }
}

/// Meshes above a dark floor under the sun. Materials: 0 clear glass, 1 absorbs, 2 is a thin wall, 3 is dark.
fn world(meshes: Vec<Mesh>) -> World {
    let sun = PunctualLight::Directional { direction: -TO_SUN, irradiance: Vec3::ONE, half_angle: 0.0 };
    World::new(Scene {
        meshes: meshes.into_iter().chain([square(0.0, true, 0.0, 3)]).collect(),
        materials: vec![
            glass(false, Vec3::ZERO),
            glass(false, ABSORPTION),
            glass(true, Vec3::ZERO),
            Material::matte(Vec3::splat(0.01)),
        ],
        lights: vec![sun],
        camera: Some(CameraPose { eye: Vec3::Z * 0.5, target: Vec3::ZERO, up: Vec3::Y, vfov: 0.01 }),
        ..Scene::default()
    })
    .unwrap()
}

/// What a face reflects of light that meets it at the sun's angle.
fn reflectance() -> f64 {
    let (cos, n) = (f64::from(TO_SUN.z), f64::from(IOR));
    let inside = (1.0 - (1.0 - cos * cos) / (n * n)).sqrt();
    let [s, p] = [(cos - n * inside) / (cos + n * inside), (n * cos - inside) / (n * cos + inside)];
    0.5 * (s * s + p * p)
}

/// What a pane of glass number 1 lets through that is so thick.
fn through_pane(absorption: Vec3, thickness: f64) -> Vec3 {
    let (f, n) = (reflectance(), f64::from(IOR));
    let inside = (1.0 - (1.0 - f64::from(TO_SUN.z).powi(2)) / (n * n)).sqrt();
    let channel = |channel: usize| {
        let a = (-f64::from(absorption[channel]) * thickness / inside).exp();
        f64::from(TINT[channel]).powi(2) * (1.0 - f).powi(2) * a / (1.0 - f * f * a * a)
    };
    vec3(channel(0) as f32, channel(1) as f32, channel(2) as f32)
}

fn towards_sun(world: &World) -> (Ray, Vec3) {
    world.beyond_panes(Ray::new(Vec3::Z * 0.1, TO_SUN), MIDDLE)
}

fn assert_left(world: &World, least_height: f32, expected: Vec3) {
    let (rest, left) = towards_sun(world);
    assert!((left - expected).abs().max_element() < 1e-5, "{left}, not {expected}");
    assert!(rest.origin.z > least_height && !world.occluded(&rest), "{rest:?}");
}

#[test]
fn panes_keep_what_their_faces_reflect_and_the_glass_absorbs() {
    let pane = |material| vec![square(1.0, false, 0.0, material), square(1.2, true, 0.0, material)];
    assert_left(&world(pane(0)), 1.19, through_pane(Vec3::ZERO, 0.2));
    assert_left(&world(pane(1)), 1.19, through_pane(ABSORPTION, 0.2));
    // Two of them, as of double glazing.
    let both = pane(0).into_iter().chain([square(2.0, false, 0.0, 1), square(2.1, true, 0.0, 1)]).collect();
    assert_left(&world(both), 2.09, through_pane(Vec3::ZERO, 0.2) * through_pane(ABSORPTION, 0.1));
}

#[test]
fn thin_walls_and_sheets_have_one_face() {
    let f = reflectance() as f32;
    for is_up in [true, false] {
        assert_left(&world(vec![square(1.0, is_up, 0.0, 2)]), 0.99, TINT * ((1.0 - f) / (1.0 + f)));
        assert_left(&world(vec![square(1.0, is_up, 0.0, 0)]), 0.99, TINT * (1.0 - f));
    }
}

#[test]
fn wedges_and_walls_throw_shadows() {
    let wedge = world(vec![square(1.0, false, 0.0, 0), square(2.0, true, 0.1, 0)]);
    let wall = world(vec![square(1.0, false, 0.0, 0), square(1.1, true, 0.0, 3), square(1.2, true, 0.0, 0)]);
    let behind = world(vec![square(1.0, false, 0.0, 0), square(1.2, true, 0.0, 0), square(2.0, true, 0.0, 3)]);
    for world in [wedge, wall, behind] {
        assert!(world.occluded(&towards_sun(&world).0));
    }
    // Nothing is asked of rays where glass cannot be: the floor is none.
    let (ray, left) = towards_sun(&world(Vec::new()));
    assert_eq!((ray.origin, left), (Vec3::Z * 0.1, Vec3::ONE));
}

#[test]
fn lights_in_front_of_a_pane_are_not_dimmed() {
    let world = world(vec![square(1.0, false, 0.0, 0), square(1.2, true, 0.0, 0)]);
    for (height, expected) in [(0.9, Vec3::ONE), (3.0, through_pane(Vec3::ZERO, 0.2))] {
        let end = TO_SUN * (height / TO_SUN.z);
        let (rest, left) = world.beyond_panes(Ray::between(TO_SUN * 0.1, end), MIDDLE);
        assert!((left - expected).abs().max_element() < 1e-5, "{left}, not {expected}");
        assert!((rest.at(rest.t_max) - end).length() < 1e-4, "{rest:?}");
    }
}

#[test]
fn all_integrators_see_the_sun_through_a_window() {
    let world = world(vec![square(1.0, false, 0.0, 1), square(1.2, true, 0.0, 1)]);
    let expected = through_pane(ABSORPTION, 0.2) * (0.01 * TO_SUN.z / std::f32::consts::PI);
    for integrator in [
        Integrator::Path(PathOptions::default()),
        Integrator::MonteCarlo(MonteCarloOptions::default()),
        Integrator::Direct(DirectOptions::default()),
        Integrator::Cached(CachedOptions { rays: 64, ..CachedOptions::default() }),
    ] {
        let settings = Settings { width: 2, height: 2, spp: 4, integrator: integrator.clone(), ..Settings::default() };
        let picture = driver::render(&world, &settings, &NeverStops).picture;
        let channel = |name: &str| picture.channel(name).unwrap().values.iter().sum::<f32>() / 4.0;
        let found = vec3(channel("R"), channel("G"), channel("B"));
        assert!((found / expected - 1.0).abs().max_element() < 0.01, "{integrator:?}: {found}, not {expected}");
    }
}
