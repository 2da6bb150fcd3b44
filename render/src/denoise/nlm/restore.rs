//! Restores the mean that filtering has removed, at the scales at which the residual is significant.
//!
//! Weights that keep single bright samples from their neighbours also keep their light. Where light comes in few bright
//! samples, most of it would be lost: a third at frosted glass with 16 samples a pixel.
//!
//! The residual `q = (noisy - denoised) / s` has a mean of 0 if nothing is lost. Its mean `m` over square cells, from
//! the whole picture down to cells of 16 pixels, each level of what the levels before have left, is taken as lost light
//! as far as it is larger than its standard error: `m max(0, 1 - e²/m²)`. It is interpolated between the centres of
//! cells, and pixels get the sum over levels times their `s`: their brightness, with less for what is brighter than a
//! few times the mean, as lamps lose nothing of their own.
//!
//! A cell that has few bright samples by chance would also have a small standard error; so the variance of a pixel is
//! taken as at least that in the cell of the level before.
//!
//! Source: shrinkage by James and Stein, "Estimation with Quadratic Loss", 1961, at each level of a pyramid.

use super::plane::Extent;
use crate::denoise::channels::Rgb;

/// The side of the smallest cells in pixels: with 256 of them, one bright sample is no trend.
const MIN_CELL: usize = 16;
/// Pixels darker than this part of the mean count as dark.
const FLOOR: f32 = 0.02;
/// A pixel this many times as bright as the mean gets half of the light that its brightness would give it.
const BRIGHT: f32 = 3.0;
/// A pixel keeps this part of its light at least.
const MIN_KEPT: f32 = 0.5;

/// Scales the pixels of `denoised` so that its means over larger areas are those of `noisy`.
pub(super) fn restore(extent: Extent, denoised: &mut Rgb, noisy: &Rgb) {
    let brightness = |i: usize| ((denoised[0][i] + denoised[1][i] + denoised[2][i]) / 3.0).abs();
    let brightness: Vec<f32> = (0..extent.len()).map(brightness).collect();
    let mean = brightness.iter().map(|&value| f64::from(value)).sum::<f64>() / extent.len() as f64;
    let mean = (mean as f32).max(f32::MIN_POSITIVE.sqrt());
    let scale = |i: usize| (brightness[i] + FLOOR * mean) / (1.0 + brightness[i] / (BRIGHT * mean));
    let residual = |i: usize| {
        let difference: f32 = noisy.iter().zip(&*denoised).map(|(noisy, denoised)| noisy[i] - denoised[i]).sum();
        difference / (3.0 * scale(i))
    };
    let residuals: Vec<f32> = (0..extent.len()).map(residual).collect();
    let mut lost = vec![0.0_f32; extent.len()];
    let mut level: Option<Cells> = None;
    let mut side = extent.width.max(extent.height).next_power_of_two();
    loop {
        let cells = Cells::new(extent, side, |i| residuals[i] - lost[i], level.as_ref());
        for (y, row) in lost.chunks_mut(extent.width).enumerate() {
            row.iter_mut().enumerate().for_each(|(x, lost)| *lost += cells.at(x, y));
        }
        level = Some(cells);
        if side <= MIN_CELL {
            break;
        }
        side /= 2;
    }
    // Black pixels stay black.
    let factor = |i: usize| (1.0 + lost[i] * scale(i) / brightness[i].max(FLOOR * FLOOR * mean)).max(MIN_KEPT);
    for values in denoised {
        values.iter_mut().enumerate().for_each(|(i, value)| *value *= factor(i));
    }
}

/// Square cells of pixels, row by row.
struct Cells {
    side: usize,
    across: usize,
    /// The light lost in each, ...
    lost: Vec<f32>,
    /// ... and the variance of a pixel's residual.
    variance: Vec<f64>,
}

impl Cells {
    /// `parents` are the cells twice as large, if there are any.
    fn new(extent: Extent, side: usize, residual: impl Fn(usize) -> f32, parents: Option<&Self>) -> Self {
        let (across, down) = (extent.width.div_ceil(side), extent.height.div_ceil(side));
        let mut sums = vec![[0.0_f64; 3]; across * down];
        for i in 0..extent.len() {
            let sum = &mut sums[i / extent.width / side * across + i % extent.width / side];
            let value = f64::from(residual(i));
            [1.0, value, value * value].iter().zip(sum).for_each(|(term, sum)| *sum += term);
        }
        let (mut lost, mut variance) = (Vec::with_capacity(sums.len()), Vec::with_capacity(sums.len()));
        for (cell, [count, sum, squares]) in sums.into_iter().enumerate() {
            let mean = sum / count;
            let above = parents.map_or(0.0, |up| up.variance[cell / across / 2 * up.across + cell % across / 2]);
            let of_pixel = (squares / count - mean * mean).max(above);
            let of_mean = of_pixel / (count - 1.0).max(1.0);
            lost.push((mean * (1.0 - of_mean / (mean * mean).max(f64::MIN_POSITIVE)).max(0.0)) as f32);
            variance.push(of_pixel);
        }
        Self { side, across, lost, variance }
    }

    /// The light lost at a pixel, linear between the centres of cells.
    fn at(&self, x: usize, y: usize) -> f32 {
        let down = self.lost.len() / self.across;
        let place = |at: usize, cells: usize| {
            let at = ((at as f32 + 0.5) / self.side as f32 - 0.5).clamp(0.0, (cells - 1) as f32);
            let first = at as usize;
            (first, (first + 1).min(cells - 1), at - first as f32)
        };
        let ((left, right, x), (top, bottom, y)) = (place(x, self.across), place(y, down));
        let row = |row: usize| {
            let [a, b] = [left, right].map(|column| self.lost[row * self.across + column]);
            a + x * (b - a)
        };
        let [a, b] = [top, bottom].map(row);
        a + y * (b - a)
    }
}
