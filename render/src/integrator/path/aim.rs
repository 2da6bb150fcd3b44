//! Paths that sample secondary lights (see [`aim`]), and continue from there as usual.

use glam::Vec2;
use halfdome_kernel::sampling::unit_double;

use super::Advance;
use crate::estimator::{aim, aimed_weight};
use crate::integrator::path_block::{BlockClosures, LANES, PathBlock};
use crate::integrator::state::Path;
use crate::integrator::wavefront::first_set;
use crate::settings::{LightSampling, Stop};
use crate::world::WHITE;

impl Advance<'_, '_> {
    /// Whether paths aim at secondary lights, and weigh what they find there. A threshold would end the two paths to one
    /// point at different throughputs, and what only one of them finds would be lost.
    #[inline(always)]
    pub(super) fn aims(&self) -> bool {
        let ends_by_chance = !matches!(self.options.stop, Stop::Threshold { .. });
        self.world.lights.lit.has_any() && self.options.lights == LightSampling::Mis && ends_by_chance
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
        let first_set = first_set(self.batch, self.depth);
        for i in (0..block.len).filter(|&i| block.u_aim[i] < chances[i]) {
            let (receiver, chance) = (block.receiver(i), chances[i]);
            let index = block.index(i);
            // What light samples and bounces have left of their sets.
            let [[.., a, b], [.., c, _]] = [0, 1].map(|set| self.batch.samplers[index].uniform4(first_set + set));
            let (surface, numbers) = (block.surface(i, &WHITE), (unit_double(Vec2::new(a, b)), c));
            let Some(aimed) = aim(self.world, &surface, &receiver, numbers) else { continue };
            let (scattered, density) = closures.eval(i, &surface, aimed.ray.direction);
            let density = self.bounce_density(i, aimed.ray.direction, density);
            let throughput = block.throughput(i) * aimed_weight(scattered, aimed.inv_density / chance, density);
            if throughput.max_element() > 0.0 {
                let (normal, target) = (block.packed_normal(i), aimed.prim_id + 1);
                let index = index as u32;
                let path = Path { index, throughput, density: f32::INFINITY, sky_density: 0.0, normal, target };
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
