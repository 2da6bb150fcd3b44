//! Cameras: pictures by each kind against formulas; and every integrator with every kind.

mod blur;
mod command;
mod kinds;
mod motion;

use glam::{Vec2, Vec3};
use halfdome::scene::{CameraPose, Optics, Scene};
use halfdome_tests::render::{material, mesh};

/// Looks along -z from the origin, with 90 degrees.
const FRONT: CameraPose = CameraPose { eye: Vec3::ZERO, target: Vec3::NEG_Z, up: Vec3::Y, vfov: 90.0 };

/// A disc of `sides` triangles that emits 1 towards +z.
fn disc(centre: Vec3, radius: f32, sides: u32) -> Vec<[Vec3; 3]> {
    let at = |i: u32| {
        let (sin, cos) = (i as f32 / sides as f32 * std::f32::consts::TAU).sin_cos();
        centre + radius * Vec2::new(cos, sin).extend(0.0)
    };
    (0..sides).map(|i| [centre, at(i), at(i + 1)]).collect()
}

/// Triangles that emit 1 from both sides, seen by a camera at the origin.
fn glowing(triangles: &[[Vec3; 3]], optics: Optics) -> Scene {
    let mut glow = material(Vec3::ZERO, Vec3::ONE);
    glow.emits_both_sides = true;
    Scene { meshes: vec![mesh(triangles, 0)], materials: vec![glow], camera: Some(FRONT), optics, ..Scene::default() }
}
