//! AOVs beyond the first surface, against the picture itself: masks of names, and light path expressions.

use std::collections::{BTreeMap, BTreeSet};

use glam::{Affine3A, Vec3};
use halfdome::film::Picture;
use halfdome::material::Inputs;
use halfdome::output::read_exr;
use halfdome::scene::{CameraPose, Instance, LightLabel, Material, Mesh, Object, PunctualLight, Scene, Sky};
use halfdome::settings::{Aov, Cryptomatte, Filter, Integrator, LightSampling, MatteKind, PathOptions, Settings, Stop};
use halfdome_tests::program::Program;
use halfdome_tests::render::{material, mesh, quad, render};
use tempfile::TempDir;

mod light_paths;
mod masks;
mod motion;

fn values<'a>(picture: &'a Picture, name: &str) -> &'a [f32] {
    &picture.channel(name).unwrap_or_else(|| panic!("there is no {name}")).values
}

/// Black slats with three names and two materials before a white sky.
fn slats() -> Scene {
    let slat = |i: u32| {
        let (left, z) = (0.11 * i as f32, 0.01 * i as f32);
        let corner = |x: f32, y: f32| Vec3::new(left + x, y, z);
        Mesh {
            name: format!("slat {}", i % 3),
            positions: vec![corner(-0.7, -0.6), corner(-0.6, -0.5), corner(-0.5, 0.6), corner(-0.6, 0.7)],
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            material: i as usize % 2,
            ..Mesh::default()
        }
    };
    let material = |name: &str| Material { name: name.to_owned(), ..Material::matte(Vec3::ZERO) };
    let camera = CameraPose { eye: Vec3::Z * 3.0, target: Vec3::ZERO, up: Vec3::Y, vfov: 35.0 };
    Scene {
        meshes: (0..8).map(slat).collect(),
        materials: vec![material("a"), material("b")],
        sky: Sky { radiance: Vec3::ONE, picture: None },
        camera: Some(camera),
        ..Scene::default()
    }
}

fn aovs(expressions: &[(&str, &str)]) -> Vec<Aov> {
    expressions.iter().map(|(name, text)| Aov::new(name, text).unwrap()).collect()
}

/// Asserts that AOVs sum to the picture.
fn assert_sum(picture: &Picture, names: &[&str]) {
    for c in ["R", "G", "B"] {
        for (pixel, &expected) in values(picture, c).iter().enumerate() {
            let sum: f64 = names.iter().map(|name| f64::from(values(picture, &format!("{name}.{c}"))[pixel])).sum();
            let expected = f64::from(expected);
            assert!((sum - expected).abs() <= 1e-6 * expected.max(1e-3), "{names:?} {c} {pixel}: {sum}, {expected}");
        }
    }
}

/// The mean over all pixels of each channel of an AOV, and of its square.
fn mean(picture: &Picture, name: &str) -> [f64; 3] {
    ["R", "G", "B"].map(|c| {
        let values = values(picture, &format!("{name}.{c}"));
        values.iter().map(|&value| f64::from(value)).sum::<f64>() / values.len() as f64
    })
}

fn program(folder: &TempDir) -> Program<'_> {
    Program { executable: env!("CARGO_BIN_EXE_halfdome-under-test"), folder: folder.path() }
}

const SCENE: &str = r#"
    [scene]
    file = "floor.obj"
    [film]
    width = 40
    height = 34
    aov = true
    cryptomatte = ["object"]
    light_groups = true
    [render]
    spp = 6
    [[aov]]
    name = "key"
    lpe = "CD<L.'key'>"
    [[light]]
    type = "point"
    name = "left"
    group = "key"
    position = [1, 2, 1]
    power = 60
    [[light]]
    type = "sphere"
    name = "bulb"
    position = [-1, 2, 1]
    radius = 0.2
    power = 30
    [sky]
    radiance = 0.1
"#;
const FLOOR: &str = "o floor\nv -2 0 -2\nv 2 0 -2\nv 2 0 2\nv -2 0 2\nf 1 4 3 2\n";

#[test]
fn parts_of_a_picture_with_all_aovs_are_the_whole() {
    let folder = tempfile::tempdir().unwrap();
    let program = program(&folder);
    program.put("s.toml", SCENE);
    program.put("floor.obj", FLOOR);
    let run = |line: &str| {
        let outcome = program.run_reproducibly(line);
        assert_eq!(outcome.code, Some(0), "{line}: {}", outcome.stderr);
    };
    let scene = "s.toml --eye 1,2,4 --target 0,0,0 --lpe sky=C.*B";
    run(&format!("render {scene} --threads 2 -o whole.exr"));
    run(&format!("render {scene} --threads 1 --shard 1/2 -o a.hdf"));
    run(&format!("render {scene} --shard 2/2 --spp 4 -o b.hdf"));
    run(&format!("render {scene} --shard 2/2 --first-sample 4 -o c.hdf"));
    run("merge c.hdf a.hdf b.hdf -o merged.exr");
    // A render that goes on with more samples than it had.
    run(&format!("render {scene} --spp 2 -o some.hdf"));
    run(&format!("render {scene} --resume -o some.hdf -o resumed.exr"));
    let files = program.files();
    let file = |name: &str| files[std::ffi::OsStr::new(name)].as_ref().unwrap();
    assert!(file("whole.exr") == file("merged.exr"));
    assert!(file("whole.exr") == file("resumed.exr"));
    let picture = read_exr(&folder.path().join("whole.exr")).unwrap();
    assert_sum(&picture, &["Light_key", "Light_bulb", "Light_sky"]);
    assert_eq!(values(&picture, "sky.B"), values(&picture, "Light_sky.B"));
    assert!(mean(&picture, "key")[0] > 0.0);
    assert!(values(&picture, "Samples.Y").iter().all(|&samples| samples == 6.0));
    let manifest = picture.metadata.attributes.iter().find(|(key, _)| key.ends_with("/manifest")).unwrap().1;
    assert!(manifest.contains("\"bulb\"") && manifest.contains("\"floor\""), "{manifest}");
}

#[test]
fn wrong_expressions_are_shown_with_their_place() {
    let folder = tempfile::tempdir().unwrap();
    let program = program(&folder);
    let before = program.files();
    for (arguments, parts) in [
        (&["--lpe", "x=C<RD"][..], &["this `<` is not closed\n    C<RD\n     ^\n", "write `>` where it ends"][..]),
        (&["--lpe", "CDL"], &["\"CDL\" has no name", "NAME=EXPRESSION"]),
        (&["--lpe", "x=CDL", "--integrator", "direct"], &["direct follows no light paths"]),
        (&["--light-groups", "--stop", "threshold", "--add-back"], &["--add-back adds light without a path"]),
        (&["--lpe", "x=C.*R.{60}L"], &["too complex"]),
        (&["--cryptomatte", "objects"], &["object, material", "did you mean `object`"]),
        (&["--cryptomatte-levels", "0"], &["a whole number from 1 to 64"]),
    ] {
        let outcome = program.run(&[&["render", "cornell", "--size", "8x8", "-o", "x.exr"][..], arguments].concat());
        assert_eq!(outcome.code, Some(1), "{arguments:?}: {}", outcome.stderr);
        parts.iter().for_each(|part| assert!(outcome.stderr.contains(part), "{part:?}: {}", outcome.stderr));
    }
    let outcome = program.run_line("render cornell --size 8x8 --spp 1 --light-groups -o x.png");
    assert!(outcome.code == Some(0) && outcome.stderr.contains("PNG has none: add an .exr"), "{}", outcome.stderr);
    std::fs::remove_file(folder.path().join("x.png")).unwrap();
    program.put("floor.obj", FLOOR);
    program.put("s.toml", SCENE.replace("CD<L.'key'>", "CD<L.'key'"));
    let outcome = program.run_line("render s.toml");
    assert!(
        outcome.stderr.contains("s.toml:14: this `<` is not closed\n    CD<L.'key'\n      ^"),
        "{}",
        outcome.stderr
    );
    assert_eq!(outcome.code, Some(1));
    assert_eq!(program.files().len(), before.len() + 2, "nothing is written");
}

#[test]
fn hits_of_first_samples_are_what_a_single_ray_sees() {
    let scene = slats();
    let settings = Settings { width: 40, height: 34, aov: true, spp: 1, ..Settings::default() };
    let (one, many) = (render(&scene, &settings), render(&scene, &Settings { spp: 9, ..settings.clone() }));
    let pixels = values(&one, "R").len();
    for name in ["Depth.Z", "Id.Object", "Id.Material", "Id.Triangle", "Id.Instance", "forward.u", "forward.v"] {
        assert_eq!(values(&one, name), values(&many, name), "{name}");
    }
    let (mut hits, mut objects) = (0, BTreeSet::new());
    for pixel in 0..pixels {
        let at = |name: &str| values(&one, name)[pixel];
        let [object, material, triangle] = ["Id.Object", "Id.Material", "Id.Triangle"].map(at);
        if object == 0.0 {
            assert_eq!((material, triangle, at("Depth.Z"), at("R")), (0.0, 0.0, 1e10, 1.0));
            continue;
        }
        // With one sample of a box filter the position is the hit's; the camera looks along -z from 3.
        assert!((at("Depth.Z") - (3.0 - at("P.Z"))).abs() < 1e-5);
        assert!((1.0..=2.0).contains(&triangle));
        assert_eq!(material, 1.0 + (object - 1.0) % 2.0);
        hits += 1;
        objects.insert(object as u32);
    }
    assert!(hits > 100 && objects.len() == 8, "{hits}, {objects:?}");
    assert_eq!((values(&many, "UV.U"), values(&many, "UV.V")), (values(&many, "u"), values(&many, "v")));
    assert!(values(&many, "Samples.Y").iter().all(|&samples| samples == 9.0));
}
