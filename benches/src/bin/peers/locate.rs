//! Finds Embree's library.

use std::fs;
use std::path::{Path, PathBuf};

/// What to do when it is not found.
const ADVICE: &str = "run benches/setup-peers.sh, or set EMBREE_LIB to the path of libembree4";

/// The path in the environment variable `EMBREE_LIB`, or the library in what `setup-peers.sh` has installed.
///
/// # Errors
/// What was looked for, and what to do.
pub(crate) fn embree() -> Result<PathBuf, String> {
    if let Some(path) = std::env::var_os("EMBREE_LIB") {
        let path = PathBuf::from(path);
        return if path.is_file() { Ok(path) } else { Err(format!("EMBREE_LIB names no file: {}", path.display())) };
    }
    let installed = Path::new(env!("CARGO_MANIFEST_DIR")).join("../target/peers");
    library_in(&installed).ok_or_else(|| ADVICE.to_owned())
}

/// The first library in `directory` or below, in the order of the names, whose name says Embree 4.
fn library_in(directory: &Path) -> Option<PathBuf> {
    let mut paths: Vec<_> = fs::read_dir(directory).ok()?.flatten().map(|entry| entry.path()).collect();
    paths.sort();
    paths.into_iter().find_map(|path| {
        if path.is_symlink() {
            None
        } else if path.is_dir() {
            library_in(&path)
        } else {
            is_embree(path.file_name()?.to_str()?).then_some(path)
        }
    })
}

/// Whether a file of this name is the library: `libembree4-4aef3270.so.4`, `libembree4.dylib`, `embree4.dll`.
fn is_embree(name: &str) -> bool {
    let stem = name.strip_prefix("lib").unwrap_or(name);
    stem.starts_with("embree4") && [".so", ".dylib", ".dll"].iter().any(|extension| name.contains(extension))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn libraries_are_known_by_name() {
        for name in ["libembree4-4aef3270.so.4", "libembree4.so", "libembree4.4.dylib", "embree4.dll"] {
            assert!(is_embree(name), "{name}");
        }
        for name in ["libembree3.so", "libtbb-dcf63f8c.so.12", "embree4.py", "embreex-4.4.0.so"] {
            assert!(!is_embree(name), "{name}");
        }
    }

    #[test]
    fn the_library_is_found_in_folders_below() {
        let directory = tempfile::tempdir().unwrap();
        let folder = directory.path().join("lib/site-packages/embreex.libs");
        fs::create_dir_all(&folder).unwrap();
        assert_eq!(library_in(directory.path()), None);
        fs::write(folder.join("libtbb.so"), "").unwrap();
        fs::write(folder.join("libembree4-1.so.4"), "").unwrap();
        assert_eq!(library_in(directory.path()), Some(folder.join("libembree4-1.so.4")));
    }
}
