//! Ctrl-C and SIGTERM: what is done so far is written, and the exit code tells.
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

/// Starts a render that would take days, sends `signal` once it is under way, and gives its last event.
fn interrupted(desk: &Desk, signal: &str) -> Value {
    let line = "render cornell --size 40x30 --spp 4000000000 -o a.exr -o a.png --progress json";
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
        let end = interrupted(&desk, signal);
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
