//! The output and the exit of bakes.

mod again;
mod shards;

use std::fs;
use std::io::{BufRead as _, BufReader};
use std::path::Path;

use halfdome::output::read_exr;
use halfdome_tests::program::{Outcome, Program};
use serde_json::{Value, json};

use crate::level::{double_sided, level, open_crates, outwards};

const EXECUTABLE: &str = env!("CARGO_BIN_EXE_halfdome-under-test");

/// Options with which a bake takes little time.
const SMALL: &str = "--size 64 --spp 8 --record-rays 64 --progress none";

/// Runs `test` with the program in a folder of its own that has the level.
pub(crate) fn in_folder(test: impl FnOnce(&Program)) {
    let folder = tempfile::tempdir().unwrap();
    let program = Program { executable: EXECUTABLE, folder: folder.path() };
    program.put("level.gltf", level().to_string());
    test(&program);
}

/// What is said of the level: it names an unknown extension.
const WARNING: &str = "warning: level.gltf: EXT_unknown is not read\n";

fn succeed(outcome: &Outcome) {
    succeed_saying(WARNING, outcome);
}

fn succeed_saying(told: &str, outcome: &Outcome) {
    assert_eq!((outcome.code, outcome.stderr.as_str()), (Some(0), told));
}

fn bake(program: &Program, options: &str) -> Outcome {
    program.run_reproducibly(&format!("bake level.gltf -o out.gltf {SMALL} {options}"))
}

/// The channels R, G and B of a picture.
fn colors(path: &Path) -> Vec<Vec<f32>> {
    let picture = read_exr(path).unwrap();
    ["R", "G", "B"].map(|name| picture.channel(name).unwrap().values.clone()).to_vec()
}

#[test]
fn each_preset_writes_its_files_and_nothing_else() {
    for (preset, files) in [
        ("raw", &["level.gltf", "out-0.exr", "out.gltf", "out.json"][..]),
        ("bevy", &["level.gltf", "out-0.exr", "out-0.ktx2", "out.gltf", "out.json"]),
        ("three", &["level.gltf", "out-0.exr", "out-0.hdr", "out.gltf", "out.json"]),
    ] {
        in_folder(|program| {
            succeed(&bake(program, &format!("--preset {preset}")));
            assert_eq!(program.names(), files);
            let baked: Value = serde_json::from_slice(&fs::read(program.folder.join("out.gltf")).unwrap()).unwrap();
            let original = level();
            assert_eq!(baked["materials"][0]["extras"], original["materials"][0]["extras"]);
            assert_eq!(baked["nodes"][0]["extensions"], original["nodes"][0]["extensions"]);
            // Two nodes no longer share a mesh.
            assert_ne!(baked["nodes"][1]["mesh"], baked["nodes"][2]["mesh"]);
            for node in 0..4 {
                let mesh = baked["nodes"][node]["mesh"].as_u64().unwrap() as usize;
                assert!(
                    baked["meshes"][mesh]["primitives"][0]["attributes"]["TEXCOORD_1"].is_u64(),
                    "{preset}, {node}"
                );
            }
            let manifest: Value = serde_json::from_slice(&fs::read(program.folder.join("out.json")).unwrap()).unwrap();
            assert_eq!(manifest["unit"], if preset == "bevy" { "E/pi" } else { "E" });
            assert_eq!(manifest["surfaces"].as_array().unwrap().len(), 4);
            // The new file is a model again, whose coordinates pass the check and are kept.
            let again = program.run_line("bake out.gltf --check-uv --size 64");
            assert_eq!(again.code, Some(0), "{}", again.stdout);
            assert!(again.stdout.contains("the model's second set"), "{}", again.stdout);
        });
    }
}

/// The channels of a KTX2 file's layers, one after the other.
fn layers(path: &Path) -> (u32, Vec<f32>) {
    let bytes = fs::read(path).unwrap();
    let reader = ktx2::Reader::new(&bytes).unwrap();
    let level = reader.levels().next().unwrap();
    let halves = level.data.chunks_exact(2).map(|bytes| half::f16::from_le_bytes([bytes[0], bytes[1]]).to_f32());
    (reader.header().layer_count, halves.collect())
}

#[test]
fn engines_get_directions_as_layers() {
    for (options, file, names, scale) in [
        ("--preset bevy --directional hl2", "out-0.hl2.ktx2", &["hl2.0", "hl2.1", "hl2.2"][..], std::f32::consts::PI),
        ("--preset three --directional sh1", "out-0.sh1.ktx2", &["sh.0", "sh.1-1", "sh.10", "sh.11"], 1.0),
    ] {
        in_folder(|program| {
            succeed(&bake(program, options));
            let manifest: Value = serde_json::from_slice(&fs::read(program.folder.join("out.json")).unwrap()).unwrap();
            assert_eq!(manifest["pages"][0]["directional"], json!({"file": file, "layers": names}));
            let (count, halves) = layers(&program.folder.join(file));
            assert_eq!(count as usize, names.len());
            let master = read_exr(&program.folder.join("out-0.exr")).unwrap();
            let mut negative = 0;
            for (layer, name) in halves.chunks_exact(halves.len() / names.len()).zip(names) {
                let green = &master.channel(&format!("{name}.G")).unwrap().values;
                assert_eq!(4 * green.len(), layer.len());
                for (texel, expected) in layer.chunks_exact(4).zip(green) {
                    assert!((texel[1] * scale - expected).abs() <= 1e-3 * expected.abs().max(0.01), "{texel:?}");
                    negative += u32::from(texel[1] < 0.0);
                }
            }
            assert_eq!(negative > 1000, names.len() == 4, "{negative}: harmonics alone have signs");
        });
    }
}

#[test]
fn maps_are_finite_lit_and_the_same_for_any_number_of_threads() {
    in_folder(|program| {
        let run = |options: &str| {
            succeed(&bake(program, options));
            let files = program.files();
            fs::remove_file(program.folder.join("out.json")).unwrap();
            files
        };
        for options in [
            "--denoise",
            "--brute --sampling bicubic",
            "--directional sh1 --preset three",
            "--mode ao --ao-distance 0.5",
        ] {
            let one = run(&format!("{options} --threads 1"));
            assert!(run(&format!("{options} --threads 3")) == one, "{options}");
            let colors = colors(&program.folder.join("out-0.exr"));
            let all: Vec<f32> = colors.concat();
            assert!(all.iter().all(|value| value.is_finite() && *value >= 0.0), "{options}");
            assert!(all.iter().filter(|value| **value > 0.0).count() > 3000, "{options}");
        }
        assert!(run("--seed 1") != run("--seed 2"));
    });
}

#[test]
fn closed_bodies_cover_the_texels_below_them_whatever_their_material_says() {
    in_folder(|program| {
        let covered = |level: Value| {
            program.put("level.gltf", level.to_string());
            let line = format!("bake level.gltf -o out.gltf {SMALL}").replace("none", "json");
            let outcome = program.run_line(&line);
            assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
            let end: Value = serde_json::from_str(outcome.stderr.lines().last().unwrap()).unwrap();
            ["covered", "moved"].map(|count| end[count].as_u64().unwrap())
        };
        let single_sided = covered(level());
        assert!(single_sided.iter().sum::<u64>() > 20, "{single_sided:?}");
        assert_eq!(covered(double_sided(level())), single_sided);
        // Nothing hides in a crate that can be looked into.
        assert_eq!(covered(double_sided(open_crates(level()))), [0, 0]);
        // A room that was modelled from outside is no body: there is something inside. Its floor's front is below it.
        assert_eq!(covered(double_sided(outwards())), [0, 0]);
        assert!(covered(outwards())[0] > single_sided[0], "a material of one side has a back");
    });
}

#[test]
fn crates_that_are_inside_out_are_named() {
    in_folder(|program| {
        let mut level = level();
        level["meshes"][1]["primitives"][0]["indices"] = json!(2);
        program.put("level.gltf", level.to_string());
        let outcome = bake(program, "--mode direct");
        assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
        let told = outcome.stderr.lines().find(|line| line.contains("inside out")).unwrap_or_default();
        assert!(told.starts_with("warning: level.gltf: 2 meshes are closed and inside out"), "{}", outcome.stderr);
        assert!(told.contains("\"crate one\"") && told.contains("\"crate two\"") && !told.contains("room\""), "{told}");
    });
}

#[test]
fn an_accuracy_that_was_not_reached_is_told() {
    in_folder(|program| {
        let missed = |options: &str| {
            let outcome = program.run_line(&format!("bake level.gltf -o out.gltf --size 16 {options} --progress none"));
            assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
            outcome.stderr.contains("warning: the requested accuracy is not reached: the estimated error is ")
        };
        assert!(missed("--mode direct --accuracy 0.01%"));
        assert!(!missed("--mode direct --accuracy 20%"));
    });
}

/// A shed around the room: a larger box whose fronts look outwards.
fn level_in_a_shed() -> Value {
    let mut level = level();
    let shed = json!({"name": "shed", "mesh": 1, "scale": [5, 4, 5], "translation": [-0.5, -0.5, -0.5]});
    level["nodes"].as_array_mut().unwrap().push(shed);
    level
}

#[test]
fn what_is_outside_is_left_out() {
    in_folder(|program| {
        program.put("level.gltf", level_in_a_shed().to_string());
        let bake = |out: &str, options: &str| {
            let line = format!("bake level.gltf -o {out}.gltf {SMALL} {options}").replace("none", "json");
            let outcome = program.run_line(&line);
            assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
            outcome.stderr
        };
        assert!(!bake("all", "").contains("outside:"));
        for (out, option) in [("auto", "--skip-outside"), ("place", "--skip-outside=2,1.5,3.5")] {
            let told = bake(out, option);
            // The shed, and the bottoms of both crates.
            assert!(told.contains("outside: 16 triangles"), "{option}: {told}");
        }
        // All triangles are still there, and those that are left out lie on a point.
        let triangles = |out: &str| {
            let (scene, _) = halfdome::scene::open(&program.folder.join(format!("{out}.gltf"))).unwrap();
            let shed = scene.meshes.iter().find(|mesh| mesh.name == "shed").unwrap();
            let is_point = shed.lightmap_texcoords.iter().all(|uv| *uv == shed.lightmap_texcoords[0]);
            (shed.triangles.len(), is_point)
        };
        assert_eq!([triangles("all"), triangles("auto"), triangles("place")], [(12, false), (12, true), (12, true)]);
        let checked = program.run_line("bake level.gltf --check-uv --skip-outside --size 64");
        assert_eq!(checked.code, Some(0), "{}{}", checked.stdout, checked.stderr);
    });
}

#[test]
fn obj_and_the_built_in_scene_can_be_baked_raw() {
    in_folder(|program| {
        succeed_saying("", &program.run_line(&format!("bake cornell -o cornell.obj {SMALL} --report report.html")));
        let model = fs::read_to_string(program.folder.join("cornell.obj")).unwrap();
        let count = |start: &str| model.lines().filter(|line| line.starts_with(start)).count();
        assert_eq!((count("f "), count("o "), count("v ")), (32, 8, count("vt ")));
        assert!(fs::read_to_string(program.folder.join("report.html")).unwrap().contains("cornell.obj"));
        // What was written is read again, and its map does not fit another density.
        let again = program.run_line(&format!("bake cornell.obj -o again.obj {SMALL} --density 20 --sky 1"));
        assert_eq!(again.code, Some(0), "{}", again.stderr);
        assert!(colors(&program.folder.join("again-0.exr")).concat().iter().any(|value| *value > 0.0));
    });
}

#[test]
fn wrong_input_is_named() {
    in_folder(|program| {
        program.put("dark.gltf", {
            let mut level = level();
            level["materials"][1]["emissiveFactor"] = json!([0, 0, 0]);
            level.to_string()
        });
        for (line, told) in [
            ("bake level.gltf -o out.obj --preset bevy", "--preset bevy needs glTF"),
            ("bake level.gltf -o out.glb", "a .gltf model cannot be written as .glb"),
            ("bake cornell -o out.glb", "the built-in scene cannot be written as .glb"),
            ("bake level.gltf -o out.png", "out.png: models cannot be written in this format"),
            ("bake level.gltf -o level.gltf", "is the input model"),
            ("bake level.gltf -o missing/out.gltf", "the folder missing does not exist"),
            ("bake level.gltf -o out.gltf --density 0", "greater than 0"),
            ("bake level.gltf -o out.gltf --density 40 --size 32", "a page has 32x32"),
            ("bake level.gltf -o out.gltf --density 1e6", "texels"),
            ("bake level.gltf -o out.gltf --size 8", "16"),
            ("bake level.gltf -o out.gltf --mode ao --directional hl2", "--mode ao cannot be directional"),
            ("bake level.gltf -o out.gltf --uv keep", "has no second set of texture coordinates"),
            ("bake level.gltf -o out.gltf --skip-outside=camera", "the file has no camera"),
            ("bake level.gltf -o out.gltf --skip-outside=1,2", "expected a place as X,Y,Z, `camera`, or `auto`"),
            ("bake level.gltf -o out.gltf --skip-outside=0.9,0.5,0.9", "0.9,0.5,0.9 is not inside a room"),
            ("bake missing.glb -o out.glb", "no such file"),
            ("bake level.gltf", "--output"),
        ] {
            let outcome = program.run_line(line);
            assert_eq!(outcome.code, Some(1), "{line}: {}", outcome.stderr);
            assert!(outcome.stderr.contains(told), "{line}: {}", outcome.stderr);
        }
        assert_eq!(program.names(), ["dark.gltf", "level.gltf"]);
        // A map that would be black is no error, but it is not silent.
        let dark = program.run_line(&format!("bake dark.gltf -o out.gltf {SMALL}"));
        assert_eq!(dark.code, Some(0));
        assert!(dark.stderr.contains("all maps are black"), "{}", dark.stderr);
    });
}
