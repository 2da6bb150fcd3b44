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
        loop {
            let file = File::create(&path)
                .map_err(|error| CliError::System(format!("{}: cannot be written: {error}", path.display())))?;
            match file.try_lock() {
                Err(TryLockError::WouldBlock) => {
                    return Err(invalid(
                        format!("{}: another run is {work}", output.display()),
                        "wait for it, stop it, or give this run an output of its own",
                    ));
                }
                // A run that ended in between removed the file: others would lock a new one.
                Ok(()) if !is_at(&path, &file) => {}
                // Some network file systems do not support locks.
                Ok(()) | Err(TryLockError::Error(_)) => return Ok(Self { path, _file: file }),
            }
        }
    }
}

/// Whether the file is still the one of this path.
#[cfg(unix)]
fn is_at(path: &Path, file: &File) -> bool {
    use std::os::unix::fs::MetadataExt as _;

    let [there, open] = [fs::metadata(path), file.metadata()].map(|found| found.map(|it| (it.dev(), it.ino())).ok());
    there.is_some() && there == open
}

/// Where the system does not tell, it is taken to be.
#[cfg(not(unix))]
fn is_at(_: &Path, _: &File) -> bool {
    true
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

    #[cfg(unix)]
    #[test]
    fn a_file_that_was_removed_or_replaced_is_not_the_one_of_its_path() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("level.json.lock");
        let first = File::create(&path).unwrap();
        assert!(is_at(&path, &first));
        fs::remove_file(&path).unwrap();
        assert!(!is_at(&path, &first));
        let second = File::create(&path).unwrap();
        assert!(!is_at(&path, &first) && is_at(&path, &second));
    }
}
