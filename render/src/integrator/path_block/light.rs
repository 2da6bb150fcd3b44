//! Light samples of a block's paths: a point on a triangle that emits for each, and the shadow ray to it.

use bytemuck::{Pod, Zeroable};
use glam::{Vec2, Vec3};
use halfdome_kernel::sampling::warp::{Triangle as TriangleWarp, Warp};
use halfdome_kernel::{Isa, Ray};

use super::columns::{Column, EmitterColumns, Integers, LANES, Rays, Vectors, gather, keep, triangle};
use super::{BlockClosures, PathBlock, Scattered};
use crate::estimator::{area_light_sample, light_warp};
use crate::integrator::state::u_light_choice;
use crate::light::few::{self, FEW};
use crate::light::{LightChoice, Receiver, SampledLight, SkyPart, SkyView, TriangleLight};
use crate::scene::Material;
use crate::settings::LightSampling;
use crate::world::{InputChange, MIDDLE, Surface, TerminatorOffset, World, interpolate};

/// The light chosen for each path of a block, with numbers that say where on each.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(super) struct LightSamples {
    /// Indices of lights.
    lights: Integers,
    /// The probability of choosing each; 0 where no light arrives.
    probability: Column,
    /// The probability of choosing the sky.
    sky_probability: Column,
    emitters: EmitterColumns,
    uv: [Column; 2],
}

/// Shadow rays of a block, and the light that each lets through.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(in crate::integrator) struct ShadowRays {
    pub(super) rays: Rays,
    pub(super) waiting: PendingLights,
    /// The reciprocals of the densities with which their directions were chosen.
    pub(super) per_density: Column,
    /// Unit vectors to the lights, and what the closures scatter of light from there.
    pub(super) towards: Vectors,
    scattered: Scattered,
    /// Whether there is any light.
    pub(super) lit: Integers,
}

/// Light that waits for its shadow ray: what it adds to the camera ray of this number.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(super) struct PendingLights {
    pub(super) index: Integers,
    pub(super) light: Vectors,
}

impl LightSamples {
    /// The point of light `i` that is sampled from `surface`, and the reciprocal of its density per area.
    #[inline(always)]
    fn point<'w>(
        &self,
        i: usize,
        surface: &Surface<'w>,
        receiver: &Receiver,
        lights: LightSampling,
    ) -> (Surface<'w>, f32) {
        let emitters = &self.emitters;
        let corners = triangle(&emitters.corners, i);
        let warp = light_warp(receiver, &corners, lights);
        let u = warp.map(Vec2::new(self.uv[0][i], self.uv[1][i]));
        let point = TriangleWarp.map(u);
        let front = emitters.normal.get(i);
        let is_behind = (emitters.emits_both_sides[i] != 0) & (front.dot(corners[0] - surface.position) > 0.0);
        let normal = if is_behind { -front } else { front };
        let light = Surface {
            position: interpolate(corners, [1.0 - point.x - point.y, point.x, point.y]),
            normal,
            smooth_normal: normal,
            shading_normal: normal,
            diffuse: Vec3::ZERO,
            emission: emitters.emission.get(i),
            offset: emitters.offset[i],
            prim_id: 0,
            instance: 0,
            tangent: Vec3::ZERO,
            wo: Vec3::ZERO,
            barycentric: [0.0; 2],
            time: MIDDLE,
            rounding: TerminatorOffset::FLAT,
            change: InputChange::NONE,
            is_back: false,
            transmits: false,
            material: surface.material,
        };
        (light, emitters.area[i] / self.probability[i] * warp.per_density(u))
    }
}

impl PathBlock {
    /// The number of the light that was chosen for path `i`.
    pub(in crate::integrator) fn light(&self, i: usize) -> u32 {
        self.light_samples.lights[i]
    }

    /// Whether path `i` has not ended at its surface.
    pub(in crate::integrator) fn is_going_on(&self, i: usize) -> bool {
        self.goes_on[i] != 0
    }

    /// The receiver of path `i`.
    #[inline(always)]
    pub(in crate::integrator) fn receiver(&self, i: usize) -> Receiver {
        Receiver { position: self.position.get(i), normal: self.receiving.get(i), behind: self.behind[i] }
    }

    /// Chooses a light for each path by the numbers drawn, among all lights and this part of the sky; whether there is
    /// any.
    #[inline(always)]
    pub(in crate::integrator) fn choose_lights(&mut self, world: &World, part: SkyPart) -> bool {
        for i in 0..LANES {
            self.packed[i] = Receiver::pack(self.shading_normal.get(i), self.transmits[i] != 0);
            let receiver = Receiver::unpack(self.position.get(i), self.packed[i]);
            self.receiving.set(i, receiver.normal);
            self.behind[i] = receiver.behind;
        }
        if !world.lights.has_any(part) {
            return false;
        }
        if world.lights.few(part).is_empty() {
            self.choose_from_all(world, part);
        } else {
            self.choose_from_few(world.lights.few(part));
        }
        let LightSamples { lights, emitters, uv, .. } = &mut self.light_samples;
        gather::<3, _, _>(world.isa(), world.emitter_records(), &lights[..self.len], emitters);
        uv[1].iter_mut().zip(&self.u_light).for_each(|(up, u_light)| *up = u_light.y);
        true
    }

    /// Chooses for one path after the other, step by step.
    #[inline(always)]
    fn choose_from_all(&mut self, world: &World, part: SkyPart) {
        let none = world.lights.lights().len() as u32 - 1;
        let mut choices = [LightChoice::None; LANES];
        let mut going = [0u8; LANES];
        for i in 0..self.len {
            let receiver = self.receiver(i);
            let weights = world.lights.weigh(&receiver, part);
            let u = u_light_choice(self.u_light[i], self.u_direction[i]);
            choices[i] = world.lights.begin(&receiver, &weights, u);
            going[i] = i as u8;
            self.light_samples.sky_probability[i] = weights.sky_probability();
        }
        let mut count = self.len;
        while count > 0 {
            let mut left = 0;
            for k in 0..count {
                let i = usize::from(going[k]);
                going[left] = going[k];
                left += usize::from(world.lights.descend(&self.receiver(i), &mut choices[i]));
            }
            count = left;
        }
        let samples = &mut self.light_samples;
        for (i, choice) in choices[..self.len].iter().enumerate() {
            let light = world.lights.end(choice);
            let light = light.unwrap_or(SampledLight { index: none, probability: 0.0, rest: 0.0 });
            (samples.lights[i], samples.probability[i]) = (light.index, light.probability);
            samples.uv[0][i] = light.rest;
        }
    }

    /// Chooses in lanes.
    #[inline(always)]
    fn choose_from_few(&mut self, few: &[TriangleLight]) {
        let mut weights = [[0.0; LANES]; FEW];
        for (weights, light) in weights.iter_mut().zip(few) {
            for (i, weight) in weights.iter_mut().enumerate() {
                *weight = few::weight(light, &self.receiver(i));
            }
        }
        let [a, b, c, d] = &weights;
        let samples = &mut self.light_samples;
        for i in 0..LANES {
            let (index, probability, rest) = few::choose([a[i], b[i], c[i], d[i]], self.u_light[i].x);
            (samples.lights[i], samples.probability[i], samples.uv[0][i]) = (index, probability, rest);
        }
    }

    /// Whether there may be a light that [`sample_lights`](Self::sample_lights) does not know.
    #[inline(always)]
    pub(in crate::integrator) fn has_other_lights(&self) -> bool {
        self.light_samples.emitters.is_plain.iter().fold(1, |all, is_plain| all & is_plain) == 0
    }

    /// The light of path `i`, if [`sample_lights`](Self::sample_lights) does not handle it.
    #[inline(always)]
    pub(in crate::integrator) fn other_light(&self, i: usize) -> Option<SampledLight> {
        let LightSamples { emitters, lights, probability, uv, .. } = &self.light_samples;
        let is_other = emitters.is_plain[i] == 0 && self.goes_on[i] != 0 && probability[i] > 0.0;
        is_other.then(|| SampledLight { index: lights[i], probability: probability[i], rest: uv[0][i] })
    }

    /// The radiance of the sky in a view, and the density with which samples of the chosen light of path `i` look there if
    /// they look for this part of the sky, without those through openings.
    #[inline(always)]
    pub(super) fn sky_anywhere(&self, world: &World, part: SkyPart, i: usize, view: &SkyView) -> (Vec3, f32) {
        let seen = world.lights.sky.seen(&self.receiver(i), part, view);
        (seen.radiance, self.light_samples.sky_probability[i] * seen.density)
    }

    /// The probability with which each path's samples of the chosen light look at the sky.
    #[inline(always)]
    pub(super) fn sky_probabilities(&self) -> Column {
        self.light_samples.sky_probability
    }

    /// Samples of the chosen lights.
    #[inline(always)]
    pub(in crate::integrator) fn sample_lights<C: BlockClosures>(
        &self,
        closures: &C,
        lights: LightSampling,
        matte: &Material,
        shadows: &mut ShadowRays,
    ) {
        // A loop each, which knows its weights.
        match lights {
            LightSampling::Naive => shadows.lit = [0; LANES],
            LightSampling::Direct => self.sample_lights_by(closures, LightSampling::Direct, matte, shadows),
            LightSampling::Mis => self.sample_lights_by(closures, LightSampling::Mis, matte, shadows),
        }
    }

    #[inline(always)]
    fn sample_lights_by<C: BlockClosures>(
        &self,
        closures: &C,
        lights: LightSampling,
        matte: &Material,
        shadows: &mut ShadowRays,
    ) {
        for i in 0..LANES {
            let surface = self.surface(i, matte);
            let (light, area) = self.light_samples.point(i, &surface, &self.receiver(i), lights);
            let (light, arrives) = area_light_sample(&surface, surface.transmits, &light, area);
            shadows.towards.set(i, light.direction);
            shadows.rays.origin.set(i, light.shadow.origin);
            shadows.rays.direction.set(i, light.shadow.direction);
            shadows.waiting.index[i] = self.paths.index[i];
            shadows.waiting.light.set(i, light.radiance);
            shadows.per_density[i] = light.inv_density;
            let is_chosen = u32::from(self.light_samples.probability[i] > 0.0);
            let is_there = self.light_samples.emitters.is_plain[i] & self.goes_on[i] & is_chosen;
            shadows.lit[i] = u32::from(arrives) & is_there;
        }
        self.weigh_samples(closures, lights, matte, shadows);
    }

    /// Multiplies the light of samples by what closures scatter of it and by the weight of light samples beside bounces.
    #[inline(always)]
    pub(super) fn weigh_samples<C: BlockClosures>(
        &self,
        closures: &C,
        lights: LightSampling,
        matte: &Material,
        shadows: &mut ShadowRays,
    ) {
        closures.eval_all(self, matte, &shadows.towards, &mut shadows.scattered);
        for i in 0..LANES {
            let weight = lights.light_weight(shadows.per_density[i], shadows.scattered.density[i]);
            let radiance = shadows.scattered.f_cos.get(i) * shadows.waiting.light.get(i) * weight;
            shadows.waiting.light.set(i, self.throughput(i) * radiance);
            shadows.lit[i] &= u32::from(radiance.max_element() > 0.0);
        }
    }
}

impl ShadowRays {
    /// Rays from 0 to 1.
    pub(in crate::integrator) fn new() -> Self {
        let mut shadows = Self::zeroed();
        shadows.rays.t_max = [1.0; LANES];
        shadows
    }

    /// Rays without an end.
    pub(in crate::integrator) fn to_sky() -> Self {
        let mut shadows = Self::zeroed();
        shadows.rays.t_max = [f32::INFINITY; LANES];
        shadows
    }

    /// Whether ray `i` carries any light.
    pub(in crate::integrator) fn is_lit(&self, i: usize) -> bool {
        self.lit[i] != 0
    }

    /// The direction of ray `i`.
    pub(in crate::integrator) fn direction(&self, i: usize) -> Vec3 {
        self.rays.direction.get(i)
    }

    /// Ray `i`.
    pub(in crate::integrator) fn ray(&self, i: usize) -> Ray {
        let Rays { origin, t_min, direction, t_max } = &self.rays;
        Ray { t_min: t_min[i], t_max: t_max[i], ..Ray::new(origin.get(i), direction.get(i)) }
    }

    /// Leaves this part of the light of ray `i`.
    pub(in crate::integrator) fn dim(&mut self, i: usize, part: Vec3) {
        self.waiting.light.set(i, self.waiting.light.get(i) * part);
    }

    /// Lets all rays begin at their origins.
    pub(in crate::integrator) fn start_at_surfaces(&mut self) {
        self.rays.t_min = [0.0; LANES];
    }

    /// Lets ray `i` begin farther on, with this part of its light.
    pub(in crate::integrator) fn pass(&mut self, i: usize, t_min: f32, part: Vec3) {
        self.rays.t_min[i] = t_min;
        self.dim(i, part);
    }

    /// Takes the light from ray `i`.
    pub(in crate::integrator) fn lose(&mut self, i: usize) {
        self.lit[i] = 0;
    }

    /// The light of ray `i`.
    pub(in crate::integrator) fn light(&self, i: usize) -> Vec3 {
        self.waiting.light.get(i)
    }

    /// Weighs the light of ray `i` for bounces with another density than the closure's.
    pub(super) fn reweigh(&mut self, i: usize, lights: LightSampling, density: impl Fn(f32) -> f32) {
        let (per_density, before) = (self.per_density[i], self.scattered.density[i]);
        let weight = |density: f32| lights.light_weight(per_density, density);
        self.waiting.light.set(i, self.waiting.light.get(i) * (weight(density(before)) / weight(before)));
    }

    /// Scales all light down to at most this radiance in any channel.
    #[inline(always)]
    pub(in crate::integrator) fn clamp(&mut self, most: f32) {
        for i in 0..LANES {
            self.waiting.light.set(i, clamp(self.waiting.light.get(i), most));
        }
    }

    /// Writes those of the first `len` shadow rays that have any light to the start of `rays`, and which camera ray's
    /// light it is, and how much, to that of `waiting`; gives their number.
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

/// Light, scaled down to at most this radiance in any channel.
#[inline(always)]
pub(in crate::integrator) fn clamp(light: Vec3, most: f32) -> Vec3 {
    let brightest = light.max_element();
    if brightest > most { light * (most / brightest) } else { light }
}
