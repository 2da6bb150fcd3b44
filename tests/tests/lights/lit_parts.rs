//! Parts of surfaces that the sun or the sky lights: paths sample them as lights, which must change nothing but noise.

use glam::Vec3;
use halfdome::material::Inputs;
use halfdome::scene::{CameraPose, Material, PunctualLight, Scene, Sky};
use halfdome_tests::render::{material, mesh, quad};

use crate::secondary::{compare_in, hollow};

/// A wall at `x` from `y` 0 to 3 and from `z` 0 to 4, with a hole between these corners.
fn wall_with_hole(x: f32, [low, high]: [[f32; 2]; 2]) -> Vec<[Vec3; 3]> {
    let part = |[y0, z0]: [f32; 2], [y1, z1]: [f32; 2]| {
        quad([[y0, z0], [y0, z1], [y1, z1], [y1, z0]].map(|[y, z]| Vec3::new(x, y, z)))
    };
    [
        part([0.0, 0.0], [low[0], 4.0]),
        part([high[0], 0.0], [3.0, 4.0]),
        part([low[0], 0.0], [high[0], low[1]]),
        part([low[0], high[1]], [high[0], 4.0]),
    ]
    .concat()
}

/// A room of 4 by 3 by 4 metres with a window in the wall at `x` 4, seen from there.
fn room(window: [[f32; 2]; 2]) -> Scene {
    let mut walls = hollow(Vec3::ZERO, Vec3::new(4.0, 3.0, 4.0));
    walls.retain(|triangle| triangle.iter().any(|corner| corner.x < 4.0));
    walls.extend(wall_with_hole(4.0, window));
    Scene {
        meshes: vec![mesh(&walls, 0)],
        materials: vec![material(Vec3::new(0.7, 0.65, 0.6), Vec3::ZERO)],
        camera: Some(CameraPose {
            eye: Vec3::new(3.8, 1.6, 0.4),
            target: Vec3::new(0.0, 1.4, 2.6),
            up: Vec3::Y,
            vfov: 60.0,
        }),
        ..Scene::default()
    }
}

/// A slit lets the sun light a hundredth of the floor, whose two triangles are the largest of the scene.
#[test]
fn aiming_at_the_sunlit_part_of_a_floor() {
    let mut scene = room([[1.2, 1.8], [1.5, 2.2]]);
    let direction = Vec3::new(-1.0, -1.0, 0.1).normalize();
    scene.lights.push(PunctualLight::Directional { direction, irradiance: Vec3::splat(60.0), half_angle: 0.0 });
    compare_in(&scene, 2.0);
}

/// A curtain that transmits the light of the sky is the brightest surface of a room.
#[test]
fn aiming_at_a_curtain_before_the_sky() {
    let mut scene = room([[1.0, 1.6], [2.0, 2.4]]);
    scene.sky = Sky { radiance: Vec3::new(4.0, 5.0, 6.0), picture: None };
    let curtain = [[0.9, 1.5], [0.9, 2.5], [2.1, 2.5], [2.1, 1.5]].map(|[y, z]| Vec3::new(3.95, y, z));
    scene.meshes.push(mesh(&quad(curtain), 1));
    let inputs = Inputs {
        base_color: Vec3::splat(0.6),
        diffuse_transmission_weight: 0.6,
        diffuse_transmission_color: Vec3::splat(0.9),
        ..Inputs::default()
    };
    scene.materials.push(Material { inputs, ..Material::default() });
    compare_in(&scene, 1.5);
}

/// The part of the ceiling that a spot light shines at sends most of the light.
#[test]
fn aiming_at_a_ceiling_above_an_uplight() {
    let mut scene = room([[1.4, 1.6], [1.8, 2.0]]);
    scene.lights.push(PunctualLight::Spot {
        position: Vec3::new(1.5, 1.2, 2.5),
        direction: Vec3::Y,
        intensity: Vec3::splat(30.0),
        radius: 0.0,
        cos_inner: 0.95,
        cos_outer: 0.94,
        edge: Default::default(),
    });
    compare_in(&scene, 1.3);
}
