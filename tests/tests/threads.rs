//! A picture depends on scene, options and seed alone: not on threads, and so not on the order of tiles.

use std::path::Path;

use halfdome::film::Picture;
use halfdome::output::read_exr;
use halfdome_tests::program::Program;

const EXECUTABLE: &str = env!("CARGO_BIN_EXE_halfdome-under-test");

/// What a run with these options writes: the EXR without the time that it took, and the PNG.
fn render(folder: &Path, options: &str) -> (Picture, Vec<u8>) {
    let program = Program { executable: EXECUTABLE, folder };
    let outcome = program.run_line(&format!("render cornell -o a.exr -o a.png --progress none {options}"));
    assert_eq!((outcome.code, outcome.stderr.as_str()), (Some(0), ""), "{options}");
    let mut picture = read_exr(&folder.join("a.exr")).unwrap();
    picture.metadata.render_time_seconds = 0.0;
    (picture, std::fs::read(folder.join("a.png")).unwrap())
}

/// Bits of all channels, so that zeros of different signs tell.
fn bits(picture: &Picture) -> Vec<(&str, Vec<u32>)> {
    let bits = |values: &[f32]| values.iter().map(|value| value.to_bits()).collect();
    picture.channels.iter().map(|channel| (channel.name.as_str(), bits(&channel.values))).collect()
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
    ] {
        let (picture, png) = render(folder.path(), &format!("{options} --threads 1"));
        assert!(picture.channels.iter().any(|channel| channel.values.iter().any(|value| *value > 0.0)));
        assert_eq!(picture.channels.len(), if options.contains("--aov") { 20 } else { 3 }, "{options}");
        for threads in [2, 16] {
            let (other, other_png) = render(folder.path(), &format!("{options} --threads {threads}"));
            assert!(bits(&other) == bits(&picture), "{options}, {threads} threads");
            assert!(other.metadata == picture.metadata && other_png == png, "{options}, {threads} threads");
        }
    }
}

#[test]
fn different_seeds_give_different_noise() {
    let folder = tempfile::tempdir().unwrap();
    let [zero, one, again] =
        [0, 1, 0].map(|seed| render(folder.path(), &format!("--size 33x65 --spp 4 --seed {seed}")));
    assert!(zero == again);
    assert_eq!([zero.0.metadata.seed, one.0.metadata.seed], [0, 1]);
    let differing = |a: &Picture, b: &Picture| {
        let (a, b) = (&a.channel("G").unwrap().values, &b.channel("G").unwrap().values);
        a.iter().zip(b).filter(|(a, b)| a != b).count()
    };
    // All but the lamp itself, and few pixels that are black in both.
    assert!(differing(&zero.0, &one.0) > 33 * 65 / 2, "{}", differing(&zero.0, &one.0));
    assert!(zero.1 != one.1);
}

/// The samples of a pixel do not depend on how many there will be: more of them refine the same picture.
#[test]
fn more_samples_refine_the_same_picture() {
    let folder = tempfile::tempdir().unwrap();
    let [few, many] = [16, 256].map(|spp| render(folder.path(), &format!("--size 33x20 --spp {spp}")).0);
    let mean = |picture: &Picture| {
        let values = &picture.channel("R").unwrap().values;
        values.iter().map(|value| f64::from(*value)).sum::<f64>() / values.len() as f64
    };
    assert!((mean(&few) / mean(&many) - 1.0).abs() < 0.05, "{} {}", mean(&few), mean(&many));
    assert_eq!([few.metadata.samples_per_pixel, many.metadata.samples_per_pixel], [16, 256]);
    assert_eq!(few.metadata.scene_hash, many.metadata.scene_hash);
}
