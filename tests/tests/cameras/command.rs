//! Cameras on the command line and in scene files: refused options, independence of threads and formats, and the output
//! of `info`.

use halfdome::output::read_exr;
use halfdome_tests::program::{Outcome, Program};
use serde_json::Value;
use tempfile::TempDir;

struct Desk {
    folder: TempDir,
}

impl Desk {
    fn new() -> Self {
        Self { folder: tempfile::tempdir().unwrap() }
    }

    fn program(&self) -> Program<'_> {
        Program { executable: env!("CARGO_BIN_EXE_halfdome-under-test"), folder: self.folder.path() }
    }

    fn run(&self, line: &str) -> Outcome {
        self.program().run_reproducibly(line)
    }

    fn refuses(&self, line: &str, parts: &[&str]) {
        let before = self.program().files();
        let Outcome { code, stdout, stderr } = self.run(line);
        assert_eq!((code, stdout.as_str()), (Some(1), ""), "{line}: {stderr}");
        for part in parts.iter().chain(&["error: "]) {
            assert!(stderr.contains(part), "{line}: {stderr} lacks {part:?}");
        }
        assert!(self.program().files() == before, "{line}: the folder has changed");
    }
}

#[test]
fn wrong_options_are_refused() {
    let desk = Desk::new();
    for (options, part) in [
        ("--camera pinhole", "one of perspective, orthographic, panorama, fisheye, cube, rays"),
        ("--aperture 8 --focus 0", "'--focus <DISTANCE>': expected a number of more than 0"),
        ("--aperture 8 --focus -1", "'--focus <DISTANCE>': expected a number of more than 0"),
        ("--aperture 8 --focus nan", "'--focus <DISTANCE>': expected a number of more than 0"),
        ("--aperture 8 --focus inf", "'--focus <DISTANCE>': expected a number of more than 0"),
        ("--aperture -8 --focus 1", "'--aperture <MM>': expected millimetres from 0"),
        ("--aperture nan --focus 1", "'--aperture <MM>': expected millimetres from 0"),
        ("--f-number 0 --focus 1", "'--f-number <N>': expected a number of more than 0"),
        ("--aperture 8 --f-number 2 --focus 1", "both `aperture` and `f_number` are given\n  help: leave one"),
        ("--aperture 8", "the lens has no focus distance\n  help: give focus"),
        ("--aperture 8 --focus 1 --focus-at 0,0,0", "both `focus` and `focus_at` are given"),
        ("--aperture 8 --focus-at 0.278,0.273,-2", "is not in front of the camera"),
        ("--aperture 8 --focus 1 --blades 1", "'--blades <N>': expected 0 for a disc, or a whole number from 3 to 64"),
        ("--aperture 8 --focus 1 --blades 2", "'--blades <N>': expected 0 for a disc, or a whole number from 3 to 64"),
        ("--aperture 8 --focus 1 --anamorphic 0", "'--anamorphic <RATIO>': expected a number from 0.01 to 100"),
        ("--blades 5", "there is no lens that `blades` could be of"),
        ("--vfov 0", "more than 0 and less than 180"),
        ("--vfov 180", "more than 0 and less than 180"),
        ("--focal-length 50 --vfov 30", "both `vfov` and `focal_length` are given"),
        ("--focal-length 0", "'--focal-length <MM>': expected a number of more than 0"),
        ("--focal-length 50 --sensor 0,24", "'--sensor <W,H>': expected two numbers of more than 0"),
        ("--sensor 36,24", "`sensor` changes nothing by itself\n  help: give focal_length or f_number too"),
        ("--shift 1", "'--shift <X,Y>': expected two numbers"),
        ("--camera fisheye --fov 361", "'--fov <DEGREES>': expected degrees, more than 0 and at most 360"),
        ("--camera fisheye --fov 0", "'--fov <DEGREES>': expected degrees, more than 0 and at most 360"),
        ("--fov 100", "the perspective camera does not use `fov`\n  help: leave it out, or choose fisheye"),
        ("--camera fisheye --vfov 40", "the fisheye camera does not use `vfov`"),
        ("--camera panorama --shift 0.1,0", "the panorama camera does not use `shift`"),
        ("--camera cube --aperture 8", "the cube camera does not use `aperture`"),
        ("--camera cube --size 60x20", "a picture of 60x20 does not hold the six faces of a cube"),
        ("--camera orthographic", "the orthographic camera has no height or width"),
        ("--camera orthographic --ortho-height 0", "'--ortho-height <LENGTH>': expected a number of more than 0"),
        ("--camera orthographic --ortho-height 1 --f-number 2", "does not use `f_number`"),
        ("--camera rays", "the rays camera has no rays\n  help: name a file by --camera-rays"),
        ("--camera-rays none.csv", "none.csv: no such file"),
        ("--near 2 --far 1", "`near` is 2 and `far` is 1, so nothing is in between\n  help: give a near"),
        ("--near -1", "'--near <DISTANCE>': expected a number from 0"),
        ("--far 0", "'--far <DISTANCE>': expected a number of more than 0"),
        ("--model-clip", "the camera is not one of a glTF file"),
    ] {
        desk.refuses(&format!("render cornell {options}"), &[part]);
        desk.refuses(&format!("info cornell {options}"), &[part]);
    }
}

#[test]
fn wrong_scene_files_are_refused_with_their_place() {
    let desk = Desk::new();
    desk.program().put("t.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    for (lines, part) in [
        ("type = \"fish\"", "s.toml:4: camera.type is \"fish\""),
        ("aperture = -1", "s.toml:4: camera.aperture is -1"),
        ("blades = 2", "s.toml:4: camera.blades is 2"),
        ("sensor = [0, 1]", "s.toml:4: camera.sensor is [0, 1]"),
        ("fov = 400", "s.toml:4: camera.fov is 400"),
        ("aparture = 1", "did you mean `aperture`?"),
        ("rays = \"none.csv\"", "s.toml:4: there is no file none.csv"),
        ("type = \"cube\"\nvfov = 30", "s.toml: the cube camera does not use `vfov`"),
        ("near = 3\nfar = 2", "s.toml: `near` is 3 and `far` is 2"),
    ] {
        desk.program().put("s.toml", format!("[scene]\nfile = \"t.obj\"\n[camera]\n{lines}\n"));
        desk.refuses("render s.toml", &[part, "help: "]);
    }
}

#[test]
fn files_of_rays_are_refused_with_their_line() {
    let desk = Desk::new();
    let put = |text: &str| desk.program().put("rays.csv", text);
    put("0,0,0,0,0,1\n0,0,0,0,0,0\n");
    let render = "render cornell --camera-rays rays.csv --size 2x1";
    desk.refuses(render, &["rays.csv:2: the direction of this ray is zero\n  help: "]);
    put("0,0,0,0,0,1\n");
    desk.refuses(render, &["rays.csv:1: the file ends after 1 rays, and a picture of 2x1 has 2 pixels\n  help: "]);
    put("0 0 0 0 0 1\n0 0 0 0 0 1\n0 0 0 0 0 1\n");
    desk.refuses(render, &["rays.csv:3: there are more rays than the 2 pixels"]);
    put("0 0 0 0 0 1\n# the last\n0 0 0 0 0\n");
    desk.refuses(render, &["rays.csv:3: this line has 5 numbers\n  help: write six numbers: ox oy oz dx dy dz"]);
    desk.refuses(&format!("{render} --eye 1,2,3"), &["the rays camera does not use `eye`"]);
}

/// Rays in an EXR, of which a picture of positions and normals is one with other names.
#[test]
fn rays_may_come_from_an_exr() {
    use halfdome::film::{Channel, Metadata, Picture};
    let desk = Desk::new();
    let channel = |(name, value): (&str, f32)| Channel { name: name.to_owned(), values: vec![value; 2] };
    let rays = [("ox", 0.278), ("oy", 0.273), ("oz", -0.8), ("dx", 0.0), ("dy", 0.0), ("dz", 1.0)];
    let picture = |count: usize| Picture {
        width: 2,
        height: 1,
        channels: rays.into_iter().take(count).map(channel).collect(),
        metadata: Metadata::default(),
    };
    let write = |name: &str, picture: &Picture| {
        halfdome::output::write(&desk.folder.path().join(name), picture, &Default::default()).unwrap();
    };
    write("rays.exr", &picture(6));
    let outcome = desk.run("render cornell --camera-rays rays.exr --size 2x1 --spp 1 --integrator normals -o a.exr");
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    let seen = read_exr(&desk.folder.path().join("a.exr")).unwrap();
    assert_eq!(seen.metadata.world_to_camera, None);
    desk.refuses(
        "render cornell --camera-rays rays.exr --size 3x1",
        &["rays.exr: it has 2x1 rays, and the picture 3x1"],
    );
    write("rays.exr", &picture(5));
    desk.refuses("render cornell --camera-rays rays.exr --size 2x1", &["rays.exr: it has no channel `dz`"]);
}

/// What lenses and borders add does not depend on threads either.
#[test]
fn any_number_of_threads_gives_the_same_bytes() {
    let desk = Desk::new();
    for options in [
        "--size 70x41 --aperture 40 --focus 1.2 --blades 5 --anamorphic 1.5",
        "--size 70x41 --f-number 1.4 --focus 1.2 --sampler r2 --aov",
        "--size 70x41 --aperture 40 --focus 1.2 --integrator cached --record-rays 64",
        "--size 70x41 --camera fisheye --fov 200 --filter mitchell --aov",
        "--size 96x16 --camera cube --progressive=16",
        "--size 64x64 --camera panorama --ipd 64 --sampler random",
    ] {
        let render = |threads: u32| {
            let line =
                format!("render cornell {options} --spp 5 --threads {threads} -o a.exr -o a.png --progress none");
            let outcome = desk.run(&line);
            assert_eq!((outcome.code, outcome.stderr.as_str()), (Some(0), ""), "{options}");
            ["a.exr", "a.png"].map(|name| std::fs::read(desk.folder.path().join(name)).unwrap())
        };
        assert!(render(1) == render(4), "{options}");
    }
}

#[test]
fn info_tells_the_camera() {
    let desk = Desk::new();
    for (options, rows) in [
        ("", &["camera              perspective\n", "camera vfov         39.3"][..]),
        ("--camera fisheye --fov 200", &["camera              fisheye, equidistant, 200°\n"]),
        ("--camera orthographic --ortho-height 2", &["camera height       2\n"]),
        ("--camera panorama --ipd 64", &["camera eyes         two, 0.064 apart"]),
        (
            "--aperture 20 --focus 3 --blades 6 --shift 0.1,0 --near 1",
            &[
                "camera lens         aperture 0.02, focus 3, 6 blades turned by 0°\n",
                "camera shift        0.1 0",
                "camera clip         from 1 to infinity\n",
            ],
        ),
    ] {
        let outcome = desk.run(&format!("info cornell {options}"));
        for row in rows {
            assert!(outcome.stdout.contains(row), "{options}: {} lacks {row:?}", outcome.stdout);
        }
    }
    let json: Value = serde_json::from_str(&desk.run("info cornell --json --camera fisheye").stdout).unwrap();
    assert_eq!((&json["camera"]["type"], &json["camera"]["fov"]), (&"fisheye".into(), &180.0.into()));
    assert_eq!(json["camera"]["vfov"], Value::Null);
}
