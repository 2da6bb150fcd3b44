//! Glossy closures in lanes. Table lookups are made path by path; everything else is computed in lanes, by the
//! functions of a single closure ([`Reflection`]).

use bytemuck::{Pod, Zeroable};
use glam::{Vec2, Vec3};
use halfdome_kernel::Isa;
use halfdome_kernel::sampling::Frame;

use super::PathBlock;
use super::closures::{BlockClosures, Closures, Continuations, Scattered};
use super::columns::{Column, LANES, Vectors, gather};
use crate::bsdf::{Bounce, Scattering};
use crate::material::{BumpShadowing, Glossy, Reflection, Shading, Side};
use crate::scene::Material;
use crate::world::{Surface, World};

/// The closures of a block's surfaces, one by one and in columns.
pub(in crate::integrator) struct GlossyLanes {
    closures: Closures<Glossy>,
    rows: Vec<GlossyRow>,
    columns: Box<GlossyColumns>,
}

/// A closure in the world, but for its tables.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
struct GlossyRow {
    reflection: Reflection,
    /// The tabled values of `wo`, which is in the shading frame.
    side: Side,
    wo: Vec3,
    axes: [Vec3; 3],
    geometric: Vec3,
    bumps: BumpShadowing,
    unused: [u32; 3],
}

/// Words of a row, and eights of them.
const WORDS: usize = size_of::<GlossyRow>() / 4;
const PARTS: usize = WORDS / 8;

/// [`GlossyRow`]s: column `k` has word `k` of each.
type GlossyColumns = [Column; WORDS];

/// The tabled values of two directions of each path, the second of which is mirrored at the surface to the first.
struct Sides {
    below: [Column; 2],
    gain: [Column; 2],
}

impl Sides {
    #[inline(always)]
    fn get(&self, k: usize, i: usize) -> Side {
        Side { below: self.below[k][i], gain: self.gain[k][i], glossy: 0.0 }
    }
}

impl GlossyRow {
    /// The closure with `wo` in the shading frame, and its tabled values.
    fn new(scattering: &Scattering<Glossy>, (wo, side): (Vec3, Side)) -> Self {
        let (closure, shading) = (scattering.closure(), scattering.shading());
        let Frame { tangent, bitangent, normal } = *shading.frame();
        Self {
            reflection: *closure.reflection(),
            side,
            wo,
            axes: [tangent, bitangent, normal],
            geometric: shading.geometric(),
            bumps: *shading.bumps(),
            unused: [0; 3],
        }
    }

    #[inline(always)]
    fn shading(&self) -> Shading {
        let [tangent, bitangent, normal] = self.axes;
        Shading::of(Frame { tangent, bitangent, normal }, self.geometric, self.bumps)
    }
}

impl Default for GlossyLanes {
    fn default() -> Self {
        Self {
            closures: Closures::default(),
            rows: Vec::with_capacity(LANES),
            columns: Box::new([[0.0; LANES]; WORDS]),
        }
    }
}

impl GlossyLanes {
    #[inline(always)]
    fn row(&self, i: usize) -> GlossyRow {
        let mut words = [0.0f32; WORDS];
        for (word, column) in words.iter_mut().zip(&*self.columns) {
            *word = column[i];
        }
        bytemuck::cast(words)
    }

    /// Looks up directions with these cosines, of each path where it is above the horizon.
    fn look_up(&self, cosines: [&Column; 2]) -> Sides {
        let mut sides = Sides { below: [[0.0; LANES]; 2], gain: [[0.0; LANES]; 2] };
        for (k, cosines) in cosines.into_iter().enumerate() {
            for (i, (scattering, &cos)) in self.closures.iter().zip(cosines).enumerate() {
                if cos > 0.0 {
                    (sides.below[k][i], sides.gain[k][i]) = scattering.closure().left_at(cos);
                }
            }
        }
        sides
    }
}

impl BlockClosures for GlossyLanes {
    /// They arrive one by one.
    const IN_LANES: bool = false;

    fn clear(&mut self) {
        self.closures.clear();
        self.rows.clear();
    }

    #[inline]
    fn arrive(&mut self, world: &World, surface: &mut Surface) -> Vec3 {
        // This kind does not handle light from behind, which the surface has handled.
        let scattering = Scattering::new(surface, world.closure::<Glossy>(surface));
        let wo = scattering.shading().frame().to_local(scattering.wo());
        let (albedo, side) = scattering.closure().seen_from(wo);
        self.rows.push(GlossyRow::new(&scattering, (wo, side)));
        let albedo = albedo * scattering.shading().bumps().mean();
        self.closures.push(scattering);
        albedo
    }

    fn arrived(&mut self, isa: Isa) {
        const NUMBERS: [u32; LANES] = {
            let mut numbers = [0; LANES];
            let mut i = 0;
            while i < LANES {
                numbers[i] = i as u32;
                i += 1;
            }
            numbers
        };
        gather::<PARTS, _, _>(isa, &self.rows, &NUMBERS[..self.rows.len()], &mut *self.columns);
    }

    fn eval(&self, i: usize, surface: &Surface, direction: Vec3) -> (Vec3, f32) {
        self.closures.eval(i, surface, direction)
    }

    fn glossy(&self, i: usize, direction: Vec3) -> Vec3 {
        self.closures.glossy(i, direction)
    }

    fn diffuse_share(&self, i: usize) -> f32 {
        self.closures.diffuse_share(i)
    }

    fn sample(&self, i: usize, surface: &Surface, u: Vec2, cosine: Vec3) -> (Bounce, bool) {
        self.closures.sample(i, surface, u, cosine)
    }

    #[inline(always)]
    fn eval_all(&self, _: &PathBlock, _: &Material, directions: &Vectors, scattered: &mut Scattered) {
        let [mut cosines, mut mirrored_cosines] = [[0.0; LANES]; 2];
        for i in 0..LANES {
            let locals = self.row(i).shading().locals(directions.get(i));
            (cosines[i], mirrored_cosines[i]) = (locals[0].z, locals[1].z);
        }
        let sides = self.look_up([&cosines, &mirrored_cosines]);
        for i in 0..LANES {
            let (row, direction) = (self.row(i), directions.get(i));
            let locals = row.shading().locals(direction);
            let wo = (row.wo, row.side);
            let (f, density) = row.reflection.eval(wo, (locals[0], sides.get(0, i)));
            let (mirrored_f, mirrored_density) = row.reflection.eval(wo, (locals[1], sides.get(1, i)));
            let shadowing = (row.bumps.factor(locals[0]), row.bumps.factor(locals[1]));
            let is_before = row.geometric.dot(direction) > 0.0;
            scattered.f_cos.set(i, if is_before { f * shadowing.0 + mirrored_f * shadowing.1 } else { Vec3::ZERO });
            scattered.density[i] = if is_before { density + mirrored_density } else { 0.0 };
        }
    }

    #[inline(always)]
    fn sample_all(&self, block: &PathBlock, _: &Material, on: &mut Continuations) {
        let (mut sampled, mut others) = (Vectors::zeroed(), Vectors::zeroed());
        let [mut cosines, mut other_cosines] = [[0.0; LANES]; 2];
        let mut is_mirrored = [0u32; LANES];
        for i in 0..LANES {
            let row = self.row(i);
            let chosen = row.reflection.choose((row.wo, row.side), block.u_direction[i]);
            let (wi, other) = row.shading().onwards(chosen.wi);
            on.direction.set(i, wi);
            sampled.set(i, chosen.wi);
            others.set(i, other);
            (cosines[i], other_cosines[i]) = (chosen.wi.z, other.z);
            is_mirrored[i] = u32::from(chosen.is_glossy & row.reflection.is_delta());
        }
        let sides = self.look_up([&cosines, &other_cosines]);
        for i in 0..LANES {
            let row = self.row(i);
            let wo = (row.wo, row.side);
            let (f, density) = row.reflection.eval(wo, (sampled.get(i), sides.get(0, i)));
            let (other_f, other_density) = row.reflection.eval(wo, (others.get(i), sides.get(1, i)));
            let is_mirrored = is_mirrored[i] != 0;
            let sum = density + other_density;
            let shadowing = (row.bumps.factor(sampled.get(i)), row.bumps.factor(others.get(i)));
            let rough = (f * shadowing.0 + other_f * shadowing.1) / sum;
            let weight = if is_mirrored { row.reflection.mirror_weight(wo) * shadowing.0 } else { rough };
            on.weight.set(i, weight);
            on.density[i] = if is_mirrored { f32::INFINITY } else { sum };
            let is_above = (cosines[i] > 0.0) & (is_mirrored | (density > 0.0));
            on.scatters[i] = u32::from(is_above & (weight.max_element() > 0.0));
        }
    }
}

#[cfg(test)]
mod tests;
