//! The shadow queue: light samples of all paths of a batch, whose shadow rays are traced together.

use bytemuck::{Pod, Zeroable};
use glam::Vec3;
use halfdome_kernel::{Isa, Ray};

use super::path_block::{LANES, ShadowRays};
use crate::estimator::ShadowRay;
use crate::world::World;

/// Light that arrives if its shadow ray is free.
#[derive(Default)]
pub(crate) struct ShadowQueue {
    /// The number of waiting rays.
    len: usize,
    shadows: Vec<Ray>,
    pending: Vec<PendingLight>,
    occluded: Vec<bool>,
    times: Vec<f32>,
    /// Those that wait for the end of a step.
    deferred: Vec<(Ray, PendingLight)>,
}

/// The contribution, and its camera ray.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
struct PendingLight {
    index: u32,
    light: Vec3,
}

impl ShadowQueue {
    /// Queues a shadow ray whose light has the weight `throughput` for the camera ray `index`.
    #[inline]
    pub(super) fn push(&mut self, index: u32, throughput: Vec3, shadow_ray: ShadowRay) {
        self.make_room(1);
        self.shadows[self.len] = shadow_ray.ray;
        self.pending[self.len] = PendingLight { index, light: throughput * shadow_ray.radiance };
        self.len += 1;
    }

    /// Queues a shadow ray behind all others of a step; gives its place among those.
    pub(super) fn defer(&mut self, index: u32, ray: Ray, light: Vec3) -> usize {
        self.deferred.push((ray, PendingLight { index, light }));
        self.deferred.len() - 1
    }

    /// Queues the deferred rays; gives the number of the first.
    pub(super) fn queue_deferred(&mut self) -> usize {
        let first = self.len;
        self.make_room(self.deferred.len());
        for (ray, pending) in self.deferred.drain(..) {
            (self.shadows[self.len], self.pending[self.len]) = (ray, pending);
            self.len += 1;
        }
        first
    }

    /// Lets the light of the first `count` shadow rays of a block wait, of those that have any.
    #[inline(always)]
    pub(super) fn extend(&mut self, isa: Isa, shadows: &ShadowRays, count: usize) {
        self.make_room(LANES);
        self.len += shadows.keep(isa, count, &mut self.shadows[self.len..], &mut self.pending[self.len..]);
    }

    /// Dims the light of those that wait from this number on.
    pub(super) fn dim(&mut self, first: usize, transmittance: impl Fn(&Ray) -> Vec3) {
        for (ray, pending) in self.shadows[first..self.len].iter().zip(&mut self.pending[first..self.len]) {
            pending.light *= transmittance(ray);
        }
    }

    /// Makes room for `count` more. What was there is not cleared, for it is written over.
    #[inline(always)]
    fn make_room(&mut self, count: usize) {
        if self.shadows.len() < self.len + count {
            self.shadows.resize(2 * self.len + count, Ray::zeroed());
            self.pending.resize(2 * self.len + count, PendingLight::zeroed());
        }
    }

    /// Adds the light whose shadow rays are free; gives their number. There are times of all camera rays, or none.
    pub(super) fn resolve(&mut self, world: &World, times: &[f32], radiance: &mut [Vec3]) -> u64 {
        let count = std::mem::take(&mut self.len);
        self.occluded.resize(count, false);
        self.times.clear();
        if !times.is_empty() {
            self.times.extend(self.pending[..count].iter().map(|pending| times[pending.index as usize]));
        }
        world.occluded_many_at(&self.shadows[..count], &self.times, &mut self.occluded);
        for (PendingLight { index, light }, occluded) in self.pending.iter().zip(&self.occluded) {
            // Adding zero is faster than an unpredictable branch.
            radiance[*index as usize] += if *occluded { Vec3::ZERO } else { *light };
        }
        count as u64
    }

    /// The number of waiting rays.
    pub(super) fn len(&self) -> usize {
        self.len
    }

    /// Whether the shadow ray of this number, of those that were resolved last, is free.
    pub(super) fn is_free(&self, number: usize) -> bool {
        !self.occluded[number]
    }

    /// The shadow rays that wait, with the numbers of their camera rays.
    pub(super) fn waiting(&self) -> impl Iterator<Item = (usize, &Ray)> {
        self.pending[..self.len].iter().map(|pending| pending.index as usize).zip(&self.shadows)
    }
}
