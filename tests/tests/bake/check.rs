//! `--check-uv`.

use std::fs;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use serde_json::{Value, json};

use crate::command::in_folder;
use crate::level::level;

/// The level with these second coordinates for the crates.
fn with_coordinates(uv: &[[f32; 2]]) -> Value {
    let mut level = level();
    let bytes: Vec<u8> = uv.iter().flatten().flat_map(|value| value.to_le_bytes()).collect();
    let uri = format!("data:application/octet-stream;base64,{}", STANDARD.encode(&bytes));
    let mut push = |list: &str, value: Value| level[list].as_array_mut().unwrap().push(value);
    push("buffers", json!({"byteLength": bytes.len(), "uri": uri}));
    push("bufferViews", json!({"buffer": 2, "byteLength": bytes.len()}));
    push("accessors", json!({"bufferView": 3, "componentType": 5126, "count": uv.len(), "type": "VEC2"}));
    level["meshes"][1]["primitives"][0]["attributes"]["TEXCOORD_1"] = json!(3);
    // One crate is enough.
    level["nodes"].as_array_mut().unwrap().remove(2);
    level
}

/// Six squares of 0.2 in a row, each `step` from the one before.
fn squares(step: f32) -> Vec<[f32; 2]> {
    let square = |i: u8| {
        let (u, v) = (0.05 + step * f32::from(i % 3), 0.1 + 0.5 * f32::from(i / 3));
        [[u, v], [u + 0.2, v], [u + 0.2, v + 0.2], [u, v + 0.2]]
    };
    (0..6).flat_map(square).collect()
}

#[test]
fn good_coordinates_pass_and_others_are_counted() {
    in_folder(|program| {
        program.put("good.gltf", with_coordinates(&squares(0.3)).to_string());
        program.put("bad.gltf", with_coordinates(&squares(0.15)).to_string());
        let good = program.run_line("bake good.gltf --check-uv=good.png --size 100");
        assert_eq!(good.code, Some(0), "{}{}", good.stdout, good.stderr);
        let says = |text: &str, name: &str, value: &str| {
            let line = text.lines().find(|line| line.starts_with(name)).unwrap_or_default();
            assert!(line.contains(value), "{name} {value}: {text}");
        };
        says(&good.stdout, "charts", "6");
        // Six squares of 20 by 20 texels on 100 by 100.
        says(&good.stdout, "fill", "24.0%");
        says(&good.stdout, "overlapping", "0 texels");
        says(&good.stdout, "lost", "0 triangles");
        assert!(fs::read(program.folder.join("good.png")).unwrap().starts_with(b"\x89PNG"));
        let bad = program.run_line("bake bad.gltf --check-uv --size 100");
        assert_eq!(bad.code, Some(5), "{}{}", bad.stdout, bad.stderr);
        let told = "error: light cannot be baked into these coordinates: 400 texels overlap\n  help: unwrap the model";
        assert!(bad.stderr.contains(told), "{}", bad.stderr);
        // Two strips of 5 by 20 texels in each of two rows.
        says(&bad.stdout, "overlapping", "400 texels");
        assert!(
            bad.stdout.contains("100 texels: chart 0 of mesh 1 (\"crate one\") and chart 1 of mesh 1"),
            "{}",
            bad.stdout
        );
        // A bake of it makes new ones, and says so.
        let bake = program.run_line("bake bad.gltf -o out.gltf --size 64 --spp 4 --record-rays 64 --progress none");
        assert_eq!(bake.code, Some(0));
        assert!(bake.stderr.contains("mesh 1 (\"crate one\") overlap in"), "{}", bake.stderr);
        // Without any, new ones are checked.
        let new = program.run_line("bake level.gltf --check-uv --size 100");
        assert_eq!(new.code, Some(0), "{}", new.stdout);
        says(&new.stdout, "coordinates", "new ones");
    });
}
