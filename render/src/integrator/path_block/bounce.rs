//! The next rays of the paths of a block.

use bytemuck::{Pod, Zeroable};
use glam::Vec3;
use halfdome_kernel::{Isa, Ray};

use super::columns::{Integers, LANES, Paths, Rays, keep};
use super::{BlockClosures, Continuations, PathBlock};
use crate::bsdf::Bounce;
use crate::integrator::state::Path;
use crate::scene::Material;

/// Such rays, with their paths.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(in crate::integrator) struct Bounces {
    /// As closures have it, before it becomes rays.
    on: Continuations,
    rays: Rays,
    pub paths: Paths,
    /// Whether the path continues.
    pub goes_on: Integers,
}

impl PathBlock {
    /// Scattered light.
    #[inline(always)]
    pub(in crate::integrator) fn bounce<C: BlockClosures>(
        &self,
        closures: &C,
        matte: &Material,
        bounces: &mut Bounces,
    ) {
        bounces.paths.index = self.paths.index;
        bounces.paths.target = self.target;
        bounces.paths.sky_probability = self.sky_probabilities();
        closures.sample_all(self, matte, &mut bounces.on);
        for i in 0..LANES {
            let (surface, direction) = (self.surface(i, matte), bounces.on.direction.get(i));
            bounces.rays.origin.set(i, surface.origin_towards(direction));
            bounces.rays.direction.set(i, direction);
            let throughput = self.paths.throughput.get(i) * self.survival[i].recip();
            bounces.paths.throughput.set(i, throughput * bounces.on.weight.get(i));
            bounces.paths.density[i] = bounces.on.density[i];
            bounces.paths.normal[i] = self.normal_after(C::SHARES_LIGHTS, i, (direction, bounces.on.density[i]));
            let survives = self.u_roulette[i] < self.survival[i];
            bounces.goes_on[i] = bounces.on.scatters[i] & u32::from(survives) & self.goes_on[i];
        }
    }
}

impl PathBlock {
    /// The [`normal`](Path::normal) of path `i`, which continues in a direction with a density.
    #[inline(always)]
    fn normal_after(&self, shares_lights: bool, i: usize, (direction, density): (Vec3, f32)) -> u32 {
        let (before, is_reflected) =
            ((self.paths.normal[i], self.paths.density[i]), self.normal.get(i).dot(direction) > 0.0);
        Path::normal_after(self.packed[i], before, (density, is_reflected), shares_lights)
    }
}

impl Bounces {
    /// Changes the bounce of path `i`, if it continues.
    pub(super) fn replace<C: BlockClosures>(
        &mut self,
        i: usize,
        block: &PathBlock,
        origin: Vec3,
        (bounce, scatters): (Bounce, bool),
    ) {
        self.rays.origin.set(i, origin);
        self.rays.direction.set(i, bounce.direction);
        self.paths.throughput.set(i, block.throughput(i) / block.survival[i] * bounce.weight);
        self.paths.density[i] = bounce.density;
        self.paths.normal[i] = block.normal_after(C::SHARES_LIGHTS, i, (bounce.direction, bounce.density));
        let survives = block.u_roulette[i] < block.survival[i];
        self.goes_on[i] = u32::from(scatters & survives) & block.goes_on[i];
    }

    /// Rays without an end.
    pub(in crate::integrator) fn new() -> Self {
        let mut bounces = Self::zeroed();
        bounces.rays.t_max = [f32::INFINITY; LANES];
        bounces
    }

    /// The direction of ray `i`.
    pub(in crate::integrator) fn direction(&self, i: usize) -> Vec3 {
        self.rays.direction.get(i)
    }

    /// The density of ray `i`'s direction.
    pub(in crate::integrator) fn density(&self, i: usize) -> f32 {
        self.paths.density[i]
    }

    /// Writes the continuing ones of the first `len` paths to the start of `paths`, and their rays to the start of
    /// `rays`; returns their number.
    #[inline(always)]
    pub(in crate::integrator) fn keep(&self, isa: Isa, len: usize, rays: &mut [Ray], paths: &mut [Path]) -> usize {
        let goes_on = &self.goes_on[..len];
        keep::<8, _, _>(isa, &self.rays, goes_on, rays);
        keep::<8, _, _>(isa, &self.paths, goes_on, paths)
    }
}
