//! The sun of a sky picture in mirrors and behind glass that bends its light: as a directional light of its size.

use std::f64::consts::{PI, TAU};

use glam::{DVec3, Vec3};
use halfdome::irradiance::{Part, Request, Sensor, by_paths};
use halfdome::material::Inputs;
use halfdome::scene::{CameraPose, Material, PunctualLight, Scene, Sky, SkyPicture};
use halfdome::world::World;
use halfdome_tests::render::{Estimate, NeverStops, mesh, quad};

use crate::panes_everywhere::integrators;
use crate::{means, plane};

const WIDTH: u32 = 1024;
const HEIGHT: u32 = WIDTH / 2;
/// In radians.
const HALF_ANGLE: f64 = 0.02;
const RADIANCE: DVec3 = DVec3::new(9000.0, 7000.0, 4000.0);

/// A sky that is black but for a sun in a direction, and the irradiance that this causes.
fn sky_with_sun(to_sun: DVec3) -> (Sky, DVec3) {
    let mut irradiance = DVec3::ZERO;
    let mut texel = |number: u32| {
        let row = f64::from(number / WIDTH);
        let [theta, phi] =
            [PI / f64::from(HEIGHT) * (row + 0.5), TAU * (f64::from(number % WIDTH) + 0.5) / f64::from(WIDTH) - PI];
        let direction = DVec3::new(theta.sin() * phi.sin(), theta.cos(), -theta.sin() * phi.cos());
        if direction.angle_between(to_sun) > HALF_ANGLE {
            return Vec3::ZERO;
        }
        irradiance += RADIANCE * (theta.sin() * PI / f64::from(HEIGHT) * TAU / f64::from(WIDTH));
        RADIANCE.as_vec3()
    };
    let texels = (0..WIDTH * HEIGHT).map(&mut texel).collect();
    (Sky { radiance: Vec3::ZERO, picture: Some(SkyPicture::new(WIDTH, HEIGHT, texels)) }, irradiance)
}

/// The same scene below the picture and below a directional light.
fn skies(scene: &Scene, to_sun: DVec3) -> [Scene; 2] {
    let (sky, irradiance) = sky_with_sun(to_sun);
    let (direction, irradiance) = (-to_sun.as_vec3(), irradiance.as_vec3());
    let light = PunctualLight::Directional { direction, irradiance, half_angle: HALF_ANGLE as f32 };
    [Scene { sky, ..scene.clone() }, Scene { lights: vec![light], ..scene.clone() }]
}

fn smooth(inputs: Inputs) -> Material {
    Material { inputs: Inputs { specular_roughness: 0.0, ..inputs }, ..Material::default() }
}

/// A wall of metal that faces the sun.
fn below_a_mirror() -> (Scene, DVec3) {
    let mut scene = plane();
    scene.materials.push(smooth(Inputs {
        base_metalness: 1.0,
        base_color: Vec3::new(0.9, 0.7, 0.5),
        ..Inputs::default()
    }));
    let wall = [[1.5, 0.0, -4.0], [1.5, 0.0, 6.0], [1.5, 3.0, 6.0], [1.5, 3.0, -4.0]].map(Vec3::from);
    scene.meshes.push(mesh(&quad(wall), 1));
    (scene, DVec3::new(-0.6, 0.7, 0.2).normalize())
}

/// A prism that lies across the view, with an edge up.
fn below_a_prism() -> (Scene, DVec3) {
    let mut scene = plane();
    let glass = Inputs { transmission_weight: 1.0, specular_weight: 1.0, ..Inputs::default() };
    scene.materials.push(smooth(glass));
    let [near, far] = [-1.0, 1.6].map(|z| [[-0.5, 0.4, z], [0.7, 0.4, z], [0.1, 1.0, z]].map(Vec3::from));
    let sides = [[0, 1], [1, 2], [2, 0]].map(|[a, b]| quad([near[a], far[a], far[b], near[b]]));
    let ends = [far, [near[0], near[2], near[1]]];
    scene.meshes.push(mesh(&[sides.concat(), ends.to_vec()].concat(), 1));
    (scene, DVec3::new(-0.3, 0.9, 0.1).normalize())
}

/// The picture's border is less sharp, and paths find neither by chance.
fn check(what: &str, found: &[DVec3], expected: &[DVec3]) {
    let [found, expected] = [found, expected].map(Estimate::of);
    let z = found.z(&expected, 5e-3).max_element();
    let scatter = (found.error / found.mean).max_element();
    assert!(z < 4.5 && scatter < 0.01, "{what}: {found:?}, not {expected:?}; z {z}, scatter {scatter}");
}

#[test]
fn all_integrators_find_it_in_mirrors_and_through_glass() {
    for (what, (scene, to_sun)) in [("mirror", below_a_mirror()), ("prism", below_a_prism())] {
        let [picture, light] = skies(&scene, to_sun);
        for (name, integrator) in integrators() {
            check(&format!("{what}, {name}"), &means(&picture, &integrator, 8), &means(&light, &integrator, 8));
        }
    }
}

/// Gloss sees it in mirrors.
#[test]
fn gloss_sees_it_in_mirrors() {
    let (mut scene, _) = below_a_mirror();
    // It is low behind the camera, before which the wall is.
    let to_sun = DVec3::new(-0.156, 0.31, 0.94).normalize();
    let wall = [[-9.0, 0.0, -3.0], [9.0, 0.0, -3.0], [9.0, 6.0, -3.0], [-9.0, 6.0, -3.0]].map(Vec3::from);
    scene.meshes[1] = mesh(&quad(wall), 1);
    for (base_metalness, specular_roughness) in [(0.0, 0.3), (1.0, 0.2), (1.0, 0.4)] {
        let inputs = Inputs { base_color: Vec3::splat(0.5), base_metalness, specular_roughness, ..Inputs::default() };
        scene.materials[0] = Material { inputs, ..Material::default() };
        let [picture, light] = skies(&scene, to_sun);
        let [.., (name, path)] = integrators();
        let [found, expected] = [&picture, &light].map(|scene| Estimate::of(&means(scene, &path, 8)));
        let z = found.z(&expected, 5e-3).max_element();
        let off = ((found.mean - expected.mean) / expected.mean).abs().max_element();
        assert!(
            z < 4.5 && off < 0.05,
            "{name}, {base_metalness}, {specular_roughness}: {found:?}, not {expected:?}; z {z}"
        );
    }
}

#[test]
fn sensors_find_it_in_mirrors_and_through_glass() {
    for (what, (scene, to_sun)) in [("mirror", below_a_mirror()), ("prism", below_a_prism())] {
        let sensors: Vec<Sensor> =
            (0..16).map(|i| Sensor { position: Vec3::new(0.06 * i as f32, 0.0, 0.5), normal: Vec3::Y }).collect();
        let [found, expected] = skies(&scene, to_sun).map(|scene| -> Vec<DVec3> {
            let world = World::new(scene).unwrap();
            let run = |seed| {
                let request = Request { spp: 64, seed, part: Part::Total };
                let values = by_paths(&world, &sensors, &request, &NeverStops).values;
                values.iter().map(|value| value.as_dvec3()).sum::<DVec3>() / sensors.len() as f64
            };
            (0..8).map(run).collect()
        });
        check(what, &found, &expected);
    }
}

/// The plane below glass whose upper face slopes by an angle in degrees.
fn below_a_wedge(floor: Material, slope: f32) -> Scene {
    let glass = smooth(Inputs { transmission_weight: 1.0, specular_weight: 1.0, ..Inputs::default() });
    let mut scene = Scene { materials: vec![floor, glass], ..plane() };
    let corners = [[-3.0, -3.0], [-3.0, 3.0], [3.0, 3.0], [3.0, -3.0]];
    let top = corners.map(|[x, z]| Vec3::new(x, 2.3 + slope.to_radians().tan() * x, z));
    let bottom = corners.map(|[x, z]| Vec3::new(x, 2.0, z));
    let below = quad(bottom).map(|[a, b, c]| [a, c, b]);
    scene.meshes.push(mesh(&[quad(top), below].concat(), 1));
    scene
}

/// Faces that differ by 2° count as parallel for shadow rays, and connections find the light through them too.
#[test]
fn light_through_a_wedge_counts_once() {
    let scene = below_a_wedge(Material::matte(Vec3::splat(0.01)), 2.0);
    let to_sun = DVec3::new(0.3, 0.9, 0.1).normalize();
    let [picture, light] = skies(&scene, to_sun);
    let (_, irradiance) = sky_with_sun(to_sun);
    let all = integrators();
    for ((what, scene), (name, integrator)) in
        [("picture", picture), ("light", light)].iter().flat_map(|scene| all.iter().map(move |it| (scene, it)))
    {
        let found = Estimate::of(&means(scene, integrator, 8)).mean;
        let expected = irradiance * (to_sun.y * 0.01 / PI * 0.96 * 0.96);
        let off = ((found - expected) / expected).abs().max_element();
        assert!(off < 0.01, "{what}, {name}: {found}, not {expected}");
    }
}

/// Gloss, whose bounces look for lights behind panes: hardly otherwise than below a plate. Of a lamp that is wider than
/// the lobe, bounces would find most again.
#[test]
fn gloss_below_a_wedge_is_as_bright_as_below_a_plate() {
    let to_sun = DVec3::new(0.3, 0.9, 0.1).normalize();
    let inputs = Inputs { base_metalness: 1.0, specular_roughness: 0.15, ..Inputs::default() };
    let [.., (name, path)] = integrators();
    let position = 20.0 * to_sun.as_vec3();
    let lamp = PunctualLight::Point { position, intensity: 4000.0 * Vec3::ONE, radius: 2.0 };
    let [wedge, plate] = [2.0, 0.0].map(|slope| {
        let mut scene = below_a_wedge(Material { inputs, ..Material::default() }, slope);
        // It looks at where the sun is mirrored.
        let eye = 1.5 * (to_sun * DVec3::new(-1.0, 1.0, -1.0)).as_vec3();
        scene.camera = Some(CameraPose { eye, target: Vec3::ZERO, up: Vec3::X, vfov: 30.0 });
        let [picture, light] = skies(&scene, to_sun);
        let lamp = Scene { lights: vec![lamp.clone()], ..scene };
        [picture, light, lamp].map(|scene| Estimate::of(&means(&scene, &path, 32)).mean)
    });
    for ((what, wedge), plate) in ["picture", "light", "lamp"].into_iter().zip(wedge).zip(plate) {
        let off = (wedge / plate - 1.0).abs().max_element();
        assert!(off < 0.03, "{what}, {name}: {wedge} and {plate}");
    }
}
