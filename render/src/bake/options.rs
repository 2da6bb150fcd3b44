//! The options of a bake.

use glam::Vec3;

use crate::settings::{CachedOptions, named};

/// The options of a bake; defaults as `BakeOptions::default()` has them.
#[derive(Clone, Debug, PartialEq)]
pub struct BakeOptions {
    /// The part of the light that counts.
    pub mode: Mode,
    /// The directional components of light.
    pub directional: Directional,
    /// The sampling of the maps, which decides gutters and seams.
    pub sampling: Sampling,
    /// The use of a model's own lightmap coordinates.
    pub coordinates: Coordinates,
    /// Texels across and down a page, [`MIN_SIZE`](Self::MIN_SIZE) to [`MAX_SIZE`](Self::MAX_SIZE).
    pub size: u32,
    /// Texels in a unit of length; `None` for as many as fit on one page.
    pub density: Option<f32>,
    /// Texels between charts at least; `None` for as many as the sampling needs.
    pub gutter: Option<u32>,
    /// Samples of direct light at each texel, or rays of ambient occlusion; at least 1.
    pub spp: u32,
    /// Whether each texel gathers for itself, without a cache.
    pub brute: bool,
    /// How light is gathered, with a cache or without.
    pub cache: CachedOptions,
    /// Ambient occlusion: the distance from which on hits do not occlude; `None` for any.
    pub ao_distance: Option<f32>,
    /// Whether surfaces that cannot be seen from inside are left out ([`LeftOut`](super::LeftOut)): from these
    /// positions, or, if there are none, from anywhere in front of a surface.
    pub skip_outside: Option<Vec<Vec3>>,
    /// Whether noise is smoothed away inside each chart.
    pub denoise: bool,
    /// Selects the random numbers.
    pub seed: u64,
}

/// The part of the light that counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mode {
    /// All of it: direct and indirect.
    Full,
    /// Light reflected by surfaces, and the sky without the sun of its picture.
    Indirect,
    /// Emitters, delta lights, and the sun of a sky's picture: that by which its texels are brighter than eight
    /// times the rest.
    Direct,
    /// None: how open to the outside each texel is, from 0 to 1.
    Ao,
}

/// The directional components of light.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Directional {
    /// Nothing: irradiance on the surface alone.
    None,
    /// Irradiance for three normals about the surface's (McTaggart 2004), for normal maps.
    Hl2,
    /// Spherical harmonics of radiance up to L1, in world space.
    Sh1,
}

/// The sampling of a map.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sampling {
    /// Between four texels.
    Bilinear,
    /// Between sixteen texels, by cubic B-splines.
    Bicubic,
}

/// The use of a model's own lightmap coordinates.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Coordinates {
    /// They are used if nothing is wrong with them, else new ones are made.
    Auto,
    /// They must be there and right.
    Keep,
    /// New ones are made.
    New,
}

/// The engine that a bake is written for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Preset {
    /// Bevy: E/π as KTX2 in half floats.
    Bevy,
    /// three.js: E as Radiance pictures, named by the materials' `MOZ_lightmap`.
    Three,
    /// Anybody: E as OpenEXR.
    Raw,
}

named!(Mode: Full = "full", Indirect = "indirect", Direct = "direct", Ao = "ao");
named!(Directional: None = "none", Hl2 = "hl2", Sh1 = "sh1");
named!(Sampling: Bilinear = "bilinear", Bicubic = "bicubic");
named!(Preset: Bevy = "bevy", Three = "three", Raw = "raw");
named!(Coordinates: Auto = "auto", Keep = "keep", New = "new");

impl BakeOptions {
    /// The least side of a page.
    pub const MIN_SIZE: u32 = 16;
    /// The greatest side of a page: textures are no larger on most machines.
    pub const MAX_SIZE: u32 = 16_384;
    /// The most texels between charts.
    pub const MAX_GUTTER: u32 = 64;

    /// Whether light is gathered through a cache.
    pub fn has_cache(&self) -> bool {
        !self.brute && matches!(self.mode, Mode::Full | Mode::Indirect)
    }

    /// Texels around a chart that are its own: between two charts there are twice as many.
    pub(crate) fn padding(&self) -> u32 {
        self.gutter.unwrap_or(2 * self.sampling.reach()).div_ceil(2).max(1)
    }

    /// All options by their names on the command line, in a fixed order.
    pub fn named(&self) -> Vec<(&'static str, String)> {
        let Self { mode, directional, sampling, coordinates, size, density, gutter, spp, .. } = self;
        let number = |number: Option<f32>| number.map_or("auto".to_owned(), |number| number.to_string());
        let mut named = vec![
            ("mode", mode.name().to_owned()),
            ("directional", directional.name().to_owned()),
            ("sampling", sampling.name().to_owned()),
            ("uv", coordinates.name().to_owned()),
            ("size", size.to_string()),
            ("density", number(*density)),
            ("gutter", number(gutter.map(|gutter| gutter as f32))),
            ("spp", spp.to_string()),
            ("brute", self.brute.to_string()),
            ("ao-distance", number(self.ao_distance)),
            ("skip-outside", self.skip_outside.as_ref().map_or("no".to_owned(), |places| self::places(places))),
            ("denoise", self.denoise.to_string()),
            ("seed", self.seed.to_string()),
        ];
        named.extend(crate::cache::named(&self.cache));
        named
    }
}

/// Places for a manifest.
fn places(places: &[Vec3]) -> String {
    let place = |place: &Vec3| place.to_array().map(|coordinate| coordinate.to_string()).join(",");
    if places.is_empty() { "auto".to_owned() } else { places.iter().map(place).collect::<Vec<_>>().join(" ") }
}

impl Sampling {
    /// Texels around the one that holds a point that a sample there may need.
    pub(crate) fn reach(self) -> u32 {
        match self {
            Self::Bilinear => 1,
            Self::Bicubic => 2,
        }
    }
}

impl Default for BakeOptions {
    fn default() -> Self {
        Self {
            mode: Mode::Full,
            directional: Directional::None,
            sampling: Sampling::Bilinear,
            coordinates: Coordinates::Auto,
            size: 1024,
            density: None,
            gutter: None,
            spp: 256,
            brute: false,
            cache: CachedOptions::default(),
            ao_distance: None,
            skip_outside: None,
            denoise: false,
            seed: 0,
        }
    }
}
