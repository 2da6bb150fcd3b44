//! Ambient occlusion: how much of the hemisphere over a surface is open, `A = 1/π ∫ V cos θ dω` (Zhukov, Iones and
//! Kronin 1998, the ambient occlusion of Landis 2002).
//!
//! Driscoll first counts the rays that hit nothing, `V = 1` or `0`, and then weights them by the length of the hit, "which
//! definitely improved things": `V = t / t_max` up to the greatest distance. Rays that hit nothing before it count 1
//! either way. The picture is 1 where there is no surface.
//!
//! Deviation: Driscoll's first pictures weight uniform directions alike, without the cosine. Here the choice of directions
//! changes the noise alone.

use glam::Vec3;
use halfdome_kernel::Ray;

use super::{FIRST_SET, RayBatch};
use crate::estimator::Hemisphere;
use crate::settings::{AoOptions, AoWeighting};
use crate::world::{Hit, World};

/// Rays that are traced together.
const BATCH: usize = 16_384;

/// Rays that wait to be traced, and their memory, which the next batch uses again.
#[derive(Default)]
pub(crate) struct AoRays {
    /// The camera ray of each ray, and its value if it hits nothing.
    shares: Vec<(usize, f32)>,
    rays: Vec<Ray>,
    hits: Vec<Hit>,
    occluded: Vec<bool>,
    times: Vec<f32>,
}

/// Writes the ambient occlusion along each camera ray to all channels; gives the number of further rays.
pub(super) fn radiance(
    world: &World,
    options: &AoOptions,
    batch: &RayBatch,
    ao_rays: &mut AoRays,
    radiance: &mut [Vec3],
) -> u64 {
    let hemisphere = Hemisphere::new(options.sampling, options.rays);
    let bounds = world.bounds();
    let t_max = options.max_distance.unwrap_or_else(|| (bounds.max - bounds.min).length());
    let mut traced = 0;
    for (index, (ray, hit)) in batch.rays.iter().zip(batch.hits).enumerate() {
        if !hit.is_hit() {
            radiance[index] = Vec3::ONE;
            continue;
        }
        radiance[index] = Vec3::ZERO;
        let surface = world.surface_at(hit).facing(ray.direction);
        let frame = surface.frame();
        for number in 0..hemisphere.rays() {
            let u = batch.samplers[index].uniform2(FIRST_SET.wrapping_add(number));
            let (local, weight) = hemisphere.direction(number, u);
            let direction = surface.above(frame.to_world(local));
            ao_rays.shares.push((index, weight / hemisphere.rays() as f32));
            ao_rays.rays.push(Ray { t_max, ..Ray::new(surface.origin_towards(direction), direction) });
            if ao_rays.rays.len() == BATCH {
                traced += ao_rays.trace(world, options.weighting, (t_max, batch.times), radiance);
            }
        }
    }
    traced + ao_rays.trace(world, options.weighting, (t_max, batch.times), radiance)
}

impl AoRays {
    /// Adds what each ray counts to its camera ray; gives their number. There are times of all camera rays, or none.
    fn trace(
        &mut self,
        world: &World,
        weighting: AoWeighting,
        (t_max, times): (f32, &[f32]),
        radiance: &mut [Vec3],
    ) -> u64 {
        let traced = self.rays.len();
        self.times.clear();
        if !times.is_empty() {
            self.times.extend(self.shares.iter().map(|(index, _)| times[*index]));
        }
        match weighting {
            AoWeighting::CacheMisses => {
                self.occluded.resize(traced, false);
                world.occluded_many_at(&self.rays, &self.times, &mut self.occluded);
                for ((index, share), occluded) in self.shares.iter().zip(&self.occluded) {
                    radiance[*index] += if *occluded { 0.0 } else { *share };
                }
            }
            AoWeighting::HitLength => {
                self.hits.resize(traced, Hit::MISS);
                world.intersect_many_at(&self.rays, &self.times, &mut self.hits);
                for ((index, share), hit) in self.shares.iter().zip(&self.hits) {
                    radiance[*index] += share * if hit.is_hit() { hit.t / t_max } else { 1.0 };
                }
            }
        }
        self.shares.clear();
        self.rays.clear();
        traced as u64
    }
}
