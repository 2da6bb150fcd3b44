//! Where pictures go: refused before the render if they cannot be written, and whole or not at all.

use std::fs;

use crate::Desk;

const OPTIONS: &str = "--size 4x4 --spp 1 --progress none";

#[test]
fn places_that_cannot_be_written_are_found_before_the_render() {
    let desk = Desk::new();
    desk.program().put("file", "not a folder");
    fs::create_dir(desk.folder.path().join("folder.exr")).unwrap();
    // A render would announce itself before the error.
    let refuses = |output: &str, parts: &[&str]| {
        let parts = [&["\n  help: "], parts].concat();
        desk.refuses(&format!("render t.obj --size 16x16 --spp 4 -o {output}"), 1, &parts);
        // One bad output among good ones is enough.
        desk.refuses(&format!("render t.obj --size 16x16 --spp 4 -o good.exr -o {output} -o good.png"), 1, &parts);
    };
    refuses("no/where.exr", &["no/where.exr", "the folder no does not exist"]);
    refuses("file/a.exr", &["file/a.exr", "file is not a folder"]);
    refuses("folder.exr", &["folder.exr", "is a folder"]);
    refuses("a.jpg", &["a.jpg", ".exr", ".png"]);
    refuses("a", &["a: has no extension"]);
    refuses("same.png -o same.png", &["same.png is given twice"]);
    refuses("same.png -o ./same.png", &["./same.png is given twice"]);
    refuses(&format!("{}.exr", "x".repeat(300)), &["cannot be written"]);
    #[cfg(target_os = "linux")]
    refuses("/proc/a.exr", &["/proc/a.exr", "cannot be written"]);
}

#[cfg(unix)]
#[test]
fn write_protected_files_are_left_alone() {
    use std::os::unix::fs::PermissionsExt as _;
    let desk = Desk::new();
    let path = desk.program().put("old.exr", "old");
    fs::set_permissions(&path, fs::Permissions::from_mode(0o444)).unwrap();
    desk.refuses("render t.obj -o old.exr", 1, &["old.exr", "write-protected", "help: "]);
}

/// The disk is "full" from the first block on: a limit that the shell sets, with the signal of it ignored.
#[cfg(unix)]
#[test]
fn a_failed_write_leaves_the_old_file_and_no_trace() {
    let desk = Desk::new();
    for name in ["a.exr", "a.png"] {
        desk.program().put(name, "old");
    }
    let before = desk.program().files();
    let program = desk.program();
    let script = format!("trap '' XFSZ; ulimit -f 0; exec {:?} \"$@\"", program.executable);
    let run = std::process::Command::new("sh")
        .args(["-c", &script, "sh", "render", "cornell", "--size", "40x40", "--spp", "1", "-o", "a.exr", "-o", "a.png"])
        .args(["--progress", "json"])
        .current_dir(program.folder)
        .output()
        .unwrap();
    let stderr = String::from_utf8(run.stderr).unwrap();
    assert_eq!(run.status.code(), Some(2), "{stderr}");
    let events = crate::good_input::events(&stderr);
    assert!(events.iter().all(|event| event["event"] != "end"), "{stderr}");
    let error = events.last().unwrap();
    assert_eq!(error["event"], "error");
    let message = error["message"].as_str().unwrap();
    assert!(message.contains("a.exr: cannot be written") && message.contains("a.png: cannot be written"), "{stderr}");
    assert!(program.files() == before, "the folder has changed");
}

#[test]
fn old_pictures_are_replaced_and_nothing_else_is_left() {
    let desk = Desk::new();
    desk.program().put("t.exr", "old");
    let outcome = desk.run(&format!("render t.obj {OPTIONS}"));
    assert_eq!((outcome.code, outcome.stdout.as_str()), (Some(0), ""), "{}", outcome.stderr);
    let names: Vec<_> = desk.program().files().into_keys().collect();
    assert_eq!(names, ["t.exr", "t.obj", "t.png"]);
    let picture = halfdome::output::read_exr(&desk.folder.path().join("t.exr")).unwrap();
    assert_eq!((picture.width, picture.height, picture.metadata.samples_per_pixel), (4, 4, 1));
    assert!(fs::read(desk.folder.path().join("t.png")).unwrap().starts_with(b"\x89PNG\r\n\x1a\n"));
}

#[test]
fn without_arguments_pictures_are_named_after_the_scene_and_go_to_the_current_folder() {
    let desk = Desk::new();
    fs::create_dir(desk.folder.path().join("models")).unwrap();
    desk.program().put("models/room.v2.obj", crate::model::TRIANGLE);
    assert_eq!(desk.run(&format!("render models/room.v2.obj {OPTIONS}")).code, Some(0));
    let names: Vec<_> = desk.program().files().into_keys().collect();
    assert_eq!(names, ["models", "models/room.v2.obj", "room.v2.exr", "room.v2.png", "t.obj"]);
}
