//! Samples of the sky through openings, for a block's paths.
//!
//! Loops over the paths are inside of those over openings, and become lanes.

use bytemuck::{Pod, Zeroable};
use glam::{Vec2, Vec3};
use halfdome_kernel::Task;
use halfdome_kernel::sampling::ONE_MINUS_EPSILON;

use super::columns::{Column, LANES, Vectors};
use super::{BlockClosures, PathBlock, ShadowRays};
use crate::light::{Openings, SkyPart};
use crate::scene::Material;
use crate::settings::LightSampling;
use crate::world::World;

/// What a block's paths see of the sky through openings.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(super) struct OpeningColumns {
    /// The weights of openings at each path.
    weights: [Column; Openings::MOST],
    /// Their sums; 0 where no opening is seen.
    total: Column,
}

impl OpeningColumns {
    /// The densities of samples in these directions.
    #[inline(always)]
    fn densities(&self, block: &PathBlock, openings: &Openings, directions: &Vectors) -> Column {
        let mut densities = [0.0; LANES];
        for (opening, weights) in self.weights.iter().enumerate().take(openings.count()) {
            for (i, (density, weight)) in densities.iter_mut().zip(weights).enumerate() {
                *density += weight * openings.cone(opening, block.position.get(i)).density(directions.get(i));
            }
        }
        for (density, total) in densities.iter_mut().zip(&self.total) {
            *density = if *total > 0.0 { *density / total } else { 0.0 };
        }
        densities
    }
}

impl PathBlock {
    /// Samples of the sky through openings, beside those of lights and of this part of the sky.
    #[inline(always)]
    pub(in crate::integrator) fn sample_openings<C: BlockClosures>(
        &self,
        closures: &C,
        (world, part): (&World, SkyPart),
        lights: LightSampling,
        matte: &Material,
        shadows: &mut ShadowRays,
    ) {
        world.isa().run(OpeningSamples { world, part, block: self, matte, shadows });
        self.weigh_samples(closures, lights, matte, shadows);
    }
}

/// The directions of such samples, as a task that is compiled for each instruction set.
struct OpeningSamples<'a> {
    world: &'a World,
    part: SkyPart,
    block: &'a PathBlock,
    matte: &'a Material,
    shadows: &'a mut ShadowRays,
}

impl Task for OpeningSamples<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { world, part, block, matte, shadows } = self;
        let sky = &world.lights.sky;
        shadows.lit = [0; LANES];
        let Some(openings) = sky.openings() else { return };
        let mut seen = OpeningColumns::zeroed();
        for i in 0..block.len {
            for (weights, free) in seen.weights.iter_mut().zip(openings.free_at(block.position.get(i))) {
                weights[i] = *free;
            }
        }
        for (opening, weights) in seen.weights.iter_mut().enumerate().take(openings.count()) {
            for (i, (weight, total)) in weights.iter_mut().zip(&mut seen.total).enumerate() {
                let receiver = block.receiver(i);
                *weight *= openings.cone(opening, receiver.position).weight(&receiver);
                *total += *weight;
            }
        }
        // The opening in which a place lies if they lie side by side: the last one that begins before.
        let (mut chosen, mut start, mut end) = ([0_u32; LANES], [0.0_f32; LANES], [0.0_f32; LANES]);
        for (opening, weights) in seen.weights.iter().enumerate().take(openings.count()) {
            for i in 0..LANES {
                let is_here = (block.u_light[i].x * seen.total[i] >= end[i]) & (weights[i] > 0.0);
                chosen[i] = if is_here { opening as u32 } else { chosen[i] };
                start[i] = if is_here { end[i] } else { start[i] };
                end[i] += weights[i];
            }
        }
        for i in 0..LANES {
            let opening = chosen[i] as usize;
            let rest = (block.u_light[i].x * seen.total[i] - start[i]) / seen.weights[opening][i];
            let u = Vec2::new(rest.clamp(0.0, ONE_MINUS_EPSILON), block.u_light[i].y);
            shadows.towards.set(i, openings.cone(opening, block.position.get(i)).direction(u));
        }
        let densities = seen.densities(block, openings, &shadows.towards);
        let mut directions = [Vec3::Y; LANES];
        for (i, direction) in directions.iter_mut().enumerate().take(block.len) {
            if seen.total[i] > 0.0 {
                *direction = shadows.towards.get(i);
            }
        }
        let views = sky.views(&directions);
        for i in (0..block.len).filter(|&i| (block.goes_on[i] != 0) & (seen.total[i] > 0.0)) {
            let (surface, direction) = (block.surface(i, matte), shadows.towards.get(i));
            if !surface.transmits && surface.normal.dot(direction) <= 0.0 {
                continue;
            }
            let (radiance, anywhere) = block.sky_anywhere(world, part, i, &views[i]);
            let inv_density = (densities[i] + anywhere).recip();
            shadows.rays.origin.set(i, surface.origin_towards(direction));
            shadows.rays.direction.set(i, direction);
            shadows.waiting.index[i] = block.paths.index[i];
            shadows.waiting.light.set(i, radiance * inv_density);
            shadows.per_density[i] = inv_density;
            shadows.lit[i] = u32::from(inv_density.is_finite());
        }
    }
}
