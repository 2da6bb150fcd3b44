//! Long, thin emissive triangles, such as LED strips, close to what they light.

use std::collections::BTreeMap;

use glam::{DVec3, Vec3};
use halfdome::scene::{CameraPose, Motion, Scene};
use halfdome::settings::{Integrator, Settings};
use halfdome_tests::render::{material, mesh, quad, seeds};

use crate::{EMISSION, SIZE, check, expected, form_factor, plane, reflected, settings};

/// The strip's.
const CORNERS: [[f32; 3]; 4] = [[-2.0, 0.05, -0.02], [2.0, 0.05, -0.02], [2.0, 0.05, 0.0], [-2.0, 0.05, 0.0]];

/// A strip of 4 m by 2 cm, 5 cm above the plane, which it lights, and the radiance of each pixel.
fn strip() -> (Scene, Vec<DVec3>) {
    let mut scene = plane();
    let camera =
        CameraPose { eye: Vec3::new(0.0, 1.0, 1.2), target: Vec3::new(0.0, 0.0, 0.35), up: Vec3::Y, vfov: 12.0 };
    scene.camera = Some(camera);
    let corners = CORNERS.map(Vec3::from);
    scene.materials.push(material(Vec3::ZERO, EMISSION));
    scene.meshes.push(mesh(&quad(corners), 1));
    let corners = corners.map(|corner| corner.as_dvec3());
    let radiance = |point| reflected(EMISSION.as_dvec3() * form_factor(point, DVec3::Y, &corners));
    let expected = expected(&scene, 0.0, radiance);
    (scene, expected)
}

#[test]
fn a_strip_lights_the_plane_by_lamberts_formula() {
    let (scene, expected) = strip();
    check(&scene, &expected, 0.03);
}

/// Samples of whole triangles have thirty times the error of paths: 0.17.
#[test]
fn samples_look_at_the_part_of_a_strip_that_is_close() {
    let (scene, expected) = strip();
    // Light samples alone are noisier.
    for (name, most) in [("path", 0.01), ("direct", 0.03)] {
        let integrator = Integrator::named(name).unwrap();
        let error = |pixels: &Vec<DVec3>| {
            let squares = pixels.iter().zip(&expected);
            squares.map(|(pixel, expected)| (pixel.y / expected.y - 1.0).powi(2)).sum::<f64>()
                / f64::from(SIZE.0 * SIZE.1)
        };
        let renders = seeds(&scene, &Settings { spp: 16, integrator, ..settings() }, 16);
        let error = renders.iter().map(error).sum::<f64>() / 16.0;
        assert!(error < most, "{error} by {name}");
    }
}

#[test]
fn a_strip_that_moves_lights_the_plane_as_it_does_in_the_mean_over_its_places() {
    const PLACES: u32 = 64;
    let (mut scene, _) = strip();
    let by = Vec3::new(0.5, 0.05, 0.3);
    let keys = [-0.5, 0.0, 0.5].map(|at| scene.meshes[1].positions.iter().map(|&p| p + at * by).collect());
    scene.motion = Some(Motion { keys: 3, meshes: BTreeMap::from([(1, keys.to_vec())]), ..Motion::default() });
    let radiance = |point| {
        let place = |i: u32| (f64::from(i) + 0.5) / f64::from(PLACES) - 0.5;
        let form_factor = |at: f64| {
            let corners = CORNERS.map(|corner| Vec3::from(corner).as_dvec3() + at * by.as_dvec3());
            form_factor(point, DVec3::Y, &corners)
        };
        let all: f64 = (0..PLACES).map(|i| form_factor(place(i))).sum();
        reflected(EMISSION.as_dvec3() * (all / f64::from(PLACES)))
    };
    // The light tree knows the middle of the motion alone, so noise is greater.
    check(&scene, &expected(&scene, 0.0, radiance), 0.2);
}
