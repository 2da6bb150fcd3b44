//! Output on stdout and stderr.

use serde_json::{Value, json};

use crate::Desk;
use crate::good_input::events;

#[test]
fn help_and_version_go_to_stdout() {
    let desk = Desk::new();
    for (line, parts) in [
        ("--help", &["render", "info", "Exit codes:", "interrupted"][..]),
        ("-h", &["render", "info"]),
        ("help render", &["--spp", "--size", "--threads", "--progress", "--seed"]),
        ("render --help", &["--spp", "--sky", "--emission", "--aov", "--output"]),
        ("info --help", &["--json"]),
        ("--version", &["halfdome 0"]),
    ] {
        let outcome = desk.run(line);
        assert_eq!((outcome.code, outcome.stderr.as_str()), (Some(0), ""), "{line}");
        assert!(parts.iter().all(|part| outcome.stdout.contains(part)), "{line}: {}", outcome.stdout);
    }
    assert_eq!(desk.program().files().len(), 1);
}

#[test]
fn info_tells_of_the_cornell_box_as_a_table_and_as_json() {
    let desk = Desk::new();
    let table = desk.run("info cornell");
    assert_eq!((table.code, table.stderr.as_str()), (Some(0), ""));
    assert!(table.stdout.lines().any(|line| line.starts_with("triangles") && line.contains("32")), "{}", table.stdout);
    let outcome = desk.run("info cornell --json");
    assert_eq!((outcome.code, outcome.stderr.as_str()), (Some(0), ""));
    let info: Value = serde_json::from_str(&outcome.stdout).unwrap();
    assert_eq!((&info["triangles"], &info["meshes"], &info["materials"]), (&json!(32), &json!(8), &json!(4)));
    assert_eq!(info["lights"]["emissive_triangles"], 2);
    assert!((info["lights"]["emissive_area"].as_f64().unwrap() - 0.130 * 0.105).abs() < 1e-7);
    assert_eq!(desk.program().files().len(), 1);
}

#[test]
fn progress_as_json_is_one_object_a_line_on_stderr() {
    let desk = Desk::new();
    // `auto` is the same where stderr is not a terminal.
    for options in ["--progress json", "--progress auto", ""] {
        let outcome = desk.run(&format!("render cornell --size 8x8 --spp 4 -o a.exr {options}"));
        assert_eq!((outcome.code, outcome.stdout.as_str()), (Some(0), ""));
        let events = events(&outcome.stderr);
        let (start, end) = (events.first().unwrap(), events.last().unwrap());
        assert_eq!((&start["event"], &start["width"], &start["spp"]), (&json!("start"), &json!(8), &json!(4)));
        assert_eq!((&end["event"], &end["finished"]), (&json!("end"), &json!(true)));
        assert_eq!(end["files"], json!(["a.exr"]));
        assert!(end["rays"].as_u64().unwrap() > 8 * 8 * 4);
    }
}

#[test]
fn silence_is_kept_and_a_summary_told_when_asked_for() {
    let desk = Desk::new();
    let silent = desk.run("render cornell --size 8x8 --spp 4 -o a.exr --progress none");
    assert_eq!((silent.code, silent.stdout.as_str(), silent.stderr.as_str()), (Some(0), "", ""));
    let warned = desk.run("render t.obj --size 8x8 --spp 4 -o a.exr --progress none");
    assert_eq!((warned.code, warned.stdout.as_str()), (Some(0), ""));
    let warnings: Vec<_> = warned.stderr.lines().collect();
    assert_eq!(warnings.len(), 2, "{warnings:?}");
    assert!(warnings[0].starts_with("warning: the model has no camera"), "{warnings:?}");
    assert!(warnings[1].starts_with("warning: the scene has no light"), "{warnings:?}");
    let told = desk.run("render cornell --size 8x8 --spp 4 -o a.exr --progress bar");
    assert_eq!((told.code, told.stdout.as_str()), (Some(0), ""));
    assert!(told.stderr.contains("cornell: 8x8, 4 spp") && told.stderr.contains("wrote a.exr"), "{}", told.stderr);
    assert!(!told.stderr.contains('\x1b'), "no colours where there is no terminal: {}", told.stderr);
}

#[test]
fn an_error_is_a_line_of_json_where_lines_of_json_are_asked_for() {
    let outcome = Desk::new().run("render nothing.obj --progress json");
    assert_eq!((outcome.code, outcome.stdout.as_str()), (Some(1), ""));
    let [error] = &events(&outcome.stderr)[..] else { panic!("{}", outcome.stderr) };
    assert_eq!(error["event"], "error");
    assert!(error["message"].as_str().unwrap().starts_with("nothing.obj: no such file\n  help: "), "{error}");
}

#[test]
fn the_instruction_set_can_be_forced_and_is_told() {
    let desk = Desk::new();
    let run = |isa: &str, line: &str| {
        let arguments: Vec<&str> = line.split_whitespace().collect();
        let output = desk.program().command(&arguments).env("HALFDOME_ISA", isa).output().unwrap();
        let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap();
        (output.status.code(), text(output.stdout), text(output.stderr))
    };
    let (code, table, _) = run("scalar", "info cornell");
    assert!(code == Some(0) && table.contains("instruction set     scalar"), "{table}");
    let (code, _, error) = run("mmx", "render cornell");
    assert!(code == Some(1) && error.contains("HALFDOME_ISA is \"mmx\"") && error.contains("scalar, "), "{error}");
    assert!(!desk.program().files().contains_key(std::ffi::OsStr::new("cornell.exr")));
    // The same picture with each of them.
    for isa in ["scalar", "portable"] {
        let (code, ..) = run(isa, &format!("render cornell --size 16x16 --spp 2 --progress none -o {isa}.png"));
        assert_eq!(code, Some(0));
    }
    let files = desk.program().files();
    assert_eq!(files[std::ffi::OsStr::new("scalar.png")], files[std::ffi::OsStr::new("portable.png")]);
}

#[test]
fn a_reader_that_has_enough_is_no_error() {
    let desk = Desk::new();
    let mut child = desk.program().command(&["info", "cornell", "--json"]).spawn().unwrap();
    drop(child.stdout.take());
    assert_eq!(child.wait().unwrap().code(), Some(0));
}
