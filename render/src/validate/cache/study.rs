//! The error of indirect light at camera hits, by paths and by caches, against the number of rays.
//!
//! A study uses some of the surface points that the camera sees through the pixels of a picture. Their irradiance by
//! many paths is the reference, which comes as two independent halves `a` and `b`: the variance of their mean is the
//! mean of `(a - b)²/4`. Errors are root mean squares over surfaces and channels, relative to the mean of the
//! reference, and without the reference's own variance.

use glam::{DVec3, Vec2, Vec3};
use halfdome_kernel::sampling::Stream;

use crate::cache::{Cache, Reading};
use crate::camera::FilmPoint;
use crate::integrator::{FillTarget, fill_for_camera, fill_for_surfaces};
use crate::irradiance::{Part, Request, Sensor, by_paths};
use crate::settings::{CachedOptions, Settings};
use crate::watch::Watch;
use crate::world::{Hit, World};

/// Irradiance that is known well.
#[derive(Clone, Debug)]
pub struct Reference {
    values: Vec<DVec3>,
    /// The mean of all channels.
    mean: f64,
    /// The variance of each value, summed over the channels.
    variances: Vec<f64>,
}

/// A root mean square, relative to the mean of what is measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RelativeError {
    /// Of all surfaces.
    pub of_all: f64,
    /// Of the 99% of the surfaces where it is least: a single one, a tenth of a millimetre above the edge of a lamp,
    /// say, may hold half of the squares, and of a pixel's light it would be little.
    pub of_most: f64,
}

impl Reference {
    /// By `spp` paths at each sensor for each half. What it is of `part` counts.
    pub fn by_paths(world: &World, sensors: &[Sensor], part: Part, spp: u32, seed: u64, watch: &dyn Watch) -> Self {
        let half = |seed| by_paths(world, sensors, &Request { spp, seed, part }, watch).values;
        let (first, second) = (half(seed), half(!seed));
        let pairs = || first.iter().zip(&second).map(|(a, b)| (a.as_dvec3(), b.as_dvec3()));
        let values: Vec<DVec3> = pairs().map(|(a, b)| 0.5 * (a + b)).collect();
        let variances = pairs().map(|(a, b)| 0.25 * a.distance_squared(b)).collect();
        let mean = values.iter().map(|value| value.element_sum()).sum::<f64>() / (3.0 * values.len() as f64);
        Self { values, mean, variances }
    }

    /// Its own error, relative to its mean.
    pub fn error(&self) -> f64 {
        (self.variances.iter().sum::<f64>() / (3.0 * self.values.len() as f64)).sqrt() / self.mean
    }

    /// The relative error of other values for the same sensors.
    pub fn error_of(&self, values: impl IntoIterator<Item = Vec3>) -> RelativeError {
        let differences = self.values.iter().zip(values).map(|(exact, value)| exact.distance_squared(value.as_dvec3()));
        let mut squares: Vec<(f64, f64)> = differences.zip(self.variances.iter().copied()).collect();
        squares.sort_by(|a, b| a.0.total_cmp(&b.0));
        let relative = |squares: &[(f64, f64)]| {
            let sum: f64 = squares.iter().map(|(square, variance)| square - variance).sum();
            (sum / (3.0 * squares.len() as f64)).max(0.0).sqrt() / self.mean
        };
        RelativeError { of_all: relative(&squares), of_most: relative(&squares[..squares.len() * 99 / 100]) }
    }
}

/// A view of a scene whose indirect light is known at some of the surfaces.
pub struct Study<'a> {
    world: &'a World,
    settings: Settings,
    sensors: Vec<Sensor>,
    reference: Reference,
    watch: &'a dyn Watch,
}

/// The cost and the error of an estimate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Run {
    /// Records of the cache; none by paths.
    pub records: usize,
    /// Rays for all pixels.
    pub rays: f64,
    /// Seconds for all pixels, or 0 if not measured.
    pub seconds: f64,
    /// Relative error.
    pub error: RelativeError,
}

/// The surfaces of a study.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Places {
    /// Those in the middles of pixels that may get a record: how metrics and gradients differ shows best there.
    Candidates,
    /// Any: what is beside edges, where all caches are as coarse as pixels are, counts as much as in a picture.
    Anywhere,
}

/// Selects where in the picture the surfaces are.
const PLACES_SEED: u64 = 11;
/// Pixels along a side of the picture.
const SIDE: u32 = 256;

impl<'a> Study<'a> {
    /// A study of `side`² surfaces, fewer where the camera sees none, with a reference of twice `spp` paths at each.
    pub fn new(world: &'a World, places: Places, side: u32, spp: u32, seed: u64, watch: &'a dyn Watch) -> Self {
        let settings = Settings { width: SIDE, height: SIDE, seed, ..Settings::default() };
        let sensors = sensors(world, places, side);
        let reference = Reference::by_paths(world, &sensors, Part::Indirect, spp, !(seed << 1), watch);
        Self { world, settings, sensors, reference, watch }
    }

    /// The same study, whose estimates have random numbers of their own; the reference stays.
    pub(super) fn with_seed(&mut self, seed: u64) -> &Self {
        self.settings.seed = seed;
        self
    }

    /// The error of the reference itself, relative to its mean.
    pub fn reference_error(&self) -> f64 {
        self.reference.error()
    }

    /// The number of pixels that a surface of the study represents.
    pub fn pixels(&self) -> f64 {
        f64::from(SIDE * SIDE) / self.sensors.len() as f64
    }

    /// By `spp` paths at each surface. The rays are those for all pixels.
    pub fn paths(&self, spp: u32) -> Run {
        let request = Request { spp, seed: self.settings.seed, part: Part::Indirect };
        let found = by_paths(self.world, &self.sensors, &request, self.watch);
        let rays = found.rays as f64 * self.pixels();
        Run { records: 0, rays, seconds: 0.0, error: self.reference.error_of(found.values) }
    }

    /// By a cache for the picture with both gradients, with each of these readings, on which its records do not depend.
    /// A surface that it does not cover gets a record of its own, which counts.
    pub(crate) fn cache(&self, options: CachedOptions, readings: &[Reading]) -> Vec<Run> {
        let cache = Cache::new(options, self.world.surroundings_hash());
        let (frozen, rays) = fill_for_camera(self.world, &self.settings, cache, self.watch);
        let surfaces: Vec<_> =
            self.sensors.iter().map(|sensor| self.world.sensor(sensor.position, sensor.normal)).collect();
        let (frozen, more) =
            fill_for_surfaces(self.world, self.settings.seed, frozen.cache, &surfaces, FillTarget::Options, self.watch);
        let (records, rays) = (frozen.cache.records().len(), (rays + more) as f64);
        let run = |&reading: &Reading| {
            let read = |sensor: &Sensor| frozen.cache.interpolate_by(reading, sensor.position, sensor.normal);
            // Nothing is missing unless filling was interrupted.
            let found = self.sensors.iter().map(|sensor| read(sensor).map_or(Vec3::ZERO, |found| found.irradiance));
            Run { records, rays, seconds: 0.0, error: self.reference.error_of(found) }
        };
        readings.iter().map(run).collect()
    }
}

/// A surface that the camera sees at random in each of `side`² equal parts of the picture, if it sees one that scatters
/// light.
fn sensors(world: &World, places: Places, side: u32) -> Vec<Sensor> {
    let camera = world.camera_on(SIDE, SIDE);
    let part = SIDE as f32 / side as f32;
    let rays = (0..side * side).map(|i| {
        let random = Stream::new(PLACES_SEED, i, 0).uniform2(0);
        let place = (Vec2::new((i % side) as f32, (i / side) as f32) + random) * part;
        let place = match places {
            Places::Anywhere => place,
            // Every other pixel is a candidate; what is an odd multiple of 2 along both axes is only in the last pass.
            Places::Candidates => Vec2::from_array([place.x, place.y].map(|along| (along as u32 & !3) as f32 + 2.5)),
        };
        camera.central_ray(&FilmPoint::within(place))
    });
    let surfaces = rays.flatten().filter_map(|ray| {
        let hit = Hit::of(&world.tree().intersect(&ray)?);
        Some(world.surface_at(&hit).facing(ray.direction))
    });
    let scattering = surfaces.filter(|surface| surface.diffuse != Vec3::ZERO);
    scattering.map(|surface| Sensor { position: surface.position, normal: surface.shading_normal }).collect()
}
