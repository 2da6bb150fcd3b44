//! The integrator and its options.

use super::{CachedOptions, Invalid};

/// The integrator with its options; [`named`](Self::named) gives each with its defaults.
#[derive(Clone, Debug, PartialEq)]
pub enum Integrator {
    /// Global illumination by path tracing.
    Path(PathOptions),
    /// Direct light and some bounces of indirect light, each gathered by many rays: their number grows exponentially.
    MonteCarlo(MonteCarloOptions),
    /// Global illumination by path tracing at few points, between which it is interpolated.
    Cached(CachedOptions),
    /// Light that comes straight from its source, or by mirrors and glass alone.
    Direct(DirectOptions),
    /// Ambient occlusion: how open a point is to the outside.
    Ao(AoOptions),
    /// The surfaces' colours, without any shading.
    Flat,
    /// The cost of path tracing with these options in each pixel: nodes and blocks of the tree visited by a sample's
    /// rays, on average.
    Heat(PathOptions),
    /// The lights that path tracing samples at the first surface, each in its own colour.
    HeatLights,
    /// Shading normals as colours.
    Normals,
    /// Diffuse reflectance.
    Albedo,
}

/// The options of path tracing.
#[derive(Clone, Debug, PartialEq)]
pub struct PathOptions {
    /// The greatest number of surface hits on a path, camera's included, at least 1: 1 shows emitters alone, 2 adds
    /// direct light.
    pub max_depth: u32,
    /// The sampling of the light that a surface receives.
    pub lights: LightSampling,
    /// The stopping rule before [`max_depth`](Self::max_depth).
    pub stop: Stop,
    /// The greatest radiance, in any channel, that a single light adds to a path after two reflections and more; what
    /// is brighter is scaled down. More than 0. It removes fireflies, and light.
    pub clamp_indirect: Option<f32>,
    /// The least roughness, 0 to 1, of gloss that a path meets after it has been spread by a wide lobe, such as diffuse
    /// reflection. It removes fireflies, and blurs caustics. Mirrors and clear glass stay.
    pub filter_glossy: f32,
    /// Path guiding: the number of paths, 1024 to 8,388,608, for training before the picture; `None` to sample closures
    /// alone. It pays where light enters through a narrow opening; the picture's mean does not depend on it.
    pub guide: Option<u32>,
}

/// The technique for light that several techniques can find. Delta lights are always sampled; lights in mirrors are
/// always found by bounces.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LightSampling {
    /// Bounces hit lights by chance.
    Naive,
    /// Light samples at each surface.
    Direct,
    /// Both, weighted by the power heuristic (Veach 1997).
    Mis,
}

/// The stopping rule of a path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Stop {
    /// Its length alone.
    Depth,
    /// Attenuation: the path ends where less than `cutoff` of its light would be reflected, in every channel.
    Threshold {
        /// Throughput in 0..=1.
        cutoff: f32,
        /// Whether the lost light is replaced by an estimate: the scene's mean radiance, attenuated as the path is.
        add_back: bool,
    },
    /// Russian roulette, without bias: survivors have a greater weight.
    Roulette {
        /// Surfaces before roulette starts.
        after: u32,
        /// The probability of going on afterwards.
        survival: Survival,
    },
}

/// The survival probability of a path.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Survival {
    /// Always the same, more than 0 and at most 1.
    Constant(f32),
    /// The largest channel of the path's throughput.
    Throughput {
        /// The greatest probability, more than 0 and at most 1.
        max: f32,
    },
    /// The square root of that channel: paths go on for longer, and clear glass ends none of them. Of a path that a
    /// guide leads, the reflectance of its last surface.
    #[default]
    RootThroughput,
}

impl Survival {
    /// By the throughput, as its name in options means.
    pub const THROUGHPUT: Self = Self::Throughput { max: 0.95 };
}

/// The options of the exponential estimator.
#[derive(Clone, Debug, PartialEq)]
pub struct MonteCarloOptions {
    /// Bounces of indirect light; 0 is direct light alone.
    pub bounces: u32,
    /// Rays that each surface on a path gathers with, at least 1.
    pub rays: u32,
    /// The sampling of their directions.
    pub sampling: HemisphereSampling,
    /// The continuation after the last bounce: nothing, or one ray a surface with Russian roulette of this survival,
    /// which is unbiased.
    pub tail: Option<Survival>,
}

/// The sampling of a hemisphere.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum HemisphereSampling {
    /// With equal density.
    Uniform,
    /// With a density in proportion to the cosine.
    Cosine,
    /// In proportion to the cosine, one from each cell of a grid. The grid may have fewer cells than there are rays to
    /// be, for it is about three times as long around as it is high.
    Stratified,
    /// With equal density, one from each cell of such a grid.
    StratifiedUniform,
}

/// Options of direct light.
#[derive(Clone, Debug, PartialEq)]
pub struct DirectOptions {
    /// The greatest number of surfaces on a path that mirrors and glass prolong, at least 1.
    pub max_depth: u32,
}

/// Options of ambient occlusion.
#[derive(Clone, Debug, PartialEq)]
pub struct AoOptions {
    /// The value of a ray that hits something.
    pub weighting: AoWeighting,
    /// The distance from which on hits do not occlude, in the scene's units; `None` for the diagonal of its bounds.
    pub max_distance: Option<f32>,
    /// Rays for each camera ray, at least 1.
    pub rays: u32,
    /// The sampling of their directions.
    pub sampling: HemisphereSampling,
}

/// The value of an occlusion ray.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AoWeighting {
    /// 1 if it hits nothing, else 0.
    CacheMisses,
    /// Its length as a part of the greatest distance: 1 if it hits nothing before.
    HitLength,
}

impl Integrator {
    /// The names of all integrators.
    pub const NAMES: [&str; 10] =
        ["path", "cached", "montecarlo", "direct", "ao", "flat", "heat", "heat-lights", "normals", "albedo"];

    /// The integrator of this name with its default options.
    pub fn named(name: &str) -> Option<Self> {
        Some(match name {
            "path" => Self::Path(PathOptions::default()),
            "cached" => Self::Cached(CachedOptions::default()),
            "montecarlo" => Self::MonteCarlo(MonteCarloOptions::default()),
            "direct" => Self::Direct(DirectOptions::default()),
            "ao" => Self::Ao(AoOptions::default()),
            "flat" => Self::Flat,
            "heat" => Self::Heat(PathOptions::default()),
            "heat-lights" => Self::HeatLights,
            "normals" => Self::Normals,
            "albedo" => Self::Albedo,
            _ => return None,
        })
    }

    /// The name in scene files and on the command line.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Path(_) => "path",
            Self::Cached(_) => "cached",
            Self::MonteCarlo(_) => "montecarlo",
            Self::Direct(_) => "direct",
            Self::Ao(_) => "ao",
            Self::Flat => "flat",
            Self::Heat(_) => "heat",
            Self::HeatLights => "heat-lights",
            Self::Normals => "normals",
            Self::Albedo => "albedo",
        }
    }

    /// Whether the picture shows light, so that it is black without any.
    pub fn needs_light(&self) -> bool {
        matches!(self, Self::Path(_) | Self::Cached(_) | Self::MonteCarlo(_) | Self::Direct(_))
    }

    /// Refuses options with which a render would never end, or that do not go together.
    pub fn check(&self) -> Result<(), Invalid> {
        match self {
            Self::MonteCarlo(options) => options.check(),
            Self::Path(options) => options.check(),
            _ => Ok(()),
        }
    }
}

impl MonteCarloOptions {
    /// The most gathering rays for one camera ray: all of the last bounce are in memory at once.
    pub const MAX_RAYS: u64 = 1 << 20;

    /// The gathering rays for one camera ray, at most: `rays + rays² + ...`, once for each bounce.
    pub fn rays_per_sample(&self) -> u64 {
        let rays = u64::from(self.rays);
        match rays {
            // One ray a surface is a path, of which any length will do.
            1 => u64::from(self.bounces),
            // 2^64 rays and more are as good as infinitely many.
            _ => (0..self.bounces.min(64)).fold(0, |sum: u64, _| sum.saturating_add(1).saturating_mul(rays)),
        }
    }

    fn check(&self) -> Result<(), Invalid> {
        if self.rays_per_sample() <= Self::MAX_RAYS {
            return Ok(());
        }
        let Self { bounces, rays, .. } = self;
        Err(Invalid::new(
            format!("{bounces} bounces of {rays} rays each are more than {} rays for each sample", Self::MAX_RAYS),
            "give fewer bounces or rays: each bounce takes `rays` times as many rays as the one before",
        ))
    }
}

impl PathOptions {
    /// Paths from which a guide is learned unless another number is given.
    pub const GUIDE_PATHS: u32 = 1 << 19;
    /// The fewest: too few for any guide.
    pub const MIN_GUIDE_PATHS: u32 = 1 << 10;
    /// The most: some gigabytes of memory.
    pub const MAX_GUIDE_PATHS: u32 = 1 << 23;

    /// A guided path's throughput is the smaller, the more light there is where it goes.
    fn check(&self) -> Result<(), Invalid> {
        match (self.guide, self.stop) {
            (Some(_), Stop::Threshold { .. }) => Err(Invalid::new(
                "guided paths cannot end by a threshold: it would end those that go where most light is",
                "leave out `guide`, or choose the stop `roulette` or `depth`",
            )),
            _ if !(0.0..=1.0).contains(&self.filter_glossy) => Err(Invalid::new(
                format!("the least roughness of gloss, {}, is not from 0 to 1", self.filter_glossy),
                "give `filter_glossy` a number from 0 to 1",
            )),
            _ => Ok(()),
        }
    }
}

impl Default for PathOptions {
    fn default() -> Self {
        Self {
            max_depth: 1024,
            lights: LightSampling::Mis,
            stop: Stop::default(),
            clamp_indirect: None,
            filter_glossy: 0.0,
            guide: None,
        }
    }
}

impl Stop {
    /// The names of all rules.
    pub const NAMES: [&str; 3] = ["depth", "threshold", "roulette"];

    /// The rule of this name with its defaults.
    pub fn named(name: &str) -> Option<Self> {
        Some(match name {
            "depth" => Self::Depth,
            "threshold" => Self::Threshold { cutoff: 0.01, add_back: false },
            "roulette" => Self::default(),
            _ => return None,
        })
    }

    /// The name in scene files and on the command line.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Depth => "depth",
            Self::Threshold { .. } => "threshold",
            Self::Roulette { .. } => "roulette",
        }
    }
}

impl Default for Stop {
    fn default() -> Self {
        Self::Roulette { after: 3, survival: Survival::default() }
    }
}

impl Default for MonteCarloOptions {
    fn default() -> Self {
        Self { bounces: 1, rays: 16, sampling: HemisphereSampling::Stratified, tail: None }
    }
}

impl Default for DirectOptions {
    fn default() -> Self {
        Self { max_depth: 32 }
    }
}

impl Default for AoOptions {
    fn default() -> Self {
        Self {
            weighting: AoWeighting::CacheMisses,
            max_distance: None,
            rays: 16,
            sampling: HemisphereSampling::Stratified,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_name_is_that_of_its_integrator() {
        for name in Integrator::NAMES {
            assert_eq!(Integrator::named(name).unwrap().name(), name);
        }
        assert_eq!(Integrator::named("Path"), None);
        for name in Stop::NAMES {
            assert_eq!(Stop::named(name).unwrap().name(), name);
        }
    }

    #[test]
    fn gathering_rays_are_a_geometric_series_and_limited() {
        let options = |bounces, rays| MonteCarloOptions { bounces, rays, ..Default::default() };
        assert_eq!(options(0, 256).rays_per_sample(), 0);
        assert_eq!(options(3, 10).rays_per_sample(), 1110);
        assert_eq!(options(1_000_000, 1).rays_per_sample(), 1_000_000);
        assert_eq!(options(u32::MAX, 2).rays_per_sample(), u64::MAX);
        let check = |bounces, rays| Integrator::MonteCarlo(options(bounces, rays)).check();
        assert!(check(1, 1 << 20).is_ok() && check(1, (1 << 20) + 1).is_err());
        // Driscoll's example: over four billion rays.
        assert!(check(2, 256).is_ok());
        let error = check(4, 256).unwrap_err();
        let guided =
            PathOptions { guide: Some(4096), stop: Stop::named("threshold").unwrap(), ..PathOptions::default() };
        assert!(Integrator::Path(guided.clone()).check().is_err());
        assert!(Integrator::Path(PathOptions { guide: None, ..guided }).check().is_ok());
        assert_eq!(error.problem, "4 bounces of 256 rays each are more than 1048576 rays for each sample");
    }
}
