//! Solids that neither reflect nor refract, whose absorption is known exactly, seen straight on.

use glam::vec3;

use super::*;
use crate::driver;
use crate::material::Inputs;
use crate::scene::{CameraPose, Material, Mesh, PunctualLight, Scene};
use crate::settings::{CachedOptions, DirectOptions, Integrator, MonteCarloOptions, PathOptions, Settings, Stop};
use crate::watch::NeverStops;

const RED: Vec3 = Vec3::new(0.1, 1.0, 3.0);
const GREEN: Vec3 = Vec3::new(2.0, 0.2, 0.7);

fn solid(absorption: Vec3) -> Material {
    let inputs = Inputs {
        specular_weight: 1.0,
        specular_roughness: 0.0,
        specular_ior: 1.0,
        transmission_weight: 1.0,
        absorption,
        ..Inputs::default()
    };
    Material { inputs, ..Material::default() }
}

/// A square across the view, its front towards the camera or away from it.
fn square(z: f32, faces_camera: bool, material: usize) -> Mesh {
    let positions = [(-9.0, -9.0), (9.0, -9.0), (9.0, 9.0), (-9.0, 9.0)].map(|(x, y)| vec3(x, y, z)).to_vec();
    let triangles = if faces_camera { vec![[0, 1, 2], [0, 2, 3]] } else { vec![[0, 2, 1], [0, 3, 2]] };
    Mesh { positions, triangles, material, ..Mesh::default() }
}

/// The two sides of a slab that matter.
fn slab([near, far]: [f32; 2], material: usize) -> [Mesh; 2] {
    [square(near, true, material), square(far, false, material)]
}

/// Materials 0 and 1 absorb, 2 is clear, 3 emits 1 and reflects nothing, 4 is grey.
fn scene(meshes: Vec<Mesh>, eye: f32) -> Scene {
    let lamp = Material { emission: Vec3::ONE, ..Material::matte(Vec3::ZERO) };
    Scene {
        meshes,
        materials: vec![solid(RED), solid(GREEN), solid(Vec3::ZERO), lamp, Material::matte(Vec3::splat(0.5))],
        camera: Some(CameraPose { eye: Vec3::Z * eye, target: Vec3::NEG_Z * 9.0, up: Vec3::Y, vfov: 0.01 }),
        ..Scene::default()
    }
}

fn integrators() -> [Integrator; 4] {
    // Chance would have to be averaged out.
    let stop = Stop::Threshold { cutoff: 0.0, add_back: false };
    [
        Integrator::Path(PathOptions { stop, ..PathOptions::default() }),
        Integrator::MonteCarlo(MonteCarloOptions { bounces: 0, ..MonteCarloOptions::default() }),
        Integrator::Direct(DirectOptions::default()),
        Integrator::Cached(CachedOptions { rays: 64, ..CachedOptions::default() }),
    ]
}

fn color(scene: &Scene, integrator: Integrator, spp: u32) -> Vec3 {
    let world = World::new(scene.clone()).unwrap();
    let settings = Settings { width: 2, height: 2, spp, integrator, ..Settings::default() };
    let picture = driver::render(&world, &settings, &NeverStops).picture;
    let channel = |name: &str| picture.channel(name).unwrap().values.iter().sum::<f32>() / 4.0;
    vec3(channel("R"), channel("G"), channel("B"))
}

/// What all integrators see of `meshes` before a wall that emits 1 at z = -5.
fn assert_seen(meshes: Vec<Mesh>, eye: f32, expected: Vec3) {
    let scene = scene(meshes.into_iter().chain([square(-5.0, true, 3)]).collect(), eye);
    for integrator in integrators() {
        let found = color(&scene, integrator.clone(), 4);
        assert!((found - expected).abs().max_element() < 1e-4, "{integrator:?}: {found}, not {expected}");
    }
}

#[test]
fn a_slab_absorbs_by_its_thickness() {
    assert_seen(slab([0.0, -1.0], 0).to_vec(), 2.0, (-RED).exp());
    assert_seen(slab([0.0, -0.3], 1).to_vec(), 2.0, (-0.3 * GREEN).exp());
}

#[test]
fn what_is_inside_is_seen_through_the_part_before_it() {
    let [front, back] = slab([0.0, -1.0], 0);
    assert_seen(vec![front, back, square(-0.4, true, 3)], 2.0, (-0.4 * RED).exp());
}

/// Wine that reaches into its glass, for one.
#[test]
fn of_solids_that_overlap_the_last_one_absorbs() {
    let both = [slab([0.0, -1.0], 0), slab([-0.6, -1.6], 1)].concat();
    assert_seen(both, 2.0, (-0.6 * RED - 1.0 * GREEN).exp());
    let in_clear = [slab([0.0, -1.0], 2), slab([-0.9, -1.6], 1)].concat();
    assert_seen(in_clear, 2.0, (-0.7 * GREEN).exp());
}

#[test]
fn solids_lie_in_each_other() {
    let bubble = [slab([0.0, -1.0], 0), slab([-0.2, -0.5], 2)].concat();
    assert_seen(bubble, 2.0, (-0.7 * RED).exp());
    let twice = [slab([0.0, -1.0], 0), slab([-0.2, -0.5], 0), slab([-2.0, -2.5], 1)].concat();
    assert_seen(twice, 2.0, (-RED - 0.5 * GREEN).exp());
}

#[test]
fn a_camera_may_be_inside() {
    assert_seen(slab([5.0, -1.0], 0).to_vec(), 0.0, (-RED).exp());
}

/// A path goes on from a rough surface by a density, and a cache's lookups then leave a part of it to records.
#[test]
fn rough_surfaces_have_the_same_inside() {
    let [front, back] = slab([0.0, -0.7], 5);
    let mut scene = scene(vec![front, back, square(-2.0, true, 4)], 2.0);
    let rough = Inputs { specular_roughness: 0.3, specular_ior: 1.5, ..solid(RED).inputs };
    scene.materials.push(Material { inputs: rough, ..Material::default() });
    let lamp = PunctualLight::Point { position: vec3(0.0, 0.0, -1.5), intensity: Vec3::ONE, radius: 0.0 };
    scene.lights.push(lamp);
    let [path, _, _, cached] = integrators().map(|integrator| color(&scene, integrator, 1 << 14));
    let error = ((path - cached) / path).abs().max_element();
    assert!(error < 0.05, "{path} by paths, {cached} by a cache");
}

#[test]
fn light_samples_are_absorbed() {
    let [front, back] = slab([0.0, -2.0], 0);
    let mut scene = scene(vec![front, back, square(-1.0, true, 4)], 2.0);
    let lamp = PunctualLight::Point { position: vec3(0.0, 0.0, -0.25), intensity: Vec3::ONE, radius: 0.0 };
    scene.lights.push(lamp);
    let expected = (-1.75 * RED).exp() * 0.5 / std::f32::consts::PI / (0.75 * 0.75);
    for integrator in integrators() {
        let found = color(&scene, integrator.clone(), 4);
        // Light that the surface reflects to itself is there in part.
        let error = ((found - expected) / expected).abs().max_element();
        assert!(error < 2e-3, "{integrator:?}: {found}, not {expected}");
    }
}
