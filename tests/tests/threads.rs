//! A picture depends on scene, options and seed alone: not on threads, and so not on the order of tiles.

use std::fs;
use std::path::Path;

use halfdome::film::Picture;
use halfdome::output::read_exr;
use halfdome_tests::program::Program;

const EXECUTABLE: &str = env!("CARGO_BIN_EXE_halfdome-under-test");

/// What a run leaves.
#[derive(PartialEq)]
struct Files {
    exr: Vec<u8>,
    png: Vec<u8>,
    /// The EXR's contents.
    picture: Picture,
}

/// What a run with these options writes, without the time that it took.
fn render(folder: &Path, options: &str) -> Files {
    let program = Program { executable: EXECUTABLE, folder };
    let line = format!("render cornell -o a.exr -o a.png --progress none {options}");
    let outcome = program.run_reproducibly(&line);
    assert_eq!((outcome.code, outcome.stderr.as_str()), (Some(0), ""), "{options}");
    let [exr, png] = ["a.exr", "a.png"].map(|name| folder.join(name));
    Files { picture: read_exr(&exr).unwrap(), exr: fs::read(exr).unwrap(), png: fs::read(png).unwrap() }
}

#[test]
fn any_number_of_threads_gives_the_same_bytes() {
    let folder = tempfile::tempdir().unwrap();
    for options in [
        "--size 33x65 --spp 20",
        "--size 33x65 --spp 9 --aov --filter gaussian",
        "--size 97x1 --spp 33 --seed 7",
        "--size 1x1 --spp 100",
        "--size 64x64 --spp 3 --aov --integrator normals --filter mitchell",
        "--size 70x33 --spp 3 --integrator montecarlo --bounces 2 --rays 5 --survival 0.5",
        "--size 70x33 --spp 3 --integrator direct --sampler r2",
        "--size 70x33 --spp 3 --integrator ao --ao-weighting hit-length --sampler random",
        "--size 70x33 --spp 3 --integrator cached --record-rays 64 --cache-error 0.5",
        "--size 70x33 --spp 3 --integrator flat",
        "--size 70x33 --spp 3 --integrator albedo",
        "--size 70x33 --spp 3 --integrator heat --lights naive --stop threshold --add-back",
        "--size 70x33 --spp 3 --lights direct --stop roulette --survival 0.5 --progressive=16",
    ] {
        let one = render(folder.path(), &format!("{options} --threads 1"));
        let channels = &one.picture.channels;
        assert!(channels.iter().any(|channel| channel.values.iter().any(|value| *value > 0.0)));
        assert_eq!(channels.len(), if options.contains("--aov") { 36 } else { 3 }, "{options}");
        for threads in [2, 16] {
            let more = render(folder.path(), &format!("{options} --threads {threads}"));
            assert!(more.exr == one.exr, "{options}, {threads} threads: the EXR differs");
            assert!(more.png == one.png, "{options}, {threads} threads: the PNG differs");
        }
    }
}

#[test]
fn any_number_of_threads_measures_the_same() {
    let folder = tempfile::tempdir().unwrap();
    let program = Program { executable: EXECUTABLE, folder: folder.path() };
    let points = (0..300).map(|i| format!("{} 0 {} 0 1 0\n", 0.02 + 0.025 * (i % 20) as f32, 0.03 * (i / 20) as f32));
    program.put("points.txt", points.collect::<String>());
    for options in [
        "--spp 20 --record-rays 64 --cache-error 0.5",
        "--spp 20 --record-rays 64 --cache-error 0.5 --metric bounded --cache-bounces 2 --seed 3",
        "--spp 3 --indirect --record-rays 64 --layout hemicube",
        "--spp 20 --brute",
    ] {
        let measure = |threads: u32| {
            let line = format!("irradiance cornell --points points.txt --progress none {options} --threads {threads}");
            let outcome = program.run_line(&line);
            assert_eq!((outcome.code, outcome.stderr.as_str()), (Some(0), ""), "{options}");
            outcome.stdout
        };
        let one = measure(1);
        // Some are inside of the boxes.
        assert!(one.lines().count() == 300 && one.lines().filter(|line| *line != "0 0 0").count() > 200);
        for threads in [2, 3] {
            assert!(measure(threads) == one, "{options}, {threads} threads");
        }
    }
}

/// Nothing but the time is left out of reproducible files, and it only there.
#[test]
fn the_time_is_stored_unless_files_are_to_be_reproducible() {
    let folder = tempfile::tempdir().unwrap();
    let reproducible = render(folder.path(), "--size 9x7 --spp 2").picture;
    assert_eq!(reproducible.metadata.render_time_seconds, 0.0);
    let program = Program { executable: EXECUTABLE, folder: folder.path() };
    let arguments = "render cornell -o a.exr --progress none --size 9x7 --spp 2";
    let mut command = program.command(&arguments.split(' ').collect::<Vec<_>>());
    assert!(command.env_remove("SOURCE_DATE_EPOCH").status().unwrap().success());
    let mut timed = read_exr(&folder.path().join("a.exr")).unwrap();
    assert!(timed.metadata.render_time_seconds > 0.0);
    timed.metadata.render_time_seconds = 0.0;
    assert!(timed == reproducible);
}

#[test]
fn different_seeds_give_different_noise() {
    let folder = tempfile::tempdir().unwrap();
    let [zero, one, again] =
        [0, 1, 0].map(|seed| render(folder.path(), &format!("--size 33x65 --spp 4 --seed {seed}")));
    assert!(zero == again);
    assert_eq!([zero.picture.metadata.seed, one.picture.metadata.seed], [0, 1]);
    let differing = |a: &Picture, b: &Picture| {
        let (a, b) = (&a.channel("G").unwrap().values, &b.channel("G").unwrap().values);
        a.iter().zip(b).filter(|(a, b)| a != b).count()
    };
    // All but the lamp itself, and few pixels that are black in both.
    assert!(differing(&zero.picture, &one.picture) > 33 * 65 / 2);
    assert!(zero.png != one.png);
}

/// The samples of a pixel do not depend on how many there will be: more of them refine the same picture.
#[test]
fn more_samples_refine_the_same_picture() {
    let folder = tempfile::tempdir().unwrap();
    let [few, many] = [16, 256].map(|spp| render(folder.path(), &format!("--size 33x20 --spp {spp}")).picture);
    let mean = |picture: &Picture| {
        let values = &picture.channel("R").unwrap().values;
        values.iter().map(|value| f64::from(*value)).sum::<f64>() / values.len() as f64
    };
    assert!((mean(&few) / mean(&many) - 1.0).abs() < 0.05, "{} {}", mean(&few), mean(&many));
    assert_eq!([few.metadata.samples_per_pixel, many.metadata.samples_per_pixel], [16, 256]);
    assert_eq!(few.metadata.scene_hash, many.metadata.scene_hash);
}
