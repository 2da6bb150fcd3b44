//! Path tracing (Kajiya 1986): `L = L_e + ∫ f L cos θ dω`, one sample of the integral a surface.
//!
//! Shirley's first program is `LightSampling::Naive`: a ray hits a surface, adds what it emits, and goes on by the
//! cosine. `Direct` samples a light at every surface as well, and leaves out what the next bounce would find again;
//! `Mis` weights both by the power heuristic (Veach 1997). The module [`bsdf`](crate::bsdf) says why mirrors and the
//! first surface need no rule of their own.
//!
//! Each surface reflects a part of the light, and a path may stop when little is left ([`Stop`]): where the product of
//! all reflectances falls below a threshold, with the scene's mean radiance in place of what is left out or without, or
//! by Russian roulette, where a path that survives with the probability `p` counts for `1/p`.
//!
//! A step is made for a block of paths at once: where they arrive is looked up, then light samples and bounces are computed
//! in lanes (see [`path_block`](super::path_block)), and what goes on is put together again. Emission, textures, mirrors, glass, the
//! sky and delta lights are done one by one.

use std::ops::Range;

use glam::{Vec2, Vec3};
use halfdome_kernel::sampling::warp::{CosineHemisphere, Warp};
use halfdome_kernel::{Ray, Task};

use super::emission::{emission, sky};
use super::path_block::{Bounces, LANES, PathBlock, ShadowRays};
use super::state::Path;
use super::wavefront::{WavefrontStep, first_set};
use super::{RayBatch, Wavefront};
use crate::bsdf::Bounce;
use crate::estimator::sample_direct_from;
use crate::light::{SampledLight, SkyPart};
use crate::settings::{PathOptions, Stop};
use crate::world::{Surface, WHITE, World};

/// What of the sky light samples find: paths go on by the cosine, and find the rest.
const SKY: SkyPart = SkyPart::Bright;

/// Writes the radiance along each camera ray; gives the number of further rays.
///
/// `watch` sees the rays that are to be traced before they are: the shadow rays of each bounce, and the paths'.
pub(super) fn radiance(
    world: &World,
    options: &PathOptions,
    batch: &RayBatch,
    wave: &mut Wavefront,
    radiance: &mut [Vec3],
    watch: &mut dyn FnMut(&Wavefront),
) -> u64 {
    let (block, shadows, bounces) = (PathBlock::new(), ShadowRays::new(), Bounces::new());
    wave.follow(world, batch, &mut PathTracer { world, options, watch, block, shadows, bounces }, radiance)
}

struct PathTracer<'a> {
    world: &'a World,
    options: &'a PathOptions,
    watch: &'a mut dyn FnMut(&Wavefront),
    block: PathBlock,
    shadows: ShadowRays,
    bounces: Bounces,
}

impl WavefrontStep for PathTracer<'_> {
    fn max_depth(&self) -> u32 {
        self.options.max_depth
    }

    fn advance(&mut self, wave: &mut Wavefront, batch: &RayBatch, depth: u32, radiance: &mut [Vec3]) {
        let Self { world, options, block, shadows, bounces, .. } = self;
        let step = Advance { world, options, wave, batch, depth, radiance };
        world.isa().run(Steps { step, block, shadows, bounces });
    }

    fn watch(&mut self, wave: &Wavefront) {
        (self.watch)(wave);
    }
}

/// The step of all paths from hit number `depth`.
struct Advance<'a> {
    world: &'a World,
    options: &'a PathOptions,
    wave: &'a mut Wavefront,
    batch: &'a RayBatch<'a>,
    depth: u32,
    radiance: &'a mut [Vec3],
}

/// The same block by block, as a task that is compiled for each instruction set.
struct Steps<'a> {
    step: Advance<'a>,
    block: &'a mut PathBlock,
    shadows: &'a mut ShadowRays,
    bounces: &'a mut Bounces,
}

impl Task for Steps<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { mut step, block, shadows, bounces } = self;
        let (mut next, mut kept) = (0, 0);
        while next < step.wave.paths.len() {
            let first = next;
            next = step.fill(first, block);
            step.miss(first..next);
            step.arrive(block);
            if step.depth < step.options.max_depth {
                step.stop(block);
                step.draw(block);
                step.sample_lights(block, shadows);
                kept = step.continue_paths(block, bounces, kept);
            }
        }
        step.wave.keep(kept);
    }
}

impl<'a> Advance<'a> {
    /// Takes paths that have hit something, from number `next` on, into the block; gives the number of the next.
    #[inline(always)]
    fn fill(&mut self, mut next: usize, block: &mut PathBlock) -> usize {
        let mut len = 0;
        for hit in &self.wave.hits[next..] {
            // Put there in any case, and the place is taken if it has hit something: nobody can foresee whether.
            block.put(len, next, hit);
            len += usize::from(hit.is_hit());
            next += 1;
            if len == LANES {
                break;
            }
        }
        block.len = len;
        next
    }

    /// Lets those of some paths see the sky that hit nothing.
    #[inline(always)]
    fn miss(&mut self, range: Range<usize>) {
        if self.world.lights.sky.mean() == Vec3::ZERO {
            return;
        }
        for i in range.filter(|&i| !self.wave.hits[i].is_hit()) {
            let (path, ray) = (&self.wave.paths[i], &self.wave.rays[i]);
            let light = path.throughput * sky(self.world, self.options.lights, path, ray.direction);
            self.radiance[path.index as usize] += light;
        }
    }

    /// Looks up where the block's paths have arrived, and collects light there.
    #[inline(always)]
    fn arrive(&mut self, block: &mut PathBlock) {
        block.arrive(self.world, &self.wave.paths, &self.wave.rays);
        for i in 0..block.len {
            if block.is_general(i) {
                self.shade_general(block, i);
            }
        }
    }

    /// Collects the light that a surface emits, and tells the block what is not in its columns.
    #[inline(never)]
    fn shade_general(&mut self, block: &mut PathBlock, i: usize) {
        let (world, source) = (self.world, block.source[i] as usize);
        let (path, ray, hit) = (&self.wave.paths[source], &self.wave.rays[source], &self.wave.hits[source]);
        let surface = world.surface_at(hit);
        let light = path.throughput * emission(world, (self.options.lights, SKY), path, &surface, ray, hit);
        self.radiance[path.index as usize] += light;
        block.set(i, &surface.facing(ray.direction));
    }

    /// Ends paths by a threshold, or finds the probability with which chance lets them go on.
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
            Stop::Roulette { after, survival } if self.depth > after => block.roulette(survival),
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
        if matches!(self.options.stop, Stop::Roulette { after, .. } if self.depth > after) {
            draw(2, &mut block.u_direction);
            for (chance, numbers) in block.u_roulette.iter_mut().zip(&block.u_direction) {
                *chance = numbers.x;
            }
        }
        draw(0, &mut block.u_light);
        draw(1, &mut block.u_direction);
        CosineHemisphere.map_many(isa, &block.u_direction[..len], &mut block.cosine[..len]);
    }

    /// Samples a light for each path of the block.
    #[inline(always)]
    fn sample_lights(&mut self, block: &mut PathBlock, shadows: &mut ShadowRays) {
        if !block.choose_lights(self.world, SKY) {
            return;
        }
        if block.has_other_lights() {
            for i in 0..block.len {
                if let Some(light) = block.other_light(i) {
                    self.sample_other_light(block, i, &light);
                }
            }
        }
        block.sample_lights(self.options.lights, &WHITE, shadows);
        self.wave.shadow_queue.extend(self.world.isa(), shadows, block.len);
    }

    /// Samples a light of which the block knows too little, for path `i`.
    #[inline(never)]
    fn sample_other_light(&mut self, block: &PathBlock, i: usize, light: &SampledLight) {
        let (surface, throughput) = self.surface_of(block, i);
        let how = (self.options.lights, SKY);
        if let Some(shadow_ray) = sample_direct_from(self.world, &surface, how, light, block.u_light[i].y) {
            self.wave.shadow_queue.push(block.index(i) as u32, throughput, shadow_ray);
        }
    }

    /// The surface of path `i` of the block, and its throughput.
    #[inline(never)]
    fn surface_of(&self, block: &PathBlock, i: usize) -> (Surface<'a>, Vec3) {
        let (source, world) = (block.source[i] as usize, self.world);
        let Wavefront { paths, rays, hits, .. } = &*self.wave;
        (world.surface_at(&hits[source]).facing(rays[source].direction), paths[source].throughput)
    }

    /// Puts the paths of the block that go on behind the others, of which there are `kept`, in the places of those that are
    /// done with; gives their number then.
    #[inline(always)]
    fn continue_paths(&mut self, block: &PathBlock, bounces: &mut Bounces, kept: usize) -> usize {
        let world = self.world;
        block.bounce(&WHITE, bounces);
        if world.lights.sky.has(SKY) {
            for i in 0..block.len {
                bounces.paths.sky_density[i] = block.sky_density(world, SKY, i, bounces.direction(i));
            }
        }
        if block.has_specular() {
            for i in 0..block.len {
                if block.is_specular(i) {
                    self.reflect(block, bounces, i);
                }
            }
        }
        let Wavefront { paths, rays, .. } = &mut *self.wave;
        kept + bounces.keep(world.isa(), block.len, &mut rays[kept..], &mut paths[kept..])
    }

    /// Lets path `i` of the block go on from a surface that may mirror or refract.
    #[inline(never)]
    fn reflect(&mut self, block: &PathBlock, bounces: &mut Bounces, i: usize) {
        let (surface, throughput) = self.surface_of(block, i);
        let source = block.source[i] as usize;
        let incoming = self.wave.rays[source].direction;
        let bounce = surface.sample_with(incoming, block.u_direction[i], block.cosine[i]);
        bounces.goes_on[i] = (block.survives(i) && bounce.is_some()).into();
        let Some(Bounce { direction, weight, density }) = bounce else { return };
        let ray = Ray::new(surface.origin_towards(direction), direction);
        let throughput = throughput * block.survival(i).recip() * weight;
        let sky_density = block.sky_density(self.world, SKY, i, direction);
        bounces.set(i, &ray, &Path { throughput, density, sky_density, ..self.wave.paths[source] });
    }
}
