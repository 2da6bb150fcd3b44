//! Error control by neighbours (Křivánek, Bouatouch, Pattanaik and Žára 2006, "adaptive caching").
//!
//! Where records overlap, the extrapolation of one record to another's position can be compared with the other's own
//! gather. If the two differ by more than `ε` times the greater irradiance, and by more than both gathers' noise
//! explains, the record's radius is too large. The error of extrapolation by gradients grows with the square of the
//! distance, so the radius within which the difference `δ` is tolerated is
//!
//! `R √(ε/δ) t`, with `t` the distance of the other in units of `R`.
//!
//! Deviation: the article shrinks records that disagree at a pixel, in the order of pixels. Here the radius is a
//! minimum over pairs of records with their previous radii, in one pass of any order. Points that are then no longer
//! covered get records of their own, which are compared in turn.

use glam::Vec3;
use rayon::prelude::*;

use super::octree::Octree;
use super::record::Record;
use super::weight::Weighting;

/// Standard errors that noise may explain.
const STANDARD_ERRORS: f32 = 2.0;

/// How much disagreement is no reason to shorten a record.
#[derive(Clone, Copy, Debug)]
pub(super) struct Tolerance {
    /// As a part of irradiance, ...
    pub(super) relative: f32,
    /// ... and in W/m² on top.
    pub(super) absolute: f32,
    /// The least factor.
    pub(super) least: f32,
}

/// The factor, at most 1, by which each record's radii are to be multiplied, so that it is not used where it disagrees
/// with others by more than `tolerance`. `weighting` says where it is used.
pub(super) fn factors(records: &[Record], weighting: &Weighting, tolerance: &Tolerance) -> Vec<f32> {
    let tree = Octree::new(records.iter().map(|record| (record.position, weighting.reach(record))));
    let limits = |other: &Record| {
        let mut limits: Vec<(usize, f32)> = Vec::new();
        tree.query(other.position, |i| {
            if weighting.weight(&records[i], &other.point()) > 0.0 {
                let limit = limit(&records[i], other, tolerance);
                limits.extend((limit < 1.0).then_some((i, limit)));
            }
        });
        limits
    };
    let mut factors = vec![1.0f32; records.len()];
    for (i, limit) in records.par_iter().map(limits).collect::<Vec<_>>().into_iter().flatten() {
        factors[i] = factors[i].min(limit.max(tolerance.least));
    }
    factors
}

/// The factor by which `other` would have the radii of `record` multiplied: infinite if the two agree.
fn limit(record: &Record, other: &Record, tolerance: &Tolerance) -> f32 {
    let step = other.position - record.position;
    let found = record.extrapolate(other.position, other.normal, true, true).max(Vec3::ZERO);
    // A gradient's noise is that of the irradiance over the mean distance, about.
    let noise = other.standard_error.hypot(record.standard_error * (1.0 + step.length() / record.mean_distance));
    let difference = (found - other.irradiance).abs().max_element() - STANDARD_ERRORS * noise;
    let tolerated = tolerance.relative * record.irradiance.max(other.irradiance).max_element() + tolerance.absolute;
    // False for NaN too.
    if difference > tolerated {
        record.relative_distance(step) * (tolerated / difference).sqrt()
    } else {
        f32::INFINITY
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cache::record::SECTORS;
    use crate::settings::Metric;
    use glam::vec3;
    use halfdome_kernel::sampling::Stream;

    const MIN_RADIUS_FACTOR: f32 = 0.5;

    fn relative(relative: f32) -> Tolerance {
        Tolerance { relative, absolute: 0.0, least: MIN_RADIUS_FACTOR }
    }

    const WEIGHTING: Weighting = Weighting::new(Metric::SplitSphere, 0.4, 2.0);

    fn record(position: Vec3, irradiance: Vec3, slope: f32, standard_error: f32) -> Record {
        Record {
            key: 0,
            position,
            normal: Vec3::Z,
            irradiance,
            standard_error,
            rotational: [Vec3::ZERO; 3],
            translational: [Vec3::X * slope; 3],
            mean_distance: 1.0,
            min_distance: 1.0,
            radii: [0.3, 0.3],
            axis: Vec3::X,
            occluders: [f32::INFINITY; SECTORS],
            clearance: f32::INFINITY,
        }
    }

    /// Records of `light` along with its slope and their standard error, at random places of the unit square.
    fn records(light: impl Fn(f32, u32) -> (f32, f32, f32)) -> Vec<Record> {
        let record = |i| {
            let [x, y, ..] = Stream::new(6, i, 0).uniform4(0);
            let (irradiance, slope, standard_error) = light(x, i);
            record(vec3(x, y, 0.0), Vec3::splat(irradiance), slope, standard_error)
        };
        (0..100).map(record).collect()
    }

    /// Of a parabola gradients leave out a known part, which at the new radius is what is tolerated.
    #[test]
    fn a_parabola_is_tolerated_up_to_the_radius() {
        let (curvature, tolerance) = (6.0, 0.08);
        let light = |x: f32| Vec3::splat(1.0 + 0.5 * curvature * x * x);
        for distance in [0.25, 0.35, 0.55] {
            let pair = [0.0, distance].map(|x| record(Vec3::X * x, light(x), curvature * x, 0.0));
            let tolerated = tolerance * light(distance).x;
            let radius = (tolerated / (0.5 * curvature)).sqrt();
            assert!((0.15..0.3).contains(&radius), "{radius} is not between the bounds");
            for factor in factors(&pair, &WEIGHTING, &relative(tolerance)) {
                assert!((0.3 * factor - radius).abs() < 1e-6, "{} instead of {radius} at {distance}", 0.3 * factor);
            }
        }
        // Beyond the reach nothing is known, and no radius becomes less than half.
        let pair = |distance: f32| [0.0, distance].map(|x| record(Vec3::X * x, light(9.0 * x), 0.0, 0.0));
        assert_eq!(factors(&pair(0.61), &WEIGHTING, &relative(tolerance)), [1.0; 2]);
        assert_eq!(factors(&pair(0.59), &WEIGHTING, &relative(0.25 * tolerance)), [MIN_RADIUS_FACTOR; 2]);
    }

    /// It is the least over all pairs, in whatever order.
    #[test]
    fn one_pass_is_the_least_over_pairs() {
        let records = records(|x, _| (1.0 + 2.0 * x * x, 4.0 * x, 0.01));
        let found = factors(&records, &WEIGHTING, &relative(0.05));
        let mut lessened = 0;
        for (i, record) in records.iter().enumerate() {
            let used = |other: &&Record| WEIGHTING.weight(record, &other.point()) > 0.0;
            let limits = records.iter().filter(used).map(|other| limit(record, other, &relative(0.05)));
            let least = limits.fold(1.0, f32::min).max(MIN_RADIUS_FACTOR);
            assert_eq!(found[i], least);
            lessened += usize::from((0.55..0.95).contains(&least));
        }
        assert!(lessened > 20, "{lessened}");
        let reversed: Vec<Record> = records.iter().rev().copied().collect();
        let mut backwards = factors(&reversed, &WEIGHTING, &relative(0.05));
        backwards.reverse();
        assert_eq!(backwards, found);
    }

    /// Known noise of the gathers does not count as disagreement; unknown noise would.
    #[test]
    fn noise_shortens_nothing() {
        // Uniform, so that it ends at √3 standard errors.
        let noisy = |told: f32| {
            let noise = |i| 0.1 * 3f32.sqrt() * (2.0 * Stream::new(7, i, 0).uniform2(0).x - 1.0);
            factors(&records(|_, i| (1.0 + noise(i), 0.0, told)), &WEIGHTING, &relative(0.1))
        };
        assert_eq!(noisy(0.1), [1.0; 100]);
        assert!(noisy(0.0).iter().filter(|&&factor| factor < 1.0).count() > 50);
    }
}
