//! AOVs beyond the first surface, against the picture itself: masks of names, and light path expressions.

use std::collections::{BTreeMap, BTreeSet};

use glam::{Affine3A, Vec3};
use halfdome::film::Picture;
use halfdome::material::Inputs;
use halfdome::output::read_exr;
use halfdome::scene::{CameraPose, Instance, LightLabel, Material, Mesh, Object, PunctualLight, Scene, Sky};
use halfdome::settings::{Aov, Cryptomatte, Filter, Integrator, LightSampling, MatteKind, PathOptions, Settings, Stop};
use halfdome_tests::program::Program;
use halfdome_tests::render::{mesh, quad, render};
use tempfile::TempDir;

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

#[test]
fn coverage_is_what_does_not_show_the_sky() {
    let scene = slats();
    for filter in [Filter::default(), Filter::from_name("gaussian", None, None).unwrap()] {
        let cryptomatte = Cryptomatte { kinds: MatteKind::ALL.to_vec(), levels: 6 };
        let settings = Settings { width: 48, height: 40, spp: 16, filter, cryptomatte, ..Settings::default() };
        let plain = render(&scene, &Settings { cryptomatte: Cryptomatte::default(), ..settings.clone() });
        let picture = render(&scene, &settings);
        let radiance = values(&picture, "R");
        assert_eq!(radiance, values(&plain, "R"), "the picture is the same");
        let mut partly = 0;
        for kind in MatteKind::ALL {
            let channel = |pair: usize, c: &str| values(&picture, &format!("{}{pair:02}.{c}", kind.layer()));
            for (pixel, radiance) in radiance.iter().enumerate() {
                let covers: Vec<f32> = (0..3).flat_map(|pair| ["G", "A"].map(|c| channel(pair, c)[pixel])).collect();
                let sum: f32 = covers.iter().sum();
                assert!((sum - (1.0 - radiance)).abs() < 1e-6, "{kind:?}, {pixel}: {sum} and {radiance}");
                assert!(covers.is_sorted_by(|a, b| a >= b), "{covers:?}");
                partly += usize::from(covers[1] > 0.0);
                for (pair, [id, cover]) in (0..3).flat_map(|pair| [(pair, ["R", "G"]), (pair, ["B", "A"])]) {
                    let id = channel(pair, id)[pixel];
                    assert_eq!(id == 0.0, channel(pair, cover)[pixel] == 0.0);
                }
            }
        }
        assert!(partly > 100, "{partly} pixels have more than one name");
        let ids = |layer: &str| {
            let mut ids: Vec<u32> =
                values(&picture, layer).iter().map(|id| id.to_bits()).filter(|&id| id != 0).collect();
            ids.sort_unstable();
            ids.dedup();
            ids.len()
        };
        assert_eq!((ids("CryptoObject00.R"), ids("CryptoMaterial00.R")), (3, 2));
    }
}

#[test]
fn an_instance_has_the_name_of_its_object_also_where_it_emits() {
    let glowing = || {
        let mut scene = slats();
        scene.materials[1].emission = Vec3::splat(0.5);
        scene
    };
    // Five slats of an object, and one of an object without a name, which keeps its own.
    let mut instanced = glowing();
    instanced.objects = vec![Object { name: "fan".to_owned() }, Object::default()];
    for (number, mesh) in instanced.meshes[..6].iter_mut().enumerate() {
        mesh.object = Some(usize::from(number == 5));
    }
    let ups = [(0, 0.0), (0, 0.25), (1, 0.0)];
    let instance = |(object, up)| Instance { object, to_world: Affine3A::from_translation(Vec3::Y * up) };
    instanced.instances = ups.map(instance).into();
    // The same as meshes of their own.
    let mut copied = glowing();
    copied.meshes[..5].iter_mut().for_each(|mesh| mesh.name = "fan".to_owned());
    let mut higher = copied.meshes[..5].to_vec();
    higher.iter_mut().flat_map(|mesh| &mut mesh.positions).for_each(|position| position.y += 0.25);
    copied.meshes.append(&mut higher);
    let cryptomatte = Cryptomatte { kinds: vec![MatteKind::Object], levels: 6 };
    let aovs = aovs(&[("fan", "C.*<O.'fan'>"), ("rest", "C.*<[OB].[^'fan']>")]);
    let settings = Settings { width: 48, height: 40, spp: 8, cryptomatte, aovs, ..Settings::default() };
    let [instanced, copied] = [instanced, copied].map(|scene| render(&scene, &settings));
    let covered = |picture: &Picture| {
        let mut covered = BTreeMap::new();
        for (id, cover) in [("00.R", "00.G"), ("00.B", "00.A"), ("01.R", "01.G"), ("01.B", "01.A")] {
            let [id, cover] = [id, cover].map(|channel| values(picture, &format!("CryptoObject{channel}")));
            for (id, cover) in id.iter().zip(cover).filter(|(id, _)| **id != 0.0) {
                *covered.entry(id.to_bits()).or_insert(0.0) += f64::from(*cover);
            }
        }
        covered
    };
    let (found, expected) = (covered(&instanced), covered(&copied));
    assert_eq!(expected.len(), 4, "fan and three of slats");
    assert_eq!(found.keys().collect::<Vec<_>>(), expected.keys().collect::<Vec<_>>());
    for (id, expected) in expected {
        assert!((found[&id] - expected).abs() < 0.5, "{id:x}: {} and {expected}", found[&id]);
    }
    for picture in [&instanced, &copied] {
        assert_sum(picture, &["fan", "rest"]);
    }
    let [found, expected] = [&instanced, &copied].map(|picture| mean(picture, "fan")[0]);
    assert!(expected > 0.01 && (found - expected).abs() < 0.01 * expected, "{found}, {expected}");
}

/// A room with every kind of light and lobe: a layered floor, a rough metal and a clear glass ball's worth of panes, a
/// lamp and a glowing panel with names, a point light, and a sky.
fn mixed() -> Scene {
    let gloss = Inputs { base_color: Vec3::new(0.7, 0.2, 0.1), specular_weight: 1.0, ..Inputs::default() };
    let coated = Inputs { coat_weight: 0.5, coat_roughness: 0.1, fuzz_weight: 0.3, specular_roughness: 0.4, ..gloss };
    let metal = Inputs { base_metalness: 1.0, specular_roughness: 0.5, base_color: Vec3::new(0.9, 0.6, 0.3), ..gloss };
    let glass = Inputs { transmission_weight: 1.0, specular_roughness: 0.0, thin_walled: true, ..gloss };
    let frosted = Inputs { transmission_weight: 0.7, specular_roughness: 0.3, ..gloss };
    let leaf = Inputs { diffuse_transmission_weight: 0.5, ..Inputs::default() };
    let named = |name: &str, inputs: Inputs| Material { name: name.to_owned(), inputs, ..Material::default() };
    let mut panel = named("panel", Inputs::default());
    (panel.emission, panel.emits_both_sides) = (Vec3::new(1.0, 2.0, 4.0), true);
    let mut lamp = Material { light_group: "key".to_owned(), ..panel.clone() };
    lamp.emission = Vec3::new(9.0, 6.0, 3.0);
    let materials = vec![
        named("floor", coated),
        named("metal", metal),
        named("glass", glass),
        named("frosted", frosted),
        named("leaf", leaf),
        panel,
        lamp,
    ];
    let place = |name: &str, material: usize, center: Vec3, side: f32, across: [Vec3; 2]| {
        let corner = |x: f32, y: f32| center + 0.5 * side * (x * across[0] + y * across[1]);
        let triangles = quad([corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)]);
        Mesh { name: name.to_owned(), ..mesh(&triangles, material) }
    };
    let (level, upright) = ([Vec3::X, Vec3::NEG_Z], [Vec3::X, Vec3::Y]);
    let mut lamp = place("lamp", 6, Vec3::new(-0.5, 1.8, 0.0), 0.4, level);
    lamp.is_added = true;
    let meshes = vec![
        place("floor", 0, Vec3::ZERO, 4.0, level),
        place("back", 1, Vec3::new(0.0, 1.0, -1.5), 3.0, upright),
        place("pane", 2, Vec3::new(-0.6, 0.6, 0.3), 0.7, upright),
        place("frosted", 3, Vec3::new(0.2, 0.5, 0.2), 0.6, upright),
        place("leaf", 4, Vec3::new(0.9, 0.5, 0.0), 0.6, upright),
        place("panel", 5, Vec3::new(0.25, 0.4, -0.8), 0.6, upright),
        lamp,
    ];
    let camera =
        CameraPose { eye: Vec3::new(0.2, 1.1, 3.2), target: Vec3::new(0.0, 0.6, 0.0), up: Vec3::Y, vfov: 50.0 };
    let sky = Sky { radiance: Vec3::new(0.1, 0.15, 0.3), picture: None };
    let mut scene = Scene { meshes, materials, sky, camera: Some(camera), ..Scene::default() };
    let intensity = Vec3::new(0.5, 1.0, 0.5);
    let point = |x: f32| PunctualLight::Point { position: Vec3::new(x, 1.5, 1.0), intensity, radius: 0.0 };
    scene.add_light(point(1.0), LightLabel { name: "left".to_owned(), group: "key".to_owned() });
    scene.lights.push(point(-1.0));
    scene
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

#[test]
fn disjoint_expressions_sum_to_the_picture() {
    let scene = mixed();
    let by_lobe = [("seen", "C[LB]"), ("d", "CD.*"), ("g", "CG.*"), ("s", "CS.*")];
    let by_length = [("none", "C."), ("one", "C.."), ("two", "C..."), ("more", "C.{4,}")];
    let by_side = [("r", "C(R.*)?[LB]"), ("t", "CT.*")];
    let by_light = [("o", "C.*O"), ("l", "C.*<[^OB]x>"), ("b", "C.*B")];
    let by_floor = [("on", "C.*<.[DGS]'floor'>.*"), ("off", "C<.[DGS][^'floor']>*[LB]")];
    let all = [&by_lobe[..], &by_length, &by_side, &by_light, &by_floor].concat();
    let base = Settings { width: 40, height: 36, spp: 8, ..Settings::default() };
    let path = |options: PathOptions| Integrator::Path(options);
    for integrator in [
        path(PathOptions::default()),
        path(PathOptions { lights: LightSampling::Naive, ..PathOptions::default() }),
        path(PathOptions { lights: LightSampling::Direct, clamp_indirect: Some(0.5), ..PathOptions::default() }),
        path(PathOptions {
            stop: Stop::Threshold { cutoff: 0.01, add_back: false },
            max_depth: 6,
            ..PathOptions::default()
        }),
    ] {
        let settings = Settings { integrator, ..base.clone() };
        let plain = render(&scene, &settings);
        let picture = render(&scene, &Settings { aovs: aovs(&all), light_groups: true, ..settings.clone() });
        for c in ["R", "G", "B"] {
            assert_eq!(values(&picture, c), values(&plain, c), "AOVs do not change the picture");
        }
        for group in [&by_lobe[..], &by_length, &by_side, &by_light, &by_floor] {
            let names: Vec<&str> = group.iter().map(|(name, _)| *name).collect();
            assert_sum(&picture, &names);
            for name in names {
                let is_there = values(&picture, &format!("{name}.G")).iter().any(|&value| value > 0.0);
                assert!(is_there, "{name} has light");
            }
        }
        assert_sum(&picture, &["Light_key", "Light_panel", "Light_rest", "Light_sky"]);
        let groups = picture.channels.iter().filter(|channel| channel.name.starts_with("Light_")).count();
        assert_eq!(groups, 4 * 3);
    }
}

/// The mean over all pixels of each channel of an AOV, and of its square.
fn mean(picture: &Picture, name: &str) -> [f64; 3] {
    ["R", "G", "B"].map(|c| {
        let values = values(picture, &format!("{name}.{c}"));
        values.iter().map(|&value| f64::from(value)).sum::<f64>() / values.len() as f64
    })
}

#[test]
fn lobes_are_the_same_whether_light_is_sampled_or_found() {
    // What light samples split among lobes, paths choose by chance: in expectation that is the same, in each channel.
    let mut scene = mixed();
    scene.lights.clear();
    scene.light_labels.clear();
    let all = [
        ("rd", "C<RD>[LB]"),
        ("rg", "C<RG>[LB]"),
        ("td", "C<TD>[LB]"),
        ("tg", "C<TG>[LB]"),
        ("dd", "CDD[LB]"),
        ("gd", "CGD[LB]"),
        ("dg", "CDG[LB]"),
    ];
    let by = |lights: LightSampling, spp: u32| {
        let integrator = Integrator::Path(PathOptions { lights, max_depth: 4, ..PathOptions::default() });
        render(&scene, &Settings { width: 24, height: 20, spp, integrator, aovs: aovs(&all), ..Settings::default() })
    };
    let (sampled, found) = (by(LightSampling::Mis, 512), by(LightSampling::Naive, 8192));
    for (name, _) in all {
        let (sampled, found) = (mean(&sampled, name), mean(&found, name));
        for (a, b) in sampled.into_iter().zip(found) {
            assert!(b > 0.0 && (a - b).abs() < 0.03 * b, "{name}: {sampled:?}, {found:?}");
        }
    }
}

#[test]
fn a_mirror_and_a_diffuse_floor_are_what_they_are_alone() {
    // A matte scene has no glossy light; a light seen directly has no surface.
    let picture = render(
        &halfdome::scene::cornell_box(),
        &Settings {
            width: 32,
            height: 32,
            spp: 4,
            aovs: aovs(&[
                ("g", "C.*G.*"),
                ("t", "C.*T.*"),
                ("seen", "CO"),
                ("direct", "CDL"),
                ("red", "CD<RD'left wall'>.*"),
                ("one", "C.*<L.'light'>"),
            ]),
            ..Settings::default()
        },
    );
    for name in ["g", "t"] {
        assert_eq!(mean(&picture, name), [0.0; 3], "{name}");
    }
    assert_eq!(values(&picture, "one.R"), values(&picture, "R"));
    let [red, green, _] = mean(&picture, "red");
    assert!(red > 4.0 * green && green > 0.0, "light by way of the red wall is red: {red}, {green}");
    assert!(mean(&picture, "direct")[0] > 0.0 && mean(&picture, "seen")[0] > 0.0);
}

#[test]
fn expressions_that_cannot_be_followed_are_refused() {
    let with = |integrator: Integrator| Settings { integrator, aovs: aovs(&[("d", "CDL")]), ..Settings::default() };
    assert!(with(Integrator::Path(PathOptions::default())).check_light_paths().is_ok());
    let problem = |settings: &Settings| settings.check_light_paths().unwrap_err().to_string();
    assert!(problem(&with(Integrator::named("cached").unwrap())).contains("cached follows no light paths"));
    let stop = Stop::Threshold { cutoff: 0.1, add_back: true };
    assert!(problem(&with(Integrator::Path(PathOptions { stop, ..PathOptions::default() }))).contains("--add-back"));
    let twice = Settings { aovs: aovs(&[("d", "CDL"), ("d", "CGL")]), ..Settings::default() };
    assert!(problem(&twice).contains("two AOVs are called"));
    for name in ["", "a.b", "R", "Noisy", "CryptoObject", "Light_x", "ä"] {
        assert!(Aov::new(name, "C.*").is_err(), "{name}");
    }
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
    assert!(outcome.code == Some(0) && outcome.stderr.contains("PNG has none: name an .exr"), "{}", outcome.stderr);
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

/// Groups of an OBJ file are objects, in masks and by their names in light path expressions.
#[test]
fn groups_of_obj_are_objects() {
    let folder = tempfile::tempdir().unwrap();
    let program = Program { executable: env!("CARGO_BIN_EXE_halfdome-under-test"), folder: folder.path() };
    let square = |left: f32| format!("v {left} 0 0\nv {} 0 0\nv {} 1 0\nv {left} 1 0\n", left + 1.0, left + 1.0);
    let faces = "o chair\nf 1 2 3 4\ng seat\nf 5 6 7 8\ng\nf 9 10 11 12\n";
    program.put("room.obj", [square(0.0), square(2.0), square(4.0), faces.to_owned()].concat());
    let line = "render room.obj --eye 2.5,0.5,5 --target 2.5,0.5,0 --sky 1 --size 32x16 --spp 4 --aov --cryptomatte object \
                --lpe seat=C<..'seat'>.* --progress none -o room.exr";
    let outcome = program.run_line(line);
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    let picture = read_exr(&folder.path().join("room.exr")).unwrap();
    let manifest = picture.metadata.attributes.iter().find(|(name, _)| name.ends_with("/manifest")).unwrap().1;
    let names: BTreeSet<&str> = manifest.split('"').filter(|word| ["chair", "seat"].contains(word)).collect();
    assert_eq!(names, BTreeSet::from(["chair", "seat"]), "{manifest}");
    // The light of the seat is there where its object is, and nowhere else.
    let objects = values(&picture, "Id.Object");
    let seat = values(&picture, "seat.R");
    let middle = |x: usize| 8 * 32 + x;
    assert!(
        seat[middle(16)] > 0.0 && seat[middle(6)] == 0.0 && seat[middle(25)] == 0.0,
        "{:?}",
        &seat[middle(0)..middle(32)]
    );
    assert!(objects[middle(16)] == 2.0 && objects[middle(6)] == 1.0 && objects[middle(25)] == 3.0);
}
