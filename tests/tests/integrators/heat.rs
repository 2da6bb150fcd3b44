//! Pictures of where work is done and which lights are chosen.

use super::*;

#[test]
fn heat_counts_visits() {
    let camera = peephole(Vec3::new(0.3, 0.2, 1.0), Vec3::ZERO);
    let mut scene =
        Scene { meshes: vec![mesh(&floor(1.0), 0)], materials: vec![Material::default()], camera, ..Scene::default() };
    let heat = |max_depth| Integrator::Heat(PathOptions { max_depth, ..PathOptions::default() });
    // The root, and its one block.
    all_are(&render(&scene, &settings(heat(1), 3)), Vec3::splat(2.0), 0.0, "camera rays");
    // The bounce starts on the block's box, leaves upwards, and meets the root alone or the block as well.
    for pixel in pixels(&render(&scene, &settings(heat(2), 3))) {
        assert!((3.0..=4.0).contains(&pixel.x), "{pixel}");
    }
    scene.camera = peephole(Vec3::Z, Vec3::Z * 2.0);
    all_are(&render(&scene, &settings(heat(9), 3)), Vec3::ONE, 0.0, "the root alone");
}

#[test]
fn heat_lights_mixes_the_colours_of_lights_as_they_are_chosen() {
    let with_lights = |intensities: [f32; 2], height: f32, translucency: f32| {
        let mut floor_material = Material::default();
        floor_material.inputs.diffuse_transmission_weight = translucency;
        let lights = intensities.map(|intensity| PunctualLight::Point {
            position: Vec3::new(0.0, 0.0, height),
            intensity: Vec3::splat(intensity),
            radius: 0.0,
        });
        let scene = Scene {
            meshes: vec![mesh(&floor(1.0), 0)],
            materials: vec![floor_material],
            lights: lights.into(),
            camera: peephole(Vec3::new(0.3, 0.2, 1.0), Vec3::ZERO),
            ..Scene::default()
        };
        let all = pixels(&render(&scene, &settings(Integrator::HeatLights, 64)));
        all.iter().sum::<DVec3>() / all.len() as f64
    };
    let [first, second] = [with_lights([1.0, 0.0], 1.0, 0.0), with_lights([0.0, 1.0], 1.0, 0.0)];
    assert!(first.distance(second) > 0.5, "{first} {second}");
    let mixed = with_lights([1.0, 3.0], 1.0, 0.0);
    assert!(mixed.distance((first + 3.0 * second) / 4.0) < 0.01, "{mixed} {first} {second}");
    // A leaf receives light from behind, and a board does not.
    assert_eq!([0.0, 0.5].map(|translucency| with_lights([1.0, 0.0], -1.0, translucency)), [DVec3::ZERO, first]);
}
