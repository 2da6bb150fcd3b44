use super::*;
use crate::scene::{CameraPose, Material, Mesh, Scene};
use crate::world::World;

/// A triangle in the plane z = 0, its front up, of this material.
fn world(material: Material) -> World {
    let positions = vec![Vec3::ZERO, Vec3::X, Vec3::Y];
    let mesh = Mesh { positions, triangles: vec![[0, 1, 2]], ..Mesh::default() };
    let camera = CameraPose { eye: Vec3::Z, target: Vec3::ZERO, up: Vec3::Y, vfov: 40.0 };
    World::new(Scene { meshes: vec![mesh], materials: vec![material], camera: Some(camera), ..Scene::default() })
        .unwrap()
}

fn grid(side: u32) -> impl Iterator<Item = Vec2> {
    (0..side * side).map(move |i| (Vec2::new((i % side) as f32, (i / side) as f32) + 0.5) / side as f32)
}

const INCOMING: Vec3 = Vec3::new(0.6, 0.0, -0.8);

fn material(diffuse: f32, specular: Specular) -> Material {
    Material { diffuse: Vec3::splat(diffuse), specular, ..Material::default() }
}

#[test]
fn a_mirror_has_one_direction_of_infinite_density() {
    let reflectance = Vec3::new(0.9, 0.8, 0.7);
    let world = world(material(0.0, Specular::Mirror { reflectance }));
    let surface = world.surface(0, 0.25, 0.25).facing(INCOMING);
    for u in grid(8) {
        let bounce = surface.sample(INCOMING, u).unwrap();
        assert!(bounce.direction.abs_diff_eq(Vec3::new(0.6, 0.0, 0.8), 1e-6), "{}", bounce.direction);
        assert_eq!((bounce.weight, bounce.density), (reflectance, f32::INFINITY));
        assert_eq!(surface.evaluate(bounce.direction), (Vec3::ZERO, 0.0), "nothing is left for light samples");
    }
}

#[test]
fn glass_bends_by_snells_law_and_shares_by_fresnels() {
    let transmittance = Vec3::new(1.0, 0.5, 0.25);
    let world = world(material(0.0, Specular::Glass { ior: 1.5, transmittance }));
    for (incoming, ratio) in [(INCOMING, 1.0 / 1.5), (-INCOMING, 1.5)] {
        let surface = world.surface(0, 0.25, 0.25).facing(incoming);
        let (reflected, beyond) = dielectric::fresnel(0.8, ratio);
        let mut reflections = 0;
        for u in grid(64) {
            let bounce = surface.sample(incoming, u).unwrap();
            assert_eq!(bounce.density, f32::INFINITY);
            assert!((bounce.direction.length() - 1.0).abs() < 1e-6);
            if bounce.direction.z * incoming.z < 0.0 {
                reflections += 1;
                assert_eq!(bounce.weight, Vec3::ONE);
                assert!(bounce.direction.abs_diff_eq(incoming * Vec3::new(1.0, 1.0, -1.0), 1e-6));
            } else {
                assert_eq!(bounce.weight, transmittance);
                assert!((bounce.direction.x - incoming.x * ratio).abs() < 1e-6, "{}", bounce.direction);
                assert!((bounce.direction.z.abs() - beyond).abs() < 1e-6, "{}", bounce.direction);
            }
        }
        assert!((reflections as f32 / 4096.0 - reflected).abs() < 1.0 / 64.0, "{reflections}, {reflected}");
    }
}

/// In a white furnace of radiance 1 a surface sends back its reflectance: the mean of all weights.
#[test]
fn weights_add_up_to_the_reflectance() {
    for (material, expected) in [
        (material(0.7, Specular::None), 0.7),
        (material(0.0, Specular::Mirror { reflectance: Vec3::splat(0.9) }), 0.9),
        (material(0.3, Specular::Mirror { reflectance: Vec3::splat(0.6) }), 0.9),
        (material(0.0, Specular::Glass { ior: 1.33, transmittance: Vec3::ONE }), 1.0),
        (material(0.0, Specular::None), 0.0),
    ] {
        let world = world(material);
        let surface = world.surface(0, 0.25, 0.25).facing(INCOMING);
        let weights = grid(60).filter_map(|u| surface.sample(INCOMING, u)).map(|bounce| f64::from(bounce.weight.x));
        let mean = weights.sum::<f64>() / 3600.0;
        assert!((mean - expected).abs() < 1e-6, "{:?}: {mean}, not {expected}", surface.material);
    }
}

/// `sample` and `evaluate` speak of the same function: `weight * density` is `f cos θ` where the density is finite.
#[test]
fn samples_agree_with_their_evaluation() {
    for material in [material(0.7, Specular::None), material(0.3, Specular::Mirror { reflectance: Vec3::splat(0.6) })] {
        let world = world(material);
        let surface = world.surface(0, 0.25, 0.25).facing(INCOMING);
        let bounces: Vec<_> = grid(30).filter_map(|u| surface.sample(INCOMING, u)).collect();
        let diffuse: Vec<_> = bounces.iter().filter(|bounce| bounce.density.is_finite()).collect();
        assert!(diffuse.len() >= 300);
        for bounce in diffuse {
            let (reflected, density) = surface.evaluate(bounce.direction);
            // The density's share of mirrors and its share in `weight` cancel.
            assert!((density - bounce.density).abs() <= 1e-6 * density);
            assert!(reflected.abs_diff_eq(bounce.weight * bounce.density, 1e-6), "{reflected}");
        }
    }
}
