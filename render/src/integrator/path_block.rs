//! A path-state block: what a few paths need to know of their surfaces, in columns, so that plain loops over them, compiled
//! for each instruction set, do as many at once as its registers hold.
//!
//! Whatever is looked up, paths, rays, triangles, materials and lights, lies in records of eight words, which are turned
//! into columns eight at a time; and so are shadow rays and next rays turned into records again. A loop here calls the functions
//! that a single path would call, on surfaces put together from the columns; what they do is inlined and has no branch. So
//! results are equal bit for bit to those of one path at a time, on every instruction set. All lanes are computed, those
//! behind the last path for nothing.
//!
//! What is not the same for all, as textures, mirrors and emission, is *general*: a block says which paths need it, and the
//! integrator shades these one by one (the slow path), and tells the block.

mod bounce;
mod columns;
mod light;

use bytemuck::Zeroable;
use glam::{Vec2, Vec3};
use halfdome_kernel::sampling::Address;
use halfdome_kernel::{Hit, Ray};

use super::state::{Path, survive};
use crate::scene::Material;
use crate::settings::Survival;
use crate::world::{Surface, World, interpolate};

pub(super) use bounce::Bounces;
pub(super) use columns::LANES;
use columns::{Column, Integers, MaterialColumns, Paths, Rays, TriangleColumns, Vectors, gather, triangle};
use light::LightSamples;
pub(super) use light::ShadowRays;

/// Paths that have arrived at a surface each.
#[derive(Clone, Copy, Zeroable)]
pub(super) struct PathBlock {
    /// How many there are.
    pub len: usize,
    /// The place of each in its wavefront.
    pub source: Integers,
    /// Where each has hit which triangle.
    u: Column,
    v: Column,
    prims: Integers,
    rays: Rays,
    paths: Paths,
    triangles: TriangleColumns,
    materials: MaterialColumns,
    /// The surfaces, whose normals face the paths. What they reflect diffusely is in `materials`.
    position: Vectors,
    normal: Vectors,
    shading_normal: Vectors,
    /// The shading normals as receivers have them.
    packed: Integers,
    /// The part of all light that is reflected or let through, at most.
    reflectance: Vectors,
    /// The probability of scattering light, other than as a mirror or glass does.
    scatters: Column,
    /// Whether there is more to a surface than the columns say.
    is_general: Integers,
    /// The probability with which chance lets a path go on.
    survival: Column,
    /// Whether it goes on as far as chance has no say.
    goes_on: Integers,
    pub addresses: [Address; LANES],
    pub u_light: [Vec2; LANES],
    pub u_direction: [Vec2; LANES],
    /// The direction about the normal that `onwards` means by the cosine.
    pub cosine: [Vec3; LANES],
    /// Numbers that decide whether paths go on; 0, with which all do, unless they are drawn.
    pub u_roulette: Column,
    light_samples: LightSamples,
}

impl PathBlock {
    /// No paths.
    pub(super) fn new() -> Self {
        Self::zeroed()
    }

    /// Takes number `source` of the paths, which has hit something, as path `i`.
    #[inline(always)]
    pub(super) fn put(&mut self, i: usize, source: usize, hit: &Hit) {
        let i = i % LANES;
        self.source[i] = source as u32;
        (self.u[i], self.v[i], self.prims[i]) = (hit.u, hit.v, hit.prim_id);
    }

    /// Looks up the paths and where they have arrived.
    #[inline(always)]
    pub(super) fn arrive(&mut self, world: &World, paths: &[Path], rays: &[Ray]) {
        let (isa, len) = (world.isa(), self.len);
        gather::<1, _, _>(isa, paths, &self.source[..len], &mut self.paths);
        gather::<1, _, _>(isa, rays, &self.source[..len], &mut self.rays);
        gather::<2, _, _>(isa, world.triangle_records(), &self.prims[..len], &mut self.triangles);
        gather::<1, _, _>(isa, world.material_records(), &self.triangles.material[..len], &mut self.materials);
        self.scatters = [1.0; LANES];
        self.survival = [1.0; LANES];
        self.goes_on = [1; LANES];
        self.reflectance = self.materials.diffuse;
        for i in 0..LANES {
            let weights = [1.0 - self.u[i] - self.v[i], self.u[i], self.v[i]];
            self.position.set(i, interpolate(triangle(&self.triangles.corners, i), weights));
            let front = self.triangles.normal.get(i);
            let cosine = front.dot(self.rays.direction.get(i));
            let normal = front * if cosine > 0.0 { -1.0 } else { 1.0 };
            self.normal.set(i, normal);
            self.shading_normal.set(i, normal);
            let emits = self.materials.emission.get(i).abs().max_element() > 0.0;
            let is_seen = (self.materials.emits_both_sides[i] != 0) | (cosine < 0.0);
            let is_simple = self.triangles.is_plain[i] & self.materials.is_matte[i];
            self.is_general[i] = u32::from((emits & is_seen) | (is_simple == 0));
        }
    }

    /// Whether there is more to the surface of path `i` than the columns say: it emits, reflects as a mirror, or varies.
    #[inline(always)]
    pub(super) fn is_general(&self, i: usize) -> bool {
        self.is_general[i] != 0
    }

    /// Lets path `i` stand at a surface that is not plain, or not matte.
    pub(super) fn set(&mut self, i: usize, surface: &Surface) {
        self.position.set(i, surface.position);
        self.normal.set(i, surface.normal);
        self.shading_normal.set(i, surface.shading_normal);
        self.materials.diffuse.set(i, surface.diffuse);
        self.reflectance.set(i, surface.reflectance());
        self.scatters[i] = 1.0 - surface.specular_probability();
    }

    /// The surface of path `i`, as far as light is scattered by it.
    #[inline(always)]
    pub(super) fn surface<'w>(&self, i: usize, matte: &'w Material) -> Surface<'w> {
        Surface {
            position: self.position.get(i),
            normal: self.normal.get(i),
            shading_normal: self.shading_normal.get(i),
            diffuse: self.materials.diffuse.get(i),
            emission: Vec3::ZERO,
            offset: self.triangles.offset[i],
            prim_id: 0,
            is_back: false,
            material: matte,
        }
    }

    /// Ends the paths of whose light less than `cutoff` would be reflected, in every channel.
    #[inline(always)]
    pub(super) fn end_below_threshold(&mut self, cutoff: f32) {
        for i in 0..LANES {
            let reflected = self.paths.throughput.get(i) * self.reflectance.get(i);
            self.goes_on[i] = u32::from(reflected.max_element() >= cutoff);
        }
    }

    /// Leaves it to chance which paths go on.
    #[inline(always)]
    pub(super) fn roulette(&mut self, survival: Survival) {
        for i in 0..LANES {
            self.survival[i] = survive(survival, self.paths.throughput.get(i) * self.reflectance.get(i));
        }
    }

    /// The camera ray of path `i` and what it would reflect, if the path has ended.
    #[inline(always)]
    pub(super) fn ended(&self, i: usize) -> Option<(u32, Vec3)> {
        let reflected = self.paths.throughput.get(i) * self.reflectance.get(i);
        (self.goes_on[i] == 0).then_some((self.paths.index[i], reflected))
    }

    /// The camera ray of path `i`.
    #[inline(always)]
    pub(super) fn index(&self, i: usize) -> usize {
        self.paths.index[i] as usize
    }

    /// Whether path `i` is at a mirror or glass.
    #[inline(always)]
    pub(super) fn is_specular(&self, i: usize) -> bool {
        self.scatters[i] < 1.0
    }

    /// Whether any path is.
    #[inline(always)]
    pub(super) fn has_specular(&self) -> bool {
        self.scatters.iter().fold(1.0, |least: f32, &scatters| least.min(scatters)) < 1.0
    }

    /// Whether path `i` survives.
    #[inline(always)]
    pub(super) fn survives(&self, i: usize) -> bool {
        self.goes_on[i] != 0 && self.u_roulette[i] < self.survival[i]
    }

    /// The probability with which chance lets path `i` go on.
    #[inline(always)]
    pub(super) fn survival(&self, i: usize) -> f32 {
        self.survival[i]
    }
}

#[cfg(test)]
mod tests;
