//! Weighted first-order regression of a picture on its features, in every pixel's window.
//!
//! For each pixel `p`, `min Σ_q w(p, q) (c_q - a - b·(f_q - f_p))²` gives a colour `a` and its gradient `b` by the
//! features `f`. Each such model predicts all pixels in its window, and a pixel's value is the weighted mean of the
//! predictions of the models around it: `Σ_p w(p, q) (a_p + b_p·(f_q - f_p)) / Σ_p w(p, q)`.
//!
//! A neighbour whose variance is far above the median around `p` has less weight in the fit, by the ratio of both: the
//! edge of a lamp, or a single bright sample, carries little information about its surroundings.
//!
//! Source: Bitterli, Rousselle, Moon, Iglesias-Guitián, Adler, Mitchell, Jarosz and Novák, "Nonlinearly Weighted
//! First-order Regression for Denoising Monte Carlo Renderings", 2016.
//!
//! Deviation: the weights by variance.

use super::plane::{Extent, Plane};
use super::weights::{TILE, Weights, offsets};

/// The most features.
pub(super) const FEATURES: usize = 9;
/// The features and a constant.
const TERMS: usize = FEATURES + 1;
/// The entries of a symmetric matrix of that size.
const ENTRIES: usize = TERMS * (TERMS + 1) / 2;
/// The part of a feature's own sum of squares that is added to it, so that features that depend on others do no harm.
const RIDGE: f64 = 1e-3;

/// A feature, and a square of it that counts as no difference.
pub(super) struct Feature {
    pub(super) plane: Plane,
    pub(super) noise: f32,
}

/// The inputs of the regression.
pub(super) struct Samples<'a> {
    pub(super) extent: Extent,
    pub(super) color: &'a [Plane; 3],
    pub(super) features: &'a [Feature],
    /// One by the variance of a pixel.
    pub(super) precision: &'a Plane,
    /// The variance up to which a pixel's neighbours count in full.
    pub(super) variance_limit: &'a Plane,
}

/// One row of pixels of a tile.
type Row = [f32; TILE[0]];

/// The models of a tile's pixels: for each colour and term, row by row.
#[derive(Clone)]
pub(super) struct Models {
    values: Vec<[[Row; TERMS]; 3]>,
}

/// Sums over a window for a row of pixels.
struct Moments {
    matrix: [Row; ENTRIES],
    right: [[Row; TERMS]; 3],
}

impl Models {
    pub(super) fn new() -> Self {
        Self { values: vec![[[[0.0; TILE[0]]; TERMS]; 3]; TILE[1]] }
    }

    /// Fits the models of a tile whose first pixel is `(left, top)`.
    #[inline(always)]
    pub(super) fn fit(&mut self, samples: &Samples, weights: &Weights, (left, top): (usize, usize)) {
        let across = TILE[0].min(samples.extent.width - left);
        let down = TILE[1].min(samples.extent.height - top);
        let mut moments = Moments { matrix: [[0.0; TILE[0]]; ENTRIES], right: [[[0.0; TILE[0]]; TERMS]; 3] };
        for y in 0..down {
            moments.gather(samples, weights, (left, top), y, across);
            for x in 0..across {
                let solution = moments.solve(x, samples.features);
                for (color, terms) in solution.iter().enumerate() {
                    terms.iter().enumerate().for_each(|(i, &term)| self.values[y][color][i][x] = term as f32);
                }
            }
        }
    }
}

impl Moments {
    #[inline(always)]
    fn gather(&mut self, samples: &Samples, weights: &Weights, (left, top): (usize, usize), row: usize, across: usize) {
        let terms = samples.features.len() + 1;
        self.matrix.iter_mut().for_each(|sums| sums.fill(0.0));
        self.right.as_flattened_mut().iter_mut().for_each(|sums| sums.fill(0.0));
        let (x, y) = (left as isize, (top + row) as isize);
        let mut difference = [[0.0; TILE[0]]; TERMS];
        difference[0].fill(1.0);
        for (number, (dx, dy)) in offsets().enumerate() {
            let weight = weights.row(number, row);
            if weight.iter().all(|&w| w == 0.0) {
                continue;
            }
            for (difference, feature) in difference[1..].iter_mut().zip(samples.features) {
                let here = feature.plane.row(x, y, across);
                let there = feature.plane.row(x + dx, y + dy, across);
                for i in 0..across {
                    difference[i] = there[i] - here[i];
                }
            }
            let mut share = *weight;
            let precision = samples.precision.row(x + dx, y + dy, across);
            let variance_limit = samples.variance_limit.row(x, y, across);
            for i in 0..across {
                let part = variance_limit[i] * precision[i];
                share[i] *= if part < 1.0 { part } else { 1.0 };
            }
            let mut entry = 0;
            for i in 0..terms {
                let mut weighted = [0.0; TILE[0]];
                for lane in 0..TILE[0] {
                    weighted[lane] = share[lane] * difference[i][lane];
                }
                for other in &difference[..=i] {
                    let sums = &mut self.matrix[entry];
                    for lane in 0..TILE[0] {
                        sums[lane] += weighted[lane] * other[lane];
                    }
                    entry += 1;
                }
                for (right, color) in self.right.iter_mut().zip(samples.color) {
                    let (sums, color) = (&mut right[i], color.row(x + dx, y + dy, across));
                    for lane in 0..across {
                        sums[lane] += weighted[lane] * color[lane];
                    }
                }
            }
        }
    }

    /// The terms for each colour of one pixel, by Cholesky's decomposition.
    fn solve(&self, lane: usize, features: &[Feature]) -> [[f64; TERMS]; 3] {
        let terms = features.len() + 1;
        let mut lower = [[0.0_f64; TERMS]; TERMS];
        let mut entry = 0;
        let count = f64::from(self.matrix[0][lane]);
        for i in 0..terms {
            for j in 0..=i {
                let mut sum = f64::from(self.matrix[entry][lane]);
                if i == j && i > 0 {
                    sum += RIDGE * sum + count * f64::from(features[i - 1].noise) + f64::MIN_POSITIVE;
                }
                sum -= (0..j).map(|k| lower[i][k] * lower[j][k]).sum::<f64>();
                lower[i][j] = if i == j { sum.max(1e-12 * f64::MIN_POSITIVE.sqrt()).sqrt() } else { sum / lower[j][j] };
                entry += 1;
            }
        }
        let mut solution = [[0.0; TERMS]; 3];
        for (right, solution) in self.right.iter().zip(&mut solution) {
            for i in 0..terms {
                let known: f64 = (0..i).map(|k| lower[i][k] * solution[k]).sum();
                solution[i] = (f64::from(right[i][lane]) - known) / lower[i][i];
            }
            for i in (0..terms).rev() {
                let known: f64 = (i + 1..terms).map(|k| lower[k][i] * solution[k]).sum();
                solution[i] = (solution[i] - known) / lower[i][i];
            }
        }
        solution
    }
}

/// The predictions of the models around a tile's pixels, for each colour row by row. `models` gives the models of the
/// tile in a column and a row of tiles.
#[inline(always)]
pub(super) fn predict<'m>(
    samples: &Samples,
    weights: &Weights,
    models: impl Fn(usize, usize) -> &'m Models,
    (left, top): (usize, usize),
) -> Vec<[Row; 3]> {
    let extent = samples.extent;
    let (across, down) = (TILE[0].min(extent.width - left), TILE[1].min(extent.height - top));
    let mut found = vec![[[0.0; TILE[0]]; 3]; down];
    let mut model: [[Row; TERMS]; 3] = [[[0.0; TILE[0]]; TERMS]; 3];
    for (y, found) in found.iter_mut().enumerate() {
        let mut sums = [[0.0; TILE[0]]; 3];
        let mut total = [0.0; TILE[0]];
        for (number, (dx, dy)) in offsets().enumerate() {
            let weight = weights.row(number, y);
            if weight.iter().all(|&w| w == 0.0) {
                continue;
            }
            let row = (top + y) as isize + dy;
            if row < 0 || row >= extent.height as isize {
                continue;
            }
            let (tile_row, in_tile) = (row as usize / TILE[1], row as usize % TILE[1]);
            // The models of a row of pixels that may lie in two tiles.
            let first = (left as isize + dx).max(0) as usize;
            let end = ((left + across) as isize + dx).clamp(0, extent.width as isize) as usize;
            let mut column = first;
            while column < end {
                let stop = end.min((column / TILE[0] + 1) * TILE[0]);
                let source = &models(column / TILE[0], tile_row).values[in_tile];
                let to = (column as isize - left as isize - dx) as usize;
                let from = column % TILE[0];
                for (target, source) in model.as_flattened_mut().iter_mut().zip(source.as_flattened()) {
                    target[to..to + stop - column].copy_from_slice(&source[from..from + stop - column]);
                }
                column = stop;
            }
            let (x, y) = (left as isize, (top + y) as isize);
            let mut values = [model[0][0], model[1][0], model[2][0]];
            for (i, feature) in samples.features.iter().enumerate() {
                let (here, there) = (feature.plane.row(x, y, across), feature.plane.row(x + dx, y + dy, across));
                for (value, model) in values.iter_mut().zip(&model) {
                    let slope = &model[i + 1];
                    for lane in 0..across {
                        value[lane] += slope[lane] * (here[lane] - there[lane]);
                    }
                }
            }
            for (sums, value) in sums.iter_mut().zip(&values) {
                for lane in 0..across {
                    sums[lane] += weight[lane] * value[lane];
                }
            }
            for lane in 0..across {
                total[lane] += weight[lane];
            }
        }
        for (found, sums) in found.iter_mut().zip(&sums) {
            for lane in 0..across {
                // A pixel is always like itself, so the total is at least 1.
                found[lane] = sums[lane] / total[lane];
            }
        }
    }
    found
}
