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
mod estimate;
mod file;
mod fill;
mod interpolate;
mod merge;
mod morton;
mod octree;
mod record;
mod regression;
#[cfg(test)]
mod tests;
mod weight;

use std::f32::consts::SQRT_2;

use crate::settings::{CachedOptions, Gradients, Metric};
use agreement::Tolerance;
use octree::Octree;
use regression::{Neighbourhood, Polynomial, polynomials};
use weight::Weighting;

pub(crate) use clamp::{Bounds, bound};
pub use estimate::ErrorEstimate;
pub(crate) use estimate::{MORE_PATHS, MORE_RECORDS, missed_accuracy};
pub(crate) use fill::{Pass, Place};
pub use interpolate::Interpolated;
pub(crate) use interpolate::Reading;
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

/// The allowed disagreement of records, relative to irradiance, over the requested error.
const TOLERANCE: f32 = 0.2;
/// The least factor on a radius by disagreement, as an edge of light is no closer for a smaller radius; ...
const MIN_RADIUS_FACTOR: f32 = 0.5;
/// ... and where an accuracy is asked for.
const ACCURATE_MIN_RADIUS_FACTOR: f32 = 0.25;
/// The allowed disagreement of records with an accuracy, relative to the root mean square error: a record has the least
/// weight where it disagrees most.
const ACCURATE_TOLERANCE: f32 = 1.5;

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
}

/// Multiplies the radii of each record by its factor.
fn shorten(records: &mut [Record], factors: &[f32]) {
    for (record, factor) in records.iter_mut().zip(factors) {
        record.radii = record.radii.map(|radius| radius * factor);
    }
}
