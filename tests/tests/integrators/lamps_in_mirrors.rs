//! Lamps in flat mirrors, at whose images paths aim: as much light as bounces alone find, with less noise.

use halfdome::scene::Sky;

use super::*;

/// How a wall reflects a lamp.
#[derive(Clone, Copy, Debug)]
enum Wall {
    Metal { roughness: f32 },
    Lacquer { roughness: f32 },
}

/// A small floor before a wall that mirrors a lamp of this radius. A card is between the lamp and the floor, which so has light
/// by way of the wall alone.
fn mirrored(wall: Wall, radius: f32) -> Scene {
    let upright = |y: f32, [x0, x1]: [f32; 2], [z0, z1]: [f32; 2]| {
        quad([[x0, z0], [x1, z0], [x1, z1], [x0, z1]].map(|[x, z]| Vec3::new(x, y, z)))
    };
    let lamp: Vec<_> = sphere(1).into_iter().map(|it| it.map(|p| radius * p + Vec3::new(0.0, 1.2, 1.0))).collect();
    let inputs = match wall {
        Wall::Metal { roughness } => Inputs {
            base_color: Vec3::new(0.9, 0.8, 0.7),
            base_metalness: 1.0,
            specular_roughness: roughness,
            ..Inputs::default()
        },
        Wall::Lacquer { roughness } => Inputs { coat_weight: 1.0, coat_roughness: roughness, ..Inputs::default() },
    };
    Scene {
        meshes: vec![
            mesh(&floor(0.5).map(|corners| corners.map(|p| p + Vec3::NEG_Y)), 0),
            mesh(&upright(1.0, [-0.7, 0.7], [0.75, 1.5]), 1),
            mesh(&upright(2.0, [-2.0, 2.0], [0.0, 2.0]), 2),
            mesh(&lamp, 3),
        ],
        materials: vec![
            material(Vec3::splat(0.5), Vec3::ZERO),
            material(Vec3::ZERO, Vec3::ZERO),
            Material { inputs, ..Material::default() },
            material(Vec3::ZERO, Vec3::new(5.0, 4.0, 3.0)),
        ],
        camera: Some(CameraPose { eye: Vec3::new(0.0, -4.0, 3.0), target: Vec3::NEG_Y, up: Vec3::Z, vfov: 4.0 }),
        // A little light besides.
        sky: Sky::constant(Vec3::splat(2e-4)),
        ..Scene::default()
    }
}

#[test]
fn paths_that_aim_find_what_bounces_find() {
    for wall in [Wall::Metal { roughness: 0.0 }, Wall::Metal { roughness: 0.25 }, Wall::Lacquer { roughness: 0.1 }] {
        let scene = mirrored(wall, 0.18);
        let ratio = aimed_by_unaimed(&scene);
        assert!((ratio - 1.0).abs().max_element() < 0.04, "{wall:?}: {ratio}");
    }
}

#[test]
fn gathers_aim_likewise() {
    let scene = mirrored(Wall::Metal { roughness: 0.05 }, 0.06);
    let ratio = cached_by_paths(&scene);
    assert!((ratio - 1.0).abs() < 0.04, "{ratio}");
}

#[test]
fn all_pixels_have_light_from_the_mirror() {
    for wall in [Wall::Metal { roughness: 0.0 }, Wall::Metal { roughness: 0.08 }] {
        let scene = mirrored(wall, 0.1);
        let [aimed, unaimed] = [LightSampling::Mis, LightSampling::Naive].map(|lights| {
            let settings =
                Settings { width: 32, height: 32, spp: 64, integrator: roulette(lights), ..Settings::default() };
            let mut values: Vec<f64> = pixels(&render(&scene, &settings)).iter().map(|value| value.x).collect();
            values.sort_by(f64::total_cmp);
            values
        });
        let middle = aimed.len() / 2;
        // Bounces find the lamp in few pixels, and leave the others to the sky.
        assert!(aimed[middle] > 2.0 * unaimed[middle], "{wall:?}: {} by {}", aimed[middle], unaimed[middle]);
        let even = aimed.iter().filter(|value| (*value / aimed[middle] - 1.0).abs() < 0.4).count();
        assert!(even * 100 >= aimed.len() * 97, "{wall:?}: {even} pixels of {} are alike", aimed.len());
    }
}
