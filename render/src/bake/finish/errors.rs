//! An estimate of each texel's relative error for reports, without further rays: the disagreement of the records that
//! the texel is interpolated from, and the noise between neighbours, from second differences around it
//! ([`noise`](super::noise)). The two are added in quadrature. Errors common to all records are not detected.
//!
//! Errors are relative to a texel's irradiance, or to a tenth of the level's mean where that is more: relative errors
//! of black texels are not visible.

use glam::Vec3;
use rayon::prelude::*;

use super::dilate::PageTexels;
use super::noise::{View, sigma};
use crate::bake::layout::texels::Texel;
use crate::cache::Cache;
use crate::integrator::lookup_point;
use crate::world::World;

/// The noise is estimated from texels at most this far away along u and v.
const REACH: i64 = 2;
/// The part of the mean brightness that errors are relative to where it is darker.
const DARK: f64 = 0.1;
/// The least large error.
const LARGE: f32 = 0.05;

/// The errors of all texels with light, in four numbers, each relative.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ErrorSummary {
    /// The root mean square.
    pub root_mean_square: f32,
    /// Half of the texels have less.
    pub median: f32,
    /// 95 of 100 texels have less.
    pub percentile_95: f32,
    /// The part of the texels that have more than 5%.
    pub above_5_percent: f32,
}

impl ErrorSummary {
    /// The summary of a list of errors; zeros if it is empty.
    pub(crate) fn of(mut errors: Vec<f32>) -> Self {
        let Some(last) = errors.len().checked_sub(1) else { return Self::default() };
        errors.sort_unstable_by(f32::total_cmp);
        let squares: f64 = errors.iter().map(|&error| f64::from(error).powi(2)).sum();
        let large = errors.iter().filter(|error| **error > LARGE).count();
        Self {
            root_mean_square: (squares / errors.len() as f64).sqrt() as f32,
            median: errors[last / 2],
            percentile_95: errors[last * 95 / 100],
            above_5_percent: large as f32 / errors.len() as f32,
        }
    }

    /// The summary as text.
    pub fn text(&self) -> String {
        let Self { median, percentile_95, above_5_percent, .. } = self;
        let [median, most, large] = [median, percentile_95, above_5_percent].map(|part| 100.0 * part);
        format!("median {median:.2}%, 95% of texels below {most:.2}%, {large:.1}% of texels above 5%")
    }
}

/// The relative error of each texel with light, page by page; 0 for others. `light` is that of all pages.
pub(crate) fn errors(
    world: &World,
    page_texels: &[PageTexels],
    texels: &[Texel],
    cache: Option<&Cache>,
    light: &[Vec<Vec3>],
) -> Vec<Vec<f32>> {
    let brightness: Vec<Vec<f32>> =
        light.iter().map(|page| page.iter().map(|value| value.element_sum()).collect()).collect();
    let bright = |texel: &Texel| brightness[texel.page as usize][texel.index as usize];
    let mean = texels.iter().map(|texel| f64::from(bright(texel))).sum::<f64>() / texels.len().max(1) as f64;
    let dark = (DARK * mean) as f32;
    let error = |texel: &Texel| {
        let page = texel.page as usize;
        let view = View { grid: &page_texels[page], brightness: &brightness[page] };
        let standard_error = cache.map_or(0.0, |cache| standard_error(world, cache, texel));
        let (bright, scale) = (bright(texel), bright(texel).max(dark));
        let noise = noise_about(&view, texel.index) * bright;
        if scale > 0.0 { noise.hypot(standard_error) / scale } else { 0.0 }
    };
    let found: Vec<f32> = texels.par_iter().map(error).collect();
    let mut errors: Vec<Vec<f32>> = brightness.iter().map(|page| vec![0.0; page.len()]).collect();
    for (texel, error) in texels.iter().zip(found) {
        errors[texel.page as usize][texel.index as usize] = error;
    }
    errors
}

/// The relative noise around a texel.
fn noise_about(view: &View, texel: u32) -> f32 {
    let steps = (-REACH..=REACH).flat_map(|y| (-REACH..=REACH).map(move |x| (x, y)));
    let mut differences: Vec<f32> =
        steps.filter_map(|step| view.at(texel, step)).flat_map(|texel| view.second_differences(texel)).collect();
    sigma(&mut differences)
}

/// The standard error of a texel's brightness by its records.
fn standard_error(world: &World, cache: &Cache, texel: &Texel) -> f32 {
    let surface = world.receiver(texel.point.prim_id, texel.point.barycentric);
    let point = lookup_point(world, &surface);
    let (mut weights, mut sum, mut squares) = (0.0, 0.0, 0.0);
    cache.weigh(&point, |record, weight| {
        let said = cache.records()[record].extrapolate(point.position, point.normal, true, true).element_sum();
        weights += f64::from(weight);
        sum += f64::from(weight * said);
        squares += f64::from(weight * said) * f64::from(said);
    });
    if weights > 0.0 { (squares / weights - (sum / weights).powi(2)).max(0.0).sqrt() as f32 } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_summary_has_the_ranks_and_the_share() {
        let summary = ErrorSummary::of((0..=100).rev().map(|i| 0.001 * i as f32).collect());
        assert!((summary.median - 0.05).abs() < 1e-6 && (summary.percentile_95 - 0.095).abs() < 1e-6);
        assert!((summary.above_5_percent - 50.0 / 101.0).abs() < 1e-6);
        assert!((summary.root_mean_square - (0.335f32 / 100.0).sqrt()).abs() < 1e-5);
        assert_eq!(summary.text(), "median 5.00%, 95% of texels below 9.50%, 49.5% of texels above 5%");
        assert_eq!(ErrorSummary::of(Vec::new()), ErrorSummary::default());
    }
}
