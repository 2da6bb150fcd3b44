//! The output and the errors of `halfdome probes`.

use std::fs;
use std::io::Write as _;
use std::process::Stdio;

use halfdome::output::read_exr;
use halfdome_tests::program::Program;
use serde_json::{Value, json};

use crate::{in_folder, refuse, succeed};

/// Options with which probes take little time.
const SMALL: &str = "--rays 64 --spp 16 --progress none";

fn read(program: &Program, name: &str) -> Value {
    serde_json::from_slice(&fs::read(program.folder.join(name)).unwrap()).unwrap()
}

#[test]
fn a_grid_is_written_in_every_format() {
    in_folder(|program| {
        let line = format!("probes cornell --grid 3x2x4 -o a.json -o a.exr -o a.ktx2 {SMALL}");
        succeed(&program.run_line(&line));
        assert_eq!(program.names(), ["a.exr", "a.json", "a.ktx2"]);
        let document = read(program, "a.json");
        assert_eq!(document["grid"]["count"], json!([3, 2, 4]));
        assert_eq!(document["coefficients"], json!(["0", "1-1", "10", "11", "2-2", "2-1", "20", "21", "22"]));
        let probes = document["probes"].as_array().unwrap();
        assert_eq!(probes.len(), 24);
        let number = |value: &Value| value.as_f64().unwrap() as f32;
        for axis in 0..3 {
            let part = |corner: &str| number(&document["grid"][corner][axis]);
            let transform = &document["grid"]["transform"];
            assert!((number(&transform["scale"][axis]) - (part("max") - part("min"))).abs() < 1e-6);
            assert!((number(&transform["translation"][axis]) - 0.5 * (part("max") + part("min"))).abs() < 1e-6);
        }

        let picture = read_exr(&program.folder.join("a.exr")).unwrap();
        assert_eq!((picture.width, picture.height, picture.channels.len()), (3, 8, 27 + 3 + 2));
        for (i, probe) in probes.iter().enumerate() {
            assert_eq!(picture.channel("sh.2-1.G").unwrap().values[i], number(&probe["sh"][5][1]));
            assert_eq!(picture.channel("P.Z").unwrap().values[i], number(&probe["position"][2]));
        }

        let bytes = fs::read(program.folder.join("a.ktx2")).unwrap();
        let reader = ktx2::Reader::new(&bytes).unwrap();
        let header = reader.header();
        assert_eq!((header.pixel_width, header.pixel_height, header.pixel_depth), (3, 4, 12));
        assert_eq!((header.face_count, header.level_count), (1, 1));
        let data = reader.levels().next().unwrap().data;
        let texel = |x: usize, y: usize, z: usize| {
            let at = ((z * 4 + y) * 3 + x) * 8;
            [0, 2, 4].map(|c| f32::from(half::f16::from_le_bytes([data[at + c], data[at + c + 1]])))
        };
        // In the Cornell box the red wall is at greater x, the green one at smaller x: what comes from +x is redder.
        let [right, left] = [texel(1, 0, 1), texel(1, 2, 1)];
        assert!(right[0] / right[1] > 1.3 * left[0] / left[1], "{right:?} {left:?}");
        // More comes from above than from below.
        let [up, down] = [texel(1, 1, 4 + 1), texel(1, 3, 4 + 1)];
        assert!(up[1] > 2.0 * down[1], "{up:?} {down:?}");
    });
}

#[test]
fn listed_points_keep_their_places_and_are_marked() {
    in_folder(|program| {
        // In the air, and in the tall block.
        let points = "# seats\n0.278 0.3 0.279\n\n0.36 0.1 0.35\n";
        program.put("seats.txt", points);
        let line = format!("probes cornell --points seats.txt -o a.json {SMALL}");
        let outcome = program.run_line(&line);
        assert_eq!((outcome.code, outcome.stderr.as_str()), (Some(0), "warning: 1 probe is inside of objects\n"));
        let document = read(program, "a.json");
        assert_eq!(document["grid"], Value::Null);
        let states: Vec<&Value> = document["probes"].as_array().unwrap().iter().map(|probe| &probe["state"]).collect();
        assert_eq!(states, ["free", "covered"]);
        assert_eq!(document["probes"][1]["position"], json!([0.36, 0.1, 0.35]));
        // Standard input is as good as a file.
        let before = program.files();
        let line = line.replace("seats.txt", "-");
        let mut command = program.command(&line.split_whitespace().collect::<Vec<_>>());
        let mut child = command.stdin(Stdio::piped()).spawn().unwrap();
        child.stdin.take().unwrap().write_all(points.as_bytes()).unwrap();
        assert!(child.wait().unwrap().success());
        assert!(program.files() == before);
    });
}

#[test]
fn probes_are_the_same_bytes_for_any_number_of_threads() {
    in_folder(|program| {
        let make = |options: &str| {
            let line = format!("probes cornell --grid 4x4x4 -o a.json -o a.ktx2 -o a.exr {SMALL} {options}");
            let outcome = program.run_reproducibly(&line);
            assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
            program.files()
        };
        let one = make("--threads 1");
        assert!(make("--threads 3") == one);
        assert!(make("--seed 1") != one);
    });
}

#[test]
fn wrong_input_is_named() {
    in_folder(|program| {
        program.put("seats.txt", "0 0 0\n0 0\n");
        program.put("none.txt", "# nobody\n");
        program.put("dark.obj", "v 0 0 0\nv 1 0 0\nv 0 0 1\nf 1 2 3\n");
        refuse(
            program,
            &[
                ("probes cornell -o a.json", "--grid"),
                ("probes cornell --grid 2x2x2", "--output"),
                ("probes cornell --grid 2x2 -o a.json", "expected three whole numbers"),
                ("probes cornell --grid 0x2x2 -o a.json", "expected three whole numbers"),
                ("probes cornell --grid 1024x1024x1024 -o a.json", "4194304 probes at most"),
                ("probes cornell --grid 2x2x2 -o a.hdr", "a.hdr: probes cannot be written in this format"),
                ("probes cornell --grid 2x2x2 -o a.json -o a.json", "a.json is given twice"),
                ("probes cornell --grid 2x2x2 --min 1,0,0 --max 0,1,1 -o a.json", "is empty"),
                ("probes dark.obj --grid 2x2x2 -o a.json", "is empty"),
                ("probes cornell --grid 2x2x2 -o missing/a.json", "the folder missing does not exist"),
                ("probes cornell --points seats.txt --grid 2x2x2 -o a.json", "cannot be used with"),
                ("probes cornell --points seats.txt -o a.ktx2", "a volume needs a grid of probes"),
                ("probes cornell --points seats.txt -o a.json", "seats.txt: line 2: has 2 values instead of three"),
                ("probes cornell --points none.txt -o a.json", "none.txt: it has no points"),
                ("probes cornell --points missing.txt -o a.json", "missing.txt: cannot be read"),
                ("probes missing.glb --grid 2x2x2 -o a.json", "missing.glb: no such file"),
                ("probes cornell --grid 2x2x2 --rays 1 -o a.json", "18"),
            ],
        );
        // Nothing shines; the box must be given, as the model is flat.
        let dark =
            program.run_line(&format!("probes dark.obj --grid 1x1x1 --min 0,0.5,0 --max 1,1,1 -o a.json {SMALL}"));
        assert_eq!(dark.code, Some(0), "{}", dark.stderr);
        assert!(dark.stderr.contains("all probes are black"), "{}", dark.stderr);
    });
}
