//! The settings of a render. Two renders with equal scene and settings are equal byte for byte.

mod aov;
mod cached;
mod cryptomatte;
mod filter;
mod integrator;
mod names;
mod shard;

use halfdome_kernel::Quality;
use halfdome_kernel::sampling::Pattern;

pub use aov::Aov;
pub(crate) use cached::named;
pub use cached::{CachedOptions, GatherLayout, Gradients, Metric};
pub use cryptomatte::{Cryptomatte, MatteKind};
pub use filter::{Filter, FilterError};
pub use integrator::{
    AoOptions, AoWeighting, DirectOptions, HemisphereSampling, Integrator, LightSampling, MonteCarloOptions,
    PathOptions, Stop, Survival,
};
pub use shard::Shard;

/// The settings of one picture; defaults as `Settings::default()` has them.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// Pixels across, 1 to [`MAX_SIDE`].
    pub width: u32,
    /// Pixels down, 1 to [`MAX_SIDE`].
    pub height: u32,
    /// The pixel filter.
    pub filter: Filter,
    /// The integrator.
    pub integrator: Integrator,
    /// Samples per pixel, at least 1.
    pub spp: u32,
    /// The sampler of random numbers.
    pub sampler: Pattern,
    /// Selects the random numbers.
    pub seed: u64,
    /// The quality of the tree; the picture does not depend on it.
    pub build: Quality,
    /// Whether the picture has channels of the first surface (AOVs) and of the variance too.
    pub aov: bool,
    /// Whether these hold the surfaces seen through mirrors and clear glass, as denoisers need, instead of the first
    /// surface.
    pub aov_through: bool,
    /// Whether the picture also has the means of two halves of its samples, `HalfA` and `HalfB`, from which denoisers
    /// estimate its error.
    pub halves: bool,
    /// The Cryptomatte layers of the picture.
    pub cryptomatte: Cryptomatte,
    /// Light by light path expressions, each in channels of its own, with different names. The integrator must be
    /// `path`.
    pub aovs: Vec<Aov>,
    /// Whether the light of each light group has channels of its own, too.
    pub light_groups: bool,
}

/// The longest side of a picture, in pixels.
pub const MAX_SIDE: u32 = 65_536;

/// The largest picture: 2^28 pixels, a square of 16,384.
pub const MAX_PIXELS: u64 = 1 << 28;

/// An estimate of the bytes that a pixel takes until it is written: sums of 128 bits, then channels of 32, twice.
pub const BYTES_PER_PIXEL: u64 = 4 * 16 + 3 * 4 * 2;

/// The additional bytes of a pixel with AOVs.
pub const AOV_BYTES_PER_PIXEL: u64 = 17 * 16 + 5 * 4 + 24 * 4 * 2;

/// The additional bytes of a pixel with halves.
pub const HALVES_BYTES_PER_PIXEL: u64 = 4 * 16 + 6 * 4 * 2;

/// The additional bytes of a pixel with a light path expression.
const LPE_BYTES_PER_PIXEL: u64 = 3 * 16 + 3 * 4 * 2;

/// The additional bytes of a pixel with a Cryptomatte layer: lists of two names, and two channels for each level.
fn matte_bytes_per_pixel(cryptomatte: &Cryptomatte) -> u64 {
    let layer = 24 + 2 * 32 + u64::from(cryptomatte.levels) * 2 * 4 * 2;
    cryptomatte.kinds.len() as u64 * layer
}

/// Settings that conflict, or a camera without a view.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{problem}\n  help: {remedy}")]
pub struct Invalid {
    /// The problem, as a sentence without a capital or a full stop.
    pub problem: String,
    /// The remedy, likewise.
    pub remedy: String,
}

impl Invalid {
    /// The problem and the remedy.
    pub fn new(problem: impl Into<String>, remedy: impl Into<String>) -> Self {
        Self { problem: problem.into(), remedy: remedy.into() }
    }
}

impl Settings {
    /// An estimate of the memory that the picture takes, in bytes, without the scene.
    pub fn picture_bytes(&self) -> u64 {
        let pixel = BYTES_PER_PIXEL
            + if self.aov { AOV_BYTES_PER_PIXEL } else { 0 }
            + if self.halves { HALVES_BYTES_PER_PIXEL } else { 0 }
            + matte_bytes_per_pixel(&self.cryptomatte)
            + self.aovs.len() as u64 * LPE_BYTES_PER_PIXEL;
        u64::from(self.width) * u64::from(self.height) * pixel
    }

    /// Refuses AOVs by light path expressions where no paths are known, or two of one name.
    pub fn check_light_paths(&self) -> Result<(), Invalid> {
        if self.aovs.is_empty() && !self.light_groups {
            return Ok(());
        }
        let is_twice = |number: usize| self.aovs[..number].iter().any(|other| other.name == self.aovs[number].name);
        if let Some(number) = (0..self.aovs.len()).find(|&number| is_twice(number)) {
            let problem = format!("two AOVs are called {:?}", self.aovs[number].name);
            return Err(Invalid::new(problem, "give each a name of its own"));
        }
        match &self.integrator {
            Integrator::Path(PathOptions { stop: Stop::Threshold { add_back: true, .. }, .. }) => Err(Invalid::new(
                "--add-back adds light without a path, of which --lpe and --light-groups know nothing",
                "leave --add-back out, or give --stop roulette",
            )),
            Integrator::Path(_) => Ok(()),
            other => Err(Invalid::new(
                format!("the integrator {} follows no light paths, which --lpe and --light-groups need", other.name()),
                "give --integrator path, or leave the light path expressions out",
            )),
        }
    }

    /// Refuses a picture of more than [`MAX_PIXELS`].
    pub fn check_pixels(width: u32, height: u32) -> Result<(), Invalid> {
        let pixels = u64::from(width) * u64::from(height);
        if pixels <= MAX_PIXELS {
            return Ok(());
        }
        Err(Invalid::new(
            format!("{width}x{height} are {pixels} pixels"),
            format!("a picture has at most {MAX_PIXELS} pixels, for example 16384x16384"),
        ))
    }
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            width: 512,
            height: 512,
            filter: Filter::default(),
            integrator: Integrator::Path(PathOptions::default()),
            spp: 64,
            sampler: Pattern::Sobol,
            seed: 0,
            build: Quality::High,
            aov: false,
            aov_through: false,
            halves: false,
            cryptomatte: Cryptomatte::default(),
            aovs: Vec::new(),
            light_groups: false,
        }
    }
}
