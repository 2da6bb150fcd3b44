//! The output and the errors of `halfdome cubemap`.

use std::collections::BTreeMap;
use std::ffi::{OsStr, OsString};
use std::fs;

use glam::Vec3;
use halfdome::output::{Map, encode_hdr, read_exr};
use halfdome_tests::program::Program;
use serde_json::Value;

use crate::{in_folder, refuse, succeed};

/// A picture of all directions that is brighter above and on the right, with a sun.
fn put_environment(program: &Program) {
    let texel = |i: u32| match i {
        150 => Vec3::splat(50.0),
        _ => Vec3::new(1.0, 0.25 + (i % 32) as f32 / 32.0, 1.5 - (i / 32) as f32 / 16.0),
    };
    let texels: Vec<Vec3> = (0..32 * 16).map(texel).collect();
    let path = program.folder.join("studio.hdr");
    fs::write(&path, encode_hdr(&path, &Map { width: 32, height: 16, texels: &texels }).unwrap().bytes).unwrap();
}

fn manifest(program: &Program, name: &str) -> Value {
    serde_json::from_slice(&fs::read(program.folder.join(name)).unwrap()).unwrap()
}

#[test]
fn every_format_has_all_levels_and_faces() {
    in_folder(|program| {
        put_environment(program);
        let outputs = "-o map.ktx2 -o map.exr -o map.png -o map.hdr";
        succeed(&program.run_line(&format!("cubemap studio.hdr {outputs} --size 16 --diffuse=4 --progress none")));
        let manifest = manifest(program, "map.json");
        let files: Vec<&str> = manifest["files"].as_array().unwrap().iter().filter_map(Value::as_str).collect();
        // Three levels of six faces and one of the diffuse map; three times a map and its diffuse one.
        assert_eq!(files.len(), 18 + 6 + 6, "{files:?}");
        let mut expected: Vec<String> = files.iter().map(|file| (*file).to_owned()).collect();
        expected.extend(["map.json".to_owned(), "studio.hdr".to_owned()]);
        expected.sort();
        assert_eq!(program.names(), expected);
        assert!(
            files.contains(&"map-pz.hdr") && files.contains(&"map-diffuse-ny.hdr") && files.contains(&"map-nx-2.hdr")
        );

        let bytes = fs::read(program.folder.join("map.ktx2")).unwrap();
        let reader = ktx2::Reader::new(&bytes).unwrap();
        let header = reader.header();
        assert_eq!((header.pixel_width, header.face_count, header.level_count), (16, 6, 3));
        let sizes: Vec<usize> = reader.levels().map(|level| level.data.len()).collect();
        assert_eq!(sizes, [16, 8, 4].map(|side| 6 * side * side * 8));
        let unfolded = read_exr(&program.folder.join("map.exr")).unwrap();
        assert_eq!((unfolded.width, unfolded.height), (72, 64));
        // The first texel of the face +z of the first level, in both.
        let first = &reader.levels().next().unwrap().data[4 * 16 * 16 * 8..];
        let corner = &manifest["levels"][0]["unfolded"]["pz"]["corner"];
        let pixel = corner[1].as_u64().unwrap() as usize * 72 + corner[0].as_u64().unwrap() as usize;
        let green = f32::from(half::f16::from_le_bytes([first[2], first[3]]));
        let expected = unfolded.channel("G").unwrap().values[pixel];
        assert!((green / expected - 1.0).abs() < 1e-3, "{green}, not {expected}");
    });
}

#[test]
fn the_manifest_and_the_table_have_the_seams_of_each_treatment() {
    in_folder(|program| {
        put_environment(program);
        for seams in ["none", "stretch", "warp", "lookup"] {
            let line =
                format!("cubemap studio.hdr -o {seams}.ktx2 --size 16 --levels 5 --seams {seams} --progress none");
            let outcome = program.run_line(&line);
            succeed(&outcome);
            assert_eq!(outcome.stdout.lines().count(), 2 + 5, "{}", outcome.stdout);
            let manifest = manifest(program, &format!("{seams}.json"));
            assert_eq!(manifest["seams"], seams);
            for level in manifest["levels"].as_array().unwrap() {
                let seam = level["seam"].as_f64().unwrap();
                assert_eq!(seam < 1e-5, seams != "none", "{seams}: {level}");
                let smooth = |treatment: &str, what: &str| level["smooth"][treatment][what].as_f64().unwrap();
                assert!(smooth("none", "seam") > 100.0 * smooth("lookup", "seam"), "{level}");
            }
            assert_eq!(manifest["levels"][2]["roughness"], 0.5);
        }
    });
}

#[test]
fn the_lookup_is_printed_and_written() {
    in_folder(|program| {
        put_environment(program);
        for language in ["wgsl", "glsl"] {
            let line = format!("cubemap studio.hdr -o a.ktx2 --size 8 --seams lookup --print-lookup {language}");
            let outcome = program.run_line(&format!("{line} --progress none"));
            succeed(&outcome);
            assert_eq!(fs::read_to_string(program.folder.join(format!("a.{language}"))).unwrap(), outcome.stdout);
            assert!(outcome.stdout.contains("exp2(level) / 8.0"), "{}", outcome.stdout);
        }
    });
}

#[test]
fn maps_are_the_same_bytes_for_any_number_of_threads() {
    in_folder(|program| {
        for source in ["cornell --at 0.278,0.3,0.279 --spp 4", "sky --daylight 30,90 --sky 0.1"] {
            let make = |options: &str| {
                let line =
                    format!("cubemap {source} -o a.ktx2 -o a.exr --size 8 --seams warp --progress none {options}");
                assert_eq!(program.run_reproducibly(&line).code, Some(0));
                program.files()
            };
            let one = make("--threads 1");
            assert!(make("--threads 3") == one, "{source}");
            let map = |files: &BTreeMap<OsString, Option<Vec<u8>>>| files[OsStr::new("a.ktx2")].clone();
            let is_sky = source.starts_with("sky");
            assert_eq!(map(&make("--threads 2 --seed 9")) == map(&one), is_sky, "seeds matter to paths alone");
        }
    });
}

#[test]
fn a_constant_sky_is_constant_and_daylight_says_what_is_missing() {
    in_folder(|program| {
        succeed(&program.run_line("cubemap sky --sky 0.25,0.5,1 -o a.ktx2 --size 8 --filter phong --progress none"));
        let bytes = fs::read(program.folder.join("a.ktx2")).unwrap();
        for level in ktx2::Reader::new(&bytes).unwrap().levels() {
            let halves: Vec<half::f16> =
                level.data.chunks_exact(2).map(|pair| half::f16::from_le_bytes([pair[0], pair[1]])).collect();
            assert!(halves.chunks_exact(4).all(|texel| texel == [0.25, 0.5, 1.0, 1.0].map(half::f16::from_f32)));
        }
        let daylight = program.run_line("cubemap sky --daylight 40,0 -o b.ktx2 --size 4 --progress none");
        assert_eq!(daylight.code, Some(0));
        assert!(daylight.stderr.contains("the sun is a light of its own"), "{}", daylight.stderr);
        let black = program.run_line("cubemap sky -o c.ktx2 --size 4 --progress none");
        assert!(black.stderr.contains("the map is black"), "{}", black.stderr);
    });
}

#[test]
fn wrong_input_is_named() {
    in_folder(|program| {
        put_environment(program);
        program.put("broken.hdr", "#?RADIANCE\n");
        refuse(
            program,
            &[
                ("cubemap studio.hdr", "--output"),
                ("cubemap studio.hdr -o a.jpg", "a.jpg: cube maps cannot be written in this format"),
                ("cubemap studio.hdr -o missing/a.ktx2", "the folder missing does not exist"),
                ("cubemap studio.hdr -o a.ktx2 -o a.ktx2", "a.ktx2 is given twice"),
                ("cubemap studio.hdr -o a.ktx2 --size 100", "expected a power of two from 2 to 2048"),
                ("cubemap studio.hdr -o a.ktx2 --size 4096", "expected a power of two"),
                ("cubemap studio.hdr -o a.ktx2 --size 8 --levels 5", "faces of 8 texels cannot have 5 levels"),
                ("cubemap studio.hdr -o a.ktx2 --seams glue", "none, stretch, warp, lookup"),
                ("cubemap studio.hdr -o a.ktx2 --at 0,0,0", "studio.hdr is not a scene"),
                (
                    "cubemap studio.hdr -o a.ktx2 --sky-picture studio.hdr",
                    "both studio.hdr and --sky-picture are given",
                ),
                ("cubemap broken.hdr -o a.ktx2", "broken.hdr: the picture is damaged"),
                ("cubemap missing.hdr -o a.ktx2", "missing.hdr: no such file"),
                ("cubemap cornell -o a.ktx2", "cornell is a scene, and needs a point"),
                ("cubemap cornell --at 1,2 -o a.ktx2", "expected three finite numbers"),
                ("cubemap missing.glb --at 0,0,0 -o a.ktx2", "missing.glb: no such file"),
                ("cubemap sky --sky-rotation 5 -o a.ktx2", "there is no environment map to rotate"),
            ],
        );
    });
}
