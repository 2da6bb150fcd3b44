//! Motion blur: moving objects behind a shutter, against formulas and against many static pictures.

use std::collections::BTreeMap;

use glam::{Affine3A, DVec3, Quat, Vec3};
use halfdome::scene::{CameraPose, Instance, Material, Motion, Object, Optics, Projection, PunctualLight, Scene};
use halfdome::settings::{Integrator, LightSampling, PathOptions, Settings};
use halfdome_tests::render::{Estimate, material, mesh, pixels, quad, render, seeds};

use super::{FRONT, disc, glowing};

fn settings(side: u32, spp: u32, seed: u64) -> Settings {
    let integrator = Integrator::Path(PathOptions { max_depth: 4, ..PathOptions::default() });
    Settings { width: side, height: side, spp, seed, integrator, ..Settings::default() }
}

/// The scene with positions of its last mesh moved from `-by / 2` to `by / 2`.
fn sliding(mut scene: Scene, by: Vec3, keys: usize) -> Scene {
    let number = scene.meshes.len() - 1;
    let positions = &scene.meshes[number].positions;
    let at = |key: usize| positions.iter().map(|&it| it + by * (key as f32 / (keys - 1) as f32 - 0.5)).collect();
    let meshes = BTreeMap::from([(number, (0..keys).map(at).collect())]);
    scene.motion = Some(Motion { keys, meshes, ..Motion::default() });
    scene
}

/// A disc of radius 0.4 that slides by one unit over a film of two: a point at (x, y) is covered while the chord at y
/// passes.
#[test]
fn a_disc_that_slides_covers_each_pixel_for_as_long_as_it_is_there() {
    const SIDE: u32 = 32;
    const RADIUS: f64 = 0.4;
    let optics = Optics { projection: Projection::Orthographic { height: 2.0 }, ..Optics::default() };
    let still = glowing(&disc(Vec3::new(0.0, 0.0, -1.0), RADIUS as f32, 512), optics);
    let covered = |x: f64, y: f64| {
        let half = (RADIUS * RADIUS - y * y).max(0.0).sqrt();
        // The disc's middle is at -0.5 to 0.5.
        ((x + half).min(0.5) - (x - half).max(-0.5)).max(0.0)
    };
    for keys in [3, 5] {
        let picture = pixels(&render(&sliding(still.clone(), Vec3::X, keys), &settings(SIDE, 4096, 0)));
        let mut squares = 0.0;
        for (i, pixel) in picture.iter().enumerate() {
            const PARTS: u32 = 32;
            let place = |pixel: u32, part: u32| {
                2.0 * (f64::from(pixel) + (f64::from(part) + 0.5) / f64::from(PARTS)) / f64::from(SIDE) - 1.0
            };
            let (column, row) = (i as u32 % SIDE, i as u32 / SIDE);
            let parts = (0..PARTS).flat_map(|y| (0..PARTS).map(move |x| (x, y)));
            let sum: f64 = parts.map(|(x, y)| covered(place(column, x), place(row, y))).sum();
            let off = pixel.x - sum / f64::from(PARTS * PARTS);
            assert!(off.abs() < 0.01, "{keys} keys, pixel {column}, {row}: {off}");
            squares += off * off;
        }
        let rms = (squares / picture.len() as f64).sqrt();
        assert!(rms < 0.002, "{keys} keys: {rms}");
        // The disc's area, as large as it is everywhere.
        let mean = picture.iter().map(|pixel| pixel.x).sum::<f64>() / picture.len() as f64;
        let exact = std::f64::consts::PI * RADIUS * RADIUS / 4.0;
        assert!((mean / exact - 1.0).abs() < 0.002, "{mean} {exact}");
    }
}

/// A shutter that opens and closes slowly has seen the edges for a shorter time.
#[test]
fn a_slow_shutter_fades_the_edges() {
    let optics = Optics { projection: Projection::Orthographic { height: 2.0 }, ..Optics::default() };
    let line = [[-0.02, -1.0], [0.02, -1.0], [0.02, 1.0], [-0.02, 1.0]].map(|[x, y]| Vec3::new(x, y, -1.0));
    let mut scene = sliding(glowing(&quad(line), optics), Vec3::X, 3);
    let at = |scene: &Scene, x: f64| {
        let picture = pixels(&render(scene, &settings(40, 2048, 0)));
        let column = ((x + 1.0) * 20.0) as usize;
        (0..40).map(|row| picture[40 * row + column].x).sum::<f64>() / 40.0
    };
    // 0.04 of the way, as long as it is at 0.025 off the middle or the end, where the openness is 1/(1 - r), and
    // 0.025/r of it.
    let even = at(&scene, 0.025);
    assert!((even - 0.04).abs() < 0.0005, "{even}");
    scene.motion.as_mut().unwrap().ramp = 0.25;
    let (middle, late) = (at(&scene, 0.025), at(&scene, 0.375));
    assert!((middle * 0.75 - 0.04).abs() < 0.0005, "{middle}");
    assert!((late / middle - (0.5 - 0.375) / 0.25).abs() < 0.02, "{late} {middle}");
}

/// A floor of white plaster under a roof, as wide as the camera sees.
fn floor() -> Vec<[Vec3; 3]> {
    quad([[-4.0, 1.0], [4.0, 1.0], [4.0, -9.0], [-4.0, -9.0]].map(|[x, z]| Vec3::new(x, -1.0, z))).to_vec()
}

fn lit_floor(lamp: &[[Vec3; 3]]) -> Scene {
    let mut glow = material(Vec3::ZERO, Vec3::splat(5.0));
    glow.emits_both_sides = true;
    Scene {
        meshes: vec![mesh(&floor(), 1), mesh(lamp, 0)],
        materials: vec![glow, Material::matte(Vec3::splat(0.7))],
        camera: Some(FRONT),
        ..Scene::default()
    }
}

fn mean(scene: &Scene, settings: &Settings, count: u64) -> Estimate {
    Estimate::of_means(&seeds(scene, settings, count))
}

/// Light samples find a lamp where it is at their time, and weigh against bounces that do.
#[test]
fn a_lamp_that_moves_lights_alike_however_it_is_sampled() {
    let lamp = quad([[-0.3, -0.2], [0.3, -0.2], [0.3, 0.2], [-0.3, 0.2]].map(|[x, y]| Vec3::new(x, 0.2 + y, -3.0 + y)));
    let scene = sliding(lit_floor(&lamp), Vec3::new(4.0, 0.6, 1.0), 3);
    let by = |lights| {
        let integrator = Integrator::Path(PathOptions { max_depth: 3, lights, ..PathOptions::default() });
        mean(&scene, &Settings { integrator, ..settings(24, 256, 0) }, 12)
    };
    let naive = by(LightSampling::Naive);
    for lights in [LightSampling::Mis, LightSampling::Direct] {
        let other = by(lights);
        assert!(other.z(&naive, 0.001).max_element() < 4.5, "{lights:?}: {other:?} {naive:?}");
    }
    // As many still lamps on its way give the same.
    let still = |number: u64| {
        let by = Vec3::new(4.0, 0.6, 1.0) * ((number as f32 + 0.5) / 64.0 - 0.5);
        let mut scene = lit_floor(&lamp);
        scene.meshes[1].positions.iter_mut().for_each(|it| *it += by);
        mean(&scene, &settings(24, 16, 100 * number), 2).mean
    };
    let stills = (0..64).map(still).sum::<DVec3>() / 64.0;
    let moving = mean(&scene, &settings(24, 256, 0), 12);
    assert!((moving.mean / stills - 1.0).abs().max_element() < 0.01, "{moving:?} {stills}");
}

/// Points, spots that turn and suns light as the mean of their places does.
#[test]
fn delta_lights_move() {
    let point = |x: f32| PunctualLight::Point { position: Vec3::new(x, 0.5, -3.0), intensity: Vec3::ONE, radius: 0.0 };
    let spot = |x: f32| PunctualLight::Spot {
        position: Vec3::new(0.0, 1.0, -3.0),
        direction: Vec3::new(x, -1.0, 0.0).normalize(),
        intensity: Vec3::ONE,
        radius: 0.0,
        cos_inner: 0.96,
        cos_outer: 0.9,
        edge: Default::default(),
    };
    let sun = |x: f32| PunctualLight::Directional {
        direction: Vec3::new(1.2 * x, -0.2, 0.0).normalize(),
        irradiance: Vec3::ONE,
        half_angle: 0.0,
    };
    // A wall that each side of shuts out light, so that many points get none in the middle of the time.
    let wall = quad([[-1.0, 1.0], [0.3, 1.0], [0.3, -9.0], [-1.0, -9.0]].map(|[y, z]| Vec3::new(0.1, y, z)));
    let kinds: [&dyn Fn(f32) -> PunctualLight; 3] = [&point, &spot, &sun];
    for (kind, light) in kinds.into_iter().enumerate() {
        let scene = |light: PunctualLight| {
            let mut scene = lit_floor(&wall);
            scene.meshes[1].material = 1;
            scene.lights.push(light);
            scene
        };
        let keys = 9;
        let place = |key: usize| 2.0 * key as f32 / (keys - 1) as f32 - 1.0;
        let mut moving = scene(light(0.0));
        let lights = BTreeMap::from([(0, (0..keys).map(|key| light(place(key))).collect())]);
        moving.motion = Some(Motion { keys, lights, ..Motion::default() });
        let moving = mean(&moving, &settings(24, 256, 0), 8);
        let stills: Vec<Scene> = (0..64).map(|i| scene(light((i as f32 + 0.5) / 32.0 - 1.0))).collect();
        let still = |(number, scene): (u64, &Scene)| mean(scene, &settings(24, 16, 100 * number), 2).mean;
        let stills = (0..).zip(&stills).map(still).sum::<DVec3>() / 64.0;
        assert!((moving.mean / stills - 1.0).abs().max_element() < 0.015, "{kind}: {moving:?} {stills}");
    }
}

/// Instances move by their transforms as copies do by their vertices, and a camera as the world does the other way.
#[test]
fn instances_and_cameras_move_as_vertices_do() {
    let turned = |key: usize| {
        let angle = 0.25 * (key as f32 - 2.0);
        Affine3A::from_rotation_translation(Quat::from_rotation_z(angle), Vec3::new(angle, 0.0, -3.0))
    };
    let blade = quad([[-0.8, -0.2], [0.8, -0.2], [0.8, 0.2], [-0.8, 0.2]].map(|[x, y]| Vec3::new(x, y, 0.1 * x)));
    let scene = |placed: bool| {
        let mut scene = lit_floor(&blade);
        scene.sky.radiance = Vec3::splat(0.5);
        scene.meshes[1].material = 1;
        // Vertex normals, which turn with the blade.
        scene.meshes[1].normals = vec![Vec3::new(0.1, 0.3, 1.0).normalize(); 6];
        let mut motion = Motion { keys: 5, ..Motion::default() };
        if placed {
            let own = scene.meshes[1].positions.clone();
            let at = |key: usize| own.iter().map(|&it| turned(key).transform_point3(it)).collect::<Vec<_>>();
            let places: Vec<Vec<Vec3>> = (0..5).map(at).collect();
            scene.meshes[1].positions = places[2].clone();
            motion.meshes.insert(1, places);
        } else {
            scene.meshes[1].object = Some(0);
            scene.objects.push(Object::default());
            scene.instances.push(Instance { object: 0, to_world: turned(2) });
            motion.instances.insert(0, (0..5).map(turned).collect());
        }
        scene.motion = Some(motion);
        scene
    };
    let [copy, instance] = [true, false].map(|placed| pixels(&render(&scene(placed), &settings(48, 256, 3))));
    let mean = copy.iter().map(|it| it.x).sum::<f64>() / copy.len() as f64;
    let off = copy.iter().zip(&instance).map(|(a, b)| (a.x - b.x).abs()).sum::<f64>() / copy.len() as f64;
    assert!(off < 2e-3 * mean, "{off} of {mean}");

    let by = Vec3::new(0.7, 0.2, 0.0);
    let mut moved = lit_floor(&blade.map(|corners| corners.map(|it| it - 3.0 * Vec3::Z)));
    moved.sky.radiance = Vec3::splat(0.5);
    let mut seen = moved.clone();
    let keys: Vec<Vec3> = (0..3).map(|key| by * (key as f32 / 2.0 - 0.5)).collect();
    let pose = |&by: &Vec3| CameraPose { eye: FRONT.eye + by, target: FRONT.target + by, ..FRONT };
    seen.motion = Some(Motion { keys: 3, cameras: keys.iter().map(pose).collect(), ..Motion::default() });
    let world = (0..2).map(|mesh| {
        let at = |by: &Vec3| moved.meshes[mesh].positions.iter().map(|&it| it - *by).collect::<Vec<_>>();
        (mesh, keys.iter().map(at).collect::<Vec<_>>())
    });
    let meshes = world.collect();
    moved.motion = Some(Motion { keys: 3, meshes, ..Motion::default() });
    let [camera, world] = [&seen, &moved].map(|scene| pixels(&render(scene, &settings(32, 1024, 1))));
    let off = camera.iter().zip(&world).map(|(a, b)| (a.x - b.x) * (a.x - b.x)).sum::<f64>() / camera.len() as f64;
    assert!(off.sqrt() < 0.01, "{off}");
}

/// A camera that turns on the spot sees a row of the sky for the time that each direction is before it.
#[test]
fn a_camera_that_turns_sees_all_that_it_passes() {
    let pose = |angle: f32| {
        let (sin, cos) = angle.sin_cos();
        CameraPose { target: Vec3::new(sin, 0.0, -cos), ..FRONT }
    };
    let disc: Vec<[Vec3; 3]> = disc(Vec3::new(0.0, 0.0, -5.0), 0.5, 128);
    let mut scene = glowing(&disc, Optics::default());
    let cameras = (0..17).map(|key| pose(0.4 * (key as f32 / 8.0 - 1.0))).collect();
    scene.motion = Some(Motion { keys: 17, cameras, ..Motion::default() });
    let blurred = pixels(&render(&scene, &settings(32, 1024, 0)));
    let mut sum = vec![DVec3::ZERO; blurred.len()];
    const STILLS: usize = 64;
    for number in 0..STILLS {
        let still = Scene {
            motion: None,
            camera: Some(pose(0.4 * ((number as f32 + 0.5) / STILLS as f32 * 2.0 - 1.0))),
            ..scene.clone()
        };
        for (sum, pixel) in sum.iter_mut().zip(pixels(&render(&still, &settings(32, 16, number as u64)))) {
            *sum += pixel / STILLS as f64;
        }
    }
    let squares = blurred.iter().zip(&sum).map(|(a, b)| (a.x - b.x) * (a.x - b.x)).sum::<f64>();
    let rms = (squares / blurred.len() as f64).sqrt();
    assert!(rms < 0.006, "{rms}");
}
