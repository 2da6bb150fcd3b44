//! `halfdome cache` and `halfdome irradiance`.

mod sensors;

use std::fs;
use std::io::Write as _;
use std::process::Stdio;

use halfdome_kernel::{Isa, Level};
use halfdome_tests::program::{Program, succeed};

const EXECUTABLE: &str = env!("CARGO_BIN_EXE_halfdome-under-test");

/// Options that make small caches quickly.
const SMALL: &str = "--record-rays 64 --cache-error 0.5 --progress none";

/// Runs `test` with the program in a folder of its own.
fn in_folder(test: impl FnOnce(&Program)) {
    let folder = tempfile::tempdir().unwrap();
    test(&Program { executable: EXECUTABLE, folder: folder.path() });
}

fn build(program: &Program, name: &str, options: &str) -> Vec<u8> {
    succeed(&program.run_line(&format!("cache build cornell -o {name} --size 48x40 {SMALL} {options}")));
    fs::read(program.folder.join(name)).unwrap()
}

#[test]
fn caches_are_the_same_bytes_for_any_number_of_threads() {
    in_folder(|program| {
        for options in ["", "--metric bounded", "--layout hemicube", "--cache-bounces 2", "--metric split-sphere"] {
            let one = build(program, "1.cache", &format!("{options} --threads 1"));
            for threads in [2, 8] {
                let more = build(program, "n.cache", &format!("{options} --threads {threads}"));
                assert!(more == one, "{options}, {threads} threads");
            }
        }
        assert_ne!(build(program, "s.cache", "--seed 1"), build(program, "t.cache", "--seed 2"));
    });
}

/// Nor do they depend on how many rays an instruction set takes at once, or on whether rays go in packets at all.
#[test]
fn caches_are_the_same_bytes_for_any_instruction_set() {
    in_folder(|program| {
        for options in ["", "--layout hemicube --metric bounded"] {
            let build = |level: &str| {
                let line = format!("cache build cornell -o a.cache --size 48x40 {SMALL} {options}");
                let mut command = program.command(&line.split_whitespace().collect::<Vec<_>>());
                assert!(command.env("HALFDOME_ISA", level).status().unwrap().success());
                fs::read(program.folder.join("a.cache")).unwrap()
            };
            let scalar = build("scalar");
            for level in Level::ALL.into_iter().filter(|&level| Isa::new(level).is_some()) {
                assert!(build(level.name()) == scalar, "{options}, {level:?}");
            }
        }
    });
}

/// A picture from a file of records is the one that fills its cache itself.
#[test]
fn saved_caches_give_the_same_picture() {
    in_folder(|program| {
        build(program, "a.cache", "");
        let render = |name: &str, options: &str| {
            let line = format!("render cornell -o {name} --size 48x40 --spp 4 --integrator cached {SMALL} {options}");
            succeed(&program.run_reproducibly(&line));
            fs::read(program.folder.join(name)).unwrap()
        };
        let fresh = render("fresh.exr", "");
        assert!(fresh == render("saved.exr", "--cache a.cache"));
    });
}

#[test]
fn caches_merge_in_any_order_and_describe_themselves() {
    in_folder(|program| {
        build(program, "a.cache", "--seed 1");
        build(program, "b.cache", "--seed 2 --eye 0.278,0.273,-0.5 --target 0.2,0.1,0.3");
        for (line, name) in [("a.cache b.cache", "ab.cache"), ("b.cache a.cache b.cache", "ba.cache")] {
            succeed(&program.run_line(&format!("cache merge {line} -o {name}")));
        }
        let [ab, ba] = ["ab.cache", "ba.cache"].map(|name| fs::read(program.folder.join(name)).unwrap());
        assert!(ab == ba);
        let records = |name: &str| {
            let outcome = program.run_line(&format!("cache info {name} --json"));
            succeed(&outcome);
            let info: serde_json::Value = serde_json::from_str(&outcome.stdout).unwrap();
            let expected = serde_json::json!({
                "cache_error": 0.5, "gradients": "both", "metric": "hessian", "layout": "stratified", "record_rays": 64,
                "cache_bounces": null, "accuracy": null
            });
            assert_eq!(info["options"], expected);
            info["records"].as_u64().unwrap()
        };
        assert!(records("a.cache") > 10);
        assert_eq!(records("ab.cache"), records("a.cache") + records("b.cache"));
        assert!(program.run_line("cache info a.cache").stdout.contains("record-rays    64"));

        // About 64 rays on a hemicube are those of 3 n² texels, n even: 48.
        build(program, "cube.cache", "--layout hemicube --cache-bounces 2");
        let cube: serde_json::Value =
            serde_json::from_str(&program.run_line("cache info cube.cache --json").stdout).unwrap();
        assert_eq!(cube["gather_rays"], 48 * cube["records"].as_u64().unwrap());
        assert_eq!((&cube["options"]["layout"], &cube["options"]["cache_bounces"]), (&"hemicube".into(), &2.into()));
    });
}

#[test]
fn records_can_be_shown() {
    in_folder(|program| {
        build(program, "a.cache", "");
        let line = format!("cache show cornell a.cache -o a.png -o a.ply --size 48x40 --spp 1 {SMALL}");
        succeed(&program.run_line(&line));
        assert!(fs::read(program.folder.join("a.png")).unwrap().starts_with(b"\x89PNG"));
        let ply = fs::read_to_string(program.folder.join("a.ply")).unwrap();
        let (header, body) = ply.split_once("end_header\n").unwrap();
        assert!(header.contains(&format!("element vertex {}\n", body.lines().count())));
        assert!(body.lines().all(|line| line.split(' ').filter_map(|word| word.parse::<f32>().ok()).count() == 11));
    });
}

/// The numbers of each line.
fn numbers(text: &str) -> Vec<Vec<f64>> {
    text.lines().map(|line| line.split(' ').map(|word| word.parse().unwrap()).collect()).collect()
}

#[test]
fn bad_input_is_named() {
    in_folder(|program| {
        let refused = |line: &str, parts: &[&str]| {
            let outcome = program.run_line(line);
            assert_eq!((outcome.code, outcome.stdout.as_str()), (Some(1), ""), "{line}: {}", outcome.stderr);
            for part in parts {
                assert!(outcome.stderr.contains(part), "{line}: {}", outcome.stderr);
            }
        };
        for value in ["0", "-1", "nan", "1.5", "x"] {
            refused(
                &format!("cache build cornell -o a --cache-error {value}"),
                &["--cache-error", "more than 0 and at most 1"],
            );
        }
        for value in ["0", "11", "1048577", "99999999999", "2.5"] {
            refused(
                &format!("cache build cornell -o a --record-rays {value}"),
                &["--record-rays", "from 12 to 1048576"],
            );
        }
        refused("cache build cornell -o a --cache-bounces 0", &["--cache-bounces", "from 1 to 16"]);
        refused("render cornell --metric hessian", &["`path` does not use --metric"]);
        refused("cache build cornell -o a --integrator path", &["`path` does not use an irradiance cache"]);
        refused("cache build cornell -o no/a", &["the folder no does not exist"]);

        let bytes = build(program, "a.cache", "");
        program.put("cut.cache", &bytes[..bytes.len() / 2]);
        program.put("foreign.cache", "v 0 0 0\n");
        let render = format!("render cornell --integrator cached {SMALL} --size 48x40");
        refused(&format!("{render} --cache cut.cache"), &["cut.cache: is cut off"]);
        refused(&format!("{render} --cache foreign.cache"), &["foreign.cache: is no irradiance cache"]);
        refused(&format!("{render} --cache none.cache"), &["none.cache: cannot be read"]);
        refused(&format!("{render} --cache a.cache --sky 1"), &["a.cache: the cache is of another scene"]);
        refused(
            "render cornell --integrator cached --cache a.cache --record-rays 64 --cache-error 0.25",
            &["was built with --cache-error 0.5, not 0.25"],
        );
        refused("render cornell --cache a.cache", &["`path` does not use an irradiance cache"]);
        refused("cache info foreign.cache", &["foreign.cache: is no irradiance cache"]);
        build(program, "b.cache", "--metric bounded");
        let remedy = "\n  help: merge caches of one scene that were built with the same options";
        refused(
            "cache merge a.cache b.cache -o c.cache",
            &["b.cache: the cache was built with --metric bounded, those before it with hessian", remedy],
        );
        refused(
            "cache merge b.cache a.cache -o c.cache",
            &["a.cache: the cache was built with --metric hessian, those before it with bounded", remedy],
        );
        build(program, "sky.cache", "--sky 1");
        let hash = |name: &str| {
            let info = program.run_line(&format!("cache info {name} --json")).stdout;
            let info: serde_json::Value = serde_json::from_str(&info).unwrap();
            info["scene_hash"].as_str().unwrap().to_owned()
        };
        let scenes = format!(
            "sky.cache: the cache is of another scene (hash {}) than those before it ({})",
            hash("sky.cache"),
            hash("a.cache")
        );
        refused("cache merge a.cache sky.cache -o c.cache", &[&scenes, remedy]);

        for option in
            ["--cache a.cache", "--cache-error 0.5", "--record-rays 64", "--cache-bounces 2", "--metric bounded"]
        {
            let line = format!("irradiance cornell --points none.txt --brute {option}");
            refused(&line, &["cannot be used with", "--brute", option.split(' ').next().unwrap()]);
        }

        program.put("points.txt", "0 0 0 0 0 1\n1 2 3 0 0 0\n");
        refused("irradiance cornell --points points.txt", &["points.txt: line 2: the normal 0 0 0 has no direction"]);
        program.put("points.txt", "0 0 0 0 0 1\n\n1 2 3 0 NaN 0\n");
        refused("irradiance cornell --points points.txt", &["line 3: the normal 0 NaN 0"]);
        refused("irradiance cornell --points none.txt", &["none.txt: cannot be read"]);
    });
}

/// Programs learn that the work began, how it went and what became of the records.
#[test]
fn the_work_is_told_as_events() {
    in_folder(|program| {
        program.put("points.txt", "0.278 0.3 0.28 0 1 0\n0.278 0.2 0.5592 0 0 -1\n");
        let events = |line: &str| {
            let outcome = program.run_line(line);
            assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
            let events: Vec<serde_json::Value> =
                outcome.stderr.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
            let [start, .., end] = &events[..] else { panic!("{events:?}") };
            assert_eq!(
                (&start["event"], &end["event"], &end["finished"]),
                (&"start".into(), &"end".into(), &true.into())
            );
            assert!(end["rays"].as_u64().unwrap() > 100);
            (start.clone(), end.clone())
        };
        let small = "--record-rays 64 --cache-error 0.5 --progress json";
        let (start, end) = events(&format!("irradiance cornell --points points.txt -o e.txt {small}"));
        assert_eq!((&start["sensors"], &start["spp"]), (&2.into(), &64.into()));
        assert_eq!((&end["cache"]["misses"], &end["cache"]["negative"]), (&0.into(), &0.into()));
        assert!(end["cache"]["records"].as_u64().unwrap() > 0);
        assert_eq!(end["files"], serde_json::json!(["e.txt"]));
        let (_, end) = events("irradiance cornell --points points.txt --brute --progress json");
        assert_eq!((&end["cache"], &end["files"]), (&serde_json::Value::Null, &serde_json::json!([])));
        let (start, end) = events(&format!("cache build cornell -o a.cache --size 48x40 {small}"));
        assert_eq!((&start["width"], &start["height"]), (&48.into(), &40.into()));
        let info: serde_json::Value =
            serde_json::from_str(&program.run_line("cache info a.cache --json").stdout).unwrap();
        assert_eq!(end["cache"]["records"], info["records"]);
    });
}

#[test]
fn an_accuracy_that_was_not_reached_is_told() {
    in_folder(|program| {
        program.put("points.txt", "0.1 0.3 0.1 0 1 0\n0.25 0.25 0.25 0 0 1\n0.25 0.25 0.25 0 0 -1\n");
        for line in [
            "irradiance cornell --points points.txt --indirect",
            "cache build cornell -o a.cache --size 4x4",
            "render cornell -o a.exr --integrator cached --size 4x4 --spp 1",
        ] {
            let missed = |accuracy: &str| {
                let outcome = program.run_line(&format!("{line} --progress none --accuracy {accuracy}"));
                assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
                outcome.stderr.contains("warning: the requested accuracy is not reached: the estimated error is ")
            };
            assert!(missed("0.01%") && !missed("20%"), "{line}");
        }
    });
}

#[test]
fn an_accuracy_can_be_asked_for_in_the_dark() {
    in_folder(|program| {
        // Inside of a block.
        program.put("points.txt", "0.2 0.1 0.2 0 1 0\n");
        for options in ["", "--indirect"] {
            let line = format!("irradiance cornell --points points.txt --accuracy 1% --progress none {options}");
            let outcome = program.run_line(&line);
            succeed(&outcome);
            assert_eq!(outcome.stdout, "0 0 0\n");
        }
    });
}
