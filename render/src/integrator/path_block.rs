//! A path-state block: the surface data of a few paths in columns, so that plain loops over them are vectorised for
//! each instruction set.
//!
//! All looked-up data (paths, rays, triangles, materials and lights) is in records of eight words, which are transposed
//! into columns eight at a time; shadow rays and next rays are transposed back into records. A loop here calls the
//! functions of a single path on surfaces assembled from the columns; these are inlined and have no branch. So results
//! equal those of one path at a time bit for bit, on every instruction set. All lanes are computed, even those after
//! the last path.
//!
//! Surfaces with textures, emission and the like are *general*: a block marks the paths that hit them, and the
//! integrator shades these one by one (the slow path) and passes the results to the block.

mod bounce;
mod closures;
mod columns;
mod glossy;
mod guided;
mod light;
mod openings;

use bytemuck::Zeroable;
use glam::{Vec2, Vec3};
use halfdome_kernel::Ray;
use halfdome_kernel::sampling::SampleId;

use super::state::{Path, survive};
use crate::scene::Material;
use crate::settings::Survival;
use crate::world::{Boundary, Hit, InputChange, Surface, TerminatorOffset, World, interpolate};

pub(super) use bounce::Bounces;
pub(super) use closures::{BlockClosures, Closures, Lambert};
use closures::{Continuations, Scattered};
pub(super) use columns::LANES;
use columns::{
    Column, InstanceColumns, Integers, MaterialColumns, Paths, Rays, TriangleColumns, Vectors, gather, triangle,
};
pub(super) use glossy::GlossyLanes;
pub(super) use guided::GuidedBlock;
use light::LightSamples;
pub(super) use light::{ShadowRays, clamp};

/// Paths that have arrived at a surface each.
#[derive(Clone, Copy, Zeroable)]
pub(super) struct PathBlock {
    /// How many there are.
    pub len: usize,
    /// The place of each in its wavefront.
    pub source: Integers,
    /// The hit of each path.
    u: Column,
    v: Column,
    prims: Integers,
    instances: Integers,
    /// When.
    time: Column,
    rays: Rays,
    paths: Paths,
    triangles: TriangleColumns,
    materials: MaterialColumns,
    /// The surfaces, whose normals face the paths. What they reflect diffusely is in `materials`.
    position: Vectors,
    normal: Vectors,
    shading_normal: Vectors,
    smooth_normal: Vectors,
    /// Whether a map tilts any of them from the smooth ones.
    has_bumps: u32,
    /// The shading normals as receivers have them, and whether light from behind counts there.
    packed: Integers,
    receiving: Vectors,
    behind: Column,
    /// The part of all light that is reflected or let through, at most.
    reflectance: Vectors,
    /// Whether light from behind counts too.
    transmits: Integers,
    /// Whether there is more to a surface than the columns say.
    is_general: Integers,
    /// The survival probability of a path.
    survival: Column,
    /// Whether it continues, apart from Russian roulette.
    goes_on: Integers,
    pub addresses: [SampleId; LANES],
    pub u_light: [Vec2; LANES],
    pub u_direction: [Vec2; LANES],
    /// The direction about the normal that `onwards` means by the cosine.
    pub cosine: [Vec3; LANES],
    /// Random numbers for Russian roulette; 0, with which all paths survive, unless they are drawn.
    pub u_roulette: Column,
    /// Numbers that decide whether paths aim at secondary lights, if there are any.
    pub u_aim: Column,
    light_samples: LightSamples,
    /// The `target` of paths that leave: 0, or of secondary lights [`Path::UNAIMED`].
    target: Integers,
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
        (self.u[i], self.v[i], self.prims[i], self.instances[i]) = (hit.u, hit.v, hit.prim_id, hit.instance);
        self.time[i] = hit.time;
    }

    /// Looks up the paths and where they have arrived, as far as surfaces are plain and matte.
    #[inline(always)]
    pub(super) fn arrive(&mut self, world: &World, paths: &[Path], rays: &[Ray]) {
        let (isa, len) = (world.isa(), self.len);
        gather::<1, _, _>(isa, paths, &self.source[..len], &mut self.paths);
        gather::<1, _, _>(isa, rays, &self.source[..len], &mut self.rays);
        gather::<2, _, _>(isa, world.triangle_records(), &self.prims[..len], &mut self.triangles);
        if let Some(records) = world.instance_records() {
            let mut instances = InstanceColumns::zeroed();
            gather::<2, _, _>(isa, records, &self.instances[..len], &mut instances);
            self.triangles.place(&instances);
        }
        gather::<1, _, _>(isa, world.material_records(), &self.triangles.material[..len], &mut self.materials);
        self.transmits = [0; LANES];
        self.survival = [1.0; LANES];
        self.goes_on = [1; LANES];
        self.has_bumps = 0;
        self.target = [0; LANES];
        self.reflectance = self.materials.diffuse;
        for i in 0..LANES {
            let weights = [1.0 - self.u[i] - self.v[i], self.u[i], self.v[i]];
            self.position.set(i, interpolate(triangle(&self.triangles.corners, i), weights));
            let front = self.triangles.normal.get(i);
            let cosine = front.dot(self.rays.direction.get(i));
            let normal = front * if cosine > 0.0 { -1.0 } else { 1.0 };
            self.normal.set(i, normal);
            self.shading_normal.set(i, normal);
            self.smooth_normal.set(i, normal);
            let emits = self.materials.emission.get(i).abs().max_element() > 0.0;
            let is_seen = (self.materials.emits_both_sides[i] != 0) | (cosine < 0.0);
            self.is_general[i] = u32::from((emits & is_seen) | (self.triangles.is_plain[i] == 0));
        }
    }

    /// Whether there is more to the surface of path `i`, if it is matte, than the columns say: it emits, or varies.
    #[inline(always)]
    pub(super) fn is_general(&self, i: usize) -> bool {
        self.is_general[i] != 0
    }

    /// Puts path `i` at a surface with this albedo.
    pub(super) fn set(&mut self, i: usize, surface: &Surface, albedo: Vec3) {
        self.position.set(i, surface.position);
        self.triangles.offset[i] = surface.offset;
        self.normal.set(i, surface.normal);
        self.shading_normal.set(i, surface.shading_normal);
        self.smooth_normal.set(i, surface.smooth_normal);
        self.has_bumps |= u32::from(surface.shading_normal != surface.smooth_normal);
        self.materials.diffuse.set(i, surface.diffuse);
        self.reflectance.set(i, albedo);
        self.transmits[i] = surface.transmits.into();
    }

    /// The boundary that path `i` has arrived at.
    pub(super) fn boundary(&self, i: usize) -> Boundary {
        let is_back = self.triangles.normal.get(i).dot(self.rays.direction.get(i)) > 0.0;
        Boundary { material: self.triangles.material[i], normal: self.normal.get(i), is_back }
    }

    /// Leaves this part of the light that path `i` finds.
    pub(super) fn dim(&mut self, i: usize, part: Vec3) {
        self.paths.throughput.set(i, self.paths.throughput.get(i) * part);
    }

    /// Puts path `i` at a secondary light, with this weight on the light that it finds from there on.
    pub(super) fn set_lit(&mut self, i: usize, kept: f32) {
        self.target[i] = Path::UNAIMED;
        self.dim(i, Vec3::splat(kept));
    }

    /// Whether the surface of path `i` aims at secondary lights: all but those do.
    #[inline(always)]
    pub(super) fn aims(&self, i: usize) -> bool {
        self.target[i] == 0
    }

    /// The normal of path `i`'s surface, packed as receivers have it.
    pub(super) fn packed_normal(&self, i: usize) -> u32 {
        self.packed[i]
    }

    /// The surface of path `i`, as far as light is scattered by it.
    #[inline(always)]
    pub(super) fn surface<'w>(&self, i: usize, matte: &'w Material) -> Surface<'w> {
        Surface {
            position: self.position.get(i),
            normal: self.normal.get(i),
            smooth_normal: self.smooth_normal.get(i),
            shading_normal: self.shading_normal.get(i),
            diffuse: self.materials.diffuse.get(i),
            emission: Vec3::ZERO,
            offset: self.triangles.offset[i],
            prim_id: 0,
            instance: 0,
            tangent: Vec3::ZERO,
            wo: Vec3::ZERO,
            barycentric: [0.0; 2],
            time: self.time[i],
            rounding: TerminatorOffset::FLAT,
            change: InputChange::NONE,
            is_back: false,
            transmits: self.transmits[i] != 0,
            material: matte,
        }
    }

    /// Multiplies light from a direction each by the shadowing of bumps at matte surfaces, if there are any.
    #[inline(always)]
    fn apply_bump_shadowing(&self, matte: &Material, directions: &Vectors, light: &mut Vectors) {
        if self.has_bumps != 0 {
            for i in 0..LANES {
                light.set(i, light.get(i) * self.surface(i, matte).bump_shadowing(directions.get(i)));
            }
        }
    }

    /// The surface that path `i` has arrived at: where, and its shading normal.
    pub(super) fn place(&self, i: usize) -> (Vec3, Vec3) {
        (self.position.get(i), self.shading_normal.get(i))
    }

    /// The factor on the throughput of path `i` by Russian roulette.
    pub(super) fn survival(&self, i: usize) -> f32 {
        self.survival[i]
    }

    /// Ends the paths of whose light less than `cutoff` would be reflected, in every channel.
    #[inline(always)]
    pub(super) fn end_below_threshold(&mut self, cutoff: f32) {
        for i in 0..LANES {
            let reflected = self.paths.throughput.get(i) * self.reflectance.get(i);
            self.goes_on[i] = u32::from(reflected.max_element() >= cutoff);
        }
    }

    /// Russian roulette. Paths at secondary lights always survive, as they are likely to find more light than others.
    #[inline(always)]
    pub(super) fn roulette(&mut self, survival: Survival) {
        for i in 0..LANES {
            let by_chance = survive(survival, self.paths.throughput.get(i) * self.reflectance.get(i));
            self.survival[i] = if self.aims(i) { by_chance } else { 1.0 };
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

    /// The throughput of path `i`.
    #[inline(always)]
    pub(super) fn throughput(&self, i: usize) -> Vec3 {
        self.paths.throughput.get(i)
    }
}

#[cfg(test)]
mod tests;
