//! Normal maps beside bumps of triangles: they shadow each other and reflect light to each other alike.

use std::f32::consts::TAU;

use glam::{UVec2, Vec2};
use halfdome::scene::{ColorSpace, Mesh, NormalMap, Sky, SpotEdge, Texture, TextureMap};
use halfdome::settings::CachedOptions;

use super::*;

/// Bumps along each side of the plane from -2 to 2, and their height by their length.
const BUMPS: f32 = 8.0;
const HEIGHT: f32 = 0.12;

/// The height over a point of the plane, 0 to 1 along each side, in the plane's units.
fn height(at: Vec2) -> f32 {
    let [x, y] = (at * BUMPS * TAU).to_array().map(f32::sin);
    HEIGHT * (4.0 / BUMPS) * x * y
}

/// The unit normal there.
fn normal(at: Vec2) -> Vec3 {
    let angles = at * BUMPS * TAU;
    let along_x = HEIGHT * TAU * angles.x.cos() * angles.y.sin();
    let along_y = HEIGHT * TAU * angles.x.sin() * angles.y.cos();
    Vec3::new(-along_x, -along_y, 1.0).normalize()
}

/// Under a white sky: bumps of triangles, or a plane with their normal map.
fn scene(inputs: Inputs, are_real: bool) -> Scene {
    let side = if are_real { 24 * BUMPS as u32 } else { 1 };
    let corners =
        (0..(side + 1) * (side + 1)).map(|i| UVec2::new(i % (side + 1), i / (side + 1)).as_vec2() / side as f32);
    let corners: Vec<Vec2> = corners.collect();
    let lift = |at: Vec2| if are_real { height(at) } else { 0.0 };
    let cell = |i: u32| {
        let first = i / side * (side + 1) + i % side;
        [[first, first + 1, first + side + 2], [first, first + side + 2, first + side + 1]]
    };
    let mesh = Mesh {
        positions: corners.iter().map(|at| (4.0 * *at - 2.0).extend(lift(*at))).collect(),
        normals: if are_real { corners.iter().map(|at| normal(*at)).collect() } else { Vec::new() },
        // The picture's first row is the upper one.
        texcoords: corners.iter().map(|at| Vec2::new(at.x, 1.0 - at.y)).collect(),
        triangles: (0..side * side).flat_map(cell).collect(),
        ..Mesh::default()
    };
    let texels = 64 * BUMPS as u32;
    let texel = |i: u32| {
        let at = Vec2::new((i % texels) as f32 + 0.5, (texels - 1 - i / texels) as f32 + 0.5) / texels as f32;
        let [x, y, z] = (normal(at) * 0.5 + 0.5).to_array().map(|part| (part * 255.0).round() as u8);
        [x, y, z, 255]
    };
    let texture = TextureMap { space: ColorSpace::Linear, ..TextureMap::default() };
    let map = NormalMap { texture, scale: Vec2::ONE };
    Scene {
        meshes: vec![mesh],
        materials: vec![Material { inputs, normal_map: (!are_real).then_some(map), ..Material::default() }],
        textures: vec![Texture::new(texels, texels, (0..texels * texels).map(texel).collect())],
        sky: Sky { radiance: Vec3::ONE, ..Sky::default() },
        camera: Some(CameraPose { eye: Vec3::new(0.0, -6.0, 6.0), target: Vec3::ZERO, up: Vec3::Z, vfov: 8.0 }),
        ..Scene::default()
    }
}

/// Mapped bumps with light from low angles alone: of a lamp, or of a white wall in its place that a spot shines at.
fn low_light(inputs: Inputs, is_reflected: bool) -> Scene {
    let mut scene = scene(inputs, false);
    let wall = quad([(-4.0, 0.0), (4.0, 0.0), (4.0, 1.2), (-4.0, 1.2)].map(|(x, z)| Vec3::new(x, 3.0, z)));
    scene.meshes.push(mesh(&wall, 1));
    scene.sky = Sky::default();
    if is_reflected {
        scene.lights.push(PunctualLight::Spot {
            position: Vec3::new(0.0, 2.0, 0.6),
            direction: Vec3::Y,
            intensity: Vec3::ONE,
            radius: 0.0,
            cos_inner: 0.9,
            cos_outer: 0.8,
            edge: SpotEdge::default(),
        });
    }
    let [white, lamp] = [(Vec3::ONE, Vec3::ZERO), (Vec3::ZERO, Vec3::ONE)].map(|(color, light)| material(color, light));
    scene.materials.push(if is_reflected { white } else { lamp });
    scene
}

/// The mean of a picture's red.
fn mean(scene: &Scene, integrator: Integrator, spp: u32) -> f64 {
    let settings = Settings { width: 32, height: 32, spp, integrator, ..Settings::default() };
    Estimate::of(&pixels(&render(scene, &settings))).mean.x
}

fn inputs(color: f32, specular_weight: f32, base_metalness: f32) -> Inputs {
    Inputs { base_color: Vec3::splat(color), specular_weight, base_metalness, ..Inputs::default() }
}

#[test]
fn mapped_bumps_reflect_as_much_of_a_sky_as_real_ones() {
    for (name, inputs) in [
        ("white", inputs(0.8, 0.0, 0.0)),
        ("dark", inputs(0.2, 0.0, 0.0)),
        ("black plastic", inputs(0.02, 1.0, 0.0)),
        ("plastic", inputs(0.6, 1.0, 0.0)),
        ("metal", inputs(0.8, 1.0, 1.0)),
    ] {
        let [mapped, real] =
            [false, true].map(|are_real| mean(&scene(inputs, are_real), path(LightSampling::Mis, Stop::Depth), 64));
        assert!((mapped / real - 1.0).abs() < 0.025, "{name}: {mapped} with a map, {real} with real bumps");
    }
}

#[test]
fn all_integrators_reflect_as_much() {
    // From high up, and so low that many bumps would face away. The sun is at the viewer's side: such bumps are lit.
    let [high, low] = [Vec3::new(0.0, -6.0, 6.0), Vec3::new(0.0, -8.0, 1.5)];
    let [diffuse, plastic] = [0.0, 1.0].map(|specular_weight| inputs(0.3, specular_weight, 0.0));
    for (name, inputs, eye) in [("diffuse", diffuse, high), ("diffuse", diffuse, low), ("plastic", plastic, high)] {
        let mut scene = scene(inputs, false);
        scene.camera = scene.camera.map(|camera| CameraPose { eye, ..camera });
        let sun = Vec3::new(0.3, 0.5, -0.7).normalize();
        scene.lights.push(PunctualLight::Directional { direction: sun, irradiance: Vec3::ONE, half_angle: 0.0 });
        let by_paths = mean(&scene, path(LightSampling::Mis, Stop::Depth), 64);
        let others = [
            Integrator::Cached(CachedOptions::default()),
            Integrator::MonteCarlo(MonteCarloOptions { bounces: 1, ..MonteCarloOptions::default() }),
            path(LightSampling::Naive, Stop::Depth),
        ];
        for integrator in others {
            let what = format!("{integrator:?}");
            let other = mean(&scene, integrator, 64);
            assert!((other / by_paths - 1.0).abs() < 0.01, "{name}: {by_paths} by paths, {other} by {what}");
        }
    }
}

#[test]
fn light_samples_bounces_and_gathers_find_as_much_light_at_low_angles() {
    for (name, inputs) in [("diffuse", inputs(0.3, 0.0, 0.0)), ("plastic", inputs(0.3, 1.0, 0.0))] {
        for is_reflected in [false, true] {
            let scene = low_light(inputs, is_reflected);
            let by = |lights: LightSampling| {
                Integrator::Path(PathOptions { lights, max_depth: 3, ..PathOptions::default() })
            };
            let [naive, direct, mis] = ALL_LIGHTS.map(|lights| mean(&scene, by(lights), 256));
            let gathers = MonteCarloOptions { bounces: 1, ..MonteCarloOptions::default() };
            let gathered = mean(&scene, Integrator::MonteCarlo(gathers), 256);
            for found in [naive, direct, gathered] {
                assert!((found / mis - 1.0).abs() < 0.03, "{name}: {mis}, {naive}, {direct}, {gathered} by gathers");
            }
        }
    }
}
