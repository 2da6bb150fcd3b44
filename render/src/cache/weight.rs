//! The weight of a record at a point, which is 0 where the record is not valid.
//!
//! With `t` the distance in units of the record's radius, `a` the error, and `c = n·n_i`:
//!
//! - split-sphere (Ward, Rubinstein and Clear 1988): `1/e - 1` with `e = t + sqrt(1 - c)/a`. The shift by 1 takes away
//!   the jump at the end, a cap the pole at the record.
//! - bounded (Tabellion and Lamorlette 2004): the tent `1 - max(t, sqrt(1 - c)/sqrt(1 - cos 10°))`.
//! - Hessian (Schwarzhaupt, Wann Jensen and Jarosz 2012): `(1 - t)(c - cos 10°)/(1 - cos 10°)`.
//!
//! Records are placed where none has a weight, and used with a *stretch*: of 2, so that `e`, `t` and the angles count
//! half (Tabellion and Lamorlette again), or of √2 with the Hessian. So records overlap their neighbours, and points
//! between covered points are covered, too. Where a surface turns by more than these angles within a few pixels, as a
//! thin column does, pictures take records with any normal up to 45° away (`wide`).
//!
//! A record is not used where its surroundings differ from the point's. All these tests are in the record's units: the
//! point must not be above or below the surface that the record and it could share, by the mean of the normals, like
//! Ward's in-front test, here in both directions, which separates shelves; and no occluder of the record may be in
//! between (deviation: Radiance traces a ray, here the record stores the nearest occluder for each sector of azimuth).
//! Nor may the point be higher than the record's nearest hit: a record of a wall behind a poster is not valid on the
//! poster.
//!
//! Radii are at least the distance of texels, even in a gap narrower than a texel, where light differs from outside. So
//! if the clearances of record and point differ much, and that of the point is known, the record is used no farther
//! away than the lesser clearance.

use glam::Vec3;
use halfdome_kernel::sampling::Frame;

use super::record::{LookupPoint, Record};
use crate::estimator::sector;
use crate::settings::Metric;

/// The weighting of records.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Weighting {
    pub(crate) metric: Metric,
    /// Ward's `a`.
    pub(crate) error: f32,
    /// The stretch of radii relative to the placing of records: at least 1.
    pub(crate) stretch: f32,
    /// The stretch of the limit on `1 - c`: at least 1.
    pub(crate) turn: f32,
}

/// `1 - cos 10°`.
const ANGLE: f32 = 0.015_192_247;
/// `1 - cos 45°`.
const WIDE_ANGLE: f32 = 0.292_893_2;
/// The greatest of Ward's weights is the inverse of this, less 1.
const CAP: f32 = 0.1;
/// How far above or below the common surface a point may be, in units of its distance ...
const SLOPE: f32 = 0.1;
/// ... and of the record's reach, for what rounding does to points that are near.
const LEVEL: f32 = 0.01;
/// A clearance below this part of another means that its point is in a gap, and the other is outside.
const HIDDEN: f32 = 0.125;
/// The part of the distance to an occluder up to which a record is used, as occluders may be nearer than rays found
/// them.
const BEFORE: f32 = 0.995;

impl Weighting {
    /// How records are weighted that are used so much farther than they keep others away.
    pub(crate) const fn new(metric: Metric, error: f32, stretch: f32) -> Self {
        Self { metric, error, stretch, turn: stretch * stretch }
    }

    /// The same up to 45° between normals.
    pub(crate) fn wide(self) -> Self {
        Self { turn: WIDE_ANGLE / ANGLE, ..self }
    }

    /// The weight of a record at a point, at least 0.
    #[inline]
    pub(crate) fn weight(&self, record: &Record, point: &LookupPoint) -> f32 {
        let LookupPoint { position, normal, clearance } = *point;
        let turn = (1.0 - normal.dot(record.normal)).max(0.0) / self.turn;
        // Most records that do not count are of another wall. By the split sphere no angle alone is too far.
        if turn >= ANGLE && self.metric != Metric::SplitSphere {
            return 0.0;
        }
        let step = position - record.position;
        let distance = record.relative_distance(step) / self.stretch;
        let weight = match self.metric {
            Metric::SplitSphere => 1.0 / (distance + turn.sqrt() / self.error).max(CAP) - 1.0,
            Metric::Bounded => 1.0 - distance.max((turn / ANGLE).sqrt()),
            Metric::Hessian => (1.0 - distance).max(0.0) * (1.0 - turn / ANGLE),
        };
        // `>` is false for NaN too.
        let is_valid = weight > 0.0
            && shares_surface(record, step, normal)
            && sees(record, step)
            && clearance.is_none_or(|clearance| shares_gap(record, step, clearance));
        if is_valid { weight } else { 0.0 }
    }

    /// The farthest that a record has a weight.
    pub(crate) fn reach(&self, record: &Record) -> f32 {
        self.stretch * record.radii[1]
    }
}

/// Whether a point a `step` away is on the record's level.
#[inline]
fn shares_surface(record: &Record, step: Vec3, normal: Vec3) -> bool {
    let height = 0.5 * step.dot(normal + record.normal);
    height.abs() <= SLOPE * step.length() + LEVEL * record.radii[0] && height <= BEFORE * record.min_distance
}

/// Whether no occluder of the record is between it and a point a `step` away.
#[inline]
fn sees(record: &Record, step: Vec3) -> bool {
    let distance_squared = step.length_squared();
    let certain = BEFORE * record.min_distance;
    if distance_squared <= certain * certain {
        return true;
    }
    let local = Frame::from_normal(record.normal).to_local(step);
    let occluder = BEFORE * record.occluders[sector(local.truncate())];
    distance_squared <= occluder * occluder
}

/// Whether a record and a point with this clearance a `step` away are both in a gap, or both outside, or near each
/// other.
#[inline]
fn shares_gap(record: &Record, step: Vec3, clearance: f32) -> bool {
    let [less, more] = [record.clearance.min(clearance), record.clearance.max(clearance)];
    less >= HIDDEN * more || step.length_squared() <= less * less
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimator::SECTORS;
    use glam::{Vec2, vec3};

    fn record() -> Record {
        Record {
            key: 0,
            position: vec3(1.0, 2.0, 3.0),
            normal: Vec3::Z,
            irradiance: Vec3::ONE,
            standard_error: 0.0,
            rotational: [Vec3::ZERO; 3],
            translational: [Vec3::ZERO; 3],
            mean_distance: 1.0,
            min_distance: 0.1,
            radii: [0.5, 1.0],
            axis: Vec3::X,
            occluders: [f32::INFINITY; SECTORS],
            clearance: f32::INFINITY,
        }
    }

    fn point(position: Vec3, normal: Vec3) -> LookupPoint {
        LookupPoint { position, normal, clearance: None }
    }

    fn weighting(metric: Metric, stretch: f32) -> Weighting {
        Weighting::new(metric, 0.5, stretch)
    }

    #[test]
    fn weights_are_the_published_ones() {
        let at = |metric, stretch, step: Vec3, normal| {
            let record = record();
            weighting(metric, stretch).weight(&record, &point(record.position + step, normal))
        };
        let near = |value: f32, expected: f32| assert!((value - expected).abs() < 1e-5, "{value}, not {expected}");
        // A quarter of the way along the axis, half of it across.
        for step in [vec3(0.25, 0.0, 0.0), vec3(0.0, 0.5, 0.0), vec3(0.0, -0.5, 0.0)] {
            near(at(Metric::SplitSphere, 1.0, step, Vec3::Z), 1.0);
            near(at(Metric::Bounded, 1.0, step, Vec3::Z), 0.5);
            near(at(Metric::Hessian, 1.0, step, Vec3::Z), 0.5);
            near(at(Metric::Bounded, 2.0, step, Vec3::Z), 0.75);
        }
        near(at(Metric::SplitSphere, 1.0, Vec3::ZERO, Vec3::Z), 9.0);
        let tilted = |degrees: f32| vec3(degrees.to_radians().sin(), 0.0, degrees.to_radians().cos());
        // 1 - cos α = 2 sin² α/2.
        let half_angle = |degrees: f32| (degrees / 2.0).to_radians().sin();
        near(at(Metric::Bounded, 1.0, Vec3::ZERO, tilted(4.0)), 1.0 - half_angle(4.0) / half_angle(10.0));
        near(at(Metric::Hessian, 1.0, Vec3::ZERO, tilted(4.0)), 1.0 - (half_angle(4.0) / half_angle(10.0)).powi(2));
        near(at(Metric::SplitSphere, 1.0, Vec3::ZERO, tilted(20.0)), 0.5 / (2f32.sqrt() * half_angle(20.0)) - 1.0);
        assert_eq!(at(Metric::Bounded, 1.0, Vec3::ZERO, tilted(11.0)), 0.0);
        assert!(at(Metric::Bounded, 2.0, Vec3::ZERO, tilted(11.0)) > 0.0);
        for metric in Metric::ALL {
            assert_eq!(at(metric, 1.0, vec3(0.51, 0.0, 0.0), Vec3::Z), 0.0);
            assert_eq!(at(metric, 2.0, vec3(0.0, 2.01, 0.0), Vec3::Z), 0.0);
            assert_eq!(at(metric, 1.0, Vec3::ZERO, Vec3::NEG_Z), 0.0);
            assert_eq!(at(metric, 1.0, Vec3::splat(f32::NAN), Vec3::Z), 0.0);
        }
    }

    /// Whether a record has a weight does not change when the world is scaled.
    #[test]
    fn validity_has_no_unit() {
        for scale in [1e-3, 1.0, 1e3] {
            let mut record = record();
            record.position *= scale;
            record.radii = record.radii.map(|radius| radius * scale);
            record.min_distance *= scale;
            record.occluders[sector(Vec2::Y)] = 0.3 * scale;
            let at = |step: Vec3, normal: Vec3| {
                weighting(Metric::Bounded, 1.0).weight(&record, &point(record.position + step * scale, normal)) > 0.0
            };
            assert!(at(vec3(0.3, 0.0, 0.0), Vec3::Z));
            assert!(at(vec3(0.0, -0.6, 0.0), Vec3::Z), "nothing is in the way");
            assert!(!at(vec3(0.0, 0.6, 0.0), Vec3::Z), "an occluder is between");
            assert!(at(vec3(0.0, 0.25, 0.0), Vec3::Z), "the occluder is behind");
            assert!(!at(vec3(0.3, 0.0, 0.04), Vec3::Z) && !at(vec3(0.3, 0.0, -0.04), Vec3::Z), "another level");
            assert!(at(vec3(0.3, 0.0, 0.02), Vec3::Z) && at(vec3(0.0, 0.0, -0.004), Vec3::Z), "the same level");
        }
    }

    /// A record that something hangs over says nothing of what is above that.
    #[test]
    fn what_hangs_over_a_record_ends_its_level() {
        let record = Record { min_distance: 0.02, ..record() };
        let at = |height: f32| {
            let step = vec3(0.3, 0.0, height);
            weighting(Metric::Bounded, 1.0).weight(&record, &point(record.position + step, Vec3::Z)) > 0.0
        };
        assert!(at(0.0) && at(0.019) && at(-0.03));
        assert!(!at(0.021));
    }

    /// Within a gap and outside of it, records serve each other up to the gap's height.
    #[test]
    fn gaps_share_no_records_with_what_is_outside() {
        let is_valid = |[of_record, of_point]: [f32; 2], step: f32| {
            let record = Record { clearance: of_record, ..record() };
            let point = LookupPoint { clearance: Some(of_point), ..point(record.position + Vec3::X * step, Vec3::Z) };
            weighting(Metric::Bounded, 1.0).weight(&record, &point) > 0.0
        };
        for (one, other) in [(0.05, 0.5), (0.05, f32::INFINITY)] {
            for clearances in [[one, other], [other, one]] {
                assert!(is_valid(clearances, 0.04) && !is_valid(clearances, 0.06), "{clearances:?}");
            }
        }
        for clearances in [[0.05, 0.05], [0.05, 0.3], [f32::INFINITY; 2]] {
            assert!(is_valid(clearances, 0.4), "{clearances:?}");
        }
    }

    /// Along a chord of a sphere the mean of the normals is level: curvature does not exclude a record.
    #[test]
    fn curved_surfaces_share_records() {
        for side in [-1.0, 1.0] {
            let mut record = record();
            record.normal = vec3(0.0, 0.0, side);
            let angle = 8f32.to_radians();
            let (step, normal) =
                (vec3(angle.sin(), 0.0, angle.cos() - 1.0) * 2.0, vec3(angle.sin(), 0.0, angle.cos()) * side);
            assert!(weighting(Metric::Bounded, 1.0).weight(&record, &point(record.position + step, normal)) > 0.0);
        }
    }
}
