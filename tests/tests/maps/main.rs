//! `halfdome cubemap` and `halfdome probes`.

mod cubemap;
mod interruption;
mod probes;

use halfdome_tests::program::{Program, succeed};

const EXECUTABLE: &str = env!("CARGO_BIN_EXE_halfdome-under-test");

/// Runs `test` with the program in a folder of its own.
fn in_folder(test: impl FnOnce(&Program)) {
    let folder = tempfile::tempdir().unwrap();
    test(&Program { executable: EXECUTABLE, folder: folder.path() });
}

/// Each line must fail with the code 1 and say this and what would be right, and no file may be written.
fn refuse(program: &Program, lines: &[(&str, &str)]) {
    let before = program.files();
    for (line, told) in lines {
        let outcome = program.run_line(&format!("{line} --progress none"));
        assert_eq!(outcome.code, Some(1), "{line}: {}", outcome.stderr);
        assert!(outcome.stderr.contains(told), "{line}: {}", outcome.stderr);
        assert!(
            outcome.stderr.contains("help:") || outcome.stderr.contains("For more information"),
            "{}",
            outcome.stderr
        );
        assert!(program.files() == before, "{line} left files");
    }
}
