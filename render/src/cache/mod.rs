//! The irradiance cache (Ward, Rubinstein and Clear 1988): indirect irradiance at few points of the surfaces,
//! interpolated at all other points,
//!
//! `E(x, n) = Σ w_i (E_i + (n_i × n)·∇_r E_i + (x - x_i)·∇_t E_i) / Σ w_i`.
//!
//! Where both gradients are in use, a polynomial of the second degree takes the place of `E_i` and `∇_t`, fitted to the
//! neighbours too (`regression`): the curvature of irradiance limits the reach of gradients.
//!
//! This module stores and interpolates records and traces no rays: callers compute the irradiance.
//!
//! A cache is frozen while it is read. It grows in rounds (`fill`), and each ends with one commit, in which radii are
//! clamped (`clamp`) and shortened where records disagree (`agreement`), and the tree is built anew. Everything is in a
//! fixed order, so a cache is the same for any number of threads.

mod agreement;
mod clamp;
mod cones;
mod doubt;
mod file;
mod fill;
mod merge;
mod morton;
mod octree;
mod record;
mod regression;
mod weight;

use std::f32::consts::SQRT_2;

use glam::Vec3;

use crate::settings::{CachedOptions, Gradients, Metric};
use agreement::Tolerance;
use octree::Octree;
use regression::{Neighbourhood, Polynomial, polynomials};
use weight::Weighting;

pub(crate) use clamp::{Bounds, bound};
pub(crate) use fill::{Pass, Place};
pub(crate) use morton::sort_by_morton_code;

pub use file::CacheFileError;
pub(crate) use file::named;
pub(crate) use record::LookupPoint;
pub use record::{Record, SECTORS};

/// Irradiance records, and what finds them.
#[derive(Clone, Debug)]
pub struct Cache {
    options: CachedOptions,
    /// The hash of the records' inputs besides the options.
    scene: u64,
    /// Whether records reach as far as their own gathers say, whatever neighbours know.
    is_rough: bool,
    /// The estimate of its error, if it is filled to an accuracy.
    estimate: Option<ErrorEstimate>,
    /// The records with their radii as they are used.
    records: Vec<Record>,
    /// Their radii as they were made.
    original_radii: Vec<[f32; 2]>,
    /// The local regression of each record, if the options have both gradients; else empty.
    polynomials: Vec<Polynomial>,
    tree: Octree,
}

/// The estimated error of a cache that was filled to an accuracy, by independent gathers at some of its points.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ErrorEstimate {
    /// The mean irradiance of the points that it was filled for, direct light included, in W/m², over all channels.
    pub light: f32,
    /// The root mean square error of its irradiance, relative to that.
    pub root_mean_square: f32,
}

impl ErrorEstimate {
    /// The root mean square error, relative to the mean, of this and of sampled light with a mean variance, in W²/m⁴.
    pub(crate) fn with(&self, variance: f64) -> f32 {
        let relative = if self.light > 0.0 { variance / f64::from(self.light).powi(2) } else { 0.0 };
        (f64::from(self.root_mean_square).powi(2) + relative).sqrt() as f32
    }
}

/// The warning where the estimate exceeds the requested error; both are relative to the mean. An error that rounds to
/// the same number counts as reached.
pub(crate) fn missed_accuracy(asked: f32, estimated: f32) -> Option<String> {
    let hundredths = |part: f32| (1e4 * part).round();
    (hundredths(estimated) > hundredths(asked)).then(|| {
        format!(
            "the requested accuracy is not reached: the estimated error is {:.2}% of the mean light, and {}% was \
             requested; --cache-error and --record-rays in place of --accuracy give more and smaller records",
            100.0 * estimated,
            hundredths(asked) / 100.0
        )
    })
}

/// The allowed disagreement of records, relative to irradiance, over the requested error.
const TOLERANCE: f32 = 0.2;
/// The least factor on a radius by disagreement, as an edge of light is no closer for a smaller radius; ...
const MIN_RADIUS_FACTOR: f32 = 0.5;
/// ... and where an accuracy is asked for.
const ACCURATE_MIN_RADIUS_FACTOR: f32 = 0.25;
/// The allowed disagreement of records with an accuracy, relative to the root mean square error: a record has the least
/// weight where it disagrees most.
const ACCURATE_TOLERANCE: f32 = 1.5;

/// The reconstruction at a point from the surrounding records.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Reading {
    /// Each by what its own gather says, as published.
    Alone(Gradients),
    /// Each by what its neighbours say as well, in a cache that has both gradients.
    Together,
}

/// Irradiance from the records around a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interpolated {
    /// In W/m², linear sRGB; never negative.
    pub irradiance: Vec3,
    /// Records whose extrapolation had a negative channel, which counted as 0.
    pub negative: u32,
}

impl Cache {
    /// A cache without records for a scene with this [hash](crate::world::World::surroundings_hash).
    pub fn new(options: CachedOptions, scene: u64) -> Self {
        let (records, original_radii, polynomials) = Default::default();
        Self {
            options,
            scene,
            is_rough: false,
            estimate: None,
            records,
            original_radii,
            polynomials,
            tree: Octree::default(),
        }
    }

    /// The same without error control by what neighbours know, for gathers to take means over it.
    pub(crate) fn rough(self) -> Self {
        Self { is_rough: true, ..self }
    }

    /// An empty cache like this one, with radii by another error; `estimate` has the light of its points.
    pub(crate) fn with_error(&self, error: f32, estimate: ErrorEstimate) -> Self {
        Self { estimate: Some(estimate), ..Self::new(CachedOptions { error, ..self.options }, self.scene) }
    }

    /// The estimate of its error, if it was filled to an accuracy.
    pub fn estimate(&self) -> Option<ErrorEstimate> {
        self.estimate
    }

    /// Says how right it is.
    pub(crate) fn set_estimate(&mut self, estimate: ErrorEstimate) {
        self.estimate = Some(estimate);
    }

    /// A cache of these records, with their radii as they were made.
    pub fn of(options: CachedOptions, scene: u64, records: Vec<Record>) -> Self {
        let mut cache = Self::new(options, scene);
        cache.commit(records);
        cache
    }

    /// The options of the records.
    pub fn options(&self) -> &CachedOptions {
        &self.options
    }

    /// The hash of the scene that the records are of.
    pub fn scene_hash(&self) -> u64 {
        self.scene
    }

    /// The records, near ones near each other.
    pub fn records(&self) -> &[Record] {
        &self.records
    }

    /// Adds records, sorts all, bounds how far they reach, and builds the tree anew.
    pub(crate) fn commit(&mut self, records: Vec<Record>) {
        let mut records: Vec<Record> = self.take_original().chain(records).collect();
        sort_by_morton_code(&mut records, |record| record.position, |record| record.key);
        self.original_radii = records.iter().map(|record| record.radii).collect();
        let factors = clamp::neighbour_factors(&records, self.slope());
        shorten(&mut records, &factors);
        let weighting = self.weighting(self.stretch());
        if self.options.gradients == Gradients::Both && !self.is_rough {
            let factors = agreement::factors(&records, &weighting, &self.tolerance());
            shorten(&mut records, &factors);
        }
        self.tree = Octree::new(records.iter().map(|record| (record.position, weighting.reach(record))));
        if self.options.gradients == Gradients::Both {
            self.polynomials = polynomials(&records, &self.neighbourhood());
        }
        self.records = records;
    }

    /// The allowed disagreement of records, relative to their irradiance, or to the mean with an accuracy.
    fn tolerance(&self) -> Tolerance {
        match (self.options.accuracy, self.estimate) {
            (Some(accuracy), Some(estimate)) => Tolerance {
                relative: 0.0,
                absolute: ACCURATE_TOLERANCE * accuracy * estimate.light,
                least: ACCURATE_MIN_RADIUS_FACTOR,
            },
            _ => Tolerance { relative: TOLERANCE * self.options.error, absolute: 0.0, least: MIN_RADIUS_FACTOR },
        }
    }

    /// Takes the records out, as they were made.
    fn take_original(&mut self) -> impl Iterator<Item = Record> + use<> {
        let records = std::mem::take(&mut self.records).into_iter().zip(std::mem::take(&mut self.original_radii));
        records.map(|(record, radii)| Record { radii, ..record })
    }

    /// The slope by which a record's radius may grow with the distance from a neighbour. A Hessian can be 0 at a
    /// transition of irradiance, as below the edge of a low object: the neighbours' radii reveal it.
    fn slope(&self) -> f32 {
        match self.options.metric {
            Metric::SplitSphere | Metric::Bounded => self.options.error,
            Metric::Hessian if self.is_rough => 1.0,
            Metric::Hessian => 0.4,
        }
    }

    /// The stretch of radii in lookups relative to placing. With the Hessian's metric the whole radius has the
    /// requested error, so the stretch is smaller.
    fn stretch(&self) -> f32 {
        match self.options.metric {
            Metric::SplitSphere | Metric::Bounded => 2.0,
            Metric::Hessian => SQRT_2,
        }
    }

    fn weighting(&self, stretch: f32) -> Weighting {
        Weighting::new(self.options.metric, self.options.error, stretch)
    }

    /// The distance of neighbours in the regression, and the weight of their gradients; with tent weights, as the
    /// split-sphere's own weight is unbounded near a record. A Hessian's records are densest where irradiance curves,
    /// so neighbours determine the curvature; other metrics need gradients more.
    fn neighbourhood(&self) -> Neighbourhood {
        match self.options.metric {
            Metric::SplitSphere | Metric::Bounded => Neighbourhood {
                weighting: Weighting { metric: Metric::Bounded, ..self.weighting(1.5) },
                gradient_weight: 0.12,
            },
            Metric::Hessian => Neighbourhood { weighting: self.weighting(2.0), gradient_weight: 0.03 },
        }
    }

    /// Whether a point needs no record of its own.
    pub(crate) fn covers(&self, point: &LookupPoint) -> bool {
        let weighting = self.weighting(1.0);
        let mut covered = false;
        self.tree.query(point.position, |i| {
            covered = covered || weighting.weight(&self.records[i], point) > 0.0;
        });
        covered
    }

    /// Calls `mix` with the index and the weight of each record that is valid at a point, in the order in which
    /// [`interpolate`](Self::interpolate) takes them.
    pub(crate) fn weigh(&self, point: &LookupPoint, mut mix: impl FnMut(usize, f32)) {
        let weighting = self.weighting(self.stretch());
        self.tree.query(point.position, |i| {
            let weight = weighting.weight(&self.records[i], point);
            if weight > 0.0 {
                mix(i, weight);
            }
        });
    }

    /// The irradiance at a point with a unit normal; `None` where no record is valid.
    pub fn interpolate(&self, position: Vec3, normal: Vec3) -> Option<Interpolated> {
        self.interpolate_by(self.reading(), position, normal)
    }

    /// The same with a reading that may not be that of the options.
    pub(crate) fn interpolate_by(&self, reading: Reading, position: Vec3, normal: Vec3) -> Option<Interpolated> {
        let point = LookupPoint { position, normal, clearance: None };
        self.mix(reading, &self.weighting(self.stretch()), &point, normal)
    }

    /// The irradiance at a point for the unit normal that a map tilts its own to.
    pub(crate) fn interpolate_tilted(&self, point: &LookupPoint, tilted: Vec3) -> Option<Interpolated> {
        self.mix(self.reading(), &self.weighting(self.stretch()), point, tilted)
    }

    /// The same, where surfaces turn so much that no record is valid by the published angles, from those up to 45°
    /// away.
    pub(crate) fn interpolate_wide(&self, point: &LookupPoint, tilted: Vec3) -> Option<Interpolated> {
        let strict = self.interpolate_tilted(point, tilted);
        strict.or_else(|| self.mix(self.reading(), &self.weighting(self.stretch()).wide(), point, tilted))
    }

    /// The reconstruction by the options.
    fn reading(&self) -> Reading {
        match self.options.gradients {
            Gradients::Both => Reading::Together,
            gradients => Reading::Alone(gradients),
        }
    }

    /// The irradiance of records at a point, for a tilted normal.
    #[inline]
    fn mix(&self, reading: Reading, weighting: &Weighting, point: &LookupPoint, tilted: Vec3) -> Option<Interpolated> {
        let LookupPoint { position, normal, .. } = *point;
        let gradients = match reading {
            Reading::Alone(gradients) => gradients,
            Reading::Together => Gradients::Both,
        };
        let rotation = gradients != Gradients::Off;
        let translation = gradients == Gradients::Both;
        let (mut sum, mut weights, mut negative) = (Vec3::ZERO, 0.0, 0);
        self.tree.query(position, |i| {
            let record = &self.records[i];
            let weight = weighting.weight(record, point);
            if weight > 0.0 {
                let irradiance = match self.polynomials.get(i) {
                    Some(polynomial) if reading == Reading::Together => {
                        polynomial.extrapolate(record, position, normal)
                    }
                    _ => record.extrapolate(position, normal, rotation, translation),
                };
                let irradiance = match tilted == normal {
                    true => irradiance,
                    false => record.tilt(irradiance, normal, tilted, rotation),
                };
                negative += u32::from(irradiance.min_element() < 0.0);
                sum += weight * irradiance.max(Vec3::ZERO);
                weights += weight;
            }
        });
        (weights > 0.0).then(|| Interpolated { irradiance: sum / weights, negative })
    }
}

/// Multiplies the radii of each record by its factor.
fn shorten(records: &mut [Record], factors: &[f32]) {
    for (record, factor) in records.iter_mut().zip(factors) {
        record.radii = record.radii.map(|radius| radius * factor);
    }
}

#[cfg(test)]
mod tests;
