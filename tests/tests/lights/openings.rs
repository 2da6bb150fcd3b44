//! Rooms that the sky lights through a window: paths look for it there, which must change nothing but noise.

use glam::{DVec3, Vec3};
use halfdome::material::Inputs;
use halfdome::scene::{CameraPose, Material, Scene, Sky, SkyPicture};
use halfdome::settings::{Integrator, LightSampling, PathOptions, Settings, Stop};
use halfdome_tests::render::{Estimate, material, mesh, quad, seeds};

use crate::secondary::{hollow, picture};
use crate::{SIZE, check_settings, expected, form_factor, plane, reflected, settings};

pub(crate) const LOW: Vec3 = Vec3::new(-3.0, 0.0, -3.0);
const HIGH: Vec3 = Vec3::new(2.5, 3.0, 6.0);
/// The window's corners in y and z.
pub(crate) const WINDOW: [[f32; 2]; 2] = [[0.9, 0.4], [1.8, 1.5]];
const SKY: Vec3 = Vec3::new(4.0, 5.0, 6.0);

/// A box that is open below, with a window in the wall at the greatest x.
fn walls() -> Vec<[Vec3; 3]> {
    let mut walls = hollow(LOW, HIGH);
    walls.retain(|triangle| {
        triangle.iter().any(|corner| corner.x < HIGH.x) && triangle.iter().any(|corner| corner.y > 0.0)
    });
    let [low, high] = WINDOW;
    for [[y0, z0], [y1, z1]] in [
        [[LOW.y, LOW.z], [HIGH.y, low[1]]],
        [[LOW.y, high[1]], [HIGH.y, HIGH.z]],
        [[LOW.y, low[1]], [low[0], high[1]]],
        [[high[0], low[1]], [HIGH.y, high[1]]],
    ] {
        walls.extend(quad([[y0, z0], [y0, z1], [y1, z1], [y1, z0]].map(|[y, z]| Vec3::new(HIGH.x, y, z))));
    }
    walls
}

/// A sky of one colour, as a constant and as a picture.
fn skies() -> [Sky; 2] {
    let picture = SkyPicture::new(6, 4, vec![SKY; 24]);
    [Sky::constant(SKY), Sky { radiance: Vec3::ZERO, picture: Some(picture) }]
}

fn path(lights: LightSampling) -> Settings {
    let options = PathOptions { lights, ..PathOptions::default() };
    Settings { integrator: Integrator::Path(options), ..settings() }
}

/// Among black walls the floor has what Lambert's formula says of the window.
#[test]
fn a_window_lights_the_floor_of_a_black_room_by_lamberts_formula() {
    let mut scene = plane();
    scene.meshes.push(mesh(&walls(), 1));
    scene.materials.push(material(Vec3::ZERO, Vec3::ZERO));
    let [low, high] = WINDOW;
    let corners = [low, [low[0], high[1]], high, [high[0], low[1]]].map(|[y, z]| Vec3::new(HIGH.x, y, z).as_dvec3());
    let radiance = |point| reflected(SKY.as_dvec3() * form_factor(point, DVec3::Y, &corners));
    let expected = expected(&scene, 0.0, radiance);
    for sky in skies() {
        scene.sky = sky;
        for lights in [LightSampling::Mis, LightSampling::Direct] {
            check_settings(&scene, &path(lights), &expected, 0.1);
        }
    }
}

/// The window has about a hundredth of what a point sees.
#[test]
fn looking_through_the_window_makes_less_noise() {
    let mut scene = plane();
    scene.meshes.push(mesh(&walls(), 1));
    scene.materials.push(material(Vec3::ZERO, Vec3::ZERO));
    for sky in skies() {
        scene.sky = sky;
        let noise = |lights| {
            let runs = seeds(&scene, &Settings { spp: 16, ..path(lights) }, 16);
            (0..(SIZE.0 * SIZE.1) as usize)
                .map(|i| Estimate::of(&runs.iter().map(|run| run[i]).collect::<Vec<_>>()).error.y.powi(2))
                .sum::<f64>()
        };
        let ratio = noise(LightSampling::Naive) / noise(LightSampling::Mis);
        assert!(ratio > 20.0, "{ratio} times the variance by bounces alone");
    }
}

/// A room of gloss, of leaves that light shines through and of a sky that is not the same everywhere.
pub(crate) fn furnished() -> Scene {
    let gradient =
        (0..12 * 6).map(|i| Vec3::new(3.0, 4.0, 6.0) * (0.2 + 0.1 * (i / 12) as f32 + 0.05 * (i % 12) as f32));
    let leaf = [[0.8, 0.2], [0.8, 1.0], [1.6, 1.0], [1.6, 0.2]].map(|[y, z]| Vec3::new(0.5, y, z));
    let floor = [[LOW.x, LOW.z], [LOW.x, HIGH.z], [HIGH.x, HIGH.z], [HIGH.x, LOW.z]].map(|[x, z]| Vec3::new(x, 0.0, z));
    let inputs = Inputs {
        base_color: Vec3::splat(0.6),
        diffuse_transmission_weight: 0.5,
        diffuse_transmission_color: Vec3::new(0.3, 0.9, 0.2),
        ..Inputs::default()
    };
    let gloss = Inputs { base_color: Vec3::new(0.4, 0.3, 0.2), specular_roughness: 0.25, ..Inputs::default() };
    Scene {
        meshes: vec![mesh(&walls(), 0), mesh(&quad(floor), 1), mesh(&quad(leaf), 2)],
        materials: vec![
            material(Vec3::new(0.7, 0.65, 0.6), Vec3::ZERO),
            Material { inputs: gloss, ..Material::default() },
            Material { inputs, ..Material::default() },
        ],
        camera: Some(CameraPose {
            eye: Vec3::new(-2.5, 1.6, 5.0),
            target: Vec3::new(1.5, 0.8, 0.5),
            up: Vec3::Y,
            vfov: 60.0,
        }),
        sky: Sky { radiance: Vec3::ZERO, picture: Some(SkyPicture::new(12, 6, gradient.collect())) },
        ..Scene::default()
    }
}

#[test]
fn looking_through_the_window_changes_nothing_in_a_furnished_room() {
    let mut scene = furnished();
    for sky in [scene.sky.clone(), Sky::constant(SKY)] {
        scene.sky = sky;
        let (alone, noise_alone) = picture(&scene, LightSampling::Naive, &Stop::Depth, 256);
        for lights in [LightSampling::Mis, LightSampling::Direct] {
            let (found, noise) = picture(&scene, lights, &Stop::Depth, 32);
            let z = found.z(&alone, 0.0);
            assert!(z.max_element() < 4.0, "{lights:?}: {} and {}: {z}", found.mean, alone.mean);
            assert!(found.error.max_element() < 0.02 * found.mean.max_element(), "{} of {}", found.error, found.mean);
            let ratio = 8.0 * noise_alone / noise;
            assert!(ratio > 3.0, "{lights:?}: {ratio} times the variance by bounces alone");
        }
    }
}

/// Guided bounces change the densities.
#[test]
fn looking_through_the_window_beside_guided_bounces() {
    let scene = furnished();
    let mean = |guide: Option<u32>| {
        let integrator = Integrator::Path(PathOptions { guide, max_depth: 6, ..PathOptions::default() });
        let settings = Settings { width: 24, height: 24, spp: 32, integrator, ..settings() };
        Estimate::of_means(&seeds(&scene, &settings, 12))
    };
    let (guided, plain) = (mean(Some(4096)), mean(None));
    let z = guided.z(&plain, 0.0);
    assert!(z.max_element() < 4.0, "{} and {}: {z}", guided.mean, plain.mean);
}
