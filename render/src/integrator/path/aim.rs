//! Paths that sample secondary lights (see [`aim`]), and continue from there as usual.

use glam::Vec2;
use halfdome_kernel::sampling::unit_double;
use halfdome_kernel::{Ray, Task};

use super::Advance;
use crate::estimator::{AimedRay, aim, aimed_density, aimed_weight, lit_at};
use crate::integrator::path_block::{BlockClosures, LANES, PathBlock};
use crate::integrator::state::Path;
use crate::integrator::wavefront::first_set;
use crate::integrator::{RayBatch, Wavefront};
use crate::light::PartAt;
use crate::settings::{LightSampling, Stop};
use crate::world::{WHITE, World};

/// The aimed rays of a block's paths, as a task that is compiled for each instruction set.
struct AimedRays<'a> {
    world: &'a World,
    batch: &'a RayBatch<'a>,
    first_set: u32,
    block: &'a PathBlock,
    chances: &'a [f32; LANES],
}

impl Task for AimedRays<'_> {
    type Output = [Option<AimedRay>; LANES];

    #[inline(always)]
    fn run(self) -> Self::Output {
        let Self { world, batch, first_set, block, chances } = self;
        let mut rays = [None; LANES];
        for i in (0..block.len).filter(|&i| block.u_aim[i] < chances[i]) {
            // What light samples and bounces have left of their sets.
            let sampler = &batch.samplers[block.index(i)];
            let [[.., a, b], [.., c, _]] = [0, 1].map(|set| sampler.uniform4(first_set + set));
            let numbers = (unit_double(Vec2::new(a, b)), c);
            rays[i] = aim(world, &block.surface(i, &WHITE), &block.receiver(i), numbers);
        }
        rays
    }
}

/// Finds the paths of a block that have come to secondary lights, and weights what they find there, likewise.
pub(super) struct FindLit<'a> {
    pub world: &'a World,
    pub wave: &'a Wavefront,
    pub block: &'a mut PathBlock,
}

impl Task for FindLit<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { world, wave, block } = self;
        for i in 0..block.len {
            let source = block.source[i] as usize;
            let (path, ray, hit) = (&wave.paths[source], &wave.rays[source], &wave.hits[source]);
            // Aimed paths that have not arrived are lost before.
            let kept = match path.is_aimed() {
                true => Some(1.0),
                false => lit_at(world, ray, hit).map(|at| kept_beside_aimed(world, path, ray, &at)),
            };
            if let Some(kept) = kept {
                block.set_lit(i, kept);
            }
        }
    }
}

/// The part of what a path finds from a secondary light on that is not left to those that were aimed there.
#[inline(always)]
fn kept_beside_aimed(world: &World, path: &Path, ray: &Ray, at: &(PartAt, f32)) -> f32 {
    if path.target != 0 || path.is_first() {
        return 1.0;
    }
    let receiver = path.receiver(ray.origin);
    let density = aimed_density(world, &receiver, ray, at) * world.lights.lit.chance(&receiver);
    LightSampling::Mis.bounce_weight(path.density, density)
}

impl Advance<'_, '_> {
    /// Whether paths aim at secondary lights, and weigh what they find there. A threshold would end the two paths to one
    /// point at different throughputs, and what only one of them finds would be lost. Those that begin where rays of
    /// gathers end are so many that they find large ones.
    #[inline(always)]
    pub(super) fn aims(&self) -> bool {
        let ends_by_chance = !matches!(self.options.stop, Stop::Threshold { .. });
        let are_many = self.batch.density == 0.0;
        let lit = &self.world.lights.lit;
        let pays = lit.has_any() && !(are_many && lit.are_large());
        pays && self.options.lights == LightSampling::Mis && ends_by_chance
    }

    /// Samples secondary lights from the block's surfaces. Such paths continue behind all others.
    #[inline(always)]
    pub(super) fn aim<C: BlockClosures>(&mut self, closures: &C, block: &PathBlock) {
        let mut chances = [0.0; LANES];
        for (i, chance) in chances[..block.len].iter_mut().enumerate() {
            *chance = if block.aims(i) { self.world.lights.lit.chance(&block.receiver(i)) } else { 0.0 };
        }
        self.aim_by(closures, block, &chances);
    }

    /// Aims with a probability from each surface.
    #[inline(never)]
    fn aim_by<C: BlockClosures>(&mut self, closures: &C, block: &PathBlock, chances: &[f32; LANES]) {
        let (world, batch, first_set) = (self.world, self.batch, first_set(self.batch, self.depth));
        let rays = world.isa().run(AimedRays { world, batch, first_set, block, chances });
        for (i, aimed) in rays.into_iter().enumerate() {
            let Some(aimed) = aimed else { continue };
            let (chance, index) = (chances[i], block.index(i));
            let surface = block.surface(i, &WHITE);
            let (scattered, density) = closures.eval(i, &surface, aimed.ray.direction);
            let density = self.bounce_density(i, aimed.ray.direction, density);
            let throughput = block.throughput(i) * aimed_weight(scattered, aimed.inv_density / chance, density);
            if throughput.max_element() > 0.0 {
                let (normal, target) = (block.packed_normal(i), aimed.prim_id + 1);
                let index = index as u32;
                let path = Path { index, throughput, density: f32::INFINITY, sky_probability: 0.0, normal, target };
                self.wave.aimed.push((aimed.ray, path));
                self.learn_aimed(block, i);
                self.keep_media_of_aimed(block, i, aimed.ray.direction);
                if self.recorder.is_some() {
                    self.record_aimed(closures, block, i, aimed.ray.direction);
                }
            }
        }
    }
}
