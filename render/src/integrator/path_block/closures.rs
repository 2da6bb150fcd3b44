//! The closures of a block's surfaces, all of one kind: Lambert's and glossy ones are computed in lanes, the others one
//! by one.

use bytemuck::{Pod, Zeroable};
use glam::{Vec2, Vec3};
use halfdome_kernel::Isa;

use super::columns::{Column, Integers, Vectors};
use super::{LANES, PathBlock};
use crate::bsdf::{Bounce, Scattering};
use crate::material::Prepared;
use crate::scene::Material;
use crate::world::{Surface, World};

/// The albedos of a block's closures.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(in crate::integrator) struct Scattered {
    /// `f cos θ`.
    pub f_cos: Vectors,
    /// The density per solid angle of bounces in this direction.
    pub density: Column,
}

/// The bounces of a block's paths.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(in crate::integrator) struct Continuations {
    pub direction: Vectors,
    pub weight: Vectors,
    pub density: Column,
    /// Whether they do.
    pub scatters: Integers,
}

/// The closures of a block's surfaces.
pub(in crate::integrator) trait BlockClosures {
    /// Whether the block itself knows all of closures whose surfaces are not general.
    const IN_LANES: bool;

    /// Whether light samples leave a part of punctual lights of a size to bounces. What scatters widely finds them worse by these.
    const SHARES_LIGHTS: bool = true;

    /// Forgets those of the block before.
    fn clear(&mut self);

    /// Takes the closure of the next path's surface, whose normals face the viewer, and passes the surface the data
    /// that it needs. Returns the albedo.
    fn arrive(&mut self, world: &World, surface: &mut Surface) -> Vec3;

    /// Called after the closures of all paths are taken.
    fn arrived(&mut self, _isa: Isa) {}

    /// `f cos θ` of path `i` for light from a unit vector, and the density per solid angle with which it is sampled.
    fn eval(&self, i: usize, surface: &Surface, direction: Vec3) -> (Vec3, f32);

    /// The part of `f cos θ` that is that of glossy lobes.
    fn glossy(&self, i: usize, direction: Vec3) -> Vec3;

    /// The part of all scattered light that is reflected diffusely, 0 to 1.
    fn diffuse_share(&self, i: usize) -> f32;

    /// The bounce of path `i`, and whether the path continues; `cosine` is the direction about the normal that `u`
    /// means by the cosine.
    fn sample(&self, i: usize, surface: &Surface, u: Vec2, cosine: Vec3) -> (Bounce, bool);

    /// [`eval`](Self::eval) of all paths, of light from a direction each.
    #[inline(always)]
    fn eval_all(&self, block: &PathBlock, matte: &Material, directions: &Vectors, scattered: &mut Scattered) {
        for i in 0..block.len {
            let (f_cos, density) = self.eval(i, &block.surface(i, matte), directions.get(i));
            scattered.f_cos.set(i, f_cos);
            scattered.density[i] = density;
        }
    }

    /// [`sample`](Self::sample) of all paths, by the block's numbers.
    #[inline(always)]
    fn sample_all(&self, block: &PathBlock, matte: &Material, on: &mut Continuations) {
        for i in 0..block.len {
            let surface = block.surface(i, matte);
            let (bounce, scatters) = self.sample(i, &surface, block.u_direction[i], block.cosine[i]);
            on.direction.set(i, bounce.direction);
            on.weight.set(i, bounce.weight);
            on.density[i] = bounce.density;
            on.scatters[i] = u32::from(scatters);
        }
    }
}

/// Diffuse reflection, of which the block itself knows all.
#[derive(Default)]
pub(in crate::integrator) struct Lambert;

impl BlockClosures for Lambert {
    const IN_LANES: bool = true;
    const SHARES_LIGHTS: bool = false;

    fn clear(&mut self) {}

    #[inline(always)]
    fn arrive(&mut self, _: &World, surface: &mut Surface) -> Vec3 {
        surface.bend();
        surface.diffuse
    }

    #[inline(always)]
    fn eval(&self, _: usize, surface: &Surface, direction: Vec3) -> (Vec3, f32) {
        let lambert = surface.lambert(direction);
        (surface.diffuse * lambert * surface.bump_shadowing(direction), lambert)
    }

    fn glossy(&self, _: usize, _: Vec3) -> Vec3 {
        Vec3::ZERO
    }

    fn diffuse_share(&self, _: usize) -> f32 {
        1.0
    }

    #[inline(always)]
    fn sample(&self, _: usize, surface: &Surface, _: Vec2, cosine: Vec3) -> (Bounce, bool) {
        let (bounce, scatters) = surface.scatter(cosine);
        (Bounce { weight: bounce.weight * surface.bump_shadowing(bounce.direction), ..bounce }, scatters)
    }

    #[inline(always)]
    fn eval_all(&self, block: &PathBlock, matte: &Material, directions: &Vectors, scattered: &mut Scattered) {
        for i in 0..LANES {
            let surface = block.surface(i, matte);
            let lambert = surface.lambert(directions.get(i));
            scattered.f_cos.set(i, surface.diffuse * lambert);
            scattered.density[i] = lambert;
        }
        block.apply_bump_shadowing(matte, directions, &mut scattered.f_cos);
    }

    #[inline(always)]
    fn sample_all(&self, block: &PathBlock, matte: &Material, on: &mut Continuations) {
        for i in 0..LANES {
            let (bounce, scatters) = block.surface(i, matte).scatter(block.cosine[i]);
            on.direction.set(i, bounce.direction);
            on.weight.set(i, bounce.weight);
            on.density[i] = bounce.density;
            on.scatters[i] = u32::from(scatters);
        }
        block.apply_bump_shadowing(matte, &on.direction, &mut on.weight);
    }
}

/// Closures of one type.
pub(in crate::integrator) struct Closures<B>(Vec<Scattering<B>>);

impl<B> Default for Closures<B> {
    fn default() -> Self {
        Self(Vec::with_capacity(LANES))
    }
}

impl<B> Closures<B> {
    pub(super) fn iter(&self) -> std::slice::Iter<'_, Scattering<B>> {
        self.0.iter()
    }

    pub(super) fn push(&mut self, scattering: Scattering<B>) {
        self.0.push(scattering);
    }
}

impl<B: Prepared> BlockClosures for Closures<B> {
    const IN_LANES: bool = false;

    fn clear(&mut self) {
        self.0.clear();
    }

    #[inline]
    fn arrive(&mut self, world: &World, surface: &mut Surface) -> Vec3 {
        let scattering = Scattering::new(surface, world.closure::<B>(surface));
        surface.transmits = scattering.transmits();
        let albedo = scattering.albedo();
        self.0.push(scattering);
        albedo
    }

    #[inline]
    fn eval(&self, i: usize, _: &Surface, direction: Vec3) -> (Vec3, f32) {
        self.0[i].eval(direction)
    }

    fn glossy(&self, i: usize, direction: Vec3) -> Vec3 {
        self.0[i].glossy(direction)
    }

    fn diffuse_share(&self, i: usize) -> f32 {
        let [diffuse, all] = [self.0[i].diffuse_albedo(), self.0[i].albedo()].map(Vec3::element_sum);
        if all > 0.0 { (diffuse / all).clamp(0.0, 1.0) } else { 0.0 }
    }

    #[inline]
    fn sample(&self, i: usize, _: &Surface, u: Vec2, _: Vec3) -> (Bounce, bool) {
        match self.0[i].sample(u) {
            Some(bounce) => (bounce, bounce.weight.max_element() > 0.0),
            None => (Bounce::NONE, false),
        }
    }
}
