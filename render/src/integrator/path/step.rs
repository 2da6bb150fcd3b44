//! A step of the paths of a tile, block by block.

use std::ops::Range;

use glam::{Vec2, Vec3};
use halfdome_kernel::sampling::warp::{CosineHemisphere, Warp};

use super::aim::FindLit;
use super::{Advance, BlockRays, SKY};
use crate::estimator::{ShadowRay, sample_light, sample_reflected};
use crate::integrator::emission::{emission, sky};
use crate::integrator::path_block::{BlockClosures, Bounces, LANES, PathBlock, ShadowRays, clamp};
use crate::integrator::state::Path;
use crate::integrator::wavefront::first_set;
use crate::light::SampledLight;
use crate::settings::{LightSampling, Stop};
use crate::world::WHITE;

/// The importance of light that mirrors reflect to surfaces that the camera does not see: bounces spread its noise over
/// many pixels.
const INDIRECT_IMPORTANCE: f32 = 0.25;

impl Advance<'_, '_> {
    /// The step of those paths, by their places in the order by kind, whose surfaces have closures of one type.
    #[inline(always)]
    pub(super) fn advance<C: BlockClosures>(
        &mut self,
        range: Range<usize>,
        closures: &mut C,
        block: &mut PathBlock,
        BlockRays { shadows, to_sky, bounces }: &mut BlockRays,
    ) {
        let mut next = range.start;
        while next < range.end {
            let first = next;
            next = range.end.min(first + LANES);
            self.fill(first..next, block);
            self.arrive(closures, block);
            if self.depth < self.options.max_depth {
                if let Some(guide) = &mut self.guide {
                    guide.locate(closures, block);
                }
                self.stop(block);
                self.draw(block);
                self.sample_lights(closures, block, shadows);
                self.sample_openings(closures, block, to_sky);
                self.continue_paths(closures, block, bounces);
                if self.aims() && self.depth + 1 < self.options.max_depth {
                    self.aim(closures, block);
                }
            }
        }
    }

    /// Takes paths that have hit something into the block.
    #[inline(always)]
    fn fill(&mut self, range: Range<usize>, block: &mut PathBlock) {
        block.len = range.len();
        for (i, &source) in self.wave.order[range].iter().enumerate() {
            block.put(i, source as usize, &self.wave.hits[source as usize]);
        }
    }

    /// Lets the paths from this place in the order on, which hit nothing, see the sky.
    #[inline(always)]
    pub(super) fn miss(&mut self, first: usize) {
        if self.world.lights.sky.mean() == Vec3::ZERO {
            return;
        }
        let mut next = first;
        while next < self.wave.order.len() {
            let (first, len) = (next, LANES.min(self.wave.order.len() - next));
            next += len;
            let mut directions = [Vec3::Y; LANES];
            for (direction, &source) in directions.iter_mut().zip(&self.wave.order[first..next]) {
                *direction = self.wave.rays[source as usize].direction;
            }
            let views = self.world.lights.sky.views(&directions);
            for (number, view) in (first..next).zip(&views) {
                let source = self.wave.order[number] as usize;
                let (path, ray) = (&self.wave.paths[source], &self.wave.rays[source]);
                let light = path.throughput * sky(self.world, (self.options.lights, SKY), path, (ray, view));
                let light = self.clamped(light);
                self.radiance[path.index as usize] += light;
                self.record_sky(source, light);
                self.learn_found(source, light);
            }
        }
    }

    /// Looks up where the block's paths have arrived, and collects light there.
    #[inline(always)]
    fn arrive<C: BlockClosures>(&mut self, closures: &mut C, block: &mut PathBlock) {
        block.arrive(self.world, &self.wave.paths, &self.wave.rays);
        if self.is_absorbed() {
            self.absorb_on_the_way(block);
        }
        closures.clear();
        for i in 0..block.len {
            if !C::IN_LANES || block.is_general(i) {
                self.shade(closures, block, i);
            }
        }
        closures.arrived(self.world.isa());
        if self.aims() {
            self.world.isa().run(FindLit { world: self.world, wave: self.wave, block });
        }
    }

    /// Collects a surface's emission, and passes the block the data that is not in its columns.
    #[inline(never)]
    fn shade<C: BlockClosures>(&mut self, closures: &mut C, block: &mut PathBlock, i: usize) {
        let (world, source) = (self.world, block.source[i] as usize);
        let (path, ray, hit) = (&self.wave.paths[source], &self.wave.rays[source], &self.wave.hits[source]);
        let surface = world.surface_at(hit);
        let mut facing = surface.facing(ray.direction);
        if facing.material.dispersion > 0.0 {
            self.disperse(block, i, &mut facing);
        }
        if path.is_spread() {
            facing.change.least_roughness = self.options.filter_glossy;
        }
        // Directions of paths are unit vectors.
        let albedo = closures.arrive(world, &mut facing);
        block.set(i, &facing, albedo);
        let mut found = Vec3::ZERO;
        if !path.is_aimed() {
            let light = emission(world, (self.options.lights, SKY), path, &surface, ray, hit);
            found = self.clamped(block.throughput(i) * light);
            self.radiance[path.index as usize] += found;
        }
        if found != Vec3::ZERO {
            self.record_emission(source, found);
            self.learn_found(source, found);
        }
    }

    /// Light that a path has found where it arrived; that was sampled at the surface before.
    #[inline(always)]
    pub(super) fn clamped(&self, light: Vec3) -> Vec3 {
        match self.options.clamp_indirect {
            Some(most) if self.depth > 2 => clamp(light, most),
            _ => light,
        }
    }

    /// Ends paths by a threshold, or computes their survival probability.
    #[inline(always)]
    fn stop(&mut self, block: &mut PathBlock) {
        match self.options.stop {
            Stop::Threshold { cutoff, add_back } => {
                block.end_below_threshold(cutoff);
                let instead = if add_back { self.world.lights.mean_radiance() } else { Vec3::ZERO };
                for i in 0..block.len {
                    if let Some((index, reflected)) = block.ended(i) {
                        self.radiance[index as usize] += reflected * instead;
                    }
                }
            }
            Stop::Roulette { after, survival } if self.depth > after => match &self.guide {
                None => block.roulette(survival),
                Some(guide) => guide.roulette(block, survival),
            },
            _ => {}
        }
    }

    /// Draws the numbers of the block's paths.
    #[inline(always)]
    fn draw(&self, block: &mut PathBlock) {
        let Some(sampler) = self.batch.samplers.first() else { return };
        let (isa, first_set, len) = (self.world.isa(), first_set(self.batch, self.depth), block.len);
        for i in 0..len {
            block.addresses[i] = self.wave.addresses[block.index(i)];
        }
        let addresses = &block.addresses[..len];
        let draw = |set: u32, numbers: &mut [Vec2; LANES]| {
            sampler.fill2(isa, first_set + set, addresses, &mut numbers[..len]);
        };
        let ends_by_chance = matches!(self.options.stop, Stop::Roulette { after, .. } if self.depth > after);
        if ends_by_chance || self.aims() {
            draw(2, &mut block.u_direction);
            for i in 0..LANES {
                let numbers = block.u_direction[i];
                (block.u_roulette[i], block.u_aim[i]) = (if ends_by_chance { numbers.x } else { 0.0 }, numbers.y);
            }
        }
        draw(0, &mut block.u_light);
        draw(1, &mut block.u_direction);
        CosineHemisphere.map_many(isa, &block.u_direction[..len], &mut block.cosine[..len]);
    }

    /// Samples a light for each path of the block.
    #[inline(always)]
    fn sample_lights<C: BlockClosures>(&mut self, closures: &C, block: &mut PathBlock, shadows: &mut ShadowRays) {
        if !block.choose_lights(self.world, SKY) {
            return;
        }
        if block.has_other_lights() || self.world.has_reflected_light() {
            for i in (0..block.len).filter(|&i| block.is_going_on(i)) {
                if let Some(light) = block.other_light(i) {
                    self.sample_other_light(closures, block, i, &light);
                }
                if self.world.has_reflected_light() {
                    self.sample_reflected_light(closures, block, i);
                }
            }
        }
        block.sample_lights(closures, self.options.lights, &WHITE, shadows);
        self.queue_samples(closures, block, shadows, PathBlock::light);
    }

    /// Samples the sky through openings for each path of the block.
    #[inline(always)]
    fn sample_openings<C: BlockClosures>(&mut self, closures: &C, block: &mut PathBlock, shadows: &mut ShadowRays) {
        let lights = self.options.lights;
        if self.world.lights.sky.openings().is_none() || lights == LightSampling::Naive {
            return;
        }
        block.sample_openings(closures, (self.world, SKY), lights, &WHITE, shadows);
        let sky = self.world.lights.sky_number();
        self.queue_samples(closures, block, shadows, |_, _| sky);
    }

    /// Defers the light of samples until their shadow rays are traced; `light` gives each path's light.
    #[inline(always)]
    fn queue_samples<C: BlockClosures>(
        &mut self,
        closures: &C,
        block: &PathBlock,
        shadows: &mut ShadowRays,
        light: impl Fn(&PathBlock, usize) -> u32,
    ) {
        if let Some(guide) = &self.guide {
            guide.reweigh_lights(block, self.options.lights, shadows);
        }
        if self.is_absorbed() {
            self.absorb_light_samples(block, shadows);
        }
        self.pass_shadows(block, shadows);
        if let Some(most) = self.clamp_at_surface() {
            shadows.clamp(most);
        }
        if self.recorder.is_some() {
            self.record_light_samples(closures, block, shadows, light);
        }
        if self.trainer.is_some() {
            self.learn_light_samples(block, shadows);
        }
        self.wave.shadow_queue.extend(self.world.isa(), shadows, block.len);
    }

    /// Samples a light of which the block knows too little, for path `i`.
    #[inline(never)]
    fn sample_other_light<C: BlockClosures>(
        &mut self,
        closures: &C,
        block: &PathBlock,
        i: usize,
        light: &SampledLight,
    ) {
        let (surface, how) = (block.surface(i, &WHITE), (self.options.lights, SKY));
        let Some(sample) = sample_light(self.world, &surface, how, light, block.u_light[i].y) else { return };
        let (scattered, density) = closures.eval(i, &surface, sample.direction);
        let density = self.bounce_density(i, sample.direction, density);
        let is_shared = C::SHARES_LIGHTS || !sample.is_punctual;
        let inv_density = if is_shared { sample.inv_density } else { 0.0 };
        let radiance = scattered * sample.radiance * self.options.lights.light_weight(inv_density, density);
        let shadow_ray = ShadowRay { ray: sample.shadow, direction: sample.direction, radiance };
        let left = match sample.is_glass_known {
            true => Some(shadow_ray),
            false => shadow_ray.through_panes(self.world, surface.time),
        };
        if let Some(shadow_ray) = left {
            self.connect(closures, block, i, (light.index, shadow_ray));
        }
    }

    /// Samples the light that mirrors and glass reflect to path `i`. Of lights with a size, bounces find what they reflect
    /// about one direction: [`Path::sees_lights`].
    #[inline(never)]
    fn sample_reflected_light<C: BlockClosures>(&mut self, closures: &C, block: &PathBlock, i: usize) {
        let importance = if self.depth > 1 { INDIRECT_IMPORTANCE } else { 1.0 };
        let surface = block.surface(i, &WHITE);
        let Some(sample) = sample_reflected(self.world, &surface, importance, block.u_light[i]) else { return };
        let (scattered, density) = closures.eval(i, &surface, sample.direction);
        let density = self.bounce_density(i, sample.direction, density);
        if C::SHARES_LIGHTS && sample.is_seen && Path::is_narrow(density) {
            return;
        }
        let radiance = scattered * sample.received * self.options.lights.light_weight(0.0, density);
        let shadow_ray = ShadowRay { ray: sample.shadow, direction: sample.direction, radiance };
        self.connect(closures, block, i, (sample.light, shadow_ray));
    }

    /// Defers the shadow ray of a light's sample for path `i`, with what the closure there reflects.
    fn connect<C: BlockClosures>(
        &mut self,
        closures: &C,
        block: &PathBlock,
        i: usize,
        (light, shadow_ray): (u32, ShadowRay),
    ) {
        let ShadowRay { ray, direction, mut radiance } = shadow_ray;
        if !radiance.cmpgt(Vec3::ZERO).any() {
            return;
        }
        if self.is_absorbed() {
            radiance *= self.arrival(block, i).transmittance_of(&ray);
        }
        let found = block.throughput(i) * radiance;
        let radiance = self.clamp_at_surface().map_or(found, |most| clamp(found, most));
        let shadow_ray = self.wave.shadow_queue.defer(block.index(i) as u32, ray, radiance);
        if self.recorder.is_some() {
            self.record_deferred(closures, block, i, (shadow_ray, light, direction, radiance));
        }
        self.learn_deferred(block, i, shadow_ray, radiance);
    }

    /// The density with which path `i` continues in a direction, given its closure's density.
    #[inline(always)]
    pub(super) fn bounce_density(&self, i: usize, direction: Vec3, closure_density: f32) -> f32 {
        self.guide.as_ref().map_or(closure_density, |guide| guide.density(i, direction, closure_density))
    }

    /// What light samples at the surfaces of this step may be at most, unless it is the first one's direct light.
    #[inline(always)]
    fn clamp_at_surface(&self) -> Option<f32> {
        self.options.clamp_indirect.filter(|_| self.depth > 1)
    }

    /// Appends the block's continuing paths to the others.
    #[inline(always)]
    fn continue_paths<C: BlockClosures>(&mut self, closures: &C, block: &PathBlock, bounces: &mut Bounces) {
        let world = self.world;
        block.bounce(closures, &WHITE, bounces);
        if let Some(guide) = &self.guide {
            guide.bounce(closures, block, bounces);
        }
        if self.recorder.is_some() {
            self.record_bounces(closures, block, bounces);
        }
        if self.trainer.is_some() {
            self.learn_bounces(closures, block, bounces);
        }
        if self.is_absorbed() {
            self.keep_media(block, bounces);
        }
        let (rays, paths) = self.wave.next_places(self.kept, LANES);
        self.kept += bounces.keep(world.isa(), block.len, rays, paths);
    }
}
