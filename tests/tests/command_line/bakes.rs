//! Bakes from the outside: one run at a time, the files that a model refers to, and maps by other versions.

use std::fs;
use std::time::{Duration, Instant};

use serde_json::{Value, json};

use crate::Desk;
use crate::model;

const FAST: &str = "--sky 1 --size 32 --spp 1 --record-rays 64 --progress none";

#[test]
fn a_second_bake_of_one_output_is_refused() {
    let desk = Desk::new();
    desk.program().put("m.gltf", model::document().to_string());
    // Hours long.
    let line = "bake t.obj -o out.obj --sky 1 --brute --record-rays 65536 --spp 65536 --size 2048 --progress none";
    let arguments: Vec<&str> = line.split(' ').collect();
    let mut run = desk.program().command(&arguments).spawn().unwrap();
    let start = Instant::now();
    while !desk.folder.path().join("out.json.lock").exists() {
        assert!(start.elapsed() < Duration::from_secs(60) && run.try_wait().unwrap().is_none(), "no lock");
    }
    // Both formats share the manifest and the maps.
    let others = ["out.obj", "out.gltf"].map(|output| {
        let source = if output == "out.obj" { "t.obj" } else { "m.gltf" };
        desk.run(&format!("bake {source} -o {output} {FAST}"))
    });
    run.kill().unwrap();
    run.wait().unwrap();
    for other in others {
        assert_eq!(other.code, Some(1), "{}", other.stderr);
        assert!(other.stderr.contains("out.json: another run is baking to files of this name"), "{}", other.stderr);
    }
    // A lock ends with its run.
    let after = desk.run(&format!("bake t.obj -o out.obj {FAST}"));
    assert_eq!(after.code, Some(0), "{}", after.stderr);
    assert!(!desk.folder.path().join("out.json.lock").exists());
}

#[test]
fn references_lead_to_the_same_files_from_another_folder() {
    let desk = Desk::new();
    for folder in ["level one", "baked"] {
        fs::create_dir(desk.folder.path().join(folder)).unwrap();
    }
    let mut document = model::document();
    document["buffers"] = json!([{"byteLength": 44, "uri": "data.bin"}]);
    desk.program().put("level one/m.gltf", document.to_string());
    desk.program().put("level one/data.bin", model::binary(model::POSITIONS, [0, 1, 2]));
    let bake = |arguments: &[&str]| {
        let all: Vec<&str> = ["bake"].into_iter().chain(arguments.iter().copied()).chain(FAST.split(' ')).collect();
        let outcome = desk.program().run(&all);
        assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    };
    bake(&["level one/m.gltf", "-o", "baked/m.gltf"]);
    let text = fs::read(desk.folder.path().join("baked/m.gltf")).unwrap();
    let json: Value = serde_json::from_slice(&text).unwrap();
    assert_eq!(json["buffers"][0]["uri"], "../level%20one/data.bin");
    assert_eq!(desk.run("info baked/m.gltf").code, Some(0));

    let obj = format!("mtllib my paint.mtl\n{}", model::TRIANGLE.replace("f ", "o the floor\nusemtl dark red\nf "));
    desk.program().put("level one/m.obj", obj);
    desk.program().put("level one/my paint.mtl", "newmtl dark red\nKd 0.5 0 0\n");
    bake(&["level one/m.obj", "-o", "baked/m.obj"]);
    let text = fs::read_to_string(desk.folder.path().join("baked/m.obj")).unwrap();
    for line in ["mtllib ../level one/my paint.mtl", "o the floor", "usemtl dark red"] {
        assert!(text.lines().any(|it| it == line), "{text} lacks {line}");
    }
    let (scene, _) = halfdome::scene::open(&desk.folder.path().join("baked/m.obj")).unwrap();
    assert_eq!((scene.warnings.len(), scene.materials[0].inputs.base_color.x), (0, 0.5), "{:?}", scene.warnings);
}

#[test]
fn maps_by_another_version_are_baked_again() {
    let desk = Desk::new();
    let line = format!("bake t.obj -o out.obj {}", FAST.replace("none", "json"));
    assert_eq!(desk.run(&line).code, Some(0));
    assert!(desk.run(&line).stderr.contains("is up to date"));
    let manifest = fs::read_to_string(desk.folder.path().join("out.json")).unwrap();
    let old = manifest.replace(concat!("halfdome ", env!("CARGO_PKG_VERSION")), "halfdome 0.0.1");
    assert!(old != manifest);
    desk.program().put("out.json", old);
    let told = desk.run(&line).stderr;
    assert!(told.contains("the maps are by \\\"halfdome 0.0.1\\\"") && told.contains("baked again"), "{told}");
    assert!(desk.run(&line).stderr.contains("is up to date"));
}
