//! An estimate of each texel's relative error, for people to look at, of what is known without a ray more: by how much the
//! records that a texel is interpolated from differ in what they say of it, and the noise between neighbours, from second
//! differences around it ([`noise`](super::noise)). The two add up as squares. What all records have wrong alike stays unseen.

use glam::Vec3;
use rayon::prelude::*;

use super::dilate::PageTexels;
use super::noise::{View, sigma};
use super::texels::Texel;
use crate::cache::Cache;
use crate::world::World;

/// Noise is told from texels that are at most so many away along u and v.
const REACH: i64 = 2;

/// The relative error of each texel with light, page by page; 0 for others. `light` is that of all pages.
pub(super) fn errors(
    world: &World,
    page_texels: &[PageTexels],
    texels: &[Texel],
    cache: Option<&Cache>,
    light: &[Vec<Vec3>],
) -> Vec<Vec<f32>> {
    let brightness: Vec<Vec<f32>> =
        light.iter().map(|page| page.iter().map(|value| value.element_sum()).collect()).collect();
    let error = |texel: &Texel| {
        let page = texel.page as usize;
        let view = View { grid: &page_texels[page], brightness: &brightness[page] };
        let standard_error = cache.map_or(0.0, |cache| standard_error(world, cache, texel));
        let bright = brightness[page][texel.index as usize];
        if bright > 0.0 { noise_about(&view, texel.index).hypot(standard_error / bright) } else { 0.0 }
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

/// The standard error of what a texel's records say of its brightness.
fn standard_error(world: &World, cache: &Cache, texel: &Texel) -> f32 {
    let surface = world.receiver(texel.point.prim_id, texel.point.barycentric);
    let (position, normal) = (surface.position, surface.shading_normal);
    let (mut weights, mut sum, mut squares) = (0.0, 0.0, 0.0);
    cache.weigh(position, normal, |record, weight| {
        let said = cache.records()[record].extrapolate(position, normal, true, true).element_sum();
        weights += f64::from(weight);
        sum += f64::from(weight * said);
        squares += f64::from(weight * said) * f64::from(said);
    });
    if weights > 0.0 { (squares / weights - (sum / weights).powi(2)).max(0.0).sqrt() as f32 } else { 0.0 }
}
