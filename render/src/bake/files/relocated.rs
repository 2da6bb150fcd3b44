//! References to files, as they must be in a model that is written to another folder.

use std::io;
use std::path::{Component, Path, PathBuf};

/// The way from the folder of one file to that of another, as names with `..` for a folder's parent; empty if the
/// folder is the same.
///
/// # Errors
/// If a folder cannot be found, or if no way leads there, as between drives.
pub fn way(from: &Path, to: &Path) -> io::Result<Vec<String>> {
    let [from, to] = [folder(from)?, folder(to)?];
    let common = from.components().zip(to.components()).take_while(|(a, b)| a == b).count();
    let up = from.components().skip(common).map(|part| (part, "..".to_owned()));
    let down = to.components().skip(common).map(|part| (part, part.as_os_str().to_string_lossy().into_owned()));
    let part = |(part, name): (Component, String)| match part {
        Component::Normal(name_in_file) if name_in_file.to_str().is_some() => Ok(name),
        Component::Normal(_) => Err(io::Error::other("a folder's name is not UTF-8")),
        _ => Err(io::Error::other("it is on another drive")),
    };
    up.chain(down).map(part).collect()
}

/// The folder of a file, as the system calls it.
fn folder(file: &Path) -> io::Result<PathBuf> {
    file.parent().filter(|folder| *folder != Path::new("")).unwrap_or(Path::new(".")).canonicalize()
}

/// A name in a URI: with `%` and the code in place of what may not be there.
pub(super) fn in_uri(name: &str) -> String {
    let byte = |byte: u8| match byte {
        b'a'..=b'z' | b'A'..=b'Z' | b'0'..=b'9' | b'-' | b'.' | b'_' | b'~' => char::from(byte).to_string(),
        other => format!("%{other:02X}"),
    };
    name.bytes().map(byte).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ways_lead_up_and_down() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::create_dir_all(folder.path().join("level one/parts")).unwrap();
        std::fs::create_dir_all(folder.path().join("baked")).unwrap();
        let at = |name: &str| folder.path().join(name);
        assert_eq!(way(&at("a.gltf"), &at("b.gltf")).unwrap(), [""; 0]);
        assert_eq!(way(&at("baked/a.gltf"), &at("level one/parts/b.gltf")).unwrap(), ["..", "level one", "parts"]);
        assert_eq!(way(&at("level one/parts/a.gltf"), &at("level one/b.gltf")).unwrap(), [".."]);
        assert!(way(&at("none/a.gltf"), &at("b.gltf")).is_err());
        assert_eq!((in_uri("level one"), in_uri("ä-1.x")), ("level%20one".to_owned(), "%C3%A4-1.x".to_owned()));
    }
}
