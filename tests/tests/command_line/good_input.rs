//! Unusual but valid input: it works, and messages name what was changed or left out.

use crate::Desk;
use crate::model::TRIANGLE;
use serde_json::Value;

/// The events of a run that prints JSON lines.
pub(crate) fn events(stderr: &str) -> Vec<Value> {
    stderr.lines().map(|line| serde_json::from_str(line).unwrap_or_else(|error| panic!("{error}: {line}"))).collect()
}

fn values(desk: &Desk, name: &str, channel: &str) -> Vec<f32> {
    let picture = halfdome::output::read_exr(&desk.folder.path().join(name)).unwrap();
    picture.channel(channel).unwrap().values.clone()
}

#[test]
fn a_scene_without_light_is_black_and_gives_a_warning() {
    let desk = Desk::new();
    let outcome = desk.run("render t.obj --size 9x7 --spp 2 -o a.exr --progress json");
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    let warnings: Vec<Value> =
        events(&outcome.stderr).into_iter().filter(|event| event["event"] == "warning").collect();
    assert!(warnings.iter().any(|warning| warning["message"].as_str().unwrap().contains("no light")), "{warnings:?}");
    assert_eq!(values(&desk, "a.exr", "R"), [0.0; 63]);
    let lit = desk.run("render t.obj --size 9x7 --spp 2 -o a.exr --progress json --sky 1");
    assert!(lit.code == Some(0) && !lit.stderr.contains("no light"), "{}", lit.stderr);
    assert!(values(&desk, "a.exr", "R").iter().all(|value| *value > 0.0));
    // Pictures that need no light need no warning either.
    let normals = desk.run("render t.obj --size 9x7 --spp 2 -o a.exr --integrator normals");
    assert!(normals.code == Some(0) && !normals.stderr.contains("no light"), "{}", normals.stderr);
}

#[test]
fn lights_without_strength_are_not_called_missing() {
    let desk = Desk::new();
    let light = |strength: f32| {
        let lights = format!(
            "[[light]]\ntype = \"point\"\nposition = [0.25, 0.25, 1]\nintensity = {strength}\n\
             [[light]]\ntype = \"directional\"\ndirection = [0, 0, -1]\nirradiance = 0\n"
        );
        desk.program().put("lit.toml", format!("[scene]\nfile = \"t.obj\"\n{lights}"));
        let outcome = desk.run("render lit.toml --size 9x7 --spp 2 -o a.exr --progress none");
        assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
        (outcome.stderr, values(&desk, "a.exr", "R").iter().any(|value| *value > 0.0))
    };
    let (told, is_lit) = light(0.0);
    let expected = "warning: all lights of the scene have a strength of 0, so the picture is black\n";
    assert!(told.ends_with(expected) && !told.contains("no light") && !is_lit, "{told}");
    let (told, is_lit) = light(2.0);
    // The sun alone has none.
    assert!(told.matches("a strength of 0").count() == 1 && !told.contains("black") && is_lit, "{told}");
}

/// A lamp seen from behind: nothing is lit.
#[test]
fn a_black_picture_in_spite_of_a_light_gives_a_warning() {
    let desk = Desk::new();
    desk.program().put("lamp.mtl", "newmtl lamp\nKe 1 1 1\n");
    desk.program().put("lamp.obj", format!("mtllib lamp.mtl\nusemtl lamp\n{TRIANGLE}"));
    let render = |eye: &str, options: &str| {
        let camera = format!("--eye {eye} --target 0.2,0.2,0 --vfov 5");
        let outcome = desk.run(&format!("render lamp.obj --size 4x4 --spp 1 -o a.exr {camera} {options}"));
        assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
        (values(&desk, "a.exr", "G"), outcome.stderr.contains("the picture is black although the scene has lights"))
    };
    let (front, behind) = ("0.2,0.2,1", "0.2,0.2,-1");
    for mode in ["json", "bar", "none"] {
        assert_eq!(render(behind, &format!("--progress {mode}")), (vec![0.0; 16], true));
    }
    assert_eq!(render(front, ""), (vec![1.0; 16], false));
    assert_eq!(render(behind, "--emission both"), (vec![1.0; 16], false));
    assert!(!render(behind, "--integrator albedo").1);
}

#[test]
fn degenerate_triangles_are_dropped_and_counted() {
    let desk = Desk::new();
    desk.program().put("thin.obj", format!("{TRIANGLE}v 2 0 0\nf 1 1 2\nf 2 4 4\n"));
    let info = desk.run("info thin.obj");
    assert!(info.stdout.contains("3 (2 degenerate, dropped)"), "{}", info.stdout);
    let json: Value = serde_json::from_str(&desk.run("info thin.obj --json").stdout).unwrap();
    assert_eq!((&json["triangles"], &json["tree"]["degenerate_triangles"]), (&3.into(), &2.into()));
    for mode in ["json", "bar"] {
        let render = desk.run(&format!("render thin.obj --size 4x4 --spp 1 --progress {mode} -o a.exr"));
        let expected = "thin.obj: 2 triangles with two equal corners are dropped: mesh 0";
        assert!(render.code == Some(0) && render.stderr.contains(expected), "{}", render.stderr);
    }
    let bake = desk.run("bake thin.obj -o out.obj --size 16 --spp 1 --record-rays 64 --sky 1 --progress none");
    let expected = "warning: thin.obj: 2 triangles with two equal corners are dropped: mesh 0";
    assert!(bake.code == Some(0) && bake.stderr.contains(expected), "{}", bake.stderr);
}

/// What a scene file adds is its own, and not the model's.
#[test]
fn warnings_about_objects_name_the_scene_file_and_the_line() {
    let desk = Desk::new();
    desk.program().put("thin.obj", format!("{TRIANGLE}v 2 0 0\nf 1 1 2\nf 2 4 4\n"));
    let object = "[[object]]\nname = \"chair\"\nfile = \"thin.obj\"\n[[instance]]\nof = \"chair\"\n";
    desk.program().put("s.toml", format!("[scene]\nfile = \"t.obj\"\ninstances = \"never\"\n{object}"));
    let render = desk.run("render s.toml --size 4x4 --spp 1 --sky 1 --progress none -o a.exr");
    let expected = "warning: s.toml:4: 2 triangles with two equal corners are dropped: mesh 1 (\"chair\")";
    assert!(render.code == Some(0) && render.stderr.contains(expected), "{}", render.stderr);
}

#[test]
fn options_win_over_the_scene_file() {
    let desk = Desk::new();
    let scene = "[scene]\nfile = \"t.obj\"\n[film]\nwidth = 5\nheight = 4\n[render]\nspp = 3\nseed = 9\n";
    desk.program().put("s.toml", scene);
    assert_eq!(desk.run("render s.toml -o a.exr --spp 2 --width 6").code, Some(0));
    let picture = halfdome::output::read_exr(&desk.folder.path().join("a.exr")).unwrap();
    assert_eq!((picture.width, picture.height), (6, 4));
    assert_eq!((picture.metadata.samples_per_pixel, picture.metadata.seed), (2, 9));
}

/// Names in files of another encoding are kept as well as may be; the model renders.
#[test]
fn names_that_are_not_utf_8_do_no_harm() {
    let desk = Desk::new();
    let obj = [b"o caf\xe9\ng \xff\xfe\nusemtl m\xe9tal\n".as_slice(), TRIANGLE.as_bytes(), b"mtllib b\xe9.mtl\n"];
    desk.program().put("latin.obj", obj.concat());
    let outcome = desk.run("render latin.obj --size 4x4 --spp 1 -o a.exr --progress json");
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    assert!(outcome.stderr.contains("is not defined; grey instead"), "{}", outcome.stderr);
    events(&outcome.stderr);
}

#[cfg(target_os = "linux")]
#[test]
fn paths_that_are_not_utf_8_work() {
    use std::ffi::OsStr;
    use std::os::unix::ffi::OsStrExt as _;
    let desk = Desk::new();
    let name = |bytes: &'static [u8]| OsStr::from_bytes(bytes);
    desk.program().put(name(b"caf\xe9.obj"), TRIANGLE);
    let mut arguments = vec![OsStr::new("render"), name(b"caf\xe9.obj")];
    arguments.extend("--size 4x4 --spp 1 --progress json".split(' ').map(OsStr::new));
    let outcome = desk.program().run(&arguments);
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    events(&outcome.stderr);
    let files = desk.program().files();
    assert!(files.contains_key(name(b"caf\xe9.exr")) && files.contains_key(name(b"caf\xe9.png")), "{:?}", files.keys());
    let info = desk.program().run(&[OsStr::new("info"), OsStr::new("--json"), name(b"caf\xe9.obj")]);
    serde_json::from_str::<Value>(&info.stdout).unwrap();
    // The errors of such a file are reported, too.
    desk.program().put(name(b"\xff.obj"), "f 1 2 3\n");
    let outcome = desk.program().run(&[OsStr::new("render"), name(b"\xff.obj")]);
    assert!(outcome.code == Some(1) && outcome.stderr.contains(".obj:1: vertex 1"), "{}", outcome.stderr);
}

/// Each level is written, and what is written in the end is what would have been written anyway.
#[test]
fn a_progressive_render_writes_its_levels_on_the_way() {
    let desk = Desk::new();
    let plain = desk.run("render cornell --size 40x24 --spp 2 -o plain.exr --progress none");
    let outcome = desk.run("render cornell --size 40x24 --spp 2 -o a.exr -o a.png --progress json --progressive=8");
    assert_eq!((plain.code, outcome.code), (Some(0), Some(0)), "{}", outcome.stderr);
    let levels: Vec<Value> = events(&outcome.stderr).into_iter().filter(|event| event["event"] == "level").collect();
    let sides: Vec<_> = levels.iter().map(|level| level["side"].as_u64().unwrap()).collect();
    assert_eq!(sides, [8, 4, 2, 1]);
    assert!(levels.iter().all(|level| level["files"] == serde_json::json!(["a.exr", "a.png"])), "{levels:?}");
    for channel in ["R", "G", "B"] {
        assert_eq!(values(&desk, "a.exr", channel), values(&desk, "plain.exr", channel));
    }
}

/// Options that the integrator would not look at are refused, unless they are the scene file's for another one.
#[test]
fn options_belong_to_their_integrator() {
    let desk = Desk::new();
    desk.program().put("deep.toml", "[scene]\nfile = \"t.obj\"\n[render]\nspp = 1\nmax_depth = 3\n");
    let refused = desk.run("render t.obj --size 4x4 -o a.exr --integrator ao --bounces 2");
    assert_eq!(refused.code, Some(1));
    assert!(refused.stderr.contains("the integrator `ao` does not use --bounces"), "{}", refused.stderr);
    for good in ["--integrator ao --ao-distance 0.5", "--max-depth 2", "--integrator montecarlo --rays 3"] {
        let outcome = desk.run(&format!("render deep.toml --size 4x4 -o a.exr {good}"));
        assert_eq!(outcome.code, Some(0), "{good}: {}", outcome.stderr);
    }
}
