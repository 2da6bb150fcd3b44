//! Instances: shared meshes look like copies, and rays leave them as they leave other surfaces.

use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use glam::{Affine3A, EulerRot, Quat, Vec3};
use halfdome::driver;
use halfdome::scene::{CameraPose, Instance, Material, Object, Overrides, Scene, Sharing, open_with};
use halfdome::settings::{Integrator, LightSampling, PathOptions, Settings};
use halfdome::world::World;
use halfdome_tests::render::{Estimate, NeverStops, mesh, pixels, quad, render};

/// A sphere of radius 1 about the origin with vertex normals and texture coordinates, as OBJ.
fn sphere(rings: usize) -> String {
    let mut text = String::from("mtllib ball.mtl\nusemtl skin\n");
    let sectors = 2 * rings;
    for i in 0..=rings {
        for j in 0..=sectors {
            let (theta, phi) =
                (i as f32 / rings as f32 * std::f32::consts::PI, j as f32 / rings as f32 * std::f32::consts::PI);
            let (x, y, z) = (theta.sin() * phi.cos(), theta.cos(), -theta.sin() * phi.sin());
            let (u, v) = (j as f32 / sectors as f32, 1.0 - i as f32 / rings as f32);
            let _ = writeln!(text, "v {x} {y} {z}\nvn {x} {y} {z}\nvt {u} {v}");
        }
    }
    let at = |i: usize, j: usize| i * (sectors + 1) + j + 1;
    for (i, j) in (0..rings).flat_map(|i| (0..sectors).map(move |j| (i, j))) {
        let corner = |it: usize| format!("{it}/{it}/{it}");
        let corners = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)].map(corner);
        let _ = writeln!(text, "f {}", corners.join(" "));
    }
    text
}

/// A floor, a lamp and balls that are stretched, mirrored and turned, read with their meshes shared as said.
fn balls(folder: &Path, sharing: Sharing) -> Scene {
    let write = |name: &str, text: &str| fs::write(folder.join(name), text).unwrap();
    write("ball.obj", &sphere(32));
    write("ball.mtl", "newmtl skin\nKd .7 .5 .3\nmap_Bump -bm 0.2 bumps.tga\nmap_Kd bumps.tga\n");
    // An uncompressed TGA of 64 x 32 grey squares.
    let mut bumps = vec![0, 0, 3, 0, 0, 0, 0, 0, 0, 0, 0, 0, 64, 0, 32, 0, 8, 0];
    bumps.extend((0..64 * 32).map(|i| if (i % 64 / 4 + i / 64 / 4) % 2 == 0 { 250 } else { 90 }));
    fs::write(folder.join("bumps.tga"), bumps).unwrap();
    write("room.obj", "v -9 -1 -9\nv -9 -1 9\nv 9 -1 9\nv 9 -1 -9\nf 1 2 3 4\n");
    write(
        "balls.toml",
        r#"
        [scene]
        file = "room.obj"
        [camera]
        eye = [0.5, 3, 8]
        target = [0, 0, 0]
        [sky]
        radiance = 0.3
        [[light]]
        type = "rectangle"
        position = [0, 6, 2]
        target = [0, 0, 0]
        size = [1, 1]
        radiance = 20
        [[object]]
        name = "ball"
        file = "ball.obj"
        [[instance]]
        of = "ball"
        at = [-2.2, 0, 0]
        rotate = [20, 50, 70]
        scale = [1, 0.5, 0.7]
        [[instance]]
        of = "ball"
        at = [0, 0, 0.4]
        scale = [-0.8, 0.8, 1]
        [[instance]]
        of = "ball"
        at = [2.2, 0.2, 0]
        rotate = [0, 10, -40]
        scale = [0.4, 1.2, 0.8]
        "#,
    );
    let sharing = Overrides { instances: Some(sharing), ..Overrides::default() };
    let (mut scene, overrides) = open_with(&folder.join("balls.toml"), &sharing).unwrap();
    overrides.apply(&mut scene).unwrap();
    scene
}

fn settings(integrator: Integrator, spp: u32) -> Settings {
    Settings { width: 96, height: 64, spp, integrator, ..Settings::default() }
}

#[test]
fn instances_look_as_their_copies_would() {
    let folder = tempfile::tempdir().unwrap();
    let [shared, copied] = [Sharing::Always, Sharing::Never].map(|sharing| balls(folder.path(), sharing));
    assert_eq!((shared.instances.len(), copied.instances.len()), (3, 0));
    assert_eq!(shared.triangle_count(), copied.triangle_count());
    for name in ["normals", "albedo"] {
        let settings = settings(Integrator::named(name).unwrap(), 4);
        let [a, b] = [&shared, &copied].map(|scene| pixels(&render(scene, &settings)));
        // Rays that pass an edge by a hair may hit what is behind; copies have normals of unit length at their corners.
        let differ = a.iter().zip(&b).filter(|(a, b)| a.distance(**b) > 0.01).count();
        assert!(differ < a.len() / 100, "{name}: {differ} of {}", a.len());
    }
    let settings = settings(Integrator::Path(PathOptions::default()), 64);
    let [a, b] = [&shared, &copied].map(|scene| pixels(&render(scene, &settings)));
    let z = Estimate::of(&a.iter().zip(&b).map(|(a, b)| *a - *b).collect::<Vec<_>>()).z(&glam::DVec3::ZERO.into(), 0.0);
    let mean = b.iter().sum::<glam::DVec3>() / b.len() as f64;
    assert!(z.max_element() < 4.0 && mean.min_element() > 0.1, "{z}, {mean}");
}

#[test]
fn pictures_of_instances_do_not_depend_on_threads() {
    let folder = tempfile::tempdir().unwrap();
    let scene = balls(folder.path(), Sharing::Always);
    let settings = settings(Integrator::Path(PathOptions::default()), 4);
    let picture = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| pixels(&driver::render(&World::new(scene.clone()).unwrap(), &settings, &NeverStops).picture))
    };
    assert_eq!(picture(1), picture(3));
}

/// Under a sky of radiance 1, white surfaces have radiance 1: a ray that started on the wrong side of a surface would
/// be caught in a closed body, or pass it.
#[test]
fn white_instances_of_any_size_and_place_vanish_under_a_white_sky() {
    let corner = |x: f32, y: f32, z: f32| Vec3::new(x, y, z);
    let cube: Vec<[Vec3; 3]> = (0..6)
        .flat_map(|face| {
            let (axis, side) = (face % 3, if face < 3 { 1.0 } else { -1.0 });
            let at = |a: f32, b: f32| {
                let mut point = corner(0.0, 0.0, 0.0);
                (point[axis], point[(axis + 1) % 3], point[(axis + 2) % 3]) = (side, side * a, b);
                point
            };
            quad([at(-1.0, -1.0), at(1.0, -1.0), at(1.0, 1.0), at(-1.0, 1.0)])
        })
        .collect();
    for (size, place, modelled_at) in
        [(1.0, 0.0, 0.0), (1e-3, 50.0, 0.0), (1e3, 1e5, 0.0), (1.0, 0.0, 1e4), (1.0, 1e4, 1e4)]
    {
        let offset = Vec3::new(modelled_at, 0.3 * modelled_at, -modelled_at);
        let cube: Vec<[Vec3; 3]> = cube.iter().map(|corners| corners.map(|p| p + offset)).collect();
        let middle = Vec3::new(place, -0.7 * place, 0.4 * place);
        let at = |x: f32, turn: f32, scale: Vec3| {
            let rotation = Quat::from_euler(EulerRot::XYZ, turn, 2.0 * turn, 3.0 * turn);
            let to_world =
                Affine3A::from_scale_rotation_translation(size * scale, rotation, middle + Vec3::X * (x * size));
            Instance { object: 0, to_world: to_world * Affine3A::from_translation(-offset) }
        };
        let scene = Scene {
            meshes: vec![halfdome::scene::Mesh { object: Some(0), ..mesh(&cube, 0) }],
            materials: vec![Material::matte(Vec3::ONE)],
            objects: vec![Object::default()],
            // They touch and run into each other.
            instances: vec![
                at(-1.5, 0.2, Vec3::ONE),
                at(0.0, 0.9, Vec3::new(1.0, -0.3, 0.6)),
                at(1.6, 0.5, Vec3::splat(0.8)),
            ],
            sky: halfdome::scene::Sky { radiance: Vec3::ONE, ..Default::default() },
            camera: Some(CameraPose {
                eye: middle + size * Vec3::new(0.5, 2.0, 6.0),
                target: middle,
                up: Vec3::Y,
                vfov: 40.0,
            }),
            ..Scene::default()
        };
        let options = PathOptions { lights: LightSampling::Naive, ..PathOptions::default() };
        let found = pixels(&render(&scene, &settings(Integrator::Path(options), 16)));
        let mean = found.iter().map(|pixel| pixel.x).sum::<f64>() / found.len() as f64;
        let low = found.iter().filter(|pixel| pixel.x < 0.999).count();
        assert!(
            (mean - 1.0).abs() < 1e-3,
            "size {size}, at {place}, modelled at {modelled_at}: mean {mean}, {low} low"
        );
    }
}
