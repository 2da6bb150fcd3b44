//! The commands: files, channels, messages and exit codes.

use halfdome::output::{ToneMapping, read_exr, write};
use halfdome_tests::program::{Outcome, Program};
use tempfile::TempDir;

const SMALL: &str = "cornell --size 24x20 --progress json --threads 1";

fn program(folder: &TempDir) -> Program<'_> {
    Program { executable: env!("CARGO_BIN_EXE_halfdome-under-test"), folder: folder.path() }
}

fn names(folder: &TempDir, file: &str) -> Vec<String> {
    read_exr(&folder.path().join(file)).unwrap().channels.into_iter().map(|channel| channel.name).collect()
}

/// Fails with `code` and says all of `parts`.
fn refuses(folder: &TempDir, line: &str, code: i32, parts: &[&str]) {
    let Outcome { code: found, stderr, .. } = program(folder).run_line(line);
    assert_eq!(found, Some(code), "{line}: {stderr}");
    parts.iter().for_each(|part| assert!(stderr.contains(part), "{line}: {stderr} lacks {part:?}"));
}

#[test]
fn a_render_is_denoised_and_keeps_its_noisy_colours() {
    let folder = tempfile::tempdir().unwrap();
    let run = |line: &str| {
        let outcome = program(&folder).run_line(line);
        assert_eq!(outcome.code, Some(0), "{line}: {}", outcome.stderr);
        outcome.stderr
    };
    run(&format!("render {SMALL} --spp 8 -o raw.exr"));
    let said = run(&format!("render {SMALL} --spp 8 --denoise nlm -o denoised.exr -o denoised.png"));
    assert!(said.contains("denoised by nlm in "), "{said}");
    assert_eq!(names(&folder, "denoised.exr"), ["B", "G", "Noisy.B", "Noisy.G", "Noisy.R", "R"]);
    let [raw, denoised] = ["raw.exr", "denoised.exr"].map(|name| read_exr(&folder.path().join(name)).unwrap());
    for name in ["R", "G", "B"] {
        let noisy = denoised.channel(&format!("Noisy.{name}")).unwrap();
        assert!(raw.channel(name).unwrap().values == noisy.values);
        assert!(denoised.channel(name).unwrap().values != noisy.values);
    }
    // In two steps it is the same, and again from the noisy colours.
    run(&format!("render {SMALL} --spp 8 --aov --aov-through -o aov.exr"));
    run("denoise aov.exr -o later.exr --with nlm --progress json --threads 2");
    run("denoise later.exr -o again.exr --with nlm --progress json");
    for file in ["later.exr", "again.exr"] {
        let later = read_exr(&folder.path().join(file)).unwrap();
        for name in ["R", "G", "B", "Noisy.R"] {
            assert!(later.channel(name).unwrap().values == denoised.channel(name).unwrap().values, "{file}, {name}");
        }
    }
}

#[test]
fn what_cannot_be_denoised_is_refused_before_it_is_rendered() {
    let folder = tempfile::tempdir().unwrap();
    refuses(&folder, &format!("render {SMALL} --spp 4 --denoise nlm"), 1, &["--spp is 4", "give --spp 5 or more"]);
    refuses(&folder, &format!("render {SMALL} --integrator heat --denoise nlm"), 1, &["counts are not denoised"]);
    refuses(&folder, &format!("render {SMALL} --denoise best"), 1, &["oidn", "nlm"]);
    assert!(program(&folder).files().is_empty());
}

#[test]
fn pictures_without_the_channels_are_refused_by_name() {
    let folder = tempfile::tempdir().unwrap();
    assert_eq!(program(&folder).run_line(&format!("render {SMALL} --spp 8 -o plain.exr")).code, Some(0));
    let parts = ["plain.exr: nlm: lacks the channels HalfA.R", "help: render with --aov"];
    refuses(&folder, "denoise plain.exr -o a.png --with nlm", 1, &parts);
    refuses(&folder, "denoise plain.exr -o plain.exr --with nlm", 1, &["plain.exr is read, and would be overwritten"]);
    refuses(&folder, "denoise none.exr -o a.png --with nlm", 1, &["none.exr"]);
    assert_eq!(program(&folder).run_line(&format!("render {SMALL} --spp 1 --aov -o one.exr")).code, Some(0));
    refuses(&folder, "denoise one.exr -o a.png --with nlm", 1, &["one half of its samples is empty", "--spp"]);
    let mut black = read_exr(&folder.path().join("plain.exr")).unwrap();
    black.channels.truncate(2);
    write(&folder.path().join("two.exr"), &black, &ToneMapping::default()).unwrap();
    refuses(&folder, "denoise two.exr -o a.exr --with nlm", 1, &["lacks the channels R, G, B"]);
}

#[cfg(unix)]
#[test]
fn a_library_that_is_missing_or_another_is_named_before_the_render() {
    let folder = tempfile::tempdir().unwrap();
    program(&folder).put("fake.so", "not a library");
    for (library, part) in [("/nowhere/lib.so", "looked for /nowhere/lib.so"), ("./fake.so", "looked for ./fake.so")] {
        let run = std::process::Command::new(program(&folder).executable)
            .args(format!("render {SMALL} --denoise oidn").split(' '))
            .env("OIDN_LIB", library)
            .current_dir(folder.path())
            .output()
            .unwrap();
        let stderr = String::from_utf8(run.stderr).unwrap();
        assert_eq!(run.status.code(), Some(1), "{stderr}");
        for part in [part, "Open Image Denoise 2 is needed", "help: set OIDN_LIB=/path/", "nlm"] {
            assert!(stderr.contains(part), "{stderr} lacks {part:?}");
        }
        assert!(!stderr.contains("\"start\""), "{stderr}");
    }
}
