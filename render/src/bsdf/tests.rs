use halfdome_kernel::sampling::warp::{CosineHemisphere, Warp};

use super::*;
use crate::scene::{CameraPose, Material, Mesh, Scene};

/// A triangle in the plane z = 0, whose front is above.
fn world(inputs: Inputs) -> World {
    world_of(Material { inputs, ..Material::default() })
}

fn world_of(material: Material) -> World {
    let positions = vec![Vec3::ZERO, Vec3::X, Vec3::Y];
    let mesh = Mesh { positions, triangles: vec![[0, 1, 2]], ..Mesh::default() };
    let camera = CameraPose { eye: Vec3::Z, target: Vec3::ZERO, up: Vec3::Y, vfov: 40.0 };
    World::new(Scene { meshes: vec![mesh], materials: vec![material], camera: Some(camera), ..Scene::default() })
        .unwrap()
}

/// The closure in the middle of it, seen along `incoming`, with another shading normal if there is one.
fn scattering(inputs: Inputs, incoming: Vec3, shading_normal: Option<Vec3>) -> Scattering<Closure> {
    let world = world(inputs);
    let mut surface = world.surface(0, 0.25, 0.25).facing(incoming);
    surface.shading_normal = shading_normal.unwrap_or(surface.shading_normal);
    world.scattering(&mut surface)
}

fn grid(side: u32) -> impl Iterator<Item = Vec2> {
    (0..side * side).map(move |i| (Vec2::new((i % side) as f32, (i / side) as f32) + 0.5) / side as f32)
}

const INCOMING: Vec3 = Vec3::new(0.6, 0.0, -0.8);

fn metal(roughness: f32) -> Inputs {
    Inputs { base_color: Vec3::ONE, base_metalness: 1.0, specular_roughness: roughness, ..Inputs::default() }
}

fn glass() -> Inputs {
    Inputs { specular_weight: 1.0, specular_roughness: 0.0, transmission_weight: 1.0, ..Inputs::default() }
}

#[test]
fn a_mirror_has_one_direction_of_infinite_density() {
    let mirror = scattering(metal(0.0), INCOMING, None);
    for u in grid(8) {
        let bounce = mirror.sample(u).unwrap();
        assert!(bounce.direction.abs_diff_eq(Vec3::new(0.6, 0.0, 0.8), 1e-6), "{}", bounce.direction);
        assert_eq!(bounce.density, f32::INFINITY);
        assert!(bounce.weight.abs_diff_eq(Vec3::ONE, 1e-5), "{}", bounce.weight);
        assert_eq!(mirror.eval(bounce.direction), (Vec3::ZERO, 0.0), "nothing is left for light samples");
    }
}

#[test]
fn glass_bends_by_snells_law_from_both_sides() {
    for (incoming, ratio) in [(INCOMING, 1.0 / 1.5), (-INCOMING, 1.5)] {
        let glass = scattering(glass(), incoming, None);
        let mut refractions = 0;
        for bounce in grid(64).filter_map(|u| glass.sample(u)) {
            assert_eq!(bounce.density, f32::INFINITY);
            assert!((bounce.direction.length() - 1.0).abs() < 1e-6);
            if bounce.direction.z * incoming.z < 0.0 {
                assert!(bounce.direction.abs_diff_eq(incoming * Vec3::new(1.0, 1.0, -1.0), 1e-6));
            } else {
                refractions += 1;
                assert!((bounce.direction.x - incoming.x * ratio).abs() < 1e-5, "{}", bounce.direction);
            }
        }
        assert!(refractions > 3000, "{refractions}");
    }
}

#[test]
fn samples_agree_with_their_evaluation_in_the_world() {
    let layered = Inputs { specular_weight: 1.0, specular_roughness: 0.4, ..Inputs::default() };
    for inputs in [Inputs::default(), layered, metal(0.5)] {
        for normal in [None, Some(Vec3::new(0.3, -0.2, 0.9).normalize())] {
            let scattering = scattering(inputs, INCOMING, normal);
            let bounces: Vec<_> = grid(30).filter_map(|u| scattering.sample(u)).collect();
            assert!(bounces.len() > 300);
            for bounce in bounces {
                let (scattered, density) = scattering.eval(bounce.direction);
                assert!((density - bounce.density).abs() <= 1e-3 * density, "{density}, {}", bounce.density);
                assert!(scattered.abs_diff_eq(bounce.weight * bounce.density, 1e-3 * (1.0 + density)), "{scattered}");
            }
        }
    }
}

#[test]
fn light_stays_on_its_side_of_the_triangle() {
    // Shading normals that lean away from the view, and towards it.
    for normal in [Vec3::new(0.9, 0.0, 0.43), Vec3::new(-0.9, 0.1, 0.4), Vec3::new(0.6, 0.75, 0.1)] {
        for inputs in [Inputs::default(), metal(0.0), metal(0.3)] {
            let scattering = scattering(inputs, INCOMING, Some(normal.normalize()));
            for bounce in grid(16).filter_map(|u| scattering.sample(u)) {
                assert!(bounce.direction.z > 0.0, "{inputs:?}, {normal}: {}", bounce.direction);
                assert_eq!(scattering.eval(Vec3::new(0.6, 0.0, -0.8)), (Vec3::ZERO, 0.0));
            }
        }
    }
}

#[test]
fn matte_surfaces_reflect_as_their_closures_do() {
    let inputs = Inputs { base_color: Vec3::new(0.1, 0.5, 0.9), ..Inputs::default() };
    let world = world(inputs);
    for normal in [Vec3::Z, Vec3::new(0.3, -0.2, 0.9), Vec3::new(-0.7, 0.1, 0.6)].map(Vec3::normalize) {
        let surface = Surface { shading_normal: normal, ..world.surface(0, 0.25, 0.25).facing(-Vec3::Z) };
        let scattering = world.scattering(&mut surface.clone());
        for u in grid(16) {
            let (bounce, goes_on) = surface.scatter(CosineHemisphere.map(u));
            let (expected, density) = scattering.eval(bounce.direction);
            let shadowing = surface.bump_shadowing(bounce.direction);
            assert!(goes_on && (bounce.density - density).abs() < 1e-5, "{bounce:?}, {density}");
            assert!(
                (bounce.weight * shadowing * density).abs_diff_eq(expected, 1e-5),
                "{bounce:?}, {shadowing}, {expected}"
            );
            assert!((surface.lambert(bounce.direction) - density).abs() < 1e-5, "{bounce:?}, {density}");
            assert_eq!(shadowing == Vec3::ONE, normal == Vec3::Z);
        }
    }
}

/// What a white surface reflects is what it receives.
#[test]
fn white_surfaces_receive_all_light_whatever_their_bumps() {
    let world = world(Inputs { base_color: Vec3::splat(0.2), ..Inputs::default() });
    let surface = world.surface(0, 0.25, 0.25).facing(-Vec3::Z);
    let surface = Surface { shading_normal: Vec3::new(0.5, 0.0, 0.8).normalize(), ..surface };
    let low = Vec3::new(0.99, 0.0, 0.14).normalize();
    assert!(surface.white().eval(low).0.abs_diff_eq(Vec3::splat(surface.lambert(low)), 1e-6));
}

/// Bumps below a coat that is smooth keep no light from it.
#[test]
fn bumps_below_a_smooth_coat_cast_no_shadows() {
    let inputs = Inputs { base_color: Vec3::ZERO, coat_weight: 1.0, coat_roughness: 0.3, ..Inputs::default() };
    let reflected = |coat_normal: CoatNormal| {
        let material = Material { inputs, coat_normal, ..Material::default() };
        let world = world_of(material);
        let surface = world.surface(0, 0.25, 0.25).facing(Vec3::new(0.9, 0.0, -0.3).normalize());
        let surface = Surface { shading_normal: Vec3::new(0.0, 0.5, 0.85).normalize(), ..surface };
        world.scattering(&mut surface.clone()).eval(Vec3::new(0.9, 0.0, 0.3).normalize()).0.x
    };
    let smooth = scattering(inputs, Vec3::new(0.9, 0.0, -0.3).normalize(), None);
    let expected = smooth.eval(Vec3::new(0.9, 0.0, 0.3).normalize()).0.x;
    let found = reflected(CoatNormal::OfVertices);
    assert!((found / expected - 1.0).abs() < 0.01 && expected > 0.1, "{found}, {expected}");
}
