//! Locks on outputs that take long to make, so that two runs do not write to one.

use std::fs::{self, File, TryLockError};
use std::path::{Path, PathBuf};

use super::error::{CliError, invalid};

/// Keeps other runs from the same output, by a lock on a file beside it.
#[derive(Debug)]
pub(super) struct Lock {
    path: PathBuf,
    _file: File,
}

impl Lock {
    /// Locks an output. `work` says what runs do with it, in an error.
    pub(super) fn new(output: &Path, work: &str) -> Result<Self, CliError> {
        let mut name = output.as_os_str().to_owned();
        name.push(".lock");
        let path = PathBuf::from(name);
        let file = File::create(&path)
            .map_err(|error| CliError::System(format!("{}: cannot be written: {error}", path.display())))?;
        match file.try_lock() {
            Err(TryLockError::WouldBlock) => Err(invalid(
                format!("{}: another run is {work}", output.display()),
                "wait for it, stop it, or give this run an output of its own",
            )),
            // Some network file systems do not support locks.
            Ok(()) | Err(TryLockError::Error(_)) => Ok(Self { path, _file: file }),
        }
    }
}

impl Drop for Lock {
    fn drop(&mut self) {
        // The lock is released with or without the file.
        let _ = fs::remove_file(&self.path);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_output_is_of_one_run_at_a_time() {
        let folder = tempfile::tempdir().unwrap();
        let output = folder.path().join("level.glb");
        let first = Lock::new(&output, "baking this model").unwrap();
        let error = Lock::new(&output, "baking this model").unwrap_err();
        assert_eq!(error.exit_code(), 1);
        assert!(error.to_string().contains("level.glb: another run is baking this model\n  help: wait"), "{error}");
        assert!(Lock::new(&folder.path().join("other.glb"), "baking this model").is_ok());
        drop(first);
        drop(Lock::new(&output, "baking this model").unwrap());
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
    }
}
