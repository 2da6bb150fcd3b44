//! Denoises maps: non-local means (Buades, Coll and Morel 2005) inside of each chart.
//!
//! A texel becomes the mean of the texels around it in the same chart that look alike, by 3 by 3 texels each, and face
//! the same way: `w = exp(-max(0, d² - 2σ²)/h²)`, with `d²` the mean square of relative differences, corrected for the
//! noise that both have, and σ the noise of the chart. No filter reaches into another chart.

use glam::Vec3;
use rayon::prelude::*;

use super::dilate::PageTexels;
use super::noise::{View, sigma};

/// Texels around one that it may be mixed with.
const REACH: i64 = 5;
/// Texels around one that are compared.
const PATCH: i64 = 1;
/// `h` in units of σ.
const STRENGTH: f32 = 0.7;
/// The cosine from which on normals face the same way.
const FACING: f32 = 0.95;

/// Smooths `layers` of a page, guided by the first one; `normals` has those of the texels with light.
pub(crate) fn denoise(grid: &PageTexels, normals: &[Vec3], layers: &mut [Vec<Vec3>], charts: usize) {
    let Some(guide) = layers.first() else { return };
    let brightness: Vec<f32> = guide.iter().map(|value| value.element_sum()).collect();
    let view = View { grid, brightness: &brightness };
    let mut differences = vec![Vec::new(); charts];
    view.differences(&mut differences);
    let noise = differences.iter_mut().map(|differences| sigma(differences)).collect();
    let filter = Filter { view, normals, noise };
    let weights: Vec<Vec<(u32, f32)>> = (0..grid.owners.len() as u32)
        .into_par_iter()
        .map(|texel| if filter.view.is_light(texel) { filter.weights(texel) } else { Vec::new() })
        .collect();
    for layer in layers {
        let before = layer.clone();
        layer.par_iter_mut().zip(&weights).filter(|(_, weights)| !weights.is_empty()).for_each(|(value, weights)| {
            let sum: Vec3 = weights.iter().map(|&(texel, weight)| weight * before[texel as usize]).sum();
            *value = sum / weights.iter().map(|(_, weight)| weight).sum::<f32>();
        });
    }
}

/// A page as the filter sees it.
struct Filter<'a> {
    view: View<'a>,
    normals: &'a [Vec3],
    /// The noise of each chart.
    noise: Vec<f32>,
}

impl Filter<'_> {
    /// The texels that a texel is mixed of.
    fn weights(&self, texel: u32) -> Vec<(u32, f32)> {
        let sigma = self.noise[self.view.grid.owners[texel as usize] as usize];
        if sigma == 0.0 {
            return Vec::new();
        }
        let steps = (-REACH..=REACH).flat_map(|dy| (-REACH..=REACH).map(move |dx| (dx, dy)));
        let weigh = |step| {
            let other = self.view.at(texel, step)?;
            if self.normals[texel as usize].dot(self.normals[other as usize]) < FACING {
                return None;
            }
            let excess = (self.distance(texel, other) - 2.0 * sigma * sigma).max(0.0);
            let weight = (-excess / (STRENGTH * sigma).powi(2)).exp();
            (weight > 1e-3).then_some((other, weight))
        };
        steps.filter_map(weigh).collect()
    }

    /// The mean square of the differences around two texels.
    fn distance(&self, a: u32, b: u32) -> f32 {
        let (mut sum, mut number) = (0.0, 0.0);
        for dy in -PATCH..=PATCH {
            for dx in -PATCH..=PATCH {
                if let (Some(a), Some(b)) = (self.view.at(a, (dx, dy)), self.view.at(b, (dx, dy))) {
                    sum += self.view.difference(a, b).powi(2);
                    number += 1.0;
                }
            }
        }
        sum / number
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bake::finish::dilate::TexelSource;
    use crate::bake::layout::atlas::Page;
    use halfdome_kernel::sampling::Stream;

    /// Two charts side by side, one ten times as bright, with a shadow's edge across both and noise of 5%.
    #[test]
    fn noise_goes_and_edges_and_other_charts_stay() {
        let page = Page { width: 40, height: 40 };
        let owners: Vec<u32> = (0..1600).map(|i| u32::from(i % 40 >= 20)).collect();
        let grid = PageTexels { page, owners, sources: vec![TexelSource::Light; 1600] };
        let truth = |i: usize| (if i % 40 < 20 { 1.0 } else { 10.0 }) * (if i / 40 < 25 { 1.0 } else { 0.3 });
        let noisy = |i: usize| {
            // The sum of four even numbers is nearly normal, with a variance of 1/3.
            let even: f32 = Stream::new(3, i as u32, 0).uniform4(0).iter().sum();
            Vec3::splat(truth(i) * (1.0 + 0.05 * (even - 2.0) * 3f32.sqrt()))
        };
        let mut layers = [(0..1600).map(noisy).collect::<Vec<Vec3>>()];
        let error = |layer: &[Vec3]| {
            let squares = layer.iter().enumerate().map(|(i, value)| (value.x / truth(i) - 1.0).powi(2));
            (squares.sum::<f32>() / 1600.0).sqrt()
        };
        let before = error(&layers[0]);
        denoise(&grid, &vec![Vec3::Z; 1600], &mut layers, 2);
        let after = error(&layers[0]);
        assert!((0.045..0.055).contains(&before) && after < 0.4 * before, "{before} {after}");
        let worst = layers[0].iter().enumerate().map(|(i, value)| (value.x / truth(i) - 1.0).abs()).fold(0.0, f32::max);
        assert!(worst < 0.15, "{worst}: an edge was mixed");
    }
}
