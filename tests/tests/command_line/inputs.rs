//! Inputs are never overwritten, whatever their name, and an endless input is refused.

use std::fs;

use serde_json::json;

use crate::Desk;

/// A glTF model of a triangle with a buffer and a texture beside it.
fn model(desk: &Desk) {
    let positions: Vec<u8> =
        [0f32, 0., 0., 1., 0., 0., 0., 1., 0.].iter().flat_map(|value| value.to_le_bytes()).collect();
    let texcoords: Vec<u8> = [0f32, 0., 1., 0., 0., 1.].iter().flat_map(|value| value.to_le_bytes()).collect();
    desk.program().put("m.bin", [positions, texcoords].concat());
    let document = json!({
        "asset": { "version": "2.0" },
        "scenes": [{ "nodes": [0] }], "scene": 0, "nodes": [{ "mesh": 0 }],
        "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0, "TEXCOORD_0": 1 }, "material": 0 }] }],
        "materials": [{ "pbrMetallicRoughness": { "baseColorTexture": { "index": 0 } } }],
        "textures": [{ "source": 0 }], "images": [{ "uri": "out.png" }],
        "buffers": [{ "uri": "m.bin", "byteLength": 60 }],
        "bufferViews": [{ "buffer": 0, "byteLength": 36 }, { "buffer": 0, "byteOffset": 36, "byteLength": 24 }],
        "accessors": [
            { "bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0] },
            { "bufferView": 1, "componentType": 5126, "count": 3, "type": "VEC2" },
        ],
    });
    desk.program().put("m.gltf", document.to_string());
}

#[test]
fn outputs_are_no_inputs() {
    let desk = Desk::new();
    let program = desk.program();
    program.put("s.toml", "[scene]\nfile = \"t.obj\"\n");
    program.put("p.txt", "0.2 0.2 1 0 0 -1\n");
    program.put("p.json", "0.2 0.2 1\n");
    program.put("t2.bvh", fs::read(program.folder.join("t.obj")).unwrap());
    for line in [
        "render cornell -o sky.exr -o out.png --size 16x8 --spp 1 --progress none",
        "cache build cornell -o c.bin --size 32x32 --record-rays 64 --progress none",
    ] {
        assert_eq!(desk.run(line).code, Some(0), "{line}");
    }
    fs::hard_link(program.folder.join("c.bin"), program.folder.join("d.bin")).unwrap();
    model(&desk);
    assert_eq!(desk.run("info m.gltf").code, Some(0));
    assert_eq!(desk.run("info t.obj --sky-picture sky.exr").code, Some(0));
    for line in [
        "irradiance t.obj --sky 1 --points p.txt -o p.txt",
        "irradiance t.obj --sky 1 --points p.txt -o t.obj",
        "irradiance cornell --points p.txt --cache c.bin -o d.bin",
        "cache build t.obj --sky 1 -o t.obj",
        "cache build s.toml --sky 1 -o s.toml",
        "cache build s.toml --sky 1 -o ./t.obj",
        "cache merge c.bin c.bin -o c.bin",
        "cubemap sky.exr -o sky.exr",
        "render t.obj --sky-picture sky.exr -o sky.exr",
        "render m.gltf --sky 1 -o out.png",
        "cubemap sky --sky-picture sky.exr -o new.ktx2 -o sky.exr",
        "probes cornell --points p.json -o p.json",
        "tree m.gltf -o m.bin",
        "bake t.obj --sky 1 -o t.obj --preset raw",
        "bake m.gltf --sky 1 -o new.gltf --report m.bin",
        "bake m.gltf --sky 1 -o new.gltf --report new.gltf",
        "bake m.gltf --check-uv=out.png",
    ] {
        desk.refuses(line, 1, &["help: "]);
    }
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink("p.txt", program.folder.join("link")).unwrap();
        desk.refuses("irradiance t.obj --sky 1 --points p.txt -o link", 1, &["link is the same file as p.txt"]);
    }
    // A cache may go on from itself: all of its records stay.
    let line = "cache build cornell --cache c.bin -o c.bin --size 32x32 --record-rays 64 --progress none";
    assert_eq!(desk.run(line).code, Some(0));
}

#[test]
fn a_bakes_pages_are_checked_before() {
    let desk = Desk::new();
    fs::create_dir(desk.program().folder.join("out-0.exr")).unwrap();
    let bake = "bake t.obj --sky 1 -o out.obj --size 32 --spp 1 --record-rays 64 --progress none";
    desk.refuses(bake, 1, &["out-0.exr", "is a folder"]);
    fs::remove_dir(desk.program().folder.join("out-0.exr")).unwrap();
    assert_eq!(desk.run(bake).code, Some(0));
    // A page's name is also that of a texture that the model shows.
    model(&desk);
    let gltf = fs::read_to_string(desk.program().folder.join("m.gltf")).unwrap();
    desk.program().put("m.gltf", gltf.replace("out.png", "new-0.exr"));
    desk.program().put("new-0.exr", fs::read(desk.program().folder.join("out-0.exr")).unwrap());
    let line = "bake m.gltf --sky 1 -o new.gltf --size 32 --spp 1 --record-rays 64";
    let before = desk.program().files();
    let outcome = desk.run(line);
    // Textures are PNG or JPEG; whether another is read or refused, it stays.
    assert_eq!(outcome.code, Some(1), "{}", outcome.stderr);
    assert!(desk.program().files() == before);
}

/// A line of zeros without an end must not fill the memory.
#[test]
fn points_have_lines() {
    let desk = Desk::new();
    desk.program().put("p.txt", vec![0; 1 << 20]);
    for line in ["irradiance t.obj --sky 1 --points p.txt", "probes t.obj --sky 1 --points p.txt -o p.json"] {
        desk.refuses(line, 1, &["p.txt: line 1: is longer than 4096 bytes", "help: give plain text"]);
    }
}

#[test]
fn a_tree_has_no_scenes_options() {
    let desk = Desk::new();
    assert_eq!(desk.run("tree t.obj -o t.bvh --progress none").code, Some(0));
    assert_eq!(desk.run("info t.bvh").code, Some(0));
    desk.refuses("info t.bvh --sky 1", 1, &["t.bvh is a tree", "help: leave them out"]);
}
