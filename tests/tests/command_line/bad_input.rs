//! Every bad input is refused with the file, the place, the problem and a remedy, and nothing is written.

use serde_json::json;

use crate::Desk;
use crate::model::{POSITIONS, TRIANGLE, binary, document, glb, with};

/// Puts a file of this name there and asserts that `render` and `info` refuse it.
fn refused(name: &str, contents: impl AsRef<[u8]>, parts: &[&str]) {
    let desk = Desk::new();
    desk.program().put(name, contents);
    let parts = [&[name, "\n  help: "], parts].concat();
    desk.refuses(&format!("render {name} --size 4x4 --spp 1"), 1, &parts);
    desk.refuses(&format!("info {name}"), 1, &parts);
}

#[test]
fn missing_files_and_folders() {
    let desk = Desk::new();
    for name in ["nothing.obj", "nothing.toml", "no/where.glb", "corne"] {
        desk.refuses(&format!("render {name}"), 1, &[name, "no such file", "help: give a scene file"]);
        desk.refuses(&format!("info {name} --json"), 1, &[name, "no such file", "help: give a scene file"]);
    }
    desk.refuses("render .", 1, &["folder", "help: "]);
    std::fs::create_dir(desk.folder.path().join("level.gltf")).unwrap();
    for line in ["bake . -o out.gltf", "bake level.gltf -o out.gltf", "bake level.gltf -o out.obj --preset raw"] {
        let name = line.split(' ').nth(1).unwrap();
        desk.refuses(line, 1, &[&format!("error: {name}: this is a folder\n  help: name a model file in it\n")]);
    }
}

#[test]
fn a_window_that_cannot_be_opened() {
    let desk = Desk::new();
    // The program under test has none.
    desk.refuses("view t.obj", 2, &["built without a window", "--features view", "--tev"]);
    desk.refuses("view", 1, &["<SCENE>"]);
}

#[test]
fn options_of_a_bake_that_contradict_each_other() {
    let desk = Desk::new();
    let bake = "bake t.obj -o out.obj --size 16 --sky 1";
    for mode in ["full", "direct", "indirect"] {
        let parts = &["--ao-distance", &format!("--mode {mode}"), "help: leave --ao-distance out"];
        desk.refuses(&format!("{bake} --mode {mode} --ao-distance 2"), 1, parts);
    }
    for option in ["--cache-error 0.2", "--gradients off", "--metric bounded", "--accuracy 1%"] {
        desk.refuses(
            &format!("{bake} --brute {option}"),
            1,
            &["cannot be used with", option.split(' ').next().unwrap()],
        );
    }
    assert_eq!(desk.run(&format!("{bake} --spp 1 --brute --record-rays 64 --layout hemicube")).code, Some(0));
}

/// Values that begin with a hyphen are told to be wrong, not taken for options.
#[test]
fn negative_values() {
    let desk = Desk::new();
    for (option, expected) in [
        ("--noise -1%", "expected a relative error"),
        ("--time -3s", "expected a time"),
        ("--integrator ao --ao-distance -1", "expected a number more than 0"),
        ("--max-depth -2", "expected a whole number"),
        ("--shard -1/2", "expected K/N"),
    ] {
        desk.refuses(&format!("render t.obj {option} -o a.exr"), 1, &[expected]);
    }
    desk.refuses("bake t.obj -o out.obj --mode ao --ao-distance -1", 1, &["expected a number greater than 0"]);
}

#[test]
fn names_that_other_renderers_have_for_options() {
    let desk = Desk::new();
    desk.refuses("render t.obj --samples 3 -o a.exr", 1, &["unexpected argument '--samples'", "'--spp'"]);
}

#[test]
fn a_picture_of_charts_is_a_png() {
    let desk = Desk::new();
    for name in ["x.jpg", "x", "x.exr"] {
        let parts = [&format!("{name}: the picture of --check-uv is a PNG"), "ends in .png"];
        desk.refuses(&format!("bake missing.obj --check-uv={name} --size 16"), 1, &parts);
    }
}

#[test]
fn reports_that_are_no_html() {
    let desk = Desk::new();
    for line in ["bake t.obj -o out.obj --size 16 --sky 1 --report r.pdf", "render t.obj --size 4x4 --report r.pdf"] {
        desk.refuses(line, 1, &["r.pdf: a report is written as HTML alone", "help: give a name that ends in .html"]);
    }
}

#[test]
fn a_file_without_sensors() {
    let desk = Desk::new();
    desk.program().put("none.txt", "# no sensors\n");
    let outcome = desk.run("irradiance cornell --points none.txt --progress none");
    let told = "warning: none.txt: the file has no sensors\n";
    assert_eq!((outcome.code, outcome.stdout.as_str(), outcome.stderr.as_str()), (Some(0), "", told));
}

#[test]
fn empty_files() {
    for name in ["a.obj", "a.ply", "a.gltf", "a.glb"] {
        refused(name, "", &["the file is empty"]);
        refused(name, " \n\t\r\n", &["the file is empty"]);
    }
    refused("a.toml", "", &["no model is named", "[scene]"]);
}

#[test]
fn files_that_are_not_what_their_names_say() {
    refused("a.obj", b"\x89PNG\r\n\x1a\n\0\0", &["this is a PNG image, not an OBJ model"]);
    refused("a.obj", b"v 0 0\x01\x02\x03\n", &["a.obj:1: ", "binary data"]);
    refused("a.ply", TRIANGLE, &["this is not a PLY model"]);
    refused("a.glb", "{}", &["this is JSON text, not binary glTF"]);
    refused("a.gltf", glb(&document(), &binary(POSITIONS, [0, 1, 2])), &["this is binary glTF (GLB), not glTF"]);
    refused("a.gltf", "{\"asset\":\n {\"version\": 2", &["a.gltf:2: ", "not valid glTF"]);
    refused("a.toml", "v 0 0 0\n", &["a.toml:1: "]);
    refused("a.toml", b"[scene]\nfile = \"\xff\"\n", &["a.toml:2: this is not UTF-8"]);
    refused("a.txt", TRIANGLE, &["`.txt` is not a model format", ".glb, .gltf, .obj, .pbrt or .ply"]);
    refused("a", TRIANGLE, &["no extension"]);
}

#[test]
fn vertices_and_faces_that_make_no_sense() {
    refused("a.obj", "v 0 0 nan\n", &["a.obj:1: `nan` is not a finite number"]);
    refused("a.obj", "v 0 0 0\nv 1 inf 0\n", &["a.obj:2: `inf` is not a finite number"]);
    refused("a.obj", "v 0 0 1e39\n", &["a.obj:1: `1e39` is not a finite number"]);
    refused("a.obj", "v 0 0 1e30\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", &["too far away"]);
    refused("a.obj", "v 0 0\n", &["a.obj:1: `v` needs 3 numbers"]);
    refused("a.obj", "v 0 0 0\nv 1 0 0\nf 1 2\n", &["a.obj:3: this face has 2 corners"]);
    refused("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n", &["a.obj:4: vertex 4 does not exist"]);
    refused("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 0\n", &["a.obj:4: vertex 0 does not exist"]);
    refused("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 -4\n", &["a.obj:4: vertex -4 does not exist"]);
    refused("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3/1\n", &["a.obj:4: texture coordinate 1 does not exist"]);
    refused("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\n", &["the model has no triangles"]);
    refused("a.obj", "These are words, and not a model.\n", &["the model has no triangles"]);
}

fn ply(vertices: &str, faces: &str) -> String {
    let count = |lines: &str| lines.lines().count();
    format!(
        "ply\nformat ascii 1.0\nelement vertex {}\nproperty float x\nproperty float y\nproperty float z\n\
         element face {}\nproperty list uchar int vertex_indices\nend_header\n{vertices}{faces}",
        count(vertices),
        count(faces)
    )
}

#[test]
fn ply_files() {
    const VERTICES: &str = "0 0 0\n1 0 0\n0 1 0\n";
    let desk = Desk::new();
    desk.program().put("right.ply", ply(VERTICES, "3 0 1 2\n"));
    assert_eq!(desk.run("info right.ply").code, Some(0));
    refused("a.ply", ply(VERTICES, "3 0 1 3\n"), &["face 0", "3"]);
    refused("a.ply", ply(VERTICES, "3 0 1 -1\n"), &["face 0"]);
    refused("a.ply", ply(VERTICES, "2 0 1\n"), &["face 0", "2"]);
    refused("a.ply", ply(VERTICES, ""), &["no triangles"]);
    refused("a.ply", ply("0 0 0\nnan 0 0\n0 1 0\n", "3 0 1 2\n"), &["a.ply:11: `nan 0 0`"]);
    refused("a.ply", ply("0 0 0\n0 -inf 0\n0 1 0\n", "3 0 1 2\n"), &["a.ply:11: `0 -inf 0`"]);
    let whole = ply(VERTICES, "3 0 1 2\n");
    let (header, _) = whole.split_at(whole.len() - VERTICES.len() - "3 0 1 2\n".len());
    for wrong in [f32::NAN, f32::INFINITY] {
        let vertices = [0.0, 0.0, 0.0, 1.0, wrong, 0.0, 0.0, 1.0, 0.0];
        let mut bytes = header.replace("ascii", "binary_little_endian").into_bytes();
        bytes.extend(vertices.into_iter().flat_map(f32::to_le_bytes));
        bytes.push(3);
        bytes.extend([0i32, 1, 2].into_iter().flat_map(i32::to_le_bytes));
        refused("a.ply", bytes, &["vertex 1", "finite"]);
    }
    for length in 4..whole.len() - 2 {
        refused("a.ply", &whole[..length], &[]);
    }
}

#[test]
fn gltf_files() {
    let right = binary(POSITIONS, [0, 1, 2]);
    let desk = Desk::new();
    desk.program().put("right.glb", glb(&document(), &right));
    assert_eq!(desk.run("info right.glb").code, Some(0));

    let changed = |pointer: &str, value| glb(&with(pointer, value), &right);
    refused("a.glb", changed("/accessors/0/count", json!(4)), &["accessor 0", "bufferView 0"]);
    refused("a.glb", changed("/accessors/0/byteOffset", json!(4)), &["accessor 0", "bufferView 0"]);
    refused("a.glb", changed("/accessors/1/count", json!(u64::MAX)), &["accessor 1"]);
    refused("a.glb", changed("/bufferViews/1/byteLength", json!(100)), &["bufferView 1", "buffer 0"]);
    refused("a.glb", changed("/bufferViews/0/buffer", json!(7)), &["bufferView 0", "buffer 7"]);
    refused("a.glb", changed("/buffers/0/byteLength", json!(4000)), &["buffer 0"]);
    refused("a.glb", changed("/meshes/0/primitives/0/attributes/POSITION", json!(9)), &["mesh 0", "accessor 9"]);
    refused("a.glb", changed("/meshes/0/primitives", json!([])), &["no triangles"]);
    refused("a.glb", changed("/nodes", json!([])), &["node 0"]);
    refused("a.glb", changed("/nodes", json!([{"children": [1]}, {"children": [0]}])), &["node 0"]);
    let ring = json!([{"mesh": 0}, {"children": [2], "name": "ring"}, {"children": [1]}]);
    refused("a.glb", changed("/nodes", ring), &["node ", "descendant of itself"]);
    refused("a.glb", changed("/nodes/0/children", json!([0])), &["node 0"]);
    refused("a.glb", changed("/asset/version", json!("1.0")), &["asset", "version"]);

    refused("a.glb", glb(&document(), &binary(POSITIONS, [0, 1, 3])), &["accessor 1", "index 3", "3 vertices"]);
    for wrong in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        let mut positions = POSITIONS;
        positions[2][1] = wrong;
        refused("a.glb", glb(&document(), &binary(positions, [0, 1, 2])), &["vertex 2 is not finite"]);
    }

    let whole = glb(&document(), &right);
    for length in (1..whole.len()).step_by(5).chain([4, 12, 20, whole.len() - 1]) {
        refused("a.glb", &whole[..length], &[]);
    }
}

/// A scene file with these lines after the model's name, which are lines 3 and on.
fn scene_refused(lines: &str, parts: &[&str]) {
    refused("a.toml", format!("[scene]\nfile = \"t.obj\"\n{lines}"), parts);
}

#[test]
fn scene_files() {
    scene_refused("[rendr]\nspp = 4\n", &["a.toml:3: unknown section \"rendr\"", "did you mean `render`"]);
    scene_refused("[render]\nsp = 4\n", &["a.toml:4: unknown key \"sp\" in [render]", "did you mean `spp`"]);
    scene_refused("[film]\nwidht = 4\n", &["a.toml:4: ", "did you mean `width`"]);
    scene_refused("[render]\nspp = \"4\"\n", &["a.toml:4: render.spp is \"4\"", "a whole number"]);
    scene_refused("[render]\nspp = 4.5\n", &["a.toml:4: render.spp is 4.5", "a whole number"]);
    scene_refused("[render]\nspp = 0\n", &["a.toml:4: render.spp is 0", "from 1"]);
    scene_refused("[render]\nseed = -1\n", &["a.toml:4: render.seed is -1", "from 0"]);
    scene_refused("[render]\nintegrator = \"pth\"\n", &["a.toml:4: ", "did you mean `path`"]);
    scene_refused("[film]\nwidth = 0\n", &["a.toml:4: film.width is 0", "from 1 to 65536"]);
    scene_refused("[film]\naov = 1\n", &["a.toml:4: film.aov is 1", "true or false"]);
    scene_refused("[film]\nfilter = \"bx\"\n", &["a.toml:4: film.filter is \"bx\"", "did you mean `box`?"]);
    scene_refused("[camera]\neye = [1, 2]\n", &["a.toml:4: camera.eye is [1, 2]", "three finite numbers"]);
    scene_refused("[camera]\neye = [1, nan, 2]\n", &["a.toml:4: ", "three finite numbers"]);
    scene_refused("[camera]\nvfov = 180\n", &["a.toml:4: camera.vfov is 180", "less than 180"]);
    scene_refused("[camera]\nup = [0, 0, 0]\n", &["a.toml:4: ", "not all zero"]);
    scene_refused("[camera]\neye = [1, 2, 3]\ntarget = [1, 2, 3]\n", &["a.toml: the camera's eye", "the same point"]);
    scene_refused("[sky]\nradiance = -1\n", &["a.toml:4: ", "not negative"]);
    scene_refused("camera = 1\n", &["a.toml:3: unknown key \"camera\" in [scene]"]);
    scene_refused("[sky]\nradiance = 1\n[sky]\n", &["a.toml:5: "]);
    refused("a.toml", "[scene]\nfile = \"nothing.obj\"\n", &["a.toml:2: there is no file nothing.obj"]);
    refused("a.toml", "[scene]\nfile = 3\n", &["a.toml:2: scene.file is 3", "expected text"]);
    refused("a.toml", "[sky]\nradiance = 1\n", &["no model is named"]);
    refused("a.toml", "sky = 1\n", &["a.toml:1: `sky` is not a section"]);
}

/// What options together get wrong is the scene file's, if it sets one of them, unless the command line puts it right.
#[test]
fn options_of_scene_files_and_the_command_line_together() {
    let desk = Desk::new();
    let film = "[film]\nwidth = 65536\nheight = 65536\nfilter = \"box\"\nsharpness = 0.5\n";
    desk.program().put("film.toml", format!("[scene]\nfile = \"t.obj\"\n{film}"));
    desk.refuses("render film.toml --filter mitchell", 1, &["error: film.toml: 65536x65536", "help: "]);
    desk.refuses("render film.toml --size 4x4", 1, &["error: film.toml: the box filter has no sharpness"]);
    desk.refuses("render film.toml --filter box --size 65536x65535", 1, &["65536x65535"]);
    desk.refuses("info film.toml", 1, &["error: film.toml: "]);
    let camera = "[camera]\neye = [1, 2, 3]\ntarget = [1, 2, 3]\n";
    desk.program().put("camera.toml", format!("[scene]\nfile = \"t.obj\"\n{camera}"));
    desk.refuses("render camera.toml", 1, &["error: camera.toml: the camera's eye"]);
    desk.refuses("render camera.toml --size 65536x65536", 1, &["error: 65536x65536"]);
    for right in ["film.toml --size 4x4 --filter box", "camera.toml --size 4x4 --target 0,0,0"] {
        let outcome = desk.run(&format!("render {right} --spp 1 -o a.exr"));
        assert_eq!(outcome.code, Some(0), "{right}: {}", outcome.stderr);
    }
}

#[test]
fn options() {
    let desk = Desk::new();
    for (option, part) in [
        ("--spp 0", "expected a whole number from 1"),
        ("--spp -3", "invalid value '-3' for '--spp <N>': expected a whole number from 1"),
        ("--seed -1", "invalid value '-1' for '--seed <N>'"),
        ("--sharpness -0.5", "invalid value '-0.5' for '--sharpness <S>'"),
        ("--spp many", "expected a whole number from 1"),
        ("--spp 4294967296", "expected a whole number from 1"),
        ("--spp", "--spp"),
        ("--sppp 4", "'--spp'"),
        ("--frobnicate", "unexpected argument"),
        ("--size 0x4", "two whole numbers from 1 to 65536"),
        ("--size 4", "two whole numbers from 1 to 65536"),
        ("--size 65537x1", "two whole numbers from 1 to 65536"),
        ("--width 0", "a whole number of pixels from 1 to 65536"),
        ("--size 4x4 --width 4", "cannot be used with"),
        ("--vfov nan", "more than 0 and less than 180"),
        ("--eye 1,2", "three finite numbers"),
        ("--sky 1,-1,1", "not negative"),
        ("--threads 0", "1..=1024"),
        ("--threads 1025", "1..=1024"),
        ("--integrator pth", "did you mean `path`"),
        ("--emission back", "one of front, both"),
        ("--filter bx", "box"),
        ("--progress loud", "json"),
        ("--exposure inf", "-64 to 64"),
        ("--tone blue", "linear"),
        ("more.obj", "unexpected argument"),
        ("--seed 18446744073709551616", "18446744073709551615"),
        ("--size 65536x65536", "at most 268435456 pixels"),
        ("--eye 1,2,3 --target 1,2,3", "help: give two different points"),
        ("--eye 0,3,0 --target 0,0,0", "help: give an up vector across the view"),
        ("--eye 1e30,0,0 --target 0,0,0", "too far away"),
        ("--filter box --sharpness 0.5", "sharpness"),
    ] {
        desk.refuses(&format!("render t.obj {option}"), 1, &[part]);
    }
    desk.refuses("rendr t.obj", 1, &["render"]);
    desk.refuses("render", 1, &["<SCENE>"]);
    desk.refuses("info", 1, &["<SCENE>"]);
}

#[cfg(target_os = "linux")]
#[test]
fn a_picture_beyond_the_memory() {
    let meminfo = std::fs::read_to_string("/proc/meminfo").unwrap();
    let total = meminfo.lines().find(|line| line.starts_with("MemTotal:")).unwrap();
    let kibibytes: u64 = total.split_whitespace().nth(1).unwrap().parse().unwrap();
    // The largest picture with all channels takes no less than its 20 channels of 32 bits.
    if kibibytes * 1024 < (20 * 4) << 28 {
        Desk::new().refuses(
            "render t.obj --size 16384x16384 --aov",
            1,
            &["16384x16384", "help: give a smaller --size"],
        );
    }
}
