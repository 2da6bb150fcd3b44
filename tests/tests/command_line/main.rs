//! The program from the outside: its output, files and exit codes, above all for errors.

mod animation;
mod bad_input;
mod bakes;
mod films;
mod good_input;
mod inputs;
mod interruption;
mod model;
mod output;
mod reports;
mod talk;
mod tev;
mod tree;
mod validate;

use halfdome_tests::program::{Outcome, Program};
use tempfile::TempDir;

/// A folder with models that are right, and the program in it.
struct Desk {
    folder: TempDir,
}

impl Desk {
    /// A folder with `t.obj`, a triangle.
    fn new() -> Self {
        let desk = Self { folder: tempfile::tempdir().unwrap() };
        desk.program().put("t.obj", model::TRIANGLE);
        desk
    }

    fn program(&self) -> Program<'_> {
        Program { executable: env!("CARGO_BIN_EXE_halfdome-under-test"), folder: self.folder.path() }
    }

    /// Runs with arguments that are separated by spaces.
    fn run(&self, line: &str) -> Outcome {
        self.program().run_line(line)
    }

    /// Asserts that the run fails with `code`, says all of `parts` and how to put it right, and leaves no trace.
    fn refuses(&self, line: &str, code: i32, parts: &[&str]) {
        let before = self.program().files();
        let Outcome { code: found, stdout, stderr } = self.run(line);
        assert_eq!((found, stdout.as_str()), (Some(code), ""), "{line}: {stderr}");
        assert!(stderr.starts_with("error: "), "{line}: {stderr}");
        for part in parts {
            assert!(stderr.contains(part), "{line}: {stderr} lacks {part:?}");
        }
        assert!(!stderr.contains("panicked"), "{line}: {stderr}");
        assert!(self.program().files() == before, "{line}: the folder has changed");
    }
}
