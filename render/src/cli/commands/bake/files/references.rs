//! What the model of a bake refers to: files beside the model that is read.

use std::path::Path;

use crate::bake::{self, gltf};
use crate::cli::error::{CliError, invalid};
use crate::scene::Disk;
use crate::scene::formats::obj;

/// References as the new model must have them.
#[derive(Debug, Default, PartialEq, Eq)]
pub(super) struct References {
    /// The folders that lead from it to the glTF file that is read, if that refers to other files.
    pub(super) folders: Vec<String>,
    /// The paths of the material libraries of the OBJ file that is read.
    pub(super) libraries: Vec<String>,
}

impl References {
    /// Those of the model that is read, for one that is written to `model`.
    pub(super) fn find(model: &Path, source: &Path) -> Result<Self, CliError> {
        let is = |path: &Path, kind: &str| path.extension().is_some_and(|it| it.eq_ignore_ascii_case(kind));
        let bytes = || std::fs::read(source).map_err(|error| CliError::Input(format!("{}: {error}", source.display())));
        let mut references = Self::default();
        if is(source, "obj") {
            for file in obj::libraries(&Disk, source, &bytes()?).map_err(CliError::input)? {
                let name = file.file_name().unwrap_or_default().to_string_lossy().into_owned();
                let mut path = way(model, &file)?;
                path.push(name);
                references.libraries.push(path.join("/"));
            }
        } else if !is(model, "obj") && !gltf::external_files(source, &bytes()?).map_err(CliError::input)?.is_empty() {
            references.folders = way(model, source)?;
        }
        Ok(references)
    }
}

/// The folders that lead from the model to a file.
fn way(model: &Path, file: &Path) -> Result<Vec<String>, CliError> {
    bake::way(model, file).map_err(|error| {
        let problem = format!("{} cannot refer to {}: {error}", model.display(), file.display());
        invalid(problem, "write it to a folder on the same drive, or beside the model that is read")
    })
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    #[test]
    fn libraries_are_those_of_the_file_with_any_extension() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        fs::create_dir(at("colours")).unwrap();
        fs::create_dir(at("baked")).unwrap();
        for name in ["colours/wood", "my paint.mtl", "other.mtl"] {
            fs::write(at(name), "newmtl a\n").unwrap();
        }
        fs::write(at("a.obj"), "mtllib colours\\wood lost.mtl\nmtllib \\\n my paint.mtl\nmtllib colours/wood\n")
            .unwrap();
        let found = References::find(&at("baked/a.obj"), &at("a.obj")).unwrap();
        assert_eq!(found.libraries, ["../colours/wood", "../my paint.mtl"]);
        fs::write(at("a.gltf"), r#"{"asset":{"version":"2.0"},"images":[{"uri":"a.png"}]}"#).unwrap();
        assert_eq!(References::find(&at("baked/b.gltf"), &at("a.gltf")).unwrap().folders, [".."]);
        fs::write(at("a.gltf"), r#"{"asset":{"version":"2.0"},"images":[{"uri":"data:,"}]}"#).unwrap();
        assert_eq!(References::find(&at("baked/b.gltf"), &at("a.gltf")).unwrap(), References::default());
    }

    #[cfg(unix)]
    #[test]
    fn what_cannot_be_named_is_told() {
        use std::os::unix::ffi::OsStrExt as _;

        let folder = tempfile::tempdir().unwrap();
        let strange = folder.path().join(std::ffi::OsStr::from_bytes(b"\xff"));
        // Some file systems have no such names.
        if fs::create_dir(&strange).is_err() {
            return;
        }
        fs::write(strange.join("a.gltf"), r#"{"asset":{"version":"2.0"},"images":[{"uri":"a.png"}]}"#).unwrap();
        let error = References::find(&folder.path().join("b.gltf"), &strange.join("a.gltf")).unwrap_err().to_string();
        assert!(
            error.contains("a folder's name is not UTF-8\n  help: write it to a folder on the same drive"),
            "{error}"
        );
    }
}
