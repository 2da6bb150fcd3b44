//! Selects the best result for each pixel, the noisy picture among them, and blends them.
//!
//! A result comes as two halves `F_A` and `F_B`, which were made of the noisy halves `A` and `B`. As the noise of `B`
//! is independent of that of `A`, the squared error of `F_A` is about `(F_A - B)²` less the variance of `B`, and the
//! error of the mean of both halves is less by the variance that averaging removes:
//!
//! `e = ½ ((F_A - B)² + (F_B - A)²) - ½ (A - B)² - ¼ (F_A - F_B)²`.
//!
//! For the noisy picture itself that is `¼ (A - B)²`. A single pixel's estimate is mostly noise; its mean over many
//! pixels is not. Errors are relative to brightness, and means are over pixels of similar brightness, so that a lamp
//! does not affect the wall behind it.
//!
//! Source: Bitterli et al. 2016, section 5; they average errors by weights of non-local means.

use rayon::prelude::*;

use super::plane::{Extent, blurred};
use crate::denoise::channels::Rgb;

/// How far the window of an error's mean reaches: wide enough for tens of independent pixels.
const ERROR_WINDOW: usize = 6;
/// How far that of choices does, so that there are no borders between them.
const CHOICE_WINDOW: usize = 2;
/// Where both halves are this many times as bright as a result, the result has lost a feature.
const LOST: f32 = 3.0;
/// Pixels whose brightness differs by this part of both together are not alike.
const CONTRAST: f32 = 0.35;

/// The blend of the results, each of two halves, and of the noisy picture.
pub(super) fn blend(extent: Extent, [a, b]: &[Rgb; 2], noisy: &Rgb, results: &[[&Rgb; 2]]) -> Rgb {
    let guide = brightness(extent, noisy, [a, b], results.last().expect("there are results"));
    let mut maps = vec![errors(&guide, [a, b], [a, b])];
    maps.extend(results.iter().map(|result| errors(&guide, [a, b], *result)));
    let best = choices(extent, &guide, &maps);
    let mut blend = [0, 1, 2].map(|_| vec![0.0_f32; extent.len()]);
    for choice in 0..=results.len() {
        let chosen: Vec<f32> = best.iter().map(|&best| f32::from(u8::from(best == choice))).collect();
        let share = blurred(extent, &chosen, CHOICE_WINDOW);
        for (c, blend) in blend.iter_mut().enumerate() {
            for (i, value) in blend.iter_mut().enumerate() {
                *value += share[i]
                    * match choice {
                        0 => noisy[c][i],
                        _ => 0.5 * (results[choice - 1][0][c][i] + results[choice - 1][1][c][i]),
                    };
            }
        }
    }
    blend
}

/// The brightness of each pixel in a result, or what both halves have at least, if the result has lost it; with a floor
/// by the whole picture's, below which all is dark.
fn brightness(extent: Extent, noisy: &Rgb, [a, b]: [&Rgb; 2], [fa, fb]: &[&Rgb; 2]) -> Vec<f32> {
    let sum = noisy.iter().flatten().map(|&value| f64::from(value.abs())).sum::<f64>();
    let floor = (0.02 * (sum / (3 * extent.len()) as f64) as f32).max(f32::MIN_POSITIVE.sqrt());
    let mean = |rgb: &Rgb, i: usize| (rgb[0][i] + rgb[1][i] + rgb[2][i]) / 3.0;
    let result = |i: usize| (0.5 * (mean(fa, i) + mean(fb, i))).abs();
    let both = |i: usize| mean(a, i).min(mean(b, i));
    let seen = |i: usize| if both(i) > LOST * (result(i) + floor) { both(i) } else { result(i) };
    (0..extent.len()).map(|i| seen(i) + floor).collect()
}

/// Each pixel's relative squared error, estimated from itself alone.
fn errors(guide: &[f32], [a, b]: [&Rgb; 2], [fa, fb]: [&Rgb; 2]) -> Vec<f32> {
    let error = |i: usize| {
        let of_color = |c: usize| {
            let (a, b, fa, fb) = (a[c][i], b[c][i], fa[c][i], fb[c][i]);
            let square = |x: f32| x * x;
            0.5 * (square(fa - b) + square(fb - a)) - 0.5 * square(a - b) - 0.25 * square(fa - fb)
        };
        (of_color(0) + of_color(1) + of_color(2)) / (guide[i] * guide[i])
    };
    (0..guide.len()).map(error).collect()
}

/// The index, for each pixel, of the map with the least errors around it; the first of equal ones.
fn choices(extent: Extent, guide: &[f32], maps: &[Vec<f32>]) -> Vec<usize> {
    let Extent { width, height } = extent;
    let choose = |pixel: usize| {
        let (x, y) = (pixel % width, pixel / width);
        let range = |at: usize, end: usize| at.saturating_sub(ERROR_WINDOW)..(at + ERROR_WINDOW + 1).min(end);
        let mut sums = [0.0_f64; 8];
        let sums = &mut sums[..maps.len()];
        for row in range(y, height) {
            for i in range(x, width).map(|column| row * width + column) {
                let contrast = (guide[i] - guide[pixel]) / (CONTRAST * (guide[i] + guide[pixel]));
                let weight = 1.0 - contrast * contrast;
                if weight > 0.0 {
                    sums.iter_mut().zip(maps).for_each(|(sum, map)| *sum += f64::from(weight * weight * map[i]));
                }
            }
        }
        (1..maps.len()).fold(0, |best, number| if sums[number] < sums[best] { number } else { best })
    };
    (0..extent.len()).into_par_iter().map(choose).collect()
}
