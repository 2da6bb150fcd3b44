//! Gloss that paths meet after a diffuse surface, made rougher by `filter_glossy`.

use super::*;

/// A floor, and a metal wall beside it, of this roughness, under a lamp; the camera sees the floor, or the wall.
fn floor_and_wall(roughness: f32, sees_wall: bool) -> Scene {
    let at = |x: f32, y: f32, z: f32| Vec3::new(x, y, z);
    let floor = quad([at(0.0, 0.0, 2.0), at(2.0, 0.0, 2.0), at(2.0, 0.0, -2.0), at(0.0, 0.0, -2.0)]);
    let wall = quad([at(0.0, 0.0, 2.0), at(0.0, 0.0, -2.0), at(0.0, 3.0, -2.0), at(0.0, 3.0, 2.0)]);
    let target = if sees_wall { at(0.0, 1.0, 0.0) } else { at(1.5, 0.0, 0.0) };
    let inputs = Inputs {
        base_color: Vec3::new(0.9, 0.7, 0.4),
        base_metalness: 1.0,
        specular_weight: 1.0,
        specular_roughness: roughness,
        ..Inputs::default()
    };
    Scene {
        meshes: vec![mesh(&floor, 0), mesh(&wall, 1)],
        materials: vec![material(Vec3::splat(0.6), Vec3::ZERO), Material { inputs, ..Material::default() }],
        lights: vec![PunctualLight::Point { position: at(1.0, 2.0, 0.5), intensity: Vec3::ONE, radius: 0.0 }],
        camera: Some(CameraPose { eye: at(1.4, 1.5, 0.2), target, up: Vec3::Z, vfov: 20.0 }),
        ..Scene::default()
    }
}

fn picture(scene: &Scene, filter_glossy: f32, max_depth: u32) -> Vec<DVec3> {
    // Paths that aim at lit surfaces depend on means of their albedo.
    let lights = LightSampling::Direct;
    let integrator = Integrator::Path(PathOptions { filter_glossy, max_depth, lights, ..PathOptions::default() });
    pixels(&render(scene, &Settings { width: 16, height: 16, ..settings(integrator, 8) }))
}

#[test]
fn gloss_behind_a_diffuse_surface_is_as_rough_as_asked() {
    let (sharp, rough) = (floor_and_wall(0.1, false), floor_and_wall(0.5, false));
    assert_eq!(picture(&sharp, 0.5, 8), picture(&rough, 0.0, 8));
    assert_ne!(picture(&sharp, 0.0, 8), picture(&rough, 0.0, 8), "the floor shows light from the wall");
    // What is rougher stays, and so do mirrors.
    assert_eq!(picture(&rough, 0.3, 8), picture(&rough, 0.0, 8));
    let mirror = floor_and_wall(0.0, false);
    assert_eq!(picture(&mirror, 0.5, 8), picture(&mirror, 0.0, 8));
}

#[test]
fn gloss_that_the_camera_sees_stays() {
    let scene = floor_and_wall(0.1, true);
    assert_eq!(picture(&scene, 0.5, 2), picture(&scene, 0.0, 2));
    assert!(picture(&scene, 0.0, 2).iter().any(|pixel| *pixel != DVec3::ZERO), "its highlight");
}

/// The camera sees another wall of metal, which shows it the first.
#[test]
fn gloss_that_mirrors_and_gloss_show_the_camera_stays() {
    let shown_by = |roughness: f32| {
        let mut scene = floor_and_wall(0.1, false);
        scene.materials[0] = Material {
            inputs: Inputs { specular_roughness: roughness, ..scene.materials[1].inputs },
            ..Material::default()
        };
        // From the floor to the wall.
        scene.camera.as_mut().unwrap().target = Vec3::new(0.7, 0.0, 0.0);
        let [sharp, filtered] = [0.0, 0.5].map(|least| picture(&scene, least, 3));
        let lit = sharp.iter().filter(|pixel| **pixel != DVec3::ZERO).count();
        (lit, sharp.iter().zip(&filtered).filter(|(sharp, filtered)| sharp != filtered).count())
    };
    let (lit, changed) = shown_by(0.0);
    assert!(lit > 200 && changed == 0, "a mirror: {changed} of {lit} pixels");
    // Few bounces of narrow lobes are wide.
    let (lit, changed) = shown_by(0.05);
    assert!(lit > 200 && changed < lit / 4, "gloss: {changed} of {lit} pixels");
}

#[test]
fn a_roughness_out_of_range_is_refused() {
    for filter_glossy in [-0.1, 1.1, f32::NAN] {
        let options = PathOptions { filter_glossy, ..PathOptions::default() };
        let problem = Integrator::Path(options).check().unwrap_err().to_string();
        assert!(problem.contains("not from 0 to 1"), "{problem}");
    }
}
