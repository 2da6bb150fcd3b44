//! What a render depends on besides the scene. Two renders with equal scene and settings are equal byte for byte.

use crate::film::Filter;

/// The settings of one picture; defaults as `Settings::default()` has them.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
    /// The pixel filter.
    pub filter: Filter,
    /// What is computed.
    pub integrator: IntegratorKind,
    /// Samples per pixel.
    pub spp: u32,
    /// The greatest number of surface hits on a path, camera's included: 1 shows emitters alone, 2 adds direct light.
    pub max_depth: u32,
    /// Selects the random numbers.
    pub seed: u64,
}

/// The integrators by their names on the command line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum IntegratorKind {
    /// Global illumination by path tracing.
    Path,
    /// Shading normals as colours.
    Normals,
    /// Diffuse reflectance.
    Albedo,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            width: 512,
            height: 512,
            filter: Filter::default(),
            integrator: IntegratorKind::Path,
            spp: 64,
            max_depth: 64,
            seed: 0,
        }
    }
}
