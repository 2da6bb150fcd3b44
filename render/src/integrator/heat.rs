//! The cost of each pixel: the nodes and blocks of the tree that a sample's rays visit. It is a count, not a time, so
//! it is the same on every machine.

use glam::Vec3;

use super::{RayBatch, Wavefront, path};
use crate::settings::PathOptions;
use crate::world::World;

/// Writes the visits of each camera ray and all rays that follow from it to all channels; gives the number of the latter.
pub(super) fn visits(
    world: &World,
    options: &PathOptions,
    batch: &RayBatch,
    wave: &mut Wavefront,
    radiance: &mut [Vec3],
) -> u64 {
    let tree = world.tree();
    let mut visits: Vec<u64> = batch.rays.iter().map(|ray| tree.intersect_visits(ray).total()).collect();
    let mut watch = |wave: &Wavefront| {
        for (index, ray) in wave.indices().zip(&wave.rays) {
            visits[index] += tree.intersect_visits(ray).total();
        }
        for (index, ray) in wave.shadow_queue.waiting() {
            visits[index] += tree.occluded_visits(ray).total();
        }
    };
    let traced = path::radiance(world, options, batch, wave, radiance, &mut watch, path::PathObservers::default());
    for (radiance, visits) in radiance.iter_mut().zip(visits) {
        *radiance = Vec3::splat(visits as f32);
    }
    traced
}
