//! Light samples of a block's paths: a point on a triangle that emits for each, and the shadow ray to it.

use bytemuck::{Pod, Zeroable};
use glam::{Vec2, Vec3};
use halfdome_kernel::sampling::warp::{Triangle as TriangleWarp, Warp};
use halfdome_kernel::{Isa, Ray};

use super::Block;
use super::columns::{Column, Emitters, Integers, LANES, Rays, Vectors, gather, keep, triangle};
use crate::estimator::{prospect, shine};
use crate::integrator::state::light_choice;
use crate::light::as_rest;
use crate::scene::Material;
use crate::settings::LightSampling;
use crate::world::{Surface, World, interpolate};

/// Light sources, one for each path of a block, with numbers that say where on each.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(super) struct Lamps {
    choices: [f64; LANES],
    rests: [f64; LANES],
    /// Numbers of sources.
    sources: Integers,
    /// Whether the source is a triangle, and all that there is to know of it is in its columns.
    is_plain: Integers,
    emitters: Emitters,
    on_lamp: [Column; 2],
}

/// Shadow rays of a block, and the light that each lets through.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(in crate::integrator) struct Shadows {
    rays: Rays,
    waiting: Waiting,
    /// Whether there is any light.
    lit: Integers,
}

/// Light that waits for its shadow ray: what it adds to the camera ray of this number.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
struct Waiting {
    index: Integers,
    light: Vectors,
}

impl Lamps {
    /// Chooses a source for each of the first `len` paths by the numbers drawn; whether there is any.
    #[inline(always)]
    fn choose(&mut self, world: &World, len: usize, on_light: &[Vec2; LANES], onwards: &[Vec2; LANES]) -> bool {
        let isa = world.isa();
        for ((choice, &on_light), &onwards) in self.choices.iter_mut().zip(on_light).zip(onwards) {
            *choice = light_choice(on_light, onwards);
        }
        let (sources, rests) = (&mut self.sources[..len], &mut self.rests[..len]);
        if !world.lights.choose_many(isa, &self.choices[..len], sources, rests) {
            return false;
        }
        gather::<3, _, _>(isa, world.emitters(), sources, &mut self.emitters);
        let [across, up] = &mut self.on_lamp;
        across.iter_mut().zip(&self.rests).for_each(|(across, &rest)| *across = as_rest(rest));
        up.iter_mut().zip(on_light).for_each(|(up, on_light)| *up = on_light.y);
        true
    }

    /// The point of lamp `i` that is sampled from `surface`, and the reciprocal of its density per area.
    #[inline(always)]
    fn point<'w>(&self, i: usize, surface: &Surface<'w>, lights: LightSampling) -> (Surface<'w>, f32) {
        let emitters = &self.emitters;
        let corners = triangle(&emitters.corners, i);
        let prospect = prospect(surface.position, surface.normal, &corners, lights);
        let u = prospect.map(Vec2::new(self.on_lamp[0][i], self.on_lamp[1][i]));
        let point = TriangleWarp.map(u);
        let front = emitters.normal.get(i);
        let is_behind = (emitters.emits_both_sides[i] != 0) & (front.dot(corners[0] - surface.position) > 0.0);
        let normal = if is_behind { -front } else { front };
        let lamp = Surface {
            position: interpolate(corners, [1.0 - point.x - point.y, point.x, point.y]),
            normal,
            shading_normal: normal,
            diffuse: Vec3::ZERO,
            emission: emitters.emission.get(i),
            offset: emitters.offset[i],
            prim_id: 0,
            is_back: false,
            material: surface.material,
        };
        (lamp, emitters.area[i] * prospect.per_density(u))
    }
}

impl Block {
    /// Chooses a light for each path by the numbers drawn; whether there is any.
    #[inline(always)]
    pub(in crate::integrator) fn choose_lights(&mut self, world: &World) -> bool {
        self.lamps.choose(world, self.len, &self.on_light, &self.onwards)
    }

    /// Whether there may be a light that [`connect`](Self::connect) does not know.
    #[inline(always)]
    pub(in crate::integrator) fn has_other_lights(&self) -> bool {
        self.lamps.emitters.is_plain.iter().fold(1, |all, is_plain| all & is_plain) == 0
    }

    /// The number of the light of path `i` and what is left of the number that chose it, if it is none that
    /// [`connect`](Self::connect) knows.
    #[inline(always)]
    pub(in crate::integrator) fn other_light(&self, i: usize) -> Option<(usize, f64)> {
        let is_other = self.lamps.emitters.is_plain[i] == 0 && self.goes_on[i] != 0;
        is_other.then(|| (self.lamps.sources[i] as usize, self.lamps.rests[i]))
    }

    /// Light from the chosen lamps.
    #[inline(always)]
    pub(in crate::integrator) fn connect(&self, lights: LightSampling, matte: &Material, shadows: &mut Shadows) {
        // A loop each, which knows its weights.
        match lights {
            LightSampling::Naive => shadows.lit = [0; LANES],
            LightSampling::Direct => self.connect_by(LightSampling::Direct, matte, shadows),
            LightSampling::Mis => self.connect_by(LightSampling::Mis, matte, shadows),
        }
    }

    #[inline(always)]
    fn connect_by(&self, lights: LightSampling, matte: &Material, shadows: &mut Shadows) {
        for i in 0..LANES {
            let surface = self.surface(i, matte);
            let (lamp, area) = self.lamps.point(i, &surface, lights);
            let (light, arrives) = shine(&surface, &lamp, area);
            let lambert = surface.lambert(light.direction);
            let weight = lights.of_light(light.per_density, self.scatters[i] * lambert);
            let radiance = (surface.diffuse * lambert) * light.radiance * weight;
            shadows.rays.origin.set(i, light.shadow.origin);
            shadows.rays.direction.set(i, light.shadow.direction);
            shadows.waiting.index[i] = self.paths.index[i];
            shadows.waiting.light.set(i, self.paths.throughput.get(i) * radiance);
            let is_there = self.lamps.emitters.is_plain[i] & self.goes_on[i];
            shadows.lit[i] = u32::from(arrives & (radiance.max_element() > 0.0)) & is_there;
        }
    }
}

impl Shadows {
    /// Rays from 0 to 1.
    pub(in crate::integrator) fn new() -> Self {
        let mut shadows = Self::zeroed();
        shadows.rays.t_max = [1.0; LANES];
        shadows
    }

    /// Writes those of the first `len` shadow rays that have any light to the start of `rays`, and which camera ray's light
    /// it is, and how much, to that of `waiting`; gives their number.
    #[inline(always)]
    pub(in crate::integrator) fn keep<W: Pod>(
        &self,
        isa: Isa,
        len: usize,
        rays: &mut [Ray],
        waiting: &mut [W],
    ) -> usize {
        let lit = &self.lit[..len];
        keep::<4, _, _>(isa, &self.waiting, lit, waiting);
        keep::<8, _, _>(isa, &self.rays, lit, rays)
    }
}
