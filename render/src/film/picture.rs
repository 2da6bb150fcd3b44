//! A finished picture: named channels of 32-bit floats, and what produced them.
//!
//! The render time is the only content of a picture that does not follow from its scene and options. Where files must
//! be the same from run to run, the environment variable `SOURCE_DATE_EPOCH` leaves it out, whatever its value: it is
//! then stored as 0.
//!
//! Source: "SOURCE_DATE_EPOCH specification", version 1.1, of reproducible-builds.org.

use std::collections::BTreeMap;

/// Channels of one size, row by row from the top left corner.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
    /// At least `R`, `G` and `B`, linear sRGB radiance; `A`, the part of each pixel that sees anything, if the film has
    /// a border (then colours are multiplied by it); further ones by pbrt's names (`Albedo.R`, `Ns.X`, `Variance.R`).
    pub channels: Vec<Channel>,
    /// The origin of the picture.
    pub metadata: Metadata,
}

/// One named plane of a picture.
#[derive(Clone, Debug, PartialEq)]
pub struct Channel {
    /// The name, for example `R` or `Albedo.R`.
    pub name: String,
    /// `width * height` values.
    pub values: Vec<f32>,
}

/// Facts that are stored with a picture.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Metadata {
    /// Samples that every pixel got (the least of them if the render was interrupted).
    pub samples_per_pixel: u32,
    /// Wall-clock seconds, the only part that differs between two equal renders; 0 if they are to be left out.
    pub render_time_seconds: f32,
    /// Rows of the matrix that takes world points to camera space (right, up, backwards), if the camera has a pose.
    pub world_to_camera: Option<[[f32; 4]; 4]>,
    /// The seed.
    pub seed: u64,
    /// A hash of all that the picture depends on in the scene.
    pub scene_hash: u64,
    /// Name of the integrator.
    pub integrator: String,
    /// Further attributes: those of Cryptomatte layers, `cryptomatte/…`.
    pub attributes: BTreeMap<String, String>,
}

impl Metadata {
    /// The stored render time: seconds, or 0 under `SOURCE_DATE_EPOCH`.
    pub(crate) fn stored_seconds(seconds: f64) -> f32 {
        let reproducible = std::env::var_os("SOURCE_DATE_EPOCH").is_some();
        if reproducible { 0.0 } else { seconds as f32 }
    }
}

impl Picture {
    /// The channel called `name`.
    pub fn channel(&self, name: &str) -> Option<&Channel> {
        self.channels.iter().find(|channel| channel.name == name)
    }
}
