//! Local regression over a record and its neighbours: irradiance around a record as a polynomial of the second degree.
//!
//! A gather is noisy, and its gradient does not include curvature. Its neighbours add information on both: around
//! record i, with x and y along and across its ellipse's axis, `E(x, y) = E + g·(x, y) + ½ (x, y) H (x, y)` is the
//! polynomial that minimizes
//!
//! `Σ_j w_j [ (E(x_j) - E_j)² + (β R_j)² |∇E(x_j) - ∇_t E_j|² ]`,
//!
//! for each channel: local regression (Cleveland 1979), with the gradients as data too. `w_j` is the weight of record j
//! at record i, `E_j` its irradiance turned to the normal of i, and `R_j` the mean distance of its surroundings: `β
//! R_j` is the distance over which a gradient is about as uncertain as irradiance is. It is short, as a gather's
//! gradient depends on the few walls between cells with different radiance; gradients decide where there are too few
//! neighbours. So noise is averaged among neighbours without further rays, and the remaining bias is of the third order
//! in their distance.
//!
//! A polynomial fitted to few neighbours may extrapolate to any value, so it is clamped: each channel stays within the
//! range of the record's own extrapolation there and of the neighbours' values at the record.

use glam::{DVec3, Vec3};
use rayon::prelude::*;

use super::octree::Octree;
use super::record::Record;
use super::weight::Weighting;

/// Irradiance about a record; vectors are of the three channels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Polynomial {
    irradiance: Vec3,
    /// Derivatives along the record's axis and across it.
    slope: [Vec3; 2],
    /// Second derivatives: along, mixed, across.
    curvature: [Vec3; 3],
    /// The least and the most of the irradiance that it was made of.
    range: [Vec3; 2],
}

/// The neighbours used in a record's regression, and the weight of their gradients.
#[derive(Clone, Copy, Debug)]
pub(super) struct Neighbourhood {
    pub(super) weighting: Weighting,
    /// β.
    pub(super) gradient_weight: f32,
}

/// The least of a gradient's weights' roots, so that the equations always have a solution.
const MIN_CERTAINTY: f32 = 1e-3;
/// The penalty on second derivatives, in units of the record's own weight: it decides where there are too few
/// neighbours.
const CURVATURE_COST: f64 = 0.01;

/// The polynomials of all records.
pub(super) fn polynomials(records: &[Record], neighbourhood: &Neighbourhood) -> Vec<Polynomial> {
    let Neighbourhood { weighting, gradient_weight } = neighbourhood;
    let tree = Octree::new(records.iter().map(|record| (record.position, weighting.reach(record))));
    let fit = |(number, record): (usize, &Record)| {
        let mut sums = Sums::new();
        sums.add(record, record, 1.0, *gradient_weight);
        tree.query(record.position, |i| {
            let weight = weighting.weight(&records[i], &record.point());
            if weight > 0.0 && i != number {
                sums.add(record, &records[i], weight, *gradient_weight);
            }
        });
        sums.solve(record)
    };
    records.par_iter().enumerate().map(fit).collect()
}

impl Polynomial {
    /// Irradiance at a point with this normal, where the record is valid. May be negative, where that of the record
    /// alone is.
    #[inline]
    pub(super) fn extrapolate(&self, record: &Record, position: Vec3, normal: Vec3) -> Vec3 {
        let step = position - record.position;
        let (x, y) = (step.dot(record.axis), step.dot(record.normal.cross(record.axis)));
        let [slope_x, slope_y] = self.slope;
        let [xx, xy, yy] = self.curvature;
        let turn = record.normal.cross(normal);
        // Walls are flat, and then the gradient need not be read.
        let turned = match turn == Vec3::ZERO {
            true => Vec3::ZERO,
            false => Vec3::from_array(record.rotational.map(|gradient| gradient.dot(turn))),
        };
        let flat = self.irradiance + x * (slope_x + 0.5 * x * xx + y * xy) + y * (slope_y + 0.5 * y * yy);
        let alone = record.extrapolate(position, record.normal, false, true);
        let [least, most] = self.range;
        flat.max(least.min(alone)).min(most.max(alone)) + turned
    }
}

/// The polynomial's coefficients: 1, x, y, x²/2, xy, y²/2.
const TERMS: usize = 6;

/// The normal equations, and the range of irradiance. Lengths are in units of the record's lesser radius.
struct Sums {
    matrix: [[f64; TERMS]; TERMS],
    right: [DVec3; TERMS],
    range: [Vec3; 2],
}

impl Sums {
    fn new() -> Self {
        let range = [Vec3::INFINITY, Vec3::NEG_INFINITY];
        Self { matrix: Default::default(), right: Default::default(), range }
    }

    /// Adds what `other` says around `record`.
    fn add(&mut self, record: &Record, other: &Record, weight: f32, gradient_weight: f32) {
        let unit = record.radii[0];
        let across = record.normal.cross(record.axis);
        let step = (other.position - record.position) / unit;
        let (x, y) = (f64::from(step.dot(record.axis)), f64::from(step.dot(across)));
        let turn = other.normal.cross(record.normal);
        let along = |vectors: [Vec3; 3], axis: Vec3| Vec3::from_array(vectors.map(|vector| vector.dot(axis)));
        let irradiance = other.irradiance + along(other.rotational, turn);
        self.range = [self.range[0].min(irradiance), self.range[1].max(irradiance)];
        self.add_row([1.0, x, y, 0.5 * x * x, x * y, 0.5 * y * y], irradiance, weight);
        let certainty = (gradient_weight * other.mean_distance / unit).max(MIN_CERTAINTY);
        let weight = weight * certainty * certainty;
        self.add_row([0.0, 1.0, 0.0, x, y, 0.0], along(other.translational, record.axis) * unit, weight);
        self.add_row([0.0, 0.0, 1.0, 0.0, x, y], along(other.translational, across) * unit, weight);
    }

    /// Adds the equation `row · coefficients = value`.
    fn add_row(&mut self, row: [f64; TERMS], value: Vec3, weight: f32) {
        let weight = f64::from(weight);
        for (i, a) in row.into_iter().enumerate().filter(|(_, a)| *a != 0.0) {
            for (sum, b) in self.matrix[i].iter_mut().zip(row) {
                *sum += weight * a * b;
            }
            self.right[i] += weight * a * value.as_dvec3();
        }
    }

    /// The coefficients, by Cholesky's `L D Lᵀ`: the matrix is positive definite.
    fn solve(mut self, record: &Record) -> Polynomial {
        for (i, times) in [(3, 1.0), (4, 2.0), (5, 1.0)] {
            self.matrix[i][i] += times * CURVATURE_COST;
        }
        let Self { mut matrix, right: mut solution, range } = self;
        for pivot in 0..TERMS {
            for row in pivot + 1..TERMS {
                let factor = matrix[row][pivot] / matrix[pivot][pivot];
                let above = matrix[pivot];
                for (value, above) in matrix[row].iter_mut().zip(above).skip(pivot) {
                    *value -= factor * above;
                }
                let eliminated = factor * solution[pivot];
                solution[row] -= eliminated;
            }
        }
        for row in (0..TERMS).rev() {
            for column in row + 1..TERMS {
                let known = matrix[row][column] * solution[column];
                solution[row] -= known;
            }
            solution[row] /= matrix[row][row];
        }
        let inverse = 1.0 / record.radii[0];
        let [irradiance, x, y, xx, xy, yy] = solution.map(DVec3::as_vec3);
        Polynomial {
            irradiance,
            slope: [x, y].map(|slope| slope * inverse),
            curvature: [xx, xy, yy].map(|curvature| curvature * inverse * inverse),
            range,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cache::record::SECTORS;
    use crate::settings::Metric;
    use glam::vec3;
    use halfdome_kernel::sampling::{Frame, Stream};

    /// The radius of the records, which are on average half as far from each other.
    const RADIUS: f32 = 0.4;

    /// Records at random places of the unit square, of irradiance and gradients that `light` gives, on a plane that is
    /// turned in space.
    fn records(light: impl Fn(f32, f32, u32) -> (Vec3, [Vec3; 2])) -> (Vec<Record>, Frame) {
        let frame = Frame::from_normal(vec3(0.3, -0.5, 0.8).normalize());
        let record = |i| {
            let [x, y, angle, _] = Stream::new(8, i, 0).uniform4(0);
            let (irradiance, [along, across]) = light(x, y, i);
            let (sin, cos) = (9.0 * angle).sin_cos();
            Record {
                key: i.into(),
                position: frame.to_world(vec3(x, y, 0.0)),
                normal: frame.normal,
                irradiance,
                standard_error: 0.0,
                rotational: [Vec3::ZERO; 3],
                translational: [0, 1, 2].map(|i| frame.to_world(vec3(along[i], across[i], 0.0))),
                mean_distance: 1.0,
                min_distance: 1.0,
                radii: [RADIUS, 2.0 * RADIUS],
                axis: frame.to_world(vec3(cos, sin, 0.0)),
                occluders: [f32::INFINITY; SECTORS],
                clearance: f32::INFINITY,
            }
        };
        ((0..25).map(record).collect(), frame)
    }

    const NEIGHBOURHOOD: Neighbourhood =
        Neighbourhood { weighting: Weighting::new(Metric::Hessian, 0.3, 2.0), gradient_weight: 0.03 };

    fn quadratic(x: f32, y: f32) -> (Vec3, [Vec3; 2]) {
        let (a, b, c) = (vec3(1.0, 2.0, -1.0), vec3(0.5, -1.0, 0.0), vec3(2.0, 0.0, 1.0));
        let value = Vec3::splat(4.0) + 0.5 * x * x * a + x * y * b + 0.5 * y * y * c + x * b;
        (value, [x * a + y * b + b, x * b + y * c])
    }

    /// The polynomial as it was found.
    fn unlimited(polynomial: &Polynomial) -> Polynomial {
        Polynomial { range: [Vec3::NEG_INFINITY, Vec3::INFINITY], ..*polynomial }
    }

    #[test]
    fn curvature_is_found_from_neighbours() {
        let (records, frame) = records(|x, y, _| quadratic(x, y));
        let polynomials = polynomials(&records, &NEIGHBOURHOOD);
        for (record, polynomial) in records.iter().zip(&polynomials) {
            let local = frame.to_local(record.position);
            for (dx, dy) in [(0.0, 0.0), (RADIUS, 0.0), (0.0, -RADIUS), (-0.3, 0.2)] {
                let exact = quadratic(local.x + dx, local.y + dy).0;
                let position = record.position + frame.to_world(vec3(dx, dy, 0.0));
                let found = unlimited(polynomial).extrapolate(record, position, frame.normal);
                let plain = record.extrapolate(position, frame.normal, true, true);
                let (error, before) = ((found - exact).length(), (plain - exact).length());
                // At the border, where neighbours are few, curvature is penalised.
                let is_inside = (local.truncate() - 0.5).abs().max_element() < 0.5 - 0.5 * RADIUS;
                let (part, rest) = if is_inside { (0.05, 3e-3) } else { (0.15, 0.01) };
                assert!(error <= part * before + rest, "{local}: {error}, by the gradient alone {before}");
            }
        }
    }

    #[test]
    fn neighbours_share_their_noise() {
        let noise = |i| Vec3::from_array([0, 1, 2].map(|channel| Stream::new(9, i, channel).uniform2(0).x - 0.5));
        let (records, frame) =
            records(|_, _, i| (Vec3::ONE + 0.1 * noise(i), [0.1 * noise(i + 99), 0.1 * noise(i + 199)]));
        let mean_square =
            |values: Vec<Vec3>| values.iter().map(|v| (*v - Vec3::ONE).length_squared()).sum::<f32>() / 25.0;
        let polynomials = polynomials(&records, &NEIGHBOURHOOD);
        let pairs = records.iter().zip(&polynomials);
        let after = mean_square(pairs.map(|(r, p)| p.extrapolate(r, r.position, frame.normal)).collect());
        let before = mean_square(records.iter().map(|record| record.irradiance).collect());
        assert!(after < 0.35 * before, "{after}, was {before}");
    }

    /// With few neighbours on one side, the regression stays within their values.
    #[test]
    fn nothing_is_beyond_what_neighbours_say() {
        let noise = |i| Vec3::from_array([0, 1, 2].map(|channel| Stream::new(10, i, channel).uniform2(0).x));
        let (all, frame) = records(|_, _, i| (noise(i), [0.1 * noise(i + 99), 0.1 * noise(i + 199)]));
        let (mut limited, mut exceeded) = (0, 0);
        for few in all.chunks(5) {
            let polynomials = polynomials(few, &NEIGHBOURHOOD);
            let [least, most] = few.iter().fold([Vec3::INFINITY, Vec3::NEG_INFINITY], |[least, most], record| {
                [least.min(record.irradiance), most.max(record.irradiance)]
            });
            for (record, polynomial) in few.iter().zip(&polynomials) {
                for angle in 0..8 {
                    let (sin, cos) = (angle as f32).sin_cos();
                    let position = record.position + frame.to_world(vec3(cos, sin, 0.0) * RADIUS);
                    let alone = record.extrapolate(position, record.normal, true, true);
                    let within = |value: Vec3| {
                        value.cmpge(least.min(alone) - 1e-6).all() && value.cmple(most.max(alone) + 1e-6).all()
                    };
                    let found = polynomial.extrapolate(record, position, frame.normal);
                    assert!(within(found), "{found} is not between {least} and {most}, nor {alone}");
                    exceeded += usize::from(!within(unlimited(polynomial).extrapolate(record, position, frame.normal)));
                    limited += 1;
                }
            }
        }
        assert!(exceeded > limited / 5, "{exceeded} of {limited} needed a limit");
    }

    /// Beyond all neighbours the record's own values hold, and other sides of an edge do not count.
    #[test]
    fn a_record_alone_is_itself() {
        let (all, frame) = records(|x, y, _| quadratic(x, y));
        let mut corner = [all[0], all[1]];
        corner[1].normal = frame.tangent;
        corner[1].axis = frame.bitangent;
        for record in corner {
            let found = polynomials(&corner, &NEIGHBOURHOOD);
            let polynomial = found[usize::from(record.key == corner[1].key)];
            let position = record.position + 0.1 * record.axis;
            let (found, expected) = (
                polynomial.extrapolate(&record, position, record.normal),
                record.extrapolate(position, record.normal, true, true),
            );
            assert!((found - expected).length() < 1e-5, "{found}, not {expected}");
        }
    }
}
