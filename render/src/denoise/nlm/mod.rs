//! The built-in denoiser: weighted first-order regression on features, cross-filtered, and not worse than the noisy
//! picture by the estimate from its two halves.
//!
//! A picture comes as the means of two halves of its samples. Each half is regressed on the features ([`regression`])
//! with weights that come from the other half ([`weights`]), so that weights are independent of the noise. This is done
//! for two strengths. [`select`](mod@select) then estimates each result's error, and the noisy picture's own, and
//! blends by them, and [`restore`](mod@restore) restores the mean over larger areas.
//!
//! Sources: Rousselle, Manzi and Zwicker, "Robust Denoising using Feature and Color Information", 2013; Bitterli et
//! al., "Nonlinearly Weighted First-order Regression for Denoising Monte Carlo Renderings", 2016.
//!
//! Deviations: features are not prefiltered, as most have no noise; the noisy picture is a third candidate; the result
//! is not filtered again.

mod plane;
mod regression;
mod restore;
mod select;
mod weights;

use halfdome_kernel::{Isa, Task};
use rayon::prelude::*;

use self::plane::{Extent, PATCH, Plane, WINDOW, blurred};
use self::regression::{FEATURES, Feature, Models, Samples, predict};
use self::weights::{Noisy, TILE, Weights};
use super::DenoiseError;
use super::channels::{Channels, Rgb};
use crate::watch::Watch;

/// How much stronger than noise the difference of patches may be.
const STRENGTHS: [f32; 2] = [0.5, 1.0];
/// Times that a picture is gone over: each strength by each half.
const PASSES: usize = 2 * STRENGTHS.len();

/// A neighbour has its full weight up to this multiple of the median variance.
const OUTLIER_VARIANCE: f32 = 6.0;

/// What is added to variances, by the square of the mean brightness: what is equal to this is equal.
const EPSILON: f32 = 1e-10;

/// Bytes that a pixel takes while it is denoised, about: inputs, planes, results and errors of all passes.
pub(super) const BYTES_PER_PIXEL: u64 = 4 * (6 + 6 + 9 + 3 * PASSES as u64 + 12 + 12);

/// Pixels that [`denoise`] reports.
pub(super) fn work(width: u32, height: u32) -> u64 {
    PASSES as u64 * u64::from(width) * u64::from(height)
}

/// The picture without noise.
pub(super) fn denoise(channels: &Channels, watch: &dyn Watch) -> Result<Rgb, DenoiseError> {
    let extent = Extent { width: channels.width as usize, height: channels.height as usize };
    let halves = channels.halves.as_ref().expect("checked before");
    let input = Input::new(extent, channels, halves);
    let passes: Vec<(usize, f32)> = STRENGTHS.iter().flat_map(|&k| [(0, k), (1, k)]).collect();
    let filtered: Option<Vec<Rgb>> =
        passes.par_iter().map(|&(half, strength)| input.filter(half, strength, watch)).collect();
    let filtered = filtered.ok_or(DenoiseError::Stopped)?;
    let pairs: Vec<[&Rgb; 2]> = filtered.chunks(2).map(|pair| [&pair[0], &pair[1]]).collect();
    let mut blend = select::blend(extent, halves, &channels.color, &pairs);
    restore::restore(extent, &mut blend, &channels.color);
    Ok(blend)
}

/// The inputs of all passes.
struct Input {
    extent: Extent,
    halves: [[Plane; 3]; 2],
    /// The variance of a half.
    variance: [Plane; 3],
    features: Vec<Feature>,
    precision: Plane,
    variance_limit: Plane,
    epsilon: f32,
}

impl Input {
    fn new(extent: Extent, channels: &Channels, halves: &[Rgb; 2]) -> Self {
        let planes = |rgb: &Rgb| rgb.each_ref().map(|values| Plane::new(extent, |i| values[i]));
        let variance = [0, 1, 2]
            .map(|c| variance(extent, &halves[0][c], &halves[1][c], channels.variance.as_ref().map(|v| &*v[c])));
        let total: Vec<f32> = (0..extent.len()).map(|i| variance.iter().map(|values| values[i]).sum()).collect();
        let usual = median(extent, &total);
        let sum: f64 = channels.color.iter().flatten().map(|value| f64::from(value.abs())).sum();
        let mean = (sum / (3 * extent.len()) as f64) as f32;
        Self {
            extent,
            halves: [planes(&halves[0]), planes(&halves[1])],
            variance: variance.map(|values| Plane::new(extent, |i| values[i])),
            features: features(extent, channels),
            precision: Plane::new(extent, |i| 1.0 / total[i].max(f32::MIN_POSITIVE)),
            variance_limit: Plane::new(extent, |i| OUTLIER_VARIANCE * usual[i].max(f32::MIN_POSITIVE)),
            epsilon: EPSILON * mean * mean + f32::MIN_POSITIVE,
        }
    }

    /// One half, filtered with weights by the other; `None` if it was stopped.
    fn filter(&self, half: usize, k: f32, watch: &dyn Watch) -> Option<Rgb> {
        let Extent { width, height } = self.extent;
        let (columns, rows) = (width.div_ceil(TILE[0]), height.div_ceil(TILE[1]));
        let noisy = Noisy { color: &self.halves[1 - half], variance: &self.variance, epsilon: self.epsilon, k };
        let samples = Samples {
            extent: self.extent,
            color: &self.halves[half],
            features: &self.features,
            precision: &self.precision,
            variance_limit: &self.variance_limit,
        };
        let isa = Isa::detect();
        let fit = |row: usize| -> Option<Vec<Models>> {
            let tile = |column: usize| {
                if watch.stop() {
                    return None;
                }
                let (mut models, mut weights) = (Models::new(), Weights::new());
                let place = (column * TILE[0], row * TILE[1]);
                isa.run(Fit { models: &mut models, weights: &mut weights, noisy: &noisy, samples: &samples, place });
                Some(models)
            };
            (0..columns).into_par_iter().map(tile).collect()
        };
        let mut found = [0, 1, 2].map(|_| vec![0.0; self.extent.len()]);
        // A window reaches into the next row of tiles, and not beyond.
        const { assert!(WINDOW <= TILE[1] && WINDOW <= TILE[0]) };
        let mut ring: [Vec<Models>; 3] = [Vec::new(), Vec::new(), fit(0)?];
        for row in 0..rows {
            ring.rotate_left(1);
            ring[2] = if row + 1 < rows { fit(row + 1)? } else { Vec::new() };
            let ring = &ring;
            let tile = |column: usize| {
                let mut weights = Weights::new();
                let place = (column * TILE[0], row * TILE[1]);
                let models = |column: usize, of_row: usize| &ring[of_row + 1 - row][column];
                isa.run(Predict { weights: &mut weights, noisy: &noisy, samples: &samples, models, place })
            };
            if watch.stop() {
                return None;
            }
            let tiles: Vec<_> = (0..columns).into_par_iter().map(tile).collect();
            for (column, tile) in tiles.into_iter().enumerate() {
                let across = TILE[0].min(width - column * TILE[0]);
                for (y, colors) in tile.iter().enumerate() {
                    let start = (row * TILE[1] + y) * width + column * TILE[0];
                    for (found, values) in found.iter_mut().zip(colors) {
                        found[start..start + across].copy_from_slice(&values[..across]);
                    }
                }
            }
            watch.advance((TILE[1].min(height - row * TILE[1]) * width) as u64, 0);
        }
        Some(found)
    }
}

/// The variance of a half's pixels. `sampled` is that of the whole picture's as if samples were independent; the
/// squared differences of the halves say how large it is around, and alone what there is without it.
fn variance(extent: Extent, a: &[f32], b: &[f32], sampled: Option<&[f32]>) -> Vec<f32> {
    let squares: Vec<f32> = a.iter().zip(b).map(|(a, b)| 0.5 * (a - b) * (a - b)).collect();
    let Some(sampled) = sampled else { return blurred(extent, &squares, PATCH) };
    // Relative to brightness, so that one bright pixel does not dominate its surroundings.
    let relative = |values: &[f32]| {
        let scaled = |i: usize| values[i] / (a[i] + b[i]).powi(2).max(f32::MIN_POSITIVE);
        blurred(extent, &(0..extent.len()).map(scaled).collect::<Vec<_>>(), WINDOW)
    };
    let (around, sampled_around) = (relative(&squares), relative(sampled));
    let typical = median(extent, sampled);
    let scaled = |i: usize| {
        let ratio = (around[i] / (2.0 * sampled_around[i]).max(f32::MIN_POSITIVE)).clamp(0.1, 4.0);
        2.0 * ratio * sampled[i].max(typical[i])
    };
    (0..extent.len()).map(scaled).collect()
}

/// The median of the three by three values around each pixel: a robust variance for pixels without bright samples.
fn median(extent: Extent, values: &[f32]) -> Vec<f32> {
    let plane = Plane::new(extent, |i| values[i]);
    let at = |x: usize, y: usize| {
        let mut around = [0.0; 9];
        for (dy, row) in around.chunks_mut(3).enumerate() {
            row.copy_from_slice(plane.row(x as isize - 1, (y + dy) as isize - 1, 3));
        }
        around.sort_unstable_by(f32::total_cmp);
        around[4]
    };
    (0..extent.height).flat_map(|y| (0..extent.width).map(move |x| (x, y))).map(|(x, y)| at(x, y)).collect()
}

/// The features that vary at all.
fn features(extent: Extent, channels: &Channels) -> Vec<Feature> {
    let mut features = Vec::with_capacity(FEATURES);
    // A hundredth of albedos and normals is nothing to speak of; of positions a part of how much they vary.
    let groups = [(&channels.albedo, Some(1e-4)), (&channels.normal, Some(1e-4)), (&channels.position, None)];
    for (group, noise) in groups {
        for values in group.iter().flatten() {
            let mean = values.iter().map(|&v| f64::from(v)).sum::<f64>() / extent.len() as f64;
            let square = values.iter().map(|&v| (f64::from(v) - mean).powi(2)).sum::<f64>() / extent.len() as f64;
            if square > 1e-12 * mean * mean {
                let noise = noise.unwrap_or(1e-7 * square as f32);
                features.push(Feature { plane: Plane::new(extent, |i| values[i]), noise });
            }
        }
    }
    features
}

struct Fit<'a> {
    models: &'a mut Models,
    weights: &'a mut Weights,
    noisy: &'a Noisy<'a>,
    samples: &'a Samples<'a>,
    place: (usize, usize),
}

impl Task for Fit<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        self.weights.find(self.noisy, self.samples.extent, self.place);
        self.models.fit(self.samples, self.weights, self.place);
    }
}

struct Predict<'a, M> {
    weights: &'a mut Weights,
    noisy: &'a Noisy<'a>,
    samples: &'a Samples<'a>,
    models: M,
    place: (usize, usize),
}

impl<'a, M: Fn(usize, usize) -> &'a Models> Task for Predict<'a, M> {
    type Output = Vec<[[f32; TILE[0]]; 3]>;

    #[inline(always)]
    fn run(self) -> Self::Output {
        self.weights.find(self.noisy, self.samples.extent, self.place);
        predict(self.samples, self.weights, self.models, self.place)
    }
}
