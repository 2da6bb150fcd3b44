//! Options that do not go together.

use std::fmt;
use std::path::{Path, PathBuf};

use super::Overrides;
use crate::settings::Invalid;

/// Options that do not go together, or with the scene.
///
/// Prints as [`Invalid`] does, after the scene file if that has a part in it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Conflict {
    group: Group,
    error: Invalid,
    file: Option<PathBuf>,
}

/// Options that can be in conflict with each other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Group {
    Camera,
    Size,
    Filter,
    Integrator,
    Sky,
    Variant,
    Aovs,
}

impl Conflict {
    pub(super) fn new(group: Group, error: Invalid) -> Self {
        Self { group, error, file: None }
    }

    /// The conflict with the name of the scene at `path`, whose file sets `options`, if any of them are involved.
    pub fn naming(self, path: &Path, options: &Overrides) -> Self {
        let file = options.sets_any(self.group).then(|| path.to_owned());
        Self { file, ..self }
    }
}

impl fmt::Display for Conflict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(file) = &self.file {
            write!(f, "{}: ", file.display())?;
        }
        write!(f, "{}", self.error)
    }
}

impl std::error::Error for Conflict {}
