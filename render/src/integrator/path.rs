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
//! A step has four parts. Paths *arrive* one by one, as each looks up another surface; lamps are looked up likewise; then
//! light and bounces are computed in lanes (see [`block`](super::block)); and what goes on is put together again. Mirrors,
//! glass, the sky and lights without a surface are done one by one.

use glam::{Vec2, Vec3};
use halfdome_kernel::sampling::warp::{CosineHemisphere, Triangle as TriangleWarp, Warp};
use halfdome_kernel::{Hit, Ray, Task};

use super::block::{Block, Bounces, LANES, Shadows};
use super::wavefront::{Path, Walk, first_set, light_choice};
use super::{CameraRays, Wavefront};
use crate::estimator::{connect_to, emitted_density, prospect, sky_density};
use crate::light::Source;
use crate::settings::{LightSampling, PathOptions, Stop, Survival};
use crate::world::{Surface, WHITE, World};

/// Writes the radiance along each camera ray; gives the number of further rays.
///
/// `watch` sees the rays that are to be traced before they are: the shadow rays of each bounce, and the paths'.
pub(super) fn radiance(
    world: &World,
    options: &PathOptions,
    camera: &CameraRays,
    wave: &mut Wavefront,
    radiance: &mut [Vec3],
    watch: &mut dyn FnMut(&Wavefront),
) -> u64 {
    wave.follow(world, camera, &mut PathTracer { world, options, watch }, radiance)
}

struct PathTracer<'a> {
    world: &'a World,
    options: &'a PathOptions,
    watch: &'a mut dyn FnMut(&Wavefront),
}

impl Walk for PathTracer<'_> {
    fn max_depth(&self) -> u32 {
        self.options.max_depth
    }

    fn advance(&mut self, wave: &mut Wavefront, camera: &CameraRays, depth: u32, radiance: &mut [Vec3]) {
        let (world, options) = (self.world, self.options);
        world.tree().isa().run(Advance { world, options, wave, camera, depth, radiance });
    }

    fn watch(&mut self, wave: &Wavefront) {
        (self.watch)(wave);
    }
}

/// The step of all paths from hit number `depth`, as a task that is compiled for each instruction set.
struct Advance<'a> {
    world: &'a World,
    options: &'a PathOptions,
    wave: &'a mut Wavefront,
    camera: &'a CameraRays<'a>,
    depth: u32,
    radiance: &'a mut [Vec3],
}

impl Task for Advance<'_> {
    type Output = ();

    #[inline(always)]
    fn run(mut self) {
        let (mut block, mut shadows, mut bounces) = (Block::EMPTY, Shadows::NONE, Bounces::NONE);
        let count = self.wave.paths.len();
        let (mut next, mut kept) = (0, 0);
        while next < count {
            block.len = 0;
            while block.len < LANES && next < count {
                self.arrive(next, &mut block);
                next += 1;
            }
            self.draw(&mut block);
            self.connect(&mut block, &mut shadows);
            block.bounce(&WHITE, &mut bounces);
            kept = self.go_on(&block, &bounces, kept);
        }
        self.wave.keep(kept);
    }
}

impl<'a> Advance<'a> {
    /// Collects light where path `i` has arrived, and takes it into the block unless it ends there.
    #[inline(always)]
    fn arrive(&mut self, i: usize, block: &mut Block) {
        let (world, &PathOptions { max_depth, lights, stop }) = (self.world, self.options);
        let (path, ray, hit) = (self.wave.paths[i], &self.wave.rays[i], &self.wave.hits[i]);
        let radiance = &mut self.radiance[path.index as usize];
        if !hit.is_hit() {
            *radiance += path.throughput * sky(world, lights, &path, ray.direction);
            return;
        }
        let surface = world.surface_at(hit);
        // Most surfaces emit nothing.
        if surface.emission.cmpne(Vec3::ZERO).any() {
            *radiance += path.throughput * emission(world, lights, &path, &surface, ray, hit);
        }
        if self.depth == max_depth {
            return;
        }
        let surface = surface.facing(ray.direction);
        let mut survival = 1.0;
        match stop {
            Stop::Threshold { cutoff, add_back } => {
                let reflected = path.throughput * surface.reflectance();
                if reflected.max_element() < cutoff {
                    if add_back {
                        *radiance += reflected * world.lights.mean_radiance();
                    }
                    return;
                }
            }
            Stop::Roulette { after, survival: chosen } if self.depth > after => {
                survival = survive(chosen, path.throughput * surface.reflectance());
            }
            _ => {}
        }
        block.push(i, self.wave.addresses[i], &surface, path.throughput, survival);
    }

    /// Draws the numbers of the block's paths.
    #[inline(always)]
    fn draw(&self, block: &mut Block) {
        let Some(sampler) = self.camera.samplers.first() else { return };
        let (isa, first_set, len) = (self.world.tree().isa(), first_set(self.camera, self.depth), block.len);
        let addresses = &block.addresses[..len];
        let draw = |set: u32, numbers: &mut [Vec2; LANES]| {
            sampler.fill2(isa, first_set + set, addresses, &mut numbers[..len]);
        };
        draw(0, &mut block.on_light);
        draw(1, &mut block.onwards);
        CosineHemisphere.map_many(isa, &block.onwards[..len], &mut block.cosine[..len]);
        if matches!(self.options.stop, Stop::Roulette { after, .. } if self.depth > after) {
            draw(2, &mut block.chances);
        }
    }

    /// Samples a light for each path of the block.
    #[inline(always)]
    fn connect(&mut self, block: &mut Block, shadows: &mut Shadows) {
        let (world, lights) = (self.world, self.options.lights);
        let (mut indices, mut choices) = ([0; LANES], [const { None }; LANES]);
        // In a loop of its own, for its chain of operations is long, and more of them overlap so.
        for (i, choice) in choices.iter_mut().enumerate().take(block.len) {
            *choice = world.lights.choose(light_choice(block.on_light[i], block.onwards[i]));
        }
        for (i, index) in indices.iter_mut().enumerate().take(block.len) {
            *index = self.wave.paths[block.source[i] as usize].index;
            let (on_light, Some(choice)) = (block.on_light[i], &choices[i]) else { continue };
            if let Source::Triangle(prim_id) = *choice.source
                && let Some(face) = world.plain_face(prim_id)
            {
                let u = Vec2::new(choice.rest, on_light.y);
                block.set_lamp(i, face, world.material_of(face), world.lights.area_density(prim_id), u);
            } else {
                let (surface, throughput) = self.stands_at(block, i);
                if let Some(connection) = connect_to(world, &surface, lights, choice, on_light.y) {
                    self.wave.connections.push(*index, throughput, connection);
                }
            }
        }
        block.connect(lights, &WHITE, shadows);
        self.wave.connections.extend(&indices[..block.len], shadows);
    }

    /// The surface of path `i` of the block, and its throughput.
    #[inline(never)]
    fn stands_at(&self, block: &Block, i: usize) -> (Surface<'a>, Vec3) {
        let (source, world) = (block.source[i] as usize, self.world);
        let Wavefront { paths, rays, hits, .. } = &*self.wave;
        (world.surface_at(&hits[source]).facing(rays[source].direction), paths[source].throughput)
    }

    /// Puts the paths of the block that go on to the others, of which there are `kept`; gives their number then.
    #[inline(always)]
    fn go_on(&mut self, block: &Block, bounces: &Bounces, mut kept: usize) -> usize {
        let (world, has_sky) = (self.world, self.world.lights.sky_probability() > 0.0);
        for i in 0..block.len {
            // The place that is next is one that is done with. It is written in any case, and kept if the path goes on:
            // nobody can foresee which.
            let goes_on = if block.scatters[i] < 1.0 {
                self.reflect(block, i, kept)
            } else {
                let wave = &mut *self.wave;
                let index = wave.paths[block.source[i] as usize].index;
                let (ray, throughput, density, reflects) = bounces.get(i);
                let sky_density =
                    if has_sky { sky_density(world, &block.surface(i, &WHITE), ray.direction) } else { 0.0 };
                wave.paths[kept] = Path { index, throughput, density, sky_density, from: block.prims[i] };
                wave.rays[kept] = ray;
                reflects
            };
            self.wave.addresses[kept] = block.addresses[i];
            kept += usize::from(goes_on & (block.chances[i].x < block.survival[i]));
        }
        kept
    }

    /// Lets path `i` of the block go on from a surface that may mirror or refract, to place `kept`; whether it does.
    #[inline(never)]
    fn reflect(&mut self, block: &Block, i: usize, kept: usize) -> bool {
        let (surface, throughput) = self.stands_at(block, i);
        let source = block.source[i] as usize;
        let incoming = self.wave.rays[source].direction;
        let Some(bounce) = surface.sample_with(incoming, block.onwards[i], block.cosine[i]) else { return false };
        let sky_density = sky_density(self.world, &surface, bounce.direction);
        let origin = surface.origin_towards(bounce.direction);
        let throughput = throughput / block.survival[i] * bounce.weight;
        let index = self.wave.paths[source].index;
        self.wave.paths[kept] = Path { index, throughput, density: bounce.density, sky_density, from: surface.prim_id };
        self.wave.rays[kept] = Ray::new(origin, bounce.direction);
        true
    }
}

/// The probability with which roulette lets a path go on of whose light `reflected` is left.
pub(super) fn survive(survival: Survival, reflected: Vec3) -> f32 {
    match survival {
        Survival::Constant(probability) => probability,
        Survival::Throughput { max } => reflected.max_element().min(max),
    }
}

/// What a path sees of the sky in its direction, weighted against the light sample that might have looked there.
pub(super) fn sky(world: &World, lights: LightSampling, path: &Path, direction: Vec3) -> Vec3 {
    world.sky.radiance(direction) * lights.of_bounce(path.density, path.sky_density)
}

/// What the surface emits along the path, weighted against the light sample that might have found it.
#[inline(always)]
pub(super) fn emission(
    world: &World,
    lights: LightSampling,
    path: &Path,
    surface: &Surface,
    ray: &Ray,
    hit: &Hit,
) -> Vec3 {
    // Most surfaces emit nothing.
    if surface.emission == Vec3::ZERO || !surface.emits_towards(ray.direction) {
        return Vec3::ZERO;
    }
    let density = emitted_density(world, surface, ray.direction, hit.t) * prospect_density(world, path, ray, hit);
    surface.emission * lights.of_bounce(path.density, density)
}

/// How much more often the point of a lamp is looked at from where the path comes from than if its points were all alike.
fn prospect_density(world: &World, path: &Path, ray: &Ray, hit: &Hit) -> f32 {
    match world.plain_face(hit.prim_id) {
        Some(face) if path.from != Hit::NO_PRIM => {
            let normal = world.normal_towards(path.from, ray.direction);
            let u = TriangleWarp.inverse(Vec2::new(hit.u, hit.v));
            prospect(ray.origin, normal, &face.corners).density(u)
        }
        _ => 1.0,
    }
}
