//! Paths of a block whose directions are mixed with those of a [`Guide`]: closures are sampled in lanes, and the
//! results are then changed where there is a guide.

use glam::{Vec2, Vec3};
use halfdome_kernel::sampling::ONE_MINUS_EPSILON;
use halfdome_kernel::sampling::warp::{CosineHemisphere, Warp};

use super::{BlockClosures, Bounces, LANES, PathBlock, ShadowRays};
use crate::bsdf::Bounce;
use crate::guide::{Guide, GuideCell};
use crate::integrator::state::survive;
use crate::settings::{LightSampling, Survival};
use crate::world::{Surface, WHITE};

/// The guide of each path.
pub(in crate::integrator) struct GuidedBlock<'a> {
    guide: &'a Guide,
    cells: [GuideCell; LANES],
}

impl<'a> GuidedBlock<'a> {
    pub(in crate::integrator) fn new(guide: &'a Guide) -> Self {
        Self { guide, cells: [GuideCell::NONE; LANES] }
    }

    /// Like [`PathBlock::roulette`], by what the last surface reflects alone: throughputs of guided paths are the smaller,
    /// the more light there is where they go.
    pub(in crate::integrator) fn roulette(&self, block: &mut PathBlock, survival: Survival) {
        for i in 0..block.len {
            // What a guided path has lost says little, as it goes where light is. The root is of a square.
            let reflectance = block.reflectance.get(i);
            let by_chance = match survival {
                Survival::RootThroughput => survive(survival, reflectance * reflectance),
                _ => survive(survival, reflectance),
            };
            block.survival[i] = if block.aims(i) { by_chance } else { 1.0 };
        }
    }

    /// Looks for the cells that the block's surfaces are in.
    #[inline(never)]
    pub(in crate::integrator) fn locate<C: BlockClosures>(&mut self, closures: &C, block: &PathBlock) {
        for i in 0..block.len {
            let (position, normal) = block.place(i);
            let cell = self.guide.cell(position, normal);
            let share = if cell.fraction > 0.0 { closures.diffuse_share(i) } else { 0.0 };
            self.cells[i] = cell.for_share(share);
        }
    }

    /// The density per solid angle of path `i` in a direction with this density of its closure.
    pub(in crate::integrator) fn density(&self, i: usize, direction: Vec3, closure_density: f32) -> f32 {
        let cell = &self.cells[i];
        if cell.fraction == 0.0 {
            return closure_density;
        }
        cell.fraction * self.guide.density(cell, direction) + (1.0 - cell.fraction) * closure_density
    }

    /// Weights light samples by the densities of bounces.
    #[inline(never)]
    pub(in crate::integrator) fn reweigh_lights(
        &self,
        block: &PathBlock,
        lights: LightSampling,
        shadows: &mut ShadowRays,
    ) {
        for i in (0..block.len).filter(|&i| self.cells[i].fraction > 0.0) {
            if shadows.is_lit(i) {
                let direction = shadows.direction(i).normalize();
                shadows.reweigh(i, lights, |density| self.density(i, direction, density));
            }
        }
    }

    /// Resamples the bounces of guided paths.
    #[inline(never)]
    pub(in crate::integrator) fn bounce<C: BlockClosures>(
        &self,
        closures: &C,
        block: &PathBlock,
        bounces: &mut Bounces,
    ) {
        for i in (0..block.len).filter(|&i| self.cells[i].fraction > 0.0) {
            let surface = block.surface(i, &WHITE);
            let bounce = self.sample(closures, i, &surface, block.u_direction[i]);
            bounces.replace::<C>(i, block, surface.origin_towards(bounce.0.direction), bounce);
        }
    }

    /// The bounce of path `i`, and whether the path continues.
    fn sample<C: BlockClosures>(&self, closures: &C, i: usize, surface: &Surface, u: Vec2) -> (Bounce, bool) {
        let cell = &self.cells[i];
        if u.x < cell.fraction {
            let direction = self.guide.sample(cell, Vec2::new(u.x / cell.fraction, u.y));
            let (scattered, density) = closures.eval(i, surface, direction);
            let density = self.density(i, direction, density);
            let weight = scattered / density;
            return (Bounce { direction, weight, density }, weight.max_element() > 0.0);
        }
        let u = Vec2::new(((u.x - cell.fraction) / (1.0 - cell.fraction)).min(ONE_MINUS_EPSILON), u.y);
        let (bounce, scatters) = closures.sample(i, surface, u, CosineHemisphere.map(u));
        if bounce.density == f32::INFINITY {
            return (Bounce { weight: bounce.weight / (1.0 - cell.fraction), ..bounce }, scatters);
        }
        let density = self.density(i, bounce.direction, bounce.density);
        (Bounce { weight: bounce.weight * (bounce.density / density), density, ..bounce }, scatters)
    }
}
