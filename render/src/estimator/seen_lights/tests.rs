//! Lights with a size in mirrors, in gloss and behind glass.

use std::f32::consts::PI;
use std::path::Path;
use std::sync::Arc;

use glam::{Vec3, vec3};

use crate::driver;
use crate::fixtures::{self, square};
use crate::material::Inputs;
use crate::scene::formats::ies;
use crate::scene::{CameraPose, Material, Mesh, ProfileFrame, PunctualLight, Scene, SpotEdge};
use crate::settings::{
    CachedOptions, DirectOptions, Integrator, LightSampling, MonteCarloOptions, PathOptions, Settings,
};
use crate::watch::NeverStops;
use crate::world::World;

/// What the camera sees in the floor lies in this direction.
const UP: Vec3 = Vec3::new(0.6, 0.0, 0.8);
/// Where the lights are.
const CENTER: Vec3 = Vec3::new(3.0, 0.0, 4.0);

fn metal(roughness: f32) -> Material {
    let inputs = Inputs { base_metalness: 1.0, specular_roughness: roughness, ..Inputs::default() };
    Material { inputs: Inputs { base_color: Vec3::ONE, ..inputs }, ..Material::default() }
}

fn glass(roughness: f32) -> Material {
    Material { inputs: Inputs { specular_roughness: roughness, ..fixtures::glass() }, ..Material::default() }
}

/// A floor of the first material under a light.
fn world(light: &PunctualLight, materials: Vec<Material>, above: Vec<Mesh>) -> World {
    looked_at(Vec3::new(-0.6, 0.0, 0.8), light, materials, above)
}

/// The same, seen from elsewhere.
fn looked_at(eye: Vec3, light: &PunctualLight, materials: Vec<Material>, above: Vec<Mesh>) -> World {
    World::new(Scene {
        meshes: [square(0.0, true, 0)].into_iter().chain(above).collect(),
        materials,
        lights: vec![light.clone()],
        camera: Some(CameraPose { eye, target: Vec3::ZERO, up: Vec3::Y, vfov: 0.01 }),
        ..Scene::default()
    })
    .unwrap()
}

/// The mean of a picture.
fn color(world: &World, integrator: Integrator, (side, spp): (u32, u32)) -> f32 {
    let settings = Settings { width: side, height: side, spp, integrator, ..Settings::default() };
    let picture = driver::render(world, &settings, &NeverStops).picture;
    picture.channel("G").unwrap().values.iter().sum::<f32>() / (side * side) as f32
}

fn path(lights: LightSampling) -> Integrator {
    Integrator::Path(PathOptions { lights, ..PathOptions::default() })
}

fn sphere(radius: f32) -> PunctualLight {
    PunctualLight::Point { position: CENTER, intensity: Vec3::splat(2.0), radius }
}

/// One of each kind, and what the camera sees of it in a mirror of silver.
fn lights() -> [(PunctualLight, f32); 5] {
    let radius = 0.5;
    let (cos_inner, cos_outer) = (0.9, 0.5);
    let spot = PunctualLight::Spot {
        position: CENTER,
        direction: vec3(-1.0, 0.0, 0.0),
        intensity: Vec3::splat(2.0),
        radius,
        cos_inner,
        cos_outer,
        edge: SpotEdge::Square,
    };
    let part = ((0.6 - cos_outer) / (cos_inner - cos_outer)).powi(2);
    let text = "IESNA91\nTILT=NONE\n1 1 1 3 1 1 2 0 0 0\n1 1 1\n0 90 180\n0\n3 3 3\n";
    let profile = Arc::new(ies::parse(Path::new("lamp.ies"), text.as_bytes()).unwrap());
    let frame = ProfileFrame::new(-Vec3::Z, 0.0);
    let profiled = PunctualLight::Profiled { position: CENTER, frame, intensity: Vec3::ONE, radius, profile };
    let sun = PunctualLight::Directional { direction: -UP, irradiance: Vec3::ONE, half_angle: 0.1 };
    let inside = PunctualLight::Point { position: vec3(0.5, 0.0, 0.2), intensity: Vec3::ONE, radius: 2.0 };
    let per_intensity = 1.0 / (PI * radius * radius);
    [
        (sphere(radius), 2.0 * per_intensity),
        (spot, 2.0 * per_intensity * part),
        (profiled, 3.0 * per_intensity),
        (sun, 1.0 / (PI * 0.1f32.sin().powi(2))),
        (inside, 1.0 / (PI * 4.0)),
    ]
}

#[test]
fn mirrors_show_lights_of_a_size_in_all_integrators() {
    for (light, expected) in lights() {
        let world = world(&light, vec![metal(0.0)], Vec::new());
        for integrator in [
            path(LightSampling::Mis),
            path(LightSampling::Direct),
            path(LightSampling::Naive),
            Integrator::MonteCarlo(MonteCarloOptions::default()),
            Integrator::Direct(DirectOptions::default()),
            Integrator::Cached(CachedOptions { rays: 64, ..CachedOptions::default() }),
        ] {
            let found = color(&world, integrator.clone(), (2, 2));
            assert!((found / expected - 1.0).abs() < 1e-4, "{found}, not {expected}: {light:?}, {integrator:?}");
        }
    }
}

#[test]
fn mirrors_show_nothing_of_lights_beside_and_behind_and_of_no_size() {
    let elsewhere = |position: Vec3| PunctualLight::Point { position, intensity: Vec3::ONE, radius: 0.5 };
    let before = square(2.0, false, 1);
    for (light, above) in [
        (elsewhere(CENTER + vec3(0.0, 0.6, 0.0)), vec![]),
        (elsewhere(-CENTER), vec![]),
        (sphere(0.5), vec![before]),
        (sphere(0.0), vec![]),
        (PunctualLight::Directional { direction: -Vec3::Z, irradiance: Vec3::ONE, half_angle: 0.1 }, vec![]),
    ] {
        let world = world(&light, vec![metal(0.0), Material::matte(Vec3::ZERO)], above);
        assert_eq!(color(&world, path(LightSampling::Mis), (2, 2)), 0.0, "{light:?}");
    }
}

#[test]
fn the_camera_sees_lights_through_glass_alone() {
    let eye = 2.0 * CENTER;
    for light in [sphere(0.5), PunctualLight::Directional { direction: UP, irradiance: Vec3::ONE, half_angle: 0.1 }] {
        let black = || Material::matte(Vec3::ZERO);
        let open = looked_at(eye, &light, vec![black()], Vec::new());
        assert_eq!(color(&open, path(LightSampling::Mis), (2, 2)), 0.0);
    }
    let pane = vec![square(6.0, true, 1), square(5.9, false, 1)];
    let world = looked_at(eye, &sphere(0.5), vec![Material::matte(Vec3::ZERO), glass(0.0)], pane);
    // Fresnel's equations at an angle of cosine 0.8.
    let (cos, n) = (0.8f32, 1.5f32);
    let inside = (1.0 - (1.0 - cos * cos) / (n * n)).sqrt();
    let [s, p] = [(cos - n * inside) / (cos + n * inside), (n * cos - inside) / (n * cos + inside)];
    let f = 0.5 * (s * s + p * p);
    let expected = 2.0 / (PI * 0.25) * (1.0 - f) / (1.0 + f);
    let options = PathOptions { max_depth: 64, ..PathOptions::default() };
    let found = color(&world, Integrator::Path(options), (64, 64));
    assert!((found / expected - 1.0).abs() < 0.01, "{found}, not {expected}");
}

/// However rough a surface is, light samples and bounces find the same, and together.
#[test]
fn what_gloss_shows_of_a_light_counts_once() {
    for (light, _) in lights() {
        for roughness in [0.1, 0.3, 0.8] {
            let world = world(&light, vec![metal(roughness)], Vec::new());
            let found = [LightSampling::Direct, LightSampling::Mis, LightSampling::Naive]
                .map(|lights| color(&world, path(lights), (32, 64)));
            let [by_samples, by_both, by_bounces] = found;
            // The better of the two has little noise.
            let is_around = matches!(light, PunctualLight::Point { radius: 2.0, .. });
            let (better, worse) = if is_around { (by_bounces, by_samples) } else { (by_samples, by_bounces) };
            assert!(by_both > 0.0 && (by_both / better - 1.0).abs() < 0.02, "{found:?}: {light:?}, {roughness}");
            assert!((worse / better - 1.0).abs() < 0.1, "{found:?}: {light:?}, {roughness}");
        }
    }
}

/// So does what is seen through rough glass, and through a pane that shadow rays cross.
#[test]
fn glass_counts_a_light_once() {
    let eye = vec3(-1.2, 0.0, 1.6);
    let rough = vec![square(1.0, true, 1), square(0.9, false, 1)];
    let pane = vec![square(1.0, true, 2), square(0.9, false, 2)];
    for (name, above, floor) in [("rough", rough, 0.5), ("pane", pane, 0.2)] {
        let materials = vec![metal(floor), glass(0.3), glass(0.0)];
        let world = looked_at(eye, &sphere(0.5), materials, above);
        let [by_samples, by_both] = [LightSampling::Direct, LightSampling::Mis].map(|lights| {
            let options = PathOptions { lights, max_depth: 64, ..PathOptions::default() };
            color(&world, Integrator::Path(options), (48, 256))
        });
        assert!((by_both / by_samples - 1.0).abs() < 0.04, "{name}: {by_both} by both, {by_samples} by samples");
    }
}

/// Bounces find lights behind panes, where light samples alone would need thousands.
#[test]
fn narrow_gloss_shows_lights_behind_panes() {
    let pane = || vec![square(1.0, true, 1), square(0.95, false, 1)];
    let (cos, n) = (0.8f32, 1.5f32);
    let inside = (1.0 - (1.0 - cos * cos) / (n * n)).sqrt();
    let [s, p] = [(cos - n * inside) / (cos + n * inside), (n * cos - inside) / (n * cos + inside)];
    let f = 0.5 * (s * s + p * p);
    for (light, expected) in [&lights()[0], &lights()[3]] {
        let expected = expected * (1.0 - f) / (1.0 + f);
        let world = world(light, vec![metal(0.02), glass(0.0)], pane());
        // Without what floor and pane show of each other.
        let once = || Integrator::Path(PathOptions { max_depth: 2, ..PathOptions::default() });
        let found = color(&world, once(), (4, 4));
        assert!((found / expected - 1.0).abs() < 0.02, "{found}, not {expected}: {light:?}");
        // Beside it there is nothing.
        let beside = PunctualLight::Point { position: CENTER + Vec3::Y, intensity: Vec3::ONE, radius: 0.5 };
        let world = looked_at(vec3(-0.6, 0.0, 0.8), &beside, vec![metal(0.02), glass(0.0)], pane());
        assert!(color(&world, path(LightSampling::Mis), (4, 4)) < 1e-3 * expected);
    }
}

/// A light in a mirror is seen in a floor that is not quite one: as bright, as long as the floor shows nothing beside it.
#[test]
fn gloss_shows_what_a_mirror_shows() {
    let light = PunctualLight::Point { position: vec3(6.0, 0.0, 4.0), intensity: Vec3::ONE, radius: 1.5 };
    let above = || vec![square(6.0, false, 1)];
    let expected = 1.0 / (PI * 1.5 * 1.5);
    // What is reflected far from the mirror's direction is left out.
    for (roughness, least) in [(0.0, 0.999), (0.02, 0.97), (0.1, 0.95), (0.2, 0.85)] {
        let world = world(&light, vec![metal(roughness), metal(0.0)], above());
        let found = color(&world, path(LightSampling::Mis), (16, 64));
        let ratio = found / expected;
        assert!(ratio > least && ratio < 1.02, "{roughness}: {found}, not {expected}");
    }
    // A diffuse one does not.
    let world = world(&light, vec![Material::matte(Vec3::ONE), metal(0.0)], above());
    let by_light_samples = color(&world, path(LightSampling::Mis), (16, 64));
    assert!(by_light_samples > 0.0 && by_light_samples < 0.5 * expected);
}
