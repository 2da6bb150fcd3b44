//! Films: a picture has the same bytes however it is split, stopped and resumed; and noise targets.

use std::fs;
use std::time::{Duration, Instant};

use halfdome::output::read_exr;

use crate::Desk;

impl Desk {
    /// Runs to its expected end; files do not contain the time.
    fn ends(&self, code: i32, line: &str) -> String {
        let outcome = self.program().run_reproducibly(line);
        assert_eq!(outcome.code, Some(code), "{line}: {}", outcome.stderr);
        outcome.stderr
    }

    fn bytes(&self, name: &str) -> Vec<u8> {
        fs::read(self.folder.path().join(name)).unwrap()
    }

    /// The luminance of a picture's pixels.
    fn values(&self, name: &str) -> Vec<f64> {
        let picture = read_exr(&self.folder.path().join(name)).unwrap();
        let channel = |name| picture.channel(name).unwrap().values.clone();
        let [r, g, b] = ["R", "G", "B"].map(channel);
        (0..r.len()).map(|i| f64::from(0.2126 * r[i] + 0.7152 * g[i] + 0.0722 * b[i])).collect()
    }
}

#[test]
fn any_split_gives_the_same_bytes() {
    for options in [
        "",
        "--aov --seed 3",
        "--integrator cached --cache-error 0.3",
        "--camera fisheye --filter mitchell",
        "--guide=4096",
    ] {
        let desk = Desk::new();
        let scene = format!("render cornell --size 90x70 --progress none {options}");
        desk.ends(0, &format!("{scene} --spp 21 -o whole.exr -o whole.hdf"));
        let same = |name: &str, films: &str| {
            desk.ends(0, &format!("merge {films} -o {name}.exr -o {name}.hdf"));
            assert!(desk.bytes(&format!("{name}.exr")) == desk.bytes("whole.exr"), "{options}: {name}");
            assert!(desk.bytes(&format!("{name}.hdf")) == desk.bytes("whole.hdf"), "{options}: {name}");
        };
        for (k, threads) in [(1, 1), (2, 3), (3, 2)] {
            desk.ends(0, &format!("{scene} --spp 21 --shard {k}/3 -o tiles{k}.hdf --threads {threads}"));
        }
        same("tiles", "tiles3.hdf tiles1.hdf tiles2.hdf");
        desk.ends(0, &format!("{scene} --spp 5 -o first.hdf"));
        desk.ends(0, &format!("{scene} --spp 21 --first-sample 5 -o second.hdf"));
        same("samples", "second.hdf first.hdf");
        // A part of a part, and a merger of mergers.
        desk.ends(0, &format!("{scene} --spp 21 --first-sample 5 --shard 1/2 -o a.hdf"));
        desk.ends(0, &format!("{scene} --spp 21 --first-sample 5 --shard 2/2 -o b.hdf"));
        desk.ends(0, "merge b.hdf first.hdf -o c.hdf");
        same("both", "a.hdf c.hdf");
        // With more samples than first asked for.
        desk.ends(0, &format!("{scene} --spp 21 --resume -o first.exr -o first.hdf"));
        assert!(desk.bytes("first.exr") == desk.bytes("whole.exr"), "{options}");
    }
}

/// A room with a bulb in an open tube, another lamp, a panel and a mirror: several paths begin at a surface.
fn room_with_a_shade(desk: &Desk) {
    let (mut room, mut corners) = (String::from("mtllib room.mtl\n"), 0);
    let mut quad = |material: &str, points: [[f64; 3]; 4]| {
        room += &format!("usemtl {material}\n");
        points.iter().for_each(|[x, y, z]| room += &format!("v {x} {y} {z}\n"));
        room += &format!("f {} {} {} {}\n", corners + 1, corners + 2, corners + 3, corners + 4);
        corners += 4;
    };
    quad("wall", [[0.0, 0.0, 0.0], [0.0, 0.0, 4.0], [4.0, 0.0, 4.0], [4.0, 0.0, 0.0]]);
    quad("gloss", [[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [4.0, 3.0, 0.0], [0.0, 3.0, 0.0]]);
    quad("wall", [[0.0, 0.0, 0.0], [0.0, 3.0, 0.0], [0.0, 3.0, 4.0], [0.0, 0.0, 4.0]]);
    quad("mirror", [[4.0, 0.0, 0.0], [4.0, 0.0, 4.0], [4.0, 3.0, 4.0], [4.0, 3.0, 0.0]]);
    quad("panel", [[1.0, 2.9, 1.0], [1.5, 2.9, 1.0], [1.5, 2.9, 1.5], [1.0, 2.9, 1.5]]);
    for i in 0..12 {
        let [(a, b), (c, d)] = [i, i + 1].map(|k| (f64::from(k) * std::f64::consts::TAU / 12.0).sin_cos());
        let at = |sin: f64, cos: f64, y: f64| [2.0 + 0.12 * cos, y, 2.0 + 0.12 * sin];
        quad("shade", [at(a, b, 1.1), at(a, b, 1.3), at(c, d, 1.3), at(c, d, 1.1)]);
    }
    let program = desk.program();
    program.put("room.obj", room);
    program.put(
        "room.mtl",
        "newmtl wall\nKd 0.7 0.7 0.7\nnewmtl gloss\nKd 0.6 0.5 0.4\nPr 0.3\nnewmtl mirror\nKd 0.9 0.9 0.9\nPm 1\nPr 0\n\
         newmtl panel\nKd 0 0 0\nKe 4 4 4\nnewmtl shade\nKd 0.8 0.8 0.8\n",
    );
    program.put(
        "room.toml",
        "scene.file = \"room.obj\"\nlight = [\n\
         { type = \"sphere\", name = \"bulb\", position = [2, 1.2, 2], radius = 0.01, power = 20 },\n\
         { type = \"point\", position = [3.5, 2.5, 0.5], power = 5 },\n]\n",
    );
}

/// Contributions to a sample are added in an order that does not depend on the samples beside it.
#[test]
fn paths_that_sample_secondary_lights_are_split_into_the_same_bytes() {
    for options in ["--lpe glossy=C<.G>.* --light-groups", "--guide=4096 --clamp-indirect 2"] {
        let desk = Desk::new();
        room_with_a_shade(&desk);
        let view = "room.toml --eye 2,1.6,3.9 --target 2,1,0";
        let scene = format!("render {view} --size 48x36 --progress none {options}");
        desk.ends(0, &format!("{scene} --spp 13 -o whole.exr"));
        desk.ends(0, &format!("{scene} --spp 3 -o first.hdf"));
        desk.ends(0, &format!("{scene} --spp 13 --first-sample 3 -o second.hdf"));
        desk.ends(0, "merge first.hdf second.hdf -o merged.exr");
        assert!(desk.bytes("merged.exr") == desk.bytes("whole.exr"), "{options}");
        desk.ends(0, &format!("{scene} --spp 13 --resume -o first.exr -o first.hdf"));
        assert!(desk.bytes("first.exr") == desk.bytes("whole.exr"), "{options}");
    }
}

/// Each tile judges itself, so that it does not matter who renders it.
#[test]
fn adaptive_pictures_are_the_same_bytes_however_they_are_split() {
    let desk = Desk::new();
    let scene = "render cornell --size 100x70 --spp 4096 --noise 10% --progress none";
    desk.ends(0, &format!("{scene} -o whole.exr"));
    for k in 1..=3 {
        desk.ends(0, &format!("{scene} --shard {k}/3 -o {k}.hdf"));
    }
    desk.ends(0, "merge 1.hdf 2.hdf 3.hdf -o parts.exr");
    assert!(desk.bytes("parts.exr") == desk.bytes("whole.exr"));
    // Stopped in the middle of a wave.
    desk.ends(4, &scene.replace("4096", "41").replace("none", "none -o go.hdf"));
    desk.ends(0, &format!("{scene} --resume -o go.exr -o go.hdf"));
    assert!(desk.bytes("go.exr") == desk.bytes("whole.exr"));
}

#[test]
#[cfg(unix)]
fn what_is_killed_loses_nothing_but_the_time_since_its_checkpoint() {
    let desk = Desk::new();
    let scene = "render cornell --size 120x90 --spp 600 --threads 2 --progress none";
    desk.ends(0, &format!("{scene} -o whole.exr"));
    let line = format!("{scene} --checkpoint 0.05s --resume -o a.exr");
    let arguments: Vec<&str> = line.split(' ').collect();
    let film = desk.folder.path().join("a.hdf");
    for _ in 0..3 {
        let before = fs::read(&film).unwrap_or_default();
        let mut command = desk.program().command(&arguments);
        let mut run = command.env("SOURCE_DATE_EPOCH", "0").spawn().unwrap();
        let start = Instant::now();
        while fs::read(&film).unwrap_or_default() == before && run.try_wait().unwrap().is_none() {
            assert!(start.elapsed() < Duration::from_secs(60), "no checkpoint");
        }
        if run.try_wait().unwrap().is_none() {
            let other = desk.program().run_line(&line);
            assert!(other.code == Some(1) || run.try_wait().unwrap().is_some(), "{}", other.stderr);
            if other.code == Some(1) {
                assert!(other.stderr.contains("a.hdf: another run is rendering this film"), "{}", other.stderr);
            }
        }
        run.kill().unwrap();
        run.wait().unwrap();
        // Whatever is there is whole.
        desk.ends(0, "merge a.hdf -o check.hdf");
    }
    desk.ends(0, &line);
    assert!(desk.bytes("a.exr") == desk.bytes("whole.exr"));
    // What is killed while it writes leaves a temporary file.
    let names: Vec<_> =
        desk.program().files().into_keys().filter(|name| !name.to_string_lossy().starts_with(".halfdome-")).collect();
    assert_eq!(names, ["a.exr", "a.hdf", "check.hdf", "t.obj", "whole.exr"]);
}

#[test]
fn more_samples_than_are_asked_for_are_told() {
    let desk = Desk::new();
    let scene = "render cornell --size 16x12 --progress none --resume -o a.exr";
    desk.ends(0, &format!("{scene} --spp 9"));
    let told = desk.ends(0, &format!("{scene} --spp 4"));
    assert!(told.contains("warning: the film has 9 samples a pixel already, more than --spp 4"), "{told}");
    assert!(!desk.ends(0, &format!("{scene} --spp 9")).contains("already"));
    desk.refuses(&format!("{scene} --spp 9 --max-depth 3"), 1, &["a.hdf", "--max-depth is 1024, not 3"]);
}

/// The root mean square of the relative errors is that of the picture against many samples, and nothing gets darker.
#[test]
fn the_noise_that_was_asked_for_is_there() {
    let desk = Desk::new();
    let scene = "render cornell --size 48x48 --progress none";
    desk.ends(0, &format!("{scene} --spp 8192 --seed 99 -o reference.exr"));
    let reference = desk.values("reference.exr");
    let mean = reference.iter().sum::<f64>() / reference.len() as f64;
    let level = (reference.iter().map(|value| value.sqrt()).sum::<f64>() / reference.len() as f64).powi(2);
    let (mut squares, mut means) = (0.0, Vec::new());
    const RUNS: u32 = 6;
    for seed in 0..RUNS {
        desk.ends(0, &format!("{scene} --spp 16384 --noise 8% --seed {seed} -o a.exr"));
        let values = desk.values("a.exr");
        let errors = values
            .iter()
            .zip(&reference)
            .map(|(value, expected)| ((value - expected) / expected.max(0.1 * level)).powi(2));
        squares += errors.sum::<f64>() / (values.len() as f64 * f64::from(RUNS));
        means.push(values.iter().sum::<f64>() / values.len() as f64 / mean);
    }
    let error = squares.sqrt();
    assert!((0.04..0.12).contains(&error), "{error}");
    let bias = means.iter().sum::<f64>() / f64::from(RUNS) - 1.0;
    let deviation =
        (means.iter().map(|mean| (mean - 1.0 - bias).powi(2)).sum::<f64>() / f64::from(RUNS * (RUNS - 1))).sqrt();
    assert!(bias.abs() < 4.0 * deviation + 1e-3, "{bias} ± {deviation}");
}

#[test]
fn limits_end_a_render_with_a_picture_and_a_code() {
    let desk = Desk::new();
    let told = desk.ends(4, "render cornell --size 32x32 --spp 48 --noise 0.1% -o a.exr --progress bar");
    assert!(told.contains("ended at a limit before its target") && told.contains("48 to 48 samples a pixel"), "{told}");
    desk.ends(4, "render cornell --size 32x32 --spp 4000000000 --time 0.5s -o a.png --progress none");
    desk.ends(0, "render cornell --size 32x32 --spp 4 --time 1h -o a.png --progress none");
}

#[test]
fn what_does_not_fit_is_named() {
    let desk = Desk::new();
    let scene = "render cornell --size 70x40 --spp 2 --progress none";
    desk.ends(0, &format!("{scene} --shard 1/2 -o one.hdf"));
    desk.ends(0, &format!("{scene} --shard 1/3 -o third.hdf"));
    desk.ends(0, &format!("{scene} --shard 2/2 --seed 7 -o seed.hdf"));
    desk.ends(0, &format!("{scene} --shard 2/2 --max-depth 3 -o depth.hdf"));
    desk.ends(0, &format!("{scene} --shard 2/2 --eye 0.27,0.3,-0.7 --target 0.27,0.27,0 -o camera.hdf"));
    desk.ends(0, &scene.replace("cornell", "t.obj --sky 1").replace("none", "none --shard 2/2 -o scene.hdf"));
    let film = desk.bytes("one.hdf");
    desk.program().put("cut.hdf", &film[..film.len() / 2]);
    let mut newer = film.clone();
    newer[8] = 5;
    desk.program().put("newer.hdf", newer);
    desk.program().put("text.hdf", "no film");
    for (films, parts) in [
        ("one.hdf", &["3 of 6 tiles are missing", "pixels 32..64 by 0..32", "name all parts"][..]),
        ("one.hdf third.hdf", &["one.hdf and third.hdf both have the samples 0..2 of the pixels 0..32 by 0..32"]),
        ("one.hdf seed.hdf", &["seed.hdf: the film is of another picture: the seed is 7, not 0"]),
        ("one.hdf depth.hdf", &["depth.hdf", "--max-depth is 3, not 1024"]),
        ("one.hdf camera.hdf", &["camera.hdf", "the camera has changed"]),
        ("one.hdf scene.hdf", &["scene.hdf", "the scene has changed"]),
        ("one.hdf cut.hdf", &["cut.hdf: is cut off or damaged"]),
        ("newer.hdf", &["newer.hdf: is a film of format 5, and this program reads format 4"]),
        ("text.hdf", &["text.hdf: is no film"]),
        ("none.hdf", &["none.hdf: cannot be read"]),
    ] {
        desk.refuses(&format!("merge {films} -o out.exr"), 1, parts);
    }
    desk.refuses("merge one.hdf -o one.hdf", 1, &["one.hdf is read, and would be overwritten"]);
    desk.refuses(&format!("{scene} --shard 1/2 -o a.exr"), 1, &["part 1 of 2 is no picture", "-o part.hdf"]);
    desk.refuses(&format!("{scene} --shard 3/2 -o a.hdf"), 1, &["expected K/N with K from 1 to N"]);
    desk.refuses(
        &format!("{scene} --noise 5% --first-sample 3 -o a.hdf"),
        1,
        &["--noise needs all samples of a pixel"],
    );
    desk.refuses(&format!("{scene} --first-sample 2 -o a.hdf"), 1, &["the first sample is 2, and a pixel has 2"]);
    desk.refuses(&format!("{scene} -o a.hdf -o b.hdf"), 1, &["b.hdf is a second film"]);
    desk.refuses(
        &format!("{scene} --seed 5 --resume -o one.hdf"),
        1,
        &["one.hdf: the film is of another picture: the seed is 0"],
    );
    desk.refuses(&format!("{scene} --resume -o text.hdf"), 1, &["text.hdf: is no film"]);
    desk.refuses(
        &format!("{scene} --checkpoint 1h -o one.png"),
        1,
        &["one.hdf: the film is there already, and checkpoints would replace it", "give --resume"],
    );
}
