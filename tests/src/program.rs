//! Runs of the program in a folder of its own, and the files there.

use std::collections::BTreeMap;
use std::ffi::{OsStr, OsString};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// The program, and the folder in which it runs.
pub struct Program<'a> {
    /// The executable.
    pub executable: &'a str,
    /// The current folder of every run.
    pub folder: &'a Path,
}

/// How a run ended and what it said.
#[derive(Debug)]
pub struct Outcome {
    /// The exit code; `None` if a signal ended the run.
    pub code: Option<i32>,
    /// Standard output, which is text.
    pub stdout: String,
    /// Standard error, which is text.
    pub stderr: String,
}

impl Outcome {
    /// Runs `command` to the end.
    fn of(mut command: Command) -> Self {
        let output = command.output().expect("the program starts");
        let text = |bytes| String::from_utf8(bytes).expect("the program speaks UTF-8");
        Self { code: output.status.code(), stdout: text(output.stdout), stderr: text(output.stderr) }
    }
}

/// The run must have succeeded without a message.
pub fn succeed(outcome: &Outcome) {
    assert_eq!((outcome.code, outcome.stderr.as_str()), (Some(0), ""));
}

impl Program<'_> {
    /// A run that is yet to start, with its streams piped or closed.
    pub fn command<S: AsRef<OsStr>>(&self, arguments: &[S]) -> Command {
        let mut command = Command::new(self.executable);
        command.args(arguments).current_dir(self.folder);
        command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
        command
    }

    /// Runs to the end.
    pub fn run<S: AsRef<OsStr>>(&self, arguments: &[S]) -> Outcome {
        Outcome::of(self.command(arguments))
    }

    /// Runs with arguments that are separated by spaces.
    pub fn run_line(&self, line: &str) -> Outcome {
        self.run(&line.split_whitespace().collect::<Vec<_>>())
    }

    /// Like [`run_line`](Self::run_line), but the files of the run do not contain its time.
    pub fn run_reproducibly(&self, line: &str) -> Outcome {
        let mut command = self.command(&line.split_whitespace().collect::<Vec<_>>());
        command.env("SOURCE_DATE_EPOCH", "0");
        Outcome::of(command)
    }

    /// Puts a file into the folder; gives its path.
    pub fn put(&self, name: impl AsRef<Path>, contents: impl AsRef<[u8]>) -> PathBuf {
        let path = self.folder.join(name);
        fs::write(&path, contents).expect("the folder can be written");
        path
    }

    /// The names of all files in the folder and below, which are UTF-8.
    pub fn names(&self) -> Vec<String> {
        self.files().into_keys().map(|name| name.into_string().expect("the name is UTF-8")).collect()
    }

    /// All files in the folder and below with their contents; folders have none.
    pub fn files(&self) -> BTreeMap<OsString, Option<Vec<u8>>> {
        let mut files = BTreeMap::new();
        let mut folders = vec![self.folder.to_owned()];
        while let Some(folder) = folders.pop() {
            for entry in fs::read_dir(folder).expect("the folder can be read") {
                let path = entry.expect("the folder can be read").path();
                if path.is_dir() {
                    folders.push(path.clone());
                }
                let name = path.strip_prefix(self.folder).expect("it is below").as_os_str().to_owned();
                files.insert(name, fs::read(&path).ok());
            }
        }
        files
    }
}
