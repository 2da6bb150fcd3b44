//! A page's charts as a picture: each in its own colour, overlaps in red, gutters darker.

use crate::bake::layout::atlas::{Atlas, NO_CHART};
use crate::bake::layout::check::Check;
use crate::bake::layout::raster::rasterize;
use crate::output::false_color::categorical_hue;
use crate::output::html::OUTSIDE;

/// Overlaps of charts.
const OVERLAP: [u8; 3] = [255, 0, 0];

/// The pixels of a page of `atlas`, 8 bits of red, green and blue each, row by row from the top.
pub fn charts_picture(atlas: &Atlas, check: &Check, page: usize) -> Vec<u8> {
    let size = atlas.pages[page];
    let mut sums = vec![([0.0f64; 3], 0.0f64); size.texels()];
    for part in atlas.parts.iter().filter(|part| part.page == page) {
        for (triangle, &chart) in part.charts.iter().enumerate().filter(|(_, chart)| **chart != NO_CHART) {
            rasterize(part.corners(triangle, size), size.width, size.height, |x, y, piece| {
                let (sum, area) = &mut sums[(y * size.width + x) as usize];
                let covered = piece.area().abs();
                sum.iter_mut().zip(color(chart)).for_each(|(sum, channel)| *sum += covered * f64::from(channel));
                *area += covered;
            });
        }
    }
    let mut pixels: Vec<[u8; 3]> = sums
        .into_iter()
        .map(|(sum, area)| {
            let rest = (1.0 - area).max(0.0);
            let mix = |i: usize| (sum[i] + rest * f64::from(OUTSIDE[i])) / (area + rest);
            [0, 1, 2].map(|i| mix(i).round() as u8)
        })
        .collect();
    check.overlapping_texels[page].iter().for_each(|&texel| pixels[texel as usize] = OVERLAP);
    pixels.concat()
}

/// A colour for a chart, never red, which shows overlaps.
pub(crate) fn color(chart: u32) -> [u8; 3] {
    // Hues from 40 to 320 degrees.
    let hue = categorical_hue(chart) * 280.0 + 40.0;
    let value = [1.0, 0.8, 0.6][chart as usize / 7 % 3];
    [5.0, 3.0, 1.0].map(|shift: f64| {
        let k = (shift + hue / 60.0) % 6.0;
        (255.0 * (value - 0.55 * value * k.min(4.0 - k).clamp(0.0, 1.0))).round() as u8
    })
}
