//! Reflected light against mirror images, a ball's caustic in double precision, and lamps that paths hit.

use std::f32::consts::PI;

use glam::{Vec2, Vec3, vec3};
use halfdome_kernel::sampling::Stream;

use super::*;
use crate::driver;
use crate::fixtures::{self, square, sun};
use crate::material::Inputs;
use crate::scene::{CameraPose, Material, Mesh, Scene};
use crate::settings::{CachedOptions, DirectOptions, Integrator, MonteCarloOptions, PathOptions, Settings};
use crate::watch::NeverStops;
use crate::world::Hit;

const CAMERA: CameraPose = CameraPose { eye: vec3(0.0, -0.2, 0.05), target: Vec3::ZERO, up: Vec3::Z, vfov: 0.01 };

fn mirror(reflectance: f32) -> Material {
    let inputs = Inputs {
        base_metalness: 1.0,
        base_color: Vec3::splat(reflectance),
        metal_edge_color: Vec3::ONE,
        specular_roughness: 0.0,
        ..Inputs::default()
    };
    Material { inputs, ..Material::default() }
}

/// Meshes above a floor, of which the camera sees the middle. Materials: 0 is the floor's, 1 a mirror, 2 glass, 3 thin
/// glass, 4 emits.
fn world(floor: Material, lights: Vec<PunctualLight>, meshes: Vec<Mesh>) -> World {
    seen_from(CAMERA.eye, floor, lights, meshes)
}

fn seen_from(eye: Vec3, floor: Material, lights: Vec<PunctualLight>, meshes: Vec<Mesh>) -> World {
    let thin = Inputs { thin_walled: true, ..fixtures::glass() };
    World::new(Scene {
        meshes: meshes.into_iter().chain([square(0.0, true, 0)]).collect(),
        materials: vec![
            floor,
            mirror(0.8),
            Material { inputs: fixtures::glass(), ..Material::default() },
            Material { inputs: thin, ..Material::default() },
            Material { emission: Vec3::ONE, ..Material::matte(Vec3::ZERO) },
        ],
        lights,
        camera: Some(CameraPose { eye, ..CAMERA }),
        ..Scene::default()
    })
    .unwrap()
}

/// So dark that nearly all light on it is direct.
fn dark() -> Material {
    Material::matte(Vec3::splat(0.05))
}

fn point(position: Vec3, radius: f32) -> PunctualLight {
    PunctualLight::Point { position, intensity: Vec3::ONE, radius }
}

/// A vertical wall at `x = 2`, its front towards the origin.
fn wall(material: usize) -> Mesh {
    let corners = [(-1.0, 0.0), (1.0, 0.0), (1.0, 2.0), (-1.0, 2.0)];
    let positions = corners.map(|(y, z)| vec3(2.0, y, z)).to_vec();
    Mesh { positions, triangles: vec![[0, 2, 1], [0, 3, 2]], material, ..Mesh::default() }
}

/// Without roulette, and with it.
const ALL: (f32, u32) = (1e6, 1024);
const SOME: (f32, u32) = (1.0, 65_536);

/// The mean over many numbers of what a sample brings to the floor at a place, by the cosine, and that of its direction.
fn irradiance(world: &World, at: Vec2, (importance, count): (f32, u32)) -> (f64, Vec3) {
    let mut hits = [Hit::MISS];
    world.intersect_many(&[Ray::new(at.extend(0.01), -Vec3::Z)], &mut hits);
    let surface = world.surface_at(&hits[0]).facing(-Vec3::Z);
    let (mut sum, mut direction) = (0.0, Vec3::ZERO);
    for i in 0..count {
        let u = Vec2::new((i as f32 + 0.5) / count as f32, (i as f32 * 0.618_034).fract());
        // Digits below those of the place, as samplers have them.
        let u = u + Vec2::new((i as f32 * 0.754_877).fract(), (i as f32 * 0.569_84).fract()) / FINER;
        let u = u.min(Vec2::splat(0.999_999));
        let Some(light) = sample_reflected(world, &surface, importance, u) else { continue };
        if !world.occluded(&light.shadow) {
            sum += f64::from(light.received.x * light.direction.z);
            direction += light.direction;
        }
    }
    (sum / f64::from(count), direction.normalize_or_zero())
}

#[test]
fn a_wall_of_mirror_shows_an_image_of_the_light() {
    let lamp = vec3(0.5, 0.3, 1.5);
    let image = vec3(3.5, 0.3, 1.5);
    for (at, is_lit) in [(Vec2::ZERO, true), (Vec2::new(-1.0, -0.4), true), (Vec2::new(1.0, 4.0), false)] {
        let world = world(dark(), vec![point(lamp, 0.0)], vec![wall(1)]);
        let (found, direction) = irradiance(&world, at, ALL);
        let way = image - at.extend(0.0);
        let expected = if is_lit { 0.8 * way.z / way.length().powi(3) } else { 0.0 };
        assert!((found - f64::from(expected)).abs() <= 2e-3 * f64::from(expected), "{at}: {found}, not {expected}");
        assert!(!is_lit || direction.dot(way.normalize()) > 0.999_999, "{at}: {direction}");
    }
    // The sun shines from where the wall's front looks.
    let to_sun = vec3(-1.0, 0.0, 0.7).normalize();
    let found = irradiance(&world(dark(), vec![sun(to_sun)], vec![wall(1)]), Vec2::new(0.6, 0.1), ALL).0;
    let expected = f64::from(0.8 * to_sun.z);
    assert!((found / expected - 1.0).abs() < 2e-3, "{found}, not {expected}");
}

/// Beside a light that is a thousand times as bright, and which the mirror does not show.
#[test]
fn a_faint_light_beside_a_bright_one_is_rarely_searched_but_right_in_the_mean() {
    let lamp = vec3(0.5, 0.3, 1.5);
    let behind = PunctualLight::Point { position: vec3(4.0, 0.0, 2.0), intensity: Vec3::splat(1e3), radius: 0.0 };
    let alone = world(dark(), vec![point(lamp, 0.0)], vec![wall(1)]);
    let beside = world(dark(), vec![point(lamp, 0.0), behind], vec![wall(1)]);
    let mut hits = [Hit::MISS];
    alone.intersect_many(&[Ray::new(vec3(0.0, 0.0, 0.01), -Vec3::Z)], &mut hits);
    const SAMPLES: u32 = 1 << 18;
    // The mean irradiance, and the part of samples that find the reflection.
    let sample = |world: &World| {
        let surface = world.surface_at(&hits[0]).facing(-Vec3::Z);
        let light = |i: u32| sample_reflected(world, &surface, 1.0, Stream::new(7, i, 0).uniform2(0));
        let found: Vec<ReflectedLight> = (0..SAMPLES).filter_map(light).collect();
        let sum: f64 = found.iter().map(|light| f64::from(light.received.x * light.direction.z)).sum();
        [sum, found.len() as f64].map(|of_all| of_all / f64::from(SAMPLES))
    };
    let [[expected, always], [found, rarely]] = [&alone, &beside].map(sample);
    assert!((found / expected - 1.0).abs() < 0.03, "{found}, not {expected}");
    assert!((rarely / (always * f64::from(LEAST_SHARE)) - 1.0).abs() < 0.06, "{rarely} of {always}");
}

#[test]
fn faint_reflections_of_panes_have_the_right_mean() {
    let lamp = vec3(0.5, 0.3, 1.5);
    let way = vec3(3.5, 0.3, 1.5);
    let cos = f64::from(way.x / way.length());
    let one = fixtures::reflectance(cos);
    let direct = f64::from(way.z / way.length().powi(3));
    let thin = irradiance(&world(dark(), vec![point(lamp, 0.0)], vec![wall(3)]), Vec2::ZERO, ALL).0;
    assert!((thin / (direct * 2.0 * one / (1.0 + one)) - 1.0).abs() < 2e-3, "{thin}");
    // Solid: the image in the front, and the one in the back, 2 cm of glass behind it.
    let mut back = wall(2);
    back.positions.iter_mut().for_each(|position| position.x += 0.02);
    back.triangles.iter_mut().for_each(|triangle| triangle.swap(1, 2));
    let solid = irradiance(&world(dark(), vec![point(lamp, 0.0)], vec![wall(2), back]), Vec2::ZERO, ALL).0;
    let expected = direct * (one + (1.0 - one).powi(2) * one);
    assert!((solid / expected - 1.0).abs() < 0.01, "{solid}, not {expected}");
}

#[test]
fn a_ball_throws_a_ring_of_sunlight() {
    let ball = fixtures::ball([96, 192]);
    let positions = ball.positions.iter().map(|position| *position + 2.0 * Vec3::Z).collect();
    let world = world(dark(), vec![sun(Vec3::Z)], vec![Mesh { positions, material: 1, ..ball }]);
    // Schlick's.
    let reflectance = |alpha: f64| 0.8 + 0.2 * (1.0 - alpha.cos()).powi(5);
    // A ray at the distance `sin α` from the axis leaves at `2α` from its direction, down to the floor from 45° on.
    let lands = |alpha: f64| alpha.sin() + (2.0 + alpha.cos()) * (std::f64::consts::PI - 2.0 * alpha).tan();
    for alpha in [1.2f64, 1.35, 1.45] {
        let step = 1e-5;
        let at = lands(alpha);
        let by = (lands(alpha + step) - lands(alpha - step)) / (2.0 * step);
        let expected = reflectance(alpha) * alpha.sin() * alpha.cos() / (at * by.abs());
        let (found, direction) = irradiance(&world, Vec2::new(at as f32, 0.0), ALL);
        assert!((found / expected - 1.0).abs() < 0.03, "{alpha}, {at}: {found}, not {expected}");
        let expected = std::f64::consts::PI - 2.0 * alpha;
        assert!((f64::from(direction.z) - expected.cos()).abs() < 5e-3, "{alpha}: {direction}");
    }
}

#[test]
fn of_many_lights_a_few_keep_the_mean() {
    let lamps: Vec<Vec3> = (0..37).map(|i| vec3(0.02 * i as f32, 0.01 * i as f32, 1.5)).collect();
    let one = |lamp: &Vec3| irradiance(&world(dark(), vec![point(*lamp, 0.0)], vec![wall(1)]), Vec2::ZERO, ALL).0;
    let expected: f64 = lamps.iter().map(one).sum();
    let all = lamps.iter().map(|lamp| point(*lamp, 0.0)).collect();
    let found = irradiance(&world(dark(), all, vec![wall(1)]), Vec2::ZERO, (1e6, 16_384)).0;
    assert!((found / expected - 1.0).abs() < 0.02, "{found}, not {expected}");
}

#[test]
fn roulette_keeps_the_mean() {
    let walls = world(dark(), vec![point(vec3(0.5, 0.3, 1.5), 0.0)], vec![wall(3)]);
    let ball = fixtures::ball([96, 192]);
    let positions = ball.positions.iter().map(|position| *position + 2.0 * Vec3::Z).collect();
    let balls = world(dark(), vec![sun(Vec3::Z)], vec![Mesh { positions, material: 1, ..ball }]);
    for (world, at) in [(&walls, Vec2::ZERO), (&walls, Vec2::new(-1.0, 0.5)), (&balls, Vec2::new(2.5, 0.0))] {
        let [all, some] = [ALL, SOME].map(|how| irradiance(world, at, how).0);
        assert!((some / all - 1.0).abs() < 0.08, "{at}: {some}, not {all}");
    }
}

/// The mean of a picture of the middle of the floor.
fn seen(world: &World, integrator: Integrator, spp: u32) -> f64 {
    let settings = Settings { width: 16, height: 16, spp, integrator, ..Settings::default() };
    let picture = driver::render(world, &settings, &NeverStops).picture;
    f64::from(picture.channel("G").unwrap().values.iter().sum::<f32>()) / 256.0
}

/// A lamp, its image in the [`wall`], and a shade that keeps its straight light off the middle of the floor.
const LAMP: Vec3 = vec3(0.5, 0.0, 1.5);
const IMAGE: Vec3 = vec3(3.5, 0.0, 1.5);
fn shade() -> Mesh {
    let positions = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(|(x, y)| vec3(x, y, 0.9)).to_vec();
    Mesh { positions, triangles: vec![[0, 1, 2], [0, 2, 3]], ..Mesh::default() }
}

#[test]
fn integrators_agree_about_surfaces_that_only_a_mirror_lights() {
    let world = world(dark(), vec![point(LAMP, 0.0)], vec![wall(1), shade()]);
    let expected = 0.8 * 0.05 / f64::from(PI) * f64::from(IMAGE.z / IMAGE.length().powi(3));
    for integrator in [
        Integrator::Path(PathOptions::default()),
        Integrator::Direct(DirectOptions::default()),
        Integrator::MonteCarlo(MonteCarloOptions::default()),
        Integrator::Cached(CachedOptions::default()),
    ] {
        let name = format!("{integrator:?}");
        let found = seen(&world, integrator, 16);
        assert!((found / expected - 1.0).abs() < 0.05, "{name}: {found}, not {expected}");
    }
}

#[test]
fn lamps_with_a_size_are_counted_once() {
    // A glossy floor sees the lamp in the mirror by its bounces, a rough one by connections: both see what emissive
    // triangles in place of the lamp bring.
    let radius = 0.2;
    let ball = fixtures::ball([32, 64]);
    let positions = ball.positions.iter().map(|position| LAMP + radius * *position).collect();
    let ball = Mesh { positions, material: 4, ..ball };
    let eye = 0.05 * vec3(-IMAGE.x, 0.0, IMAGE.z).normalize();
    for roughness in [0.15, 0.5, 1.0] {
        let mut floor = mirror(0.9);
        floor.inputs.specular_roughness = roughness;
        let picture = |lights: Vec<PunctualLight>, meshes: Vec<Mesh>, spp| {
            seen(&seen_from(eye, floor.clone(), lights, meshes), Integrator::Path(PathOptions::default()), spp)
        };
        let lit = picture(vec![point(LAMP, radius)], vec![wall(1), shade()], 256);
        // Of the radiance 1 instead of the intensity.
        let meshes = picture(vec![], vec![wall(1), shade(), ball.clone()], 2048) / f64::from(PI * radius * radius);
        assert!((lit / meshes - 1.0).abs() < 0.03, "{roughness}: {lit}, not {meshes}");
    }
}
