//! Lamps in glass, at which paths aim straight through it: as much light as bounces alone find, with less noise.

use super::*;

/// A floor below a globe of glass of this roughness, and the materials of the floor, the glass and an emissive bulb. The
/// camera sees a part of the floor alone.
fn globe(roughness: f32) -> Scene {
    let middle = 0.7 * Vec3::Z;
    let outside = sphere(3).into_iter().map(|it| it.map(|p| middle + 0.25 * p));
    // The hollow inside has its front towards its middle.
    let hollow = sphere(3).into_iter().map(|[a, b, c]| [a, c, b].map(|p| middle + 0.24 * p));
    let mut shell = mesh(&outside.chain(hollow).collect::<Vec<_>>(), 1);
    // Smooth: flat faces of clear glass would be panes, which light samples go through.
    let count = shell.positions.len();
    let normal = |(number, p): (usize, &Vec3)| (*p - middle).normalize() * if 2 * number < count { 1.0 } else { -1.0 };
    shell.normals = shell.positions.iter().enumerate().map(normal).collect();
    let inputs = Inputs { transmission_weight: 1.0, specular_roughness: roughness, ..Inputs::default() };
    Scene {
        meshes: vec![mesh(&floor(3.0), 0), shell],
        materials: vec![
            material(Vec3::splat(0.5), Vec3::ZERO),
            Material { inputs, ..Material::default() },
            material(Vec3::ZERO, Vec3::new(5.0, 4.0, 3.0)),
        ],
        camera: Some(CameraPose { eye: Vec3::new(0.0, -4.0, 3.0), target: Vec3::NEG_Y, up: Vec3::Z, vfov: 6.0 }),
        ..Scene::default()
    }
}

/// With a bulb in the globe, of this radius.
fn bulb(roughness: f32, radius: f32) -> Scene {
    let mut scene = globe(roughness);
    let bulb: Vec<_> = sphere(1).into_iter().map(|it| it.map(|p| radius * p + 0.7 * Vec3::Z)).collect();
    scene.meshes.push(mesh(&bulb, 2));
    scene
}

/// With a point light in it, whose light glass lets out alone if it is rough.
fn point(roughness: f32) -> Scene {
    let light = PunctualLight::Point { position: 0.7 * Vec3::Z, intensity: Vec3::ONE, radius: 0.0 };
    Scene { lights: vec![light], ..globe(roughness) }
}

#[test]
fn paths_that_aim_find_what_bounces_find() {
    for roughness in [0.0, 0.3, 0.8] {
        let scene = bulb(roughness, 0.18);
        let ratio = aimed_by_unaimed(&scene);
        assert!((ratio - 1.0).abs().max_element() < 0.03, "roughness {roughness}: {ratio}");
    }
}

#[test]
fn points_in_rough_glass_give_what_light_samples_alone_find() {
    for roughness in [0.4, 0.8] {
        let scene = point(roughness);
        let [aimed, unaimed] = [(LightSampling::Mis, 1024), (LightSampling::Direct, 2048)]
            .map(|(lights, spp)| estimate(&scene, roulette(lights), spp).mean.x);
        assert!((aimed / unaimed - 1.0).abs() < 0.04, "roughness {roughness}: {aimed}, {unaimed}");
    }
}

#[test]
fn gathers_aim_likewise() {
    let scene = bulb(0.3, 0.06);
    let ratio = cached_by_paths(&scene);
    assert!((ratio - 1.0).abs() < 0.04, "{ratio}");
}

#[test]
fn aimed_paths_have_less_noise() {
    for (name, scene, least) in [
        ("a filament in clear glass", bulb(0.0, 0.01), 100.0),
        ("a bulb in frosted glass", bulb(0.3, 0.03), 15.0),
        ("a point in frosted glass", point(0.4), 5.0),
    ] {
        let [aimed, unaimed] = [LightSampling::Mis, LightSampling::Direct].map(|lights| variance(&scene, lights));
        assert!(unaimed > least * aimed, "{name}: variance {aimed}, without aim {unaimed}");
    }
}
