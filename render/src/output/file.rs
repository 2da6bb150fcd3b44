//! Atomic writing of files, and a check beforehand that it will succeed.
//!
//! The bytes go to a temporary file in the same folder, which then takes the file's name in one step (`rename`).
//! Readers see the old picture or the new one; a failure leaves the old one and no temporary file.

use std::fs;
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};

use tempfile::{Builder, NamedTempFile};

use super::OutputError;

/// A place where a file can be written.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct OutputFile {
    /// The path as the user gave it, for messages.
    path: PathBuf,
    /// Where the file is: the end of `path` if that is a symbolic link.
    target: PathBuf,
    /// The folder that holds `target`.
    folder: PathBuf,
}

impl OutputFile {
    /// Checks that a file can be written at `path`, by writing one beside it. An existing file stays as it is.
    ///
    /// # Errors
    /// If the folder does not exist, is no folder or cannot be written, or if `path` is anything but a file that may
    /// be replaced.
    pub fn check(path: &Path) -> Result<Self, OutputError> {
        let file = Self::locate(path)?;
        file.temporary().map_err(|error| OutputError::unwritable(path, &error))?;
        Ok(file)
    }

    /// Writes the file, in place of the one that was there.
    ///
    /// # Errors
    /// What the operating system says; then the file is as it was before.
    pub fn write(&self, bytes: &[u8]) -> Result<(), OutputError> {
        self.replace(bytes).map_err(|error| OutputError::unwritable(&self.path, &error))
    }

    /// Removes the file, if it is there.
    ///
    /// # Errors
    /// The error of the operating system.
    pub fn remove(&self) -> Result<(), OutputError> {
        match fs::remove_file(&self.target) {
            Err(error) if error.kind() != io::ErrorKind::NotFound => Err(OutputError::unwritable(&self.path, &error)),
            _ => Ok(()),
        }
    }

    fn replace(&self, bytes: &[u8]) -> io::Result<()> {
        let mut temporary = self.temporary()?;
        temporary.write_all(bytes)?;
        // Otherwise the new name might reach the disk before the bytes do.
        temporary.as_file().sync_all()?;
        temporary.persist(&self.target)?;
        Ok(())
    }

    /// An empty file in the folder that vanishes when it is dropped.
    fn temporary(&self) -> io::Result<NamedTempFile> {
        let mut builder = Builder::new();
        builder.prefix(".halfdome-").suffix(".tmp");
        #[cfg(unix)]
        {
            // As for any new file, the umask decides who may read it; temporary files would be the owner's alone.
            use std::os::unix::fs::PermissionsExt as _;
            builder.permissions(fs::Permissions::from_mode(0o666));
        }
        builder.tempfile_in(&self.folder).map_err(|error| without_path(&error))
    }

    fn locate(path: &Path) -> Result<Self, OutputError> {
        let error = |problem: &str, remedy: String| Err(OutputError::new(path, problem, remedy));
        match fs::metadata(path) {
            Ok(metadata) if metadata.is_dir() => return error("is a folder", "name a file in it".to_owned()),
            Ok(metadata) if !metadata.is_file() => {
                return error(
                    "is not a file that can be replaced",
                    "name a plain file, not a device or pipe".to_owned(),
                );
            }
            Ok(metadata) if metadata.permissions().readonly() => {
                return error("is write-protected", "unprotect the file, or choose another name".to_owned());
            }
            Ok(_) => {}
            // The folder's turn comes below.
            Err(error) if matches!(error.kind(), io::ErrorKind::NotFound | io::ErrorKind::NotADirectory) => {}
            Err(error) => return Err(OutputError::unwritable(path, &error)),
        }

        let target = if path.is_symlink() {
            match fs::canonicalize(path) {
                Ok(target) => target,
                Err(_) => return error("is a link to a file that is not there", "remove the link".to_owned()),
            }
        } else {
            path.to_owned()
        };

        let folder = match target.parent() {
            _ if target.file_name().is_none() => return error("has no file name", "name a file".to_owned()),
            Some(folder) if folder != Path::new("") => folder.to_owned(),
            _ => PathBuf::from("."),
        };
        match fs::metadata(&folder) {
            Ok(metadata) if metadata.is_dir() => Ok(Self { path: path.to_owned(), target, folder }),
            Ok(_) => error(&format!("{} is not a folder", folder.display()), "name a folder that exists".to_owned()),
            Err(failure) if failure.kind() == io::ErrorKind::NotFound => error(
                &format!("the folder {} does not exist", folder.display()),
                "create the folder, or choose another".to_owned(),
            ),
            Err(failure) => Err(OutputError::unwritable(path, &failure)),
        }
    }
}

/// The error without the temporary file's path.
fn without_path(error: &io::Error) -> io::Error {
    let text = error.to_string();
    io::Error::new(error.kind(), text.split(" at path ").next().unwrap_or_default())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn messages_name_no_temporary_file() {
        let named =
            io::Error::new(io::ErrorKind::NotFound, "No such file (os error 2) at path \"/proc/.halfdome-x.tmp\"");
        let error = without_path(&named);
        assert_eq!((error.kind(), error.to_string().as_str()), (io::ErrorKind::NotFound, "No such file (os error 2)"));
        #[cfg(target_os = "linux")]
        {
            let path = Path::new("/proc/x.glb");
            let error = OutputFile::check(path).unwrap_err().to_string();
            assert!(error.starts_with("/proc/x.glb: cannot be written: ") && !error.contains(".tmp"), "{error}");
        }
    }

    fn names(folder: &Path) -> Vec<String> {
        let entries = fs::read_dir(folder).unwrap();
        let mut names: Vec<_> = entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    fn problem(path: &Path) -> String {
        let error = OutputFile::check(path).unwrap_err();
        assert_eq!(error.file, path);
        error.problem
    }

    #[test]
    fn checking_leaves_no_trace() {
        let folder = tempfile::tempdir().unwrap();
        let old = folder.path().join("old.exr");
        fs::write(&old, "old").unwrap();
        OutputFile::check(&old).unwrap();
        OutputFile::check(&folder.path().join("new.exr")).unwrap();
        assert_eq!(names(folder.path()), ["old.exr"]);
        assert_eq!(fs::read(&old).unwrap(), b"old");
    }

    #[test]
    fn writing_replaces_and_leaves_the_file_alone_in_its_folder() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png");
        for bytes in [&b"first"[..], b"second, longer", b""] {
            OutputFile::check(&path).unwrap().write(bytes).unwrap();
            assert_eq!(fs::read(&path).unwrap(), bytes);
            assert_eq!(names(folder.path()), ["a.png"]);
        }
    }

    #[test]
    fn a_bare_name_is_in_the_current_folder() {
        let file = OutputFile::locate(Path::new("a-picture-that-is-not-there.exr")).unwrap();
        assert_eq!(file.folder, Path::new("."));
    }

    #[test]
    fn wrong_places_are_named() {
        let folder = tempfile::tempdir().unwrap();
        let missing = folder.path().join("missing");
        assert_eq!(problem(&missing.join("a.exr")), format!("the folder {} does not exist", missing.display()));
        assert_eq!(problem(folder.path()), "is a folder");
        assert_eq!(problem(&folder.path().join("..")), "is a folder");
        let plain = folder.path().join("plain");
        fs::write(&plain, "").unwrap();
        assert_eq!(problem(&plain.join("a.exr")), format!("{} is not a folder", plain.display()));
        assert_eq!(
            OutputFile::check(&folder.path().join("missing/a.exr")).unwrap_err().to_string(),
            format!(
                "{0}/a.exr: the folder {0} does not exist\n  help: create the folder, or choose another",
                missing.display()
            )
        );
    }

    #[test]
    fn a_write_protected_file_stays() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.exr");
        fs::write(&path, "kept").unwrap();
        let mut permissions = fs::metadata(&path).unwrap().permissions();
        permissions.set_readonly(true);
        fs::set_permissions(&path, permissions).unwrap();
        assert_eq!(problem(&path), "is write-protected");
    }

    #[test]
    fn a_failed_write_leaves_nothing_behind() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.exr");
        let file = OutputFile::check(&path).unwrap();
        // Between check and write, a folder takes the name.
        fs::create_dir(&path).unwrap();
        fs::write(path.join("inside"), "").unwrap();
        let error = file.write(b"bytes").unwrap_err();
        assert!(error.problem.starts_with("cannot be written: "), "{error}");
        assert_eq!(names(folder.path()), ["a.exr"]);
        assert_eq!(names(&path), ["inside"]);
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn a_folder_that_takes_no_files_is_found_out() {
        // Not even the superuser can create a file there.
        assert!(problem(Path::new("/proc/a.exr")).starts_with("cannot be written: "));
        assert_eq!(problem(Path::new("/dev/null")), "is not a file that can be replaced");
    }

    #[cfg(unix)]
    #[test]
    fn new_files_have_the_usual_permissions() {
        use std::os::unix::fs::PermissionsExt as _;
        let folder = tempfile::tempdir().unwrap();
        let (ours, usual) = (folder.path().join("ours"), folder.path().join("usual"));
        OutputFile::check(&ours).unwrap().write(b"").unwrap();
        fs::File::create(&usual).unwrap();
        let mode = |path: &Path| fs::metadata(path).unwrap().permissions().mode();
        assert_eq!(mode(&ours), mode(&usual));
    }

    #[cfg(unix)]
    #[test]
    fn links_are_followed() {
        use std::os::unix::fs::symlink;
        let folder = tempfile::tempdir().unwrap();
        let (link, file) = (folder.path().join("link.exr"), folder.path().join("file.exr"));
        symlink(&file, &link).unwrap();
        assert_eq!(problem(&link), "is a link to a file that is not there");
        fs::write(&file, "old").unwrap();
        OutputFile::check(&link).unwrap().write(b"new").unwrap();
        assert!(link.is_symlink());
        assert_eq!(fs::read(&file).unwrap(), b"new");
    }
}
