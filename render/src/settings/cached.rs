//! The options of the irradiance cache.

/// The options of the `cached` integrator and of the cache commands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CachedOptions {
    /// The allowed error of a record where it is used, more than 0 and at most [`MAX_CACHE_ERROR`](Self::MAX_ERROR):
    /// Ward's `a` for the split-sphere metrics, and the fourth root of the relative error for the Hessian one, so that
    /// all radii are proportional to it.
    pub error: f32,
    /// The gradients by which records are extrapolated.
    pub gradients: Gradients,
    /// The metric of a record's radius.
    pub metric: Metric,
    /// The layout of a record's hemisphere.
    pub layout: GatherLayout,
    /// Rays of a record, about, [`MIN_RAYS`](Self::MIN_RAYS) to [`MAX_RAYS`](Self::MAX_RAYS): the nearest number that
    /// the layout can have.
    pub rays: u32,
    /// The number of reflections before a record: `None` for unlimited, by paths, which for many records end in another
    /// cache; else each bounce has a cache of its own.
    pub bounces: Option<u32>,
    /// The root mean square error that irradiance may have, relative to its mean over all points, more than 0 and at
    /// most [`MAX_ACCURACY`](Self::MAX_ACCURACY). Then `error` and `rays` are chosen for the scene; `None` takes them
    /// as they are.
    pub accuracy: Option<f32>,
}

/// The gradients by which records are extrapolated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Gradients {
    /// None: a record's irradiance is that of all around it.
    Off,
    /// Rotational gradients.
    Rotation,
    /// Rotational and translational gradients.
    Both,
}

/// The metric of a record's radius and weight.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Metric {
    /// The harmonic mean distance of the record's surroundings, and Ward's weight (Ward, Rubinstein and Clear 1988).
    SplitSphere,
    /// The same, bounded by the gradient and by the size of a pixel, and a linear weight (Tabellion and Lamorlette
    /// 2004).
    Bounded,
    /// An ellipse by the second derivatives of irradiance (Schwarzhaupt, Wann Jensen and Jarosz 2012).
    Hessian,
}

/// The layout of a record's hemisphere.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GatherLayout {
    /// Rings and sectors of equal weight, a random direction in each cell.
    Stratified,
    /// Half a cube, a direction through the middle of each texel.
    Hemicube,
}

impl CachedOptions {
    /// The greatest error: beyond it a record would reach farther than what it sees.
    pub const MAX_ERROR: f32 = 1.0;
    /// The least accuracy that can be asked for.
    pub const MAX_ACCURACY: f32 = 0.5;
    /// The fewest rays for gradients.
    pub const MIN_RAYS: u32 = 12;
    /// The most rays of a record.
    pub const MAX_RAYS: u32 = 1 << 20;
    /// The most bounces that can have a cache each.
    pub const MAX_BOUNCES: u32 = 16;
}

impl Default for CachedOptions {
    fn default() -> Self {
        Self {
            error: 0.3,
            gradients: Gradients::Both,
            metric: Metric::Hessian,
            layout: GatherLayout::Stratified,
            rays: 2048,
            bounces: None,
            accuracy: None,
        }
    }
}

/// A type of few values that have names on the command line and in scene files.
macro_rules! named {
    ($type:ident: $($variant:ident = $name:literal),+) => {
        impl $type {
            /// Every value.
            pub const ALL: [Self; [$($name),+].len()] = [$(Self::$variant),+];

            /// The name in scene files and on the command line.
            pub fn name(self) -> &'static str {
                match self { $(Self::$variant => $name),+ }
            }
        }
    };
}

pub(crate) use named;

named!(Gradients: Off = "off", Rotation = "rotation", Both = "both");
named!(Metric: SplitSphere = "split-sphere", Bounded = "bounded", Hessian = "hessian");
named!(GatherLayout: Stratified = "stratified", Hemicube = "hemicube");
