//! Other renderers, each run by a script that answers requests; `benches/renderers/serve.py` describes the protocol.

use std::ffi::OsStr;
use std::fs;
use std::io::{BufRead, BufReader, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};

use serde_json::{Value, json};

use crate::renderer::{Renderer, Rendering};

const SETUP: &str = "run benches/setup-renderers.sh";
/// Where Dr.Jit, Mitsuba's compiler, looks for LLVM.
const LLVM_PATH: &str = "DRJIT_LIBLLVM_PATH";

/// A peer's process, ready to render.
pub(crate) struct Peer {
    name: &'static str,
    about: String,
    process: Child,
    requests: ChildStdin,
    answers: BufReader<ChildStdout>,
    /// The file that it writes pictures to.
    picture: PathBuf,
    /// How many numbers a picture has.
    length: usize,
}

impl Peer {
    /// Starts `script` of the folder `benches/renderers` with `arguments`, which name a scene whose pictures have
    /// `length` numbers; `directory` is for the pictures.
    ///
    /// # Errors
    /// If it is not installed or does not start, with what to do; the script's own words are on standard error.
    pub(crate) fn start(
        name: &'static str,
        script: &str,
        arguments: &[&OsStr],
        directory: &Path,
        length: usize,
    ) -> Result<Self, String> {
        let root = Path::new(env!("CARGO_MANIFEST_DIR"));
        let installed = root.join("../target/renderers");
        let python = installed.join("bin/python");
        if !python.is_file() {
            return Err(SETUP.to_owned());
        }
        let mut command = Command::new(python);
        command.arg(root.join("renderers").join(script)).args(arguments).stdin(Stdio::piped()).stdout(Stdio::piped());
        let llvm = installed.join("libLLVM.so");
        if std::env::var_os(LLVM_PATH).is_none() && llvm.exists() {
            command.env(LLVM_PATH, llvm);
        }
        Self::spawn(name, command, directory.join(name), length)
    }

    fn spawn(name: &'static str, mut command: Command, picture: PathBuf, length: usize) -> Result<Self, String> {
        let mut process = command.spawn().map_err(|error| format!("{error}; {SETUP}"))?;
        let (Some(requests), Some(answers)) = (process.stdin.take(), process.stdout.take()) else {
            return Err("its input and output are no pipes".to_owned());
        };
        let answers = BufReader::new(answers);
        let mut peer = Self { name, about: String::new(), process, requests, answers, picture, length };
        let ready = peer.answer()?;
        match ready["about"].as_str() {
            Some(about) => peer.about = about.to_owned(),
            None => return Err(format!("does not say what it is: {ready}")),
        }
        Ok(peer)
    }

    /// The next line of the script.
    fn answer(&mut self) -> Result<Value, String> {
        let mut line = String::new();
        match self.answers.read_line(&mut line) {
            Ok(0) => Err(format!("it ended; if something is missing, {SETUP}")),
            Ok(_) => serde_json::from_str(&line).map_err(|error| format!("answers what is no JSON: {error}")),
            Err(error) => Err(error.to_string()),
        }
    }
}

impl Renderer for Peer {
    fn name(&self) -> &str {
        self.name
    }

    fn about(&self) -> &str {
        &self.about
    }

    fn render(&mut self, spp: u32, seed: u32) -> Result<Rendering, String> {
        let request = json!({ "spp": spp, "seed": seed, "picture": self.picture });
        writeln!(self.requests, "{request}").map_err(|error| error.to_string())?;
        let answer = self.answer()?;
        let seconds = answer["seconds"].as_f64().ok_or_else(|| format!("gives no time: {answer}"))?;
        let bytes = fs::read(&self.picture).map_err(|error| format!("{}: {error}", self.picture.display()))?;
        let (values, rest) = bytes.as_chunks::<4>();
        let pixels: Vec<f32> = values.iter().map(|&value| f32::from_ne_bytes(value)).collect();
        if pixels.len() != self.length || !rest.is_empty() {
            return Err(format!("gives {} bytes for a picture of {} numbers", bytes.len(), self.length));
        }
        if pixels.iter().any(|value| !value.is_finite()) {
            return Err("gives a picture with values that are no finite numbers".to_owned());
        }
        Ok(Rendering { pixels, seconds, rays: None })
    }
}

impl Drop for Peer {
    fn drop(&mut self) {
        // It holds nothing that is worth a farewell, and may have ended already.
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;

    /// A peer of `length` numbers a picture that a shell script stands for.
    fn peer(script: &str, directory: &Path, length: usize) -> Result<Peer, String> {
        let mut command = Command::new("sh");
        command.args(["-c", script]).stdin(Stdio::piped()).stdout(Stdio::piped()).current_dir(directory);
        Peer::spawn("stand-in", command, directory.join("stand-in"), length)
    }

    #[test]
    fn a_peer_is_asked_and_its_picture_read() {
        let directory = tempfile::tempdir().unwrap();
        fs::write(directory.path().join("stand-in"), [0.25f32, 1.5].map(f32::to_ne_bytes).as_flattened()).unwrap();
        let script = r#"echo '{"about":"Shell 1"}'; read line; echo "$line" > asked; echo '{"seconds":2.5}'"#;
        let mut peer = peer(script, directory.path(), 2).unwrap();
        assert_eq!((peer.name(), peer.about()), ("stand-in", "Shell 1"));
        let Rendering { pixels, seconds, rays } = peer.render(64, 7).unwrap();
        assert_eq!((pixels, seconds, rays), (vec![0.25, 1.5], 2.5, None));
        let asked: Value = serde_json::from_str(&fs::read_to_string(directory.path().join("asked")).unwrap()).unwrap();
        let picture = directory.path().join("stand-in");
        assert_eq!(asked, json!({ "spp": 64, "seed": 7, "picture": picture }));
        // It has ended since.
        assert!(peer.render(64, 8).is_err());
    }

    #[test]
    fn a_peer_that_fails_says_how() {
        let directory = tempfile::tempdir().unwrap();
        let problem = |script: &str, length| {
            peer(script, directory.path(), length).and_then(|mut peer| peer.render(1, 0)).unwrap_err()
        };
        assert_eq!(problem("exit 1", 1), "it ended; if something is missing, run benches/setup-renderers.sh");
        assert!(problem("echo hello", 1).starts_with("answers what is no JSON"));
        assert_eq!(problem("echo '{}'", 1), "does not say what it is: {}");
        let rendered = r#"echo '{"about":"Shell 1"}'; read line; echo '{"seconds":1}'"#;
        assert!(problem(rendered, 1).contains("No such file"));
        fs::write(directory.path().join("stand-in"), f32::NAN.to_ne_bytes()).unwrap();
        assert_eq!(problem(rendered, 2), "gives 4 bytes for a picture of 2 numbers");
        assert_eq!(problem(rendered, 1), "gives a picture with values that are no finite numbers");
        assert_eq!(problem(r#"echo '{"about":"Shell 1"}'; read line; echo '{}'"#, 1), "gives no time: {}");
    }
}
