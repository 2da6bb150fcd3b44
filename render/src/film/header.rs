//! The common header of all parts of one picture, and the differences between two pictures.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::{Extras, MatteLayer};
use crate::settings::Invalid;

/// The identity of a film. Films with equal headers are parts of one picture.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct FilmHeader {
    /// The version of the program.
    pub program: String,
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
    /// Whether there are pixels without rays.
    pub has_border: bool,
    /// Whether there are channels of the first surface.
    pub aov: bool,
    /// Whether there are sums of half of the samples.
    pub halves: bool,
    /// The names of its Cryptomatte layers.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub cryptomatte: Vec<MatteLayer>,
    /// The names of its AOVs by light path expressions.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub light: Vec<String>,
    /// The seed.
    pub seed: u64,
    /// The name of the integrator.
    pub integrator: String,
    /// All other settings that a sample depends on, by their names.
    pub options: BTreeMap<String, String>,
    /// A hash of the scene.
    pub scene_hash: u64,
    /// A hash of the scene without its camera.
    pub surroundings_hash: u64,
    /// Rows of the matrix that takes world points to camera space, if the camera has a pose.
    pub world_to_camera: Option<[[f32; 4]; 4]>,
    /// The brightness to which errors are relative, if they are estimated. In a file it stands behind the header, as
    /// JSON may round it.
    #[serde(skip)]
    pub level: Option<f64>,
}

/// Why a film cannot be used.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct FilmError(Invalid);

impl From<Invalid> for FilmError {
    fn from(error: Invalid) -> Self {
        Self(error)
    }
}

impl FilmError {
    pub(crate) fn new(problem: impl Into<String>, remedy: impl Into<String>) -> Self {
        Self(Invalid::new(problem, remedy))
    }

    /// The error with the name of the file that it is about.
    #[must_use]
    pub fn naming(self, file: &str) -> Self {
        Self::new(format!("{file}: {}", self.0.problem), self.0.remedy)
    }
}

impl FilmHeader {
    /// The contents of its tiles.
    pub(super) fn extras(&self) -> Extras {
        Extras { features: self.aov, halves: self.halves, mattes: self.cryptomatte.len(), light: self.light.len() }
    }

    /// Refuses a film of another picture than `expected`; the error names the difference.
    ///
    /// # Errors
    /// If anything differs but the level, which follows from the rest.
    pub fn check(&self, expected: &Self) -> Result<(), FilmError> {
        let of = |what: &str, ours: &dyn ToString, theirs: &dyn ToString| {
            let (ours, theirs) = (ours.to_string(), theirs.to_string());
            (ours != theirs).then(|| format!("{what} is {ours}, not {theirs}"))
        };
        let size = |header: &Self| format!("{}x{}", header.width, header.height);
        let mattes = |header: &Self| {
            let layers = header.cryptomatte.iter().map(|layer| format!("{} with {} levels", layer.layer, layer.levels));
            let layers: Vec<String> = layers.collect();
            if layers.is_empty() { "off".to_owned() } else { layers.join(", ") }
        };
        let light = |header: &Self| if header.light.is_empty() { "off".to_owned() } else { header.light.join(", ") };
        let on = |flag: bool| if flag { "on" } else { "off" };
        let keys: std::collections::BTreeSet<&String> = self.options.keys().chain(expected.options.keys()).collect();
        let value = |header: &Self, key: &String| header.options.get(key).cloned().unwrap_or_else(|| "none".to_owned());
        let mut differences: Vec<String> = [
            of("the version of halfdome", &self.program, &expected.program),
            of("the size", &size(self), &size(expected)),
            of("the integrator", &self.integrator, &expected.integrator),
            of("the seed", &self.seed, &expected.seed),
            of("--aov", &on(self.aov), &on(expected.aov)),
            of("the sums of halves (--noise, --denoise)", &on(self.halves), &on(expected.halves)),
            of("--lpe or --light-groups", &light(self), &light(expected)),
            of("--cryptomatte", &mattes(self), &mattes(expected)),
        ]
        .into_iter()
        .flatten()
        .collect();
        if self.integrator == expected.integrator {
            let differing = keys.into_iter().filter_map(|key| of(key, &value(self, key), &value(expected, key)));
            differences.extend(differing);
        }
        if differences.is_empty() && self.cryptomatte != expected.cryptomatte {
            differences.push("names of objects or materials have changed".to_owned());
        }
        if self.surroundings_hash != expected.surroundings_hash {
            differences.push("the scene has changed".to_owned());
        } else if self.scene_hash != expected.scene_hash {
            differences.push("the camera has changed".to_owned());
        }
        if differences.is_empty() {
            return Ok(());
        }
        Err(FilmError::new(
            format!("the film is of another picture: {}", differences.join("; ")),
            "give the scene and the options with which it was begun, or begin anew with another file",
        ))
    }
}
