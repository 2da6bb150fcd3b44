//! Bounds on a record's radii.

use glam::Vec3;
use rayon::prelude::*;

use super::cones::Cones;
use super::record::Record;
use crate::settings::{CachedOptions, Metric};

/// Bounds of a record's radii where it lies, in the scene's units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Bounds {
    /// No record reaches less far: more than 0.
    pub(crate) lower: f32,
    /// No record reaches farther: at least `lower`, or infinite.
    pub(crate) upper: f32,
}

/// A channel of irradiance counts as at least this part of the greatest one when gradients are compared with it.
const DARKEST: f32 = 0.1;

/// Bounds the radii of a new record, and the gradient that goes with them (Křivánek et al. 2008, 4.3):
///
/// - by the gradient: `R <= E/|∇_t|` for each channel, beyond which extrapolation would give nothing or less than
///   nothing. It is multiplied by one half, as records are used twice as far as they are placed; by the bounded metric
///   by the error, as it has the other radius;
/// - with the Hessian by half the mean distance of what is seen: a gradient's noise is that of the irradiance over this
///   distance, about, and grows with the way;
/// - by `bounds`; where that makes a radius longer, the gradient becomes as much weaker.
pub(crate) fn bound(record: &mut Record, options: &CachedOptions, bounds: Bounds) {
    let limit = match options.metric {
        Metric::SplitSphere => 0.5 * gradient_radius(record),
        Metric::Bounded => options.error * gradient_radius(record),
        Metric::Hessian => 0.5 * gradient_radius(record).min(record.mean_distance),
    };
    record.radii = record.radii.map(|radius| radius.min(limit));
    let shortest = record.radii[0];
    // `max` and `min` instead of `clamp` make a number of NaN.
    record.radii = record.radii.map(|radius| radius.min(bounds.upper).max(bounds.lower));
    if shortest < bounds.lower {
        let scale = shortest / bounds.lower;
        record.translational = record.translational.map(|gradient| gradient * scale);
    }
}

/// The least `E/|∇_t|` of the channels, infinite without a gradient.
fn gradient_radius(record: &Record) -> f32 {
    let least = record.irradiance.max(Vec3::splat(DARKEST * record.irradiance.max_element()));
    let radii = std::array::from_fn::<f32, 3, _>(|channel| {
        let length = record.translational[channel].length();
        if length > 0.0 { least[channel] / length } else { f32::INFINITY }
    });
    radii.into_iter().fold(f32::INFINITY, f32::min)
}

/// Neighbour clamping (Křivánek et al. 2006): no record may reach farther than a neighbour does by more than `slope`
/// times the distance to it, as what the neighbour sees is at most that much farther away. Gives the factor, at most 1,
/// by which each record's radii are to be multiplied.
///
/// Over the original radii one pass in any order reaches the fixed point: a chain of neighbours is longer than the way
/// itself. The records lie along a curve.
pub(crate) fn neighbour_factors(records: &[Record], slope: f32) -> Vec<f32> {
    let cones = Cones::new(records.iter().map(|record| (record.position, record.radii[0])).collect());
    let factor = |record: &Record| cones.least(record.position, slope, record.radii[0]) / record.radii[0];
    records.par_iter().map(factor).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cache::morton::sort_by_morton_code;
    use crate::cache::record::SECTORS;
    use glam::vec3;
    use halfdome_kernel::sampling::Stream;

    fn record(position: Vec3, radius: f32) -> Record {
        Record {
            key: 0,
            position,
            normal: Vec3::Z,
            irradiance: vec3(2.0, 1.0, 0.001),
            standard_error: 0.0,
            rotational: [Vec3::ZERO; 3],
            translational: [Vec3::ZERO; 3],
            mean_distance: radius,
            min_distance: 0.0,
            radii: [radius, 2.0 * radius],
            axis: Vec3::X,
            occluders: [f32::INFINITY; SECTORS],
            clearance: f32::INFINITY,
        }
    }

    const BOUNDS: Bounds = Bounds { lower: 0.1, upper: 1.5 };

    fn options(metric: Metric) -> CachedOptions {
        CachedOptions { metric, error: 0.3, ..CachedOptions::default() }
    }

    #[test]
    fn radii_are_bounded_and_short_ones_weaken_the_gradient() {
        let bounded = |radius, translational: [Vec3; 3], metric| {
            let mut record = Record { translational, ..record(Vec3::ZERO, radius) };
            bound(&mut record, &options(metric), BOUNDS);
            (record.radii, record.translational)
        };
        let flat = [Vec3::ZERO; 3];
        assert_eq!(bounded(1.0, flat, Metric::Bounded), ([1.0, 1.5], flat));
        assert_eq!(bounded(0.0, flat, Metric::Bounded), ([0.1, 0.1], flat), "not 0/0");
        let steep = [Vec3::X * 4.0, Vec3::ZERO, Vec3::ZERO];
        assert_eq!(bounded(1.0, steep, Metric::Bounded), ([0.15, 0.15], steep), "the error times 2/4");
        assert_eq!(bounded(1.0, steep, Metric::SplitSphere), ([0.25, 0.25], steep), "half of 2/4");
        assert_eq!(bounded(0.05, steep, Metric::SplitSphere), ([0.1, 0.1], steep.map(|gradient| gradient * 0.5)));
        assert_eq!(bounded(0.7, steep, Metric::Hessian), ([0.25, 0.25], steep), "half of 2/4");
        // The dark channel counts as a tenth of the bright one.
        let dark = [Vec3::ZERO, Vec3::ZERO, Vec3::Y * 0.4];
        assert_eq!(bounded(1.0, dark, Metric::Bounded).0, [0.15, 0.15]);
    }

    /// Iterating over pairs until nothing changes, which is what neighbour clamping means, gives the same.
    #[test]
    fn one_pass_reaches_the_fixed_point() {
        let mut records: Vec<Record> = (0..200)
            .map(|i| {
                let [x, y, z, r] = Stream::new(2, i, 0).uniform4(0);
                record(vec3(x, y, 0.1 * z), 0.001 + r * r * r)
            })
            .collect();
        sort_by_morton_code(&mut records, |record| record.position, |record| record.key);
        for slope in [1.0, 0.3] {
            let mut radii: Vec<f32> = records.iter().map(|record| record.radii[0]).collect();
            loop {
                let before = radii.clone();
                for i in 0..records.len() {
                    for j in 0..records.len() {
                        let distance = records[i].position.distance(records[j].position);
                        radii[i] = radii[i].min(radii[j] + slope * distance);
                    }
                }
                if before == radii {
                    break;
                }
            }
            let factors = neighbour_factors(&records, slope);
            assert!(factors.iter().filter(|&&factor| factor < 0.9).count() > 50, "nothing was to clamp");
            for ((factor, radius), record) in factors.iter().zip(radii).zip(&records) {
                assert!((factor * record.radii[0] - radius).abs() < 1e-6);
            }
        }
    }
}
