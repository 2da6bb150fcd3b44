//! Refuses outputs that are inputs, so that a mistyped name does not overwrite a file.

use std::fs;
use std::path::{Path, PathBuf};

use super::error::{CliError, invalid};

/// Refuses outputs that are the same file as one of the inputs, whatever their paths are called, links included.
pub(super) fn refuse<P: AsRef<Path>, Q: AsRef<Path>>(outputs: &[P], inputs: &[Q]) -> Result<(), CliError> {
    let inputs: Vec<(&Path, Identity)> =
        inputs.iter().filter_map(|path| Some((path.as_ref(), Identity::of(path.as_ref())?))).collect();
    for output in outputs.iter().map(AsRef::as_ref) {
        let Some(identity) = Identity::of(output) else { continue };
        if let Some((input, _)) = inputs.iter().find(|(_, other)| identity.is_same(other)) {
            let problem = match *input == output {
                true => format!("{} is read, and would be overwritten", output.display()),
                false => format!("{} is the same file as {}, which is read", output.display(), input.display()),
            };
            return Err(invalid(problem, "give the output a name of its own"));
        }
    }
    Ok(())
}

/// Refuses a report whose name says that it is something else than HTML.
pub(super) fn check_report(path: Option<&Path>) -> Result<(), CliError> {
    let is_html = |path: &&Path| {
        path.extension().is_some_and(|it| ["html", "htm"].iter().any(|html| it.eq_ignore_ascii_case(html)))
    };
    match path.filter(|path| !is_html(path)) {
        None => Ok(()),
        Some(path) => Err(invalid(
            format!("{}: a report is written as HTML alone", path.display()),
            "give a name that ends in .html",
        )),
    }
}

/// The identity of a file.
struct Identity {
    path: PathBuf,
    #[cfg(unix)]
    inode: (u64, u64),
}

impl Identity {
    /// `None` if there is no such file.
    fn of(path: &Path) -> Option<Self> {
        #[cfg(unix)]
        let inode = {
            use std::os::unix::fs::MetadataExt as _;
            let metadata = fs::metadata(path).ok()?;
            (metadata.dev(), metadata.ino())
        };
        Some(Self {
            path: fs::canonicalize(path).ok()?,
            #[cfg(unix)]
            inode,
        })
    }

    fn is_same(&self, other: &Self) -> bool {
        #[cfg(unix)]
        if self.inode == other.inode {
            return true;
        }
        self.path == other.path
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reports_are_html() {
        for good in [None, Some("r.html"), Some("a.b/r.HTM")] {
            assert!(check_report(good.map(Path::new)).is_ok(), "{good:?}");
        }
        for bad in ["r.pdf", "r", "html"] {
            let error = check_report(Some(Path::new(bad))).unwrap_err().to_string();
            assert!(error.starts_with(&format!("{bad}: ")) && error.contains("help: give a name"), "{error}");
        }
    }

    #[test]
    fn a_file_is_known_by_all_its_names() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        fs::write(path("input"), "precious").unwrap();
        fs::write(path("other"), "old").unwrap();
        fs::create_dir(path("sub")).unwrap();
        let inputs = [path("input"), path("missing")];
        for output in ["other", "new", "missing", "sub"] {
            assert!(refuse(&[path(output)], &inputs).is_ok(), "{output}");
        }
        let mut names = vec![path("input"), path("sub/../input")];
        #[cfg(unix)]
        {
            std::os::unix::fs::symlink("input", path("link")).unwrap();
            std::os::unix::fs::symlink(folder.path(), path("folder")).unwrap();
            names.extend([path("link"), path("folder/input")]);
        }
        fs::hard_link(path("input"), path("twin")).unwrap();
        #[cfg(unix)]
        names.push(path("twin"));
        for name in names {
            let error = refuse(&[path("other"), name.clone()], &inputs).unwrap_err().to_string();
            assert!(error.contains("input") && error.contains("help: give the output a name"), "{name:?}: {error}");
        }
    }
}
