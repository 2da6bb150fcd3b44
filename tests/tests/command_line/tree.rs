//! `halfdome tree`, and `halfdome info` of what it writes.

use std::fs;

use halfdome_kernel::{Bvh, Quality};
use serde_json::{Value, json};

use crate::Desk;
use crate::good_input::events;

/// The bytes of a tree that the program writes without a word.
fn written(desk: &Desk, scene: &str, options: &str) -> Vec<u8> {
    let outcome = desk.run(&format!("tree {scene} -o a.bvh --progress none {options}"));
    assert_eq!((outcome.code, outcome.stdout.as_str(), outcome.stderr.as_str()), (Some(0), "", ""), "{options}");
    fs::read(desk.folder.path().join("a.bvh")).unwrap()
}

#[test]
fn a_tree_is_what_the_kernel_builds_of_the_triangles() {
    let desk = Desk::new();
    let scene = halfdome::scene::cornell_box();
    let triangles: Vec<_> =
        scene.meshes.iter().flat_map(|mesh| (0..mesh.triangles.len()).map(|face| mesh.corners(face))).collect();
    for quality in Quality::ALL {
        let (bvh, _) = Bvh::build(&triangles, &quality.into()).unwrap();
        for threads in [1, 3] {
            let bytes = written(&desk, "cornell", &format!("--build {quality} --threads {threads}"));
            assert!(bytes == bvh.to_bytes()[..], "{quality}, {threads} threads");
        }
    }
    assert_eq!(desk.program().files().len(), 2, "the model and the tree");
    desk.program().put("t.toml", "[scene]\nfile = \"t.obj\"\n[render]\nbuild = \"fast\"\n");
    assert!(written(&desk, "t.toml", "") == written(&desk, "t.obj", "--build fast"));
}

#[test]
fn info_tells_of_a_tree_as_a_table_and_as_json() {
    let desk = Desk::new();
    let bytes = written(&desk, "cornell", "");
    let statistics = Bvh::from_bytes(&bytes).unwrap().statistics();
    let outcome = desk.run("info a.bvh --json");
    assert_eq!((outcome.code, outcome.stderr.as_str()), (Some(0), ""));
    let info: Value = serde_json::from_str(&outcome.stdout).unwrap();
    for (key, value) in [
        ("tree", json!("a.bvh")),
        ("version", json!(1)),
        ("bytes", json!(bytes.len())),
        ("triangles", json!(32)),
        ("nodes", json!(statistics.nodes)),
        ("leaves", json!(statistics.leaves)),
        ("leaf_blocks", json!(statistics.blocks)),
        ("depth", json!(statistics.depth)),
        ("stack", json!(statistics.stack)),
        ("sah_cost", json!(statistics.cost)),
        ("bounds", json!({ "lower": [0.0, 0.0, 0.0], "upper": [0.556f32, 0.5488f32, 0.5592f32] })),
    ] {
        assert_eq!(info[key], value, "{key}");
    }
    let table = desk.run("info a.bvh");
    assert_eq!((table.code, table.stderr.as_str()), (Some(0), ""));
    let has = |line: &str| assert!(table.stdout.lines().any(|found| found == line), "{}", table.stdout);
    has("triangles           32");
    has("bounds              0 0 0  to  0.556 0.5488 0.5592");
    has("version             1");
    has(&format!("quality             SAH cost {:.2}", statistics.cost));
}

#[test]
fn what_was_written_and_dropped_is_told() {
    let desk = Desk::new();
    desk.program().put("d.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nf 1 2 2\n");
    let outcome = desk.run("tree d.obj -o d.bvh --progress json");
    assert_eq!((outcome.code, outcome.stdout.as_str()), (Some(0), ""));
    let events = events(&outcome.stderr);
    let end = events.last().unwrap();
    let dropped = json!({ "degenerate": 1, "not_finite": 0, "out_of_range": 0 });
    assert_eq!((&end["event"], &end["triangles"], &end["dropped"]), (&json!("end"), &json!(1), &dropped));
    assert_eq!((&end["bytes"], &end["files"]), (&json!(640), &json!(["d.bvh"])));
    let outcome = desk.run("tree d.obj -o d.bvh --progress bar");
    assert!(
        outcome
            .stderr
            .ends_with("1 primitive kept, 1 dropped, the first of them 1: 1 degenerate\nwrote d.bvh, 640 B\n"),
        "{}",
        outcome.stderr
    );
}

#[test]
fn bad_trees_are_refused() {
    let desk = Desk::new();
    let bytes = written(&desk, "cornell", "");
    let refused = |bytes: &[u8], part: &str| {
        desk.program().put("b.bvh", bytes);
        for line in ["info b.bvh", "info b.bvh --json"] {
            desk.refuses(line, 1, &["b.bvh: ", part, "\n  help: "]);
        }
    };
    refused(b"", "cut off: 0 bytes of at least 64");
    refused(b"HIERARCHY\nROOT Hips\n", "these bytes are not a tree");
    refused(&bytes[..bytes.len() - 1], "cut off");
    refused(&[&bytes[..], &[0]].concat(), "1 more");
    let mut damaged = bytes.clone();
    damaged[1000] ^= 4;
    refused(&damaged, "damaged");
    let mut old = bytes.clone();
    old[12] = 0;
    refused(&old, "version 0, older than 1");
    let mut big_endian = bytes.clone();
    big_endian[8..12].reverse();
    refused(&big_endian, "big-endian");
    desk.refuses("info c.bvh", 1, &["c.bvh: no such file", "help: "]);
}

#[test]
fn bad_usage_is_refused() {
    let desk = Desk::new();
    desk.refuses("tree cornell", 1, &["--output"]);
    desk.refuses("tree", 1, &["<SCENE>"]);
    desk.refuses("tree nothing.obj -o a.bvh", 1, &["nothing.obj: no such file"]);
    desk.refuses("tree cornell -o no/where.bvh", 1, &["the folder no does not exist", "help: "]);
    desk.refuses("tree cornell -o a.obj", 1, &["a.obj: a tree's name ends in .bvh", "help: call it a.bvh"]);
    desk.refuses("tree cornell -o a.bvh --build best", 1, &["one of fast, medium, high"]);
    desk.refuses("tree cornell -o a.bvh --spp 3", 1, &["unexpected argument"]);
}
