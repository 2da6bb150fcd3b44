//! The path integrator where radiance has a closed form: closed rooms that glow alike all over, and rooms with holes.
//!
//! In a closed room whose every surface emits `Le` and reflects `ρ`, radiance is `Le + ρ Le + ρ² Le + … = Le / (1 - ρ)`
//! everywhere, in all directions; paths of at most `d` surfaces see the first `d` terms.

use std::f64::consts::PI;

use glam::{DVec3, Vec3};
use halfdome::scene::{CameraPose, Scene};
use halfdome::settings::{Integrator, PathOptions, Settings};
use halfdome_tests::render::{Estimate, material, mesh, pixels, quad, render};

const EMISSION: Vec3 = Vec3::new(1.0, 2.0, 0.5);
const REFLECTANCE: Vec3 = Vec3::new(0.2, 0.5, 0.8);

/// The box from -1 to 1 with its fronts inside.
fn cube() -> Vec<[Vec3; 3]> {
    let face = |axis: usize, side: f32| {
        let at = |a: f32, b: f32| {
            let mut point = Vec3::ZERO;
            (point[axis], point[(axis + 1) % 3], point[(axis + 2) % 3]) = (side, a, b);
            point
        };
        let corners = [at(-1.0, -1.0), at(1.0, -1.0), at(1.0, 1.0), at(-1.0, 1.0)];
        quad(if side > 0.0 { [corners[3], corners[2], corners[1], corners[0]] } else { corners })
    };
    (0..3).flat_map(|axis| [face(axis, -1.0), face(axis, 1.0)]).flatten().collect()
}

/// The tetrahedron in every other corner of the box, fronts outside.
fn tetrahedron() -> Vec<[Vec3; 3]> {
    let [a, b, c, d] =
        [[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]].map(|p: [i8; 3]| Vec3::from(p.map(f32::from)));
    vec![[a, b, c], [a, c, d], [a, d, b], [b, d, c]]
}

/// A sphere about the origin of `8 * 4^levels` triangles, fronts outside.
fn sphere(levels: u32) -> Vec<[Vec3; 3]> {
    let signs = [(1.0, 1.0, 1.0), (1.0, 1.0, -1.0), (1.0, -1.0, 1.0), (1.0, -1.0, -1.0)];
    let all = signs.into_iter().flat_map(|(x, y, z)| [(x, y, z), (-x, y, z)]);
    let octant = |(x, y, z): (f32, f32, f32)| {
        let triangle = [Vec3::X * x, Vec3::Y * y, Vec3::Z * z];
        if x * y * z > 0.0 { triangle } else { [triangle[0], triangle[2], triangle[1]] }
    };
    let mut triangles: Vec<_> = all.map(octant).collect();
    for _ in 0..levels {
        let split = |[a, b, c]: [Vec3; 3]| {
            let [ab, bc, ca] = [a + b, b + c, c + a].map(Vec3::normalize);
            [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
        };
        triangles = triangles.into_iter().flat_map(split).collect();
    }
    triangles
}

/// The room with its fronts as they are or, if both sides emit, of no importance; seen from the inside.
fn room(triangles: &[[Vec3; 3]], reflectance: Vec3, both: bool) -> Scene {
    let mut surface = material(reflectance, EMISSION);
    surface.emits_both_sides = both;
    let camera =
        CameraPose { eye: Vec3::new(0.1, 0.05, -0.2), target: Vec3::new(0.3, 0.4, 0.9), up: Vec3::Y, vfov: 100.0 };
    Scene { meshes: vec![mesh(triangles, 0)], materials: vec![surface], camera: Some(camera), ..Scene::default() }
}

/// The first `depth` terms of the series.
fn radiance(reflectance: Vec3, depth: u32) -> DVec3 {
    let (emission, reflectance) = (EMISSION.as_dvec3(), reflectance.as_dvec3());
    (0..depth).fold(DVec3::ZERO, |sum, _| emission + reflectance * sum)
}

fn check(name: &str, scene: &Scene, reflectance: Vec3, max_depth: u32, spp: u32, closeness: f64) {
    let integrator = Integrator::Path(PathOptions { max_depth, ..PathOptions::default() });
    let settings = Settings { width: 24, height: 24, spp, integrator, ..Settings::default() };
    let pixels = pixels(&render(scene, &settings));
    let expected = radiance(reflectance, max_depth);
    let estimate = Estimate::of(&pixels);
    let z = estimate.z(&expected.into(), 1e-5);
    assert!(z.max_element() < 4.0, "{name}, depth {max_depth}: {estimate:?}, not {expected}, z {z}");
    let off = ((estimate.mean - expected) / expected).abs().max_element();
    assert!(off < closeness, "{name}, depth {max_depth}: {estimate:?}, not {expected}");
    // A pixel is off by more than the mean, but not by much.
    let worst = pixels.iter().map(|pixel| ((pixel - expected) / expected).abs().max_element()).fold(0.0, f64::max);
    assert!(worst < 60.0 * closeness, "{name}, depth {max_depth}: a pixel is off by {worst}");
}

#[test]
fn closed_rooms_glow_by_the_geometric_series() {
    for (name, scene) in [
        ("box", room(&cube(), REFLECTANCE, false)),
        ("tetrahedron", room(&tetrahedron(), REFLECTANCE, true)),
        ("sphere", room(&sphere(3), REFLECTANCE, true)),
    ] {
        check(name, &scene, REFLECTANCE, 64, 256, 0.01);
    }
}

#[test]
fn paths_of_few_surfaces_see_as_many_terms() {
    let scene = room(&cube(), REFLECTANCE, false);
    for depth in [2, 3, 4, 5, 8] {
        check("box", &scene, REFLECTANCE, depth, 128, 0.01);
    }
    let integrator = Integrator::Path(PathOptions { max_depth: 1, ..PathOptions::default() });
    let settings = Settings { width: 8, height: 8, spp: 4, integrator, ..Settings::default() };
    for pixel in pixels(&render(&scene, &settings)) {
        assert_eq!(pixel, EMISSION.as_dvec3(), "emitters alone");
    }
}

#[test]
fn bright_rooms_lose_nothing_to_roulette() {
    let reflectance = Vec3::new(0.9, 0.95, 0.97);
    check("box", &room(&cube(), reflectance, false), reflectance, 400, 256, 0.02);
}

#[test]
fn rooms_far_from_the_origin_and_of_other_scales_glow_alike() {
    for (scale, shift) in [(1e-4, Vec3::ZERO), (1e5, Vec3::ZERO), (1.0, Vec3::new(500.0, -300.0, 200.0))] {
        let place = |p: Vec3| p * scale + shift;
        let triangles: Vec<_> = cube().into_iter().map(|corners| corners.map(place)).collect();
        let mut scene = room(&triangles, REFLECTANCE, false);
        let camera = scene.camera.as_mut().unwrap();
        (camera.eye, camera.target) = (place(camera.eye), place(camera.target));
        check(&format!("box times {scale} at {shift}"), &scene, REFLECTANCE, 64, 128, 0.01);
    }
}

/// In a sphere every part of the wall sees every other alike: with a share `s` of it glowing, all of it reflects
/// `ρ s Le / (1 - ρ)`, and what glows adds `Le`.
#[test]
fn a_sphere_that_glows_in_part_is_lit_evenly() {
    let triangles = sphere(4);
    let (glowing, dark): (Vec<_>, Vec<_>) = triangles.iter().partition(|corners| corners.iter().all(|p| p.y > 0.3));
    let area = |triangles: &[[Vec3; 3]]| -> f64 {
        triangles.iter().map(|[a, b, c]| f64::from((b - a).cross(c - a).length()) / 2.0).sum()
    };
    let mut scene = room(&triangles, REFLECTANCE, true);
    let mut grey = scene.materials[0].clone();
    grey.emission = Vec3::ZERO;
    scene.materials.push(grey);
    scene.meshes = vec![mesh(&glowing, 0), mesh(&dark, 1)];
    scene.camera = Some(CameraPose { eye: Vec3::new(0.0, 0.2, 0.0), target: Vec3::NEG_Y, up: Vec3::Z, vfov: 80.0 });
    let settings = Settings { width: 24, height: 24, spp: 256, ..Settings::default() };
    let estimate = Estimate::of(&pixels(&render(&scene, &settings)));
    let reflectance = REFLECTANCE.as_dvec3();
    let share = area(&glowing) / area(&triangles);
    let expected = reflectance / (1.0 - reflectance) * EMISSION.as_dvec3() * share;
    // Flat triangles are not quite a sphere: allow for two thousandths.
    assert!(share > 0.2 && area(&triangles) > 3.98 * PI, "{share}");
    assert!(estimate.z(&expected.into(), 0.004).max_element() < 4.0, "{estimate:?}, not {expected}");
}
