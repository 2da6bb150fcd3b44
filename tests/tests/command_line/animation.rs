//! Frames of an animated model, one or a sequence.

use serde_json::{Value, json};

use crate::Desk;
use crate::model;

const CAMERA: &str = "--size 6x6 --spp 1 --sky 1 --eye 0.2,0.2,3 --target 0.2,0.2,0 --vfov 30";

/// A desk with `m.glb`, whose triangle has gone by one along x at frame 2 (of 24 a second), and `m.toml`, which is at
/// frame 2.
fn desk() -> Desk {
    let desk = Desk::new();
    let mut document = model::document();
    let mut binary = model::binary(model::POSITIONS, [0, 1, 2]);
    let start = binary.len();
    let numbers = [0.0, 2.0 / 24.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0_f32];
    binary.extend(numbers.iter().flat_map(|number| number.to_le_bytes()));
    document["buffers"][0]["byteLength"] = json!(binary.len());
    for (view, accessor) in [
        (json!([start, 8]), json!({"bufferView": 2, "componentType": 5126, "count": 2, "type": "SCALAR"})),
        (json!([start + 8, 24]), json!({"bufferView": 3, "componentType": 5126, "count": 2, "type": "VEC3"})),
    ] {
        let view = json!({"buffer": 0, "byteOffset": view[0], "byteLength": view[1]});
        document["bufferViews"].as_array_mut().unwrap().push(view);
        document["accessors"].as_array_mut().unwrap().push(accessor);
    }
    document["animations"] = json!([{
        "name": "Slide",
        "channels": [{"sampler": 0, "target": {"node": 0, "path": "translation"}}],
        "samplers": [{"input": 2, "output": 3}]
    }]);
    desk.program().put("m.glb", model::glb(&document, &binary));
    desk.program().put("m.toml", "[scene]\nfile = \"m.glb\"\nframe = 4\nfps = 48\nanimation = \"Slide\"\n");
    desk
}

fn bounds(desk: &Desk, line: &str) -> Value {
    let outcome = desk.run(&format!("info --json {line}"));
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    serde_json::from_str::<Value>(&outcome.stdout).unwrap()["bounds"]["lower"][0].clone()
}

fn red(desk: &Desk, name: &str) -> Vec<f32> {
    let picture = halfdome::output::read_exr(&desk.folder.path().join(name)).unwrap();
    picture.channel("R").unwrap().values.clone()
}

#[test]
fn a_frame_is_chosen_by_option_or_scene_file() {
    let desk = desk();
    for (line, x) in [
        ("m.glb", 0.0),
        ("m.glb --frame 1", 0.5),
        ("m.glb --frame 1.5", 0.75),
        ("m.glb --frame 1 --fps 12", 1.0),
        ("m.toml", 1.0),
        ("m.toml --frame 2", 0.5),
    ] {
        assert_eq!(bounds(&desk, line), json!(x), "{line}");
    }
    let table = desk.run("info m.glb").stdout;
    assert!(table.contains("\nanimation           Slide, 0.000 to 0.083 s\n"), "{table}");
    desk.refuses("render m.glb --frame 1 --animation Slid", 1, &["no animation \"Slid\"", "did you mean `Slide`?"]);
    desk.refuses("render m.glb --frame x", 1, &["expected a number of a frame"]);
    let still = desk.run("info t.obj --frame 3").stdout;
    assert!(still.contains("the scene has no animations, so all its frames are the same"), "{still}");
}

#[test]
fn a_sequence_is_the_same_as_its_frames() {
    let desk = desk();
    let outcome = desk.run(&format!("render m.glb {CAMERA} --frames 0..2 --step 2 -o f.##.exr"));
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    assert!(!desk.folder.path().join("f.01.exr").exists());
    for frame in [0, 2] {
        assert_eq!(desk.run(&format!("render m.glb {CAMERA} --frame {frame} -o one.exr")).code, Some(0));
        assert_eq!(red(&desk, "one.exr"), red(&desk, &format!("f.0{frame}.exr")));
    }
    assert!(red(&desk, "f.00.exr") != red(&desk, "f.02.exr"));
    // What is there may stay, even if it is something else.
    desk.program().put("f.02.exr", "mine");
    let outcome = desk.run(&format!("render m.glb {CAMERA} --frames 1..2 --skip-existing -o f.##.exr"));
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    assert_eq!(std::fs::read(desk.folder.path().join("f.02.exr")).unwrap(), b"mine");
    assert!(desk.folder.path().join("f.01.exr").exists());
}

#[test]
fn wrong_sequences_are_refused() {
    let desk = desk();
    desk.refuses(
        "render m.glb --frames 1..2 -o f.exr",
        1,
        &["f.exr has no place for the frame's number", "f.####.exr"],
    );
    desk.refuses("render m.glb --frames 3..2", 1, &["frames go upwards"]);
    desk.refuses("render m.glb --frames 1..2 --frame 1", 1, &["--frame"]);
    desk.refuses("render m.glb --step 2", 1, &["--frames"]);
    for option in ["--resume", "--checkpoint"] {
        let told = format!("--skip-existing does not go with {option}: an interrupted frame has a picture");
        desk.refuses(
            &format!("render m.glb --frames 1..2 --skip-existing {option}"),
            1,
            &[&told, "leave --skip-existing out"],
        );
    }
}

#[test]
fn an_empty_picture_is_no_frame_that_is_there() {
    let desk = desk();
    desk.program().put("f.1.exr", "");
    let line = format!("render m.glb {CAMERA} --frames 1..1 --skip-existing -o f.#.exr");
    let outcome = desk.run(&line);
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    assert!(!std::fs::read(desk.folder.path().join("f.1.exr")).unwrap().is_empty());
}

#[test]
fn a_warning_of_all_frames_is_printed_once() {
    let desk = desk();
    let outcome = desk.run(&format!("render m.glb {CAMERA} --frames 1..3 --aov -o f.#.png --progress none"));
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    assert_eq!(outcome.stderr.matches("AOVs were requested, but PNG has none").count(), 1, "{}", outcome.stderr);
}
