//! Ctrl-C and SIGTERM: the results so far are written, with the right exit code.
#![cfg(unix)]

use std::io::{BufRead as _, BufReader};
use std::process::{Child, Command};

use serde_json::Value;

use crate::Desk;

/// A run that ends with the test, however that ends.
struct Run(Child);

impl Drop for Run {
    fn drop(&mut self) {
        // It may have ended by itself, as it should.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// Starts what would take days, sends `signal` once it is under way, and gives its last event.
fn interrupted(desk: &Desk, line: &str, signal: &str) -> Value {
    let arguments: Vec<_> = line.split(' ').collect();
    let mut run = Run(desk.program().command(&arguments).spawn().unwrap());
    let mut last = Value::Null;
    for line in BufReader::new(run.0.stderr.take().unwrap()).lines() {
        let event: Value = serde_json::from_str(&line.unwrap()).unwrap();
        if event["event"] == "progress" && last["event"] != "progress" {
            let kill = Command::new("kill").args([signal, &run.0.id().to_string()]).status().unwrap();
            assert!(kill.success());
        }
        last = event;
    }
    assert_eq!(run.0.wait().unwrap().code(), Some(3));
    last
}

#[test]
fn signals_end_a_render_with_the_picture_so_far() {
    for signal in ["-INT", "-TERM"] {
        let desk = Desk::new();
        let line = "render cornell --size 40x30 --spp 4000000000 -o a.exr -o a.png --progress json";
        let end = interrupted(&desk, line, signal);
        assert_eq!((&end["event"], &end["finished"]), (&"end".into(), &false.into()));
        let names: Vec<_> = desk.program().files().into_keys().collect();
        assert_eq!(names, ["a.exr", "a.png", "t.obj"]);
        let picture = halfdome::output::read_exr(&desk.folder.path().join("a.exr")).unwrap();
        assert_eq!((picture.width, picture.height), (40, 30));
        let samples = picture.metadata.samples_per_pixel;
        assert!((1..4_000_000_000).contains(&samples), "{samples}");
        // A valid picture: nothing but numbers, and light in every corner of the lit room.
        let red = &picture.channel("R").unwrap().values;
        assert!(red.iter().all(|value| value.is_finite() && *value >= 0.0));
        assert!(red.iter().filter(|value| **value > 0.0).count() > 40 * 30 / 2);
    }
}

/// A line for each sensor or none.
#[test]
fn signals_end_sensors_with_nothing_written() {
    for options in ["--brute --spp 4000000000", "--spp 4000000000", "--record-rays 1048576 --cache-error 0.001"] {
        let desk = Desk::new();
        let points = (0..500).map(|i| format!("{} 0 {} 0 1 0\n", 0.001 * i as f32, 0.001 * (i * 7 % 500) as f32));
        desk.program().put("points.txt", points.collect::<String>());
        let line = format!("irradiance cornell --points points.txt -o e.txt --progress json {options}");
        let end = interrupted(&desk, &line, "-INT");
        assert_eq!((&end["event"], &end["finished"]), (&"end".into(), &false.into()), "{options}");
        assert_eq!(end["message"], "nothing was written");
        let names: Vec<_> = desk.program().files().into_keys().collect();
        assert_eq!(names, ["points.txt", "t.obj"], "{options}");
    }
}

/// What is said of an interrupted cache is what is in its file; without a record there is none.
#[test]
fn signals_end_a_cache_with_the_records_so_far() {
    let desk = Desk::new();
    let line = "cache build cornell -o a.cache --size 400x300 --cache-error 0.05 --progress json --record-rays";
    for rays in [1024, 1_048_576] {
        let end = interrupted(&desk, &format!("{line} {rays}"), "-INT");
        assert_eq!((&end["event"], &end["finished"]), (&"end".into(), &false.into()), "{rays}");
        let (message, records) = (end["message"].as_str().unwrap(), end["cache"]["records"].as_u64().unwrap());
        let cache = desk.folder.path().join("a.cache");
        if records == 0 {
            assert_eq!(message, "no records yet, so nothing was written");
            assert!(!cache.exists());
            continue;
        }
        assert_eq!(message, format!("{records} records were written; continue with --cache a.cache"));
        let info = desk.program().run_line("cache info a.cache --json").stdout;
        assert_eq!(serde_json::from_str::<Value>(&info).unwrap()["records"], records);
        std::fs::remove_file(cache).unwrap();
    }
}

#[test]
fn signals_end_experiments_after_those_that_are_done() {
    let desk = Desk::new();
    let mut run = Run(desk.program().command(&["validate", "--json", "furnace"]).spawn().unwrap());
    let mut lines = Vec::new();
    for line in BufReader::new(run.0.stdout.take().unwrap()).lines() {
        lines.push(serde_json::from_str::<Value>(&line.unwrap()).unwrap());
        if lines.len() == 1 {
            assert!(Command::new("kill").args(["-INT", &run.0.id().to_string()]).status().unwrap().success());
        }
    }
    assert_eq!(run.0.wait().unwrap().code(), Some(3));
    assert!(lines[0]["name"] == "furnace-sphere" && lines.iter().all(|line| line["pass"] == true), "{lines:?}");
}
