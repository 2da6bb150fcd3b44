//! Training data of a [guide](crate::guide): the bounces of paths, and the light that they found from there on.

use glam::Vec3;

use super::Advance;
use crate::guide::GuideSample;
use crate::integrator::path_block::{BlockClosures, Bounces, PathBlock, ShadowRays};
use crate::integrator::shadow_queue::ShadowQueue;
use crate::world::WHITE;

/// More is no radiance that a picture could hold.
const MOST_LIGHT: f32 = 1e25;
/// No bounce before.
const NONE: u32 = u32::MAX;

/// The bounces of a batch of paths.
#[derive(Default)]
pub(in crate::integrator) struct Trainer {
    bounces: Vec<Bounced>,
    /// The last bounce of each path.
    last: Vec<u32>,
    /// The last bounces of the continuing paths.
    next: Vec<u32>,
    /// Those of the aimed paths.
    aimed: Vec<u32>,
    waiting: Vec<Waiting>,
    /// Those whose shadow rays are deferred.
    deferred: Vec<Waiting>,
}

/// A bounce.
struct Bounced {
    sample: GuideSample,
    /// The one before it, on the same path.
    before: u32,
    /// The sum of the colour channels of the throughput before.
    throughput: f32,
}

/// A light sample that waits for its shadow ray.
struct Waiting {
    shadow_ray: usize,
    last: u32,
    light: f32,
}

impl Trainer {
    /// Begins with this many paths.
    pub(in crate::integrator) fn start(&mut self, count: usize) {
        self.bounces.clear();
        self.last.clear();
        self.last.resize(count, NONE);
        self.next.clear();
        self.aimed.clear();
        self.waiting.clear();
        self.deferred.clear();
    }

    /// The bounces that have found light, and not so much that sums of it would be infinite.
    pub(in crate::integrator) fn found(&self) -> impl Iterator<Item = GuideSample> {
        let samples = self.bounces.iter().map(|bounced| bounced.sample);
        samples.filter(|sample| sample.light > 0.0 && sample.light < MOST_LIGHT)
    }

    /// Adds light that a path has found after its last bounce to all its bounces.
    fn add(&mut self, mut last: u32, light: f32) {
        while let Some(bounced) = self.bounces.get_mut(last as usize) {
            bounced.sample.light += light / bounced.throughput;
            last = bounced.before;
        }
    }

    /// Replaces all paths by the continuing ones, and lets deferred light samples wait, whose first shadow ray has this
    /// number.
    pub(super) fn keep_next(&mut self, first_deferred: usize) {
        let Self { last, next, aimed, waiting, deferred, .. } = self;
        next.append(aimed);
        std::mem::swap(last, next);
        next.clear();
        waiting.extend(deferred.drain(..).map(|w| Waiting { shadow_ray: first_deferred + w.shadow_ray, ..w }));
    }

    /// A light sample of path `i`, if it has bounced before.
    fn light_sample(&self, block: &PathBlock, i: usize, shadow_ray: usize, light: Vec3) -> Option<Waiting> {
        let last = self.last[block.source[i] as usize];
        (last != NONE).then(|| Waiting { shadow_ray, last, light: light.element_sum() })
    }

    /// Adds the light samples whose shadow rays are free.
    pub(super) fn resolve(&mut self, queue: &ShadowQueue) {
        let mut waiting = std::mem::take(&mut self.waiting);
        for Waiting { shadow_ray, last, light } in waiting.drain(..) {
            if queue.is_free(shadow_ray) {
                self.add(last, light);
            }
        }
        self.waiting = waiting;
    }
}

impl Advance<'_, '_> {
    /// Learns of light that a path has found where it arrived.
    pub(super) fn learn_found(&mut self, source: usize, light: Vec3) {
        if let Some(trainer) = &mut self.trainer {
            let last = trainer.last[source];
            trainer.add(last, light.element_sum());
        }
    }

    /// Learns of the light samples of a block, which are about to join the shadow queue.
    pub(super) fn learn_light_samples(&mut self, block: &PathBlock, shadows: &ShadowRays) {
        let lit = (0..block.len).filter(|&i| shadows.is_lit(i));
        for (shadow_ray, i) in (self.wave.shadow_queue.len()..).zip(lit) {
            if let Some(trainer) = &mut self.trainer {
                let sample = trainer.light_sample(block, i, shadow_ray, shadows.light(i));
                trainer.waiting.extend(sample);
            }
        }
    }

    /// Learns of a light sample of path `i` whose shadow ray is deferred, with its place among those.
    pub(super) fn learn_deferred(&mut self, block: &PathBlock, i: usize, shadow_ray: usize, light: Vec3) {
        if let Some(trainer) = &mut self.trainer {
            let sample = trainer.light_sample(block, i, shadow_ray, light);
            trainer.deferred.extend(sample);
        }
    }

    /// Learns the bounces of a block's paths.
    pub(super) fn learn_bounces<C: BlockClosures>(&mut self, closures: &C, block: &PathBlock, bounces: &Bounces) {
        let Some(trainer) = &mut self.trainer else { return };
        for i in (0..block.len).filter(|&i| bounces.goes_on[i] != 0) {
            let ((position, normal), direction) = (block.place(i), bounces.direction(i));
            let closure_density = match bounces.density(i) {
                f32::INFINITY => f32::INFINITY,
                _ => closures.eval(i, &block.surface(i, &WHITE), direction).1,
            };
            let share = closures.diffuse_share(i);
            let sample = GuideSample { position, normal, direction, light: 0.0, closure_density, share };
            let throughput = block.throughput(i).element_sum() / block.survival(i);
            let before = trainer.last[block.source[i] as usize];
            trainer.next.push(trainer.bounces.len() as u32);
            trainer.bounces.push(Bounced { sample, before, throughput });
        }
    }

    /// Learns that path `i` continues in a direction that its closure has not sampled.
    pub(super) fn learn_aimed(&mut self, block: &PathBlock, i: usize) {
        if let Some(trainer) = &mut self.trainer {
            trainer.aimed.push(trainer.last[block.source[i] as usize]);
        }
    }
}
