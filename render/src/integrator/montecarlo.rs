//! Driscoll's exponential estimator: direct light at every surface, and indirect light gathered by many rays over its
//! hemisphere, whose surfaces gather in their turn: `L_i ≈ ρ/N Σ L(ω_k)`, for a number of bounces. The render time
//! grows exponentially with their number.
//!
//! The tree of rays is traversed breadth first: all surfaces of a bounce, then all rays that leave them. Light with
//! more bounces is left out, which makes pictures too dark, or estimated by a path with Russian roulette
//! (`MonteCarloOptions::tail`).
//!
//! Delta functions do not gather: light in mirrors and glass comes from one direction at a time, by a ray that does not
//! count as a bounce.

use glam::{Vec2, Vec3};
use halfdome_kernel::Ray;
use halfdome_kernel::sampling::{Sampler, unit_double};

use super::emission::{emission, lights_on_the_way, sky};
use super::media::{Arrival, Media};
use super::panes::PathsAtPanes;
use super::shadow_queue::ShadowQueue;
use super::state::{Path, survive};
use super::{FIRST_SET, RayBatch};
use crate::bsdf::Scattering;
use crate::estimator::{Hemisphere, sample_direct, sky_probability};
use crate::light::SkyPart;
use crate::material::{Closure, Kind};
use crate::settings::{LightSampling, MonteCarloOptions};
use crate::world::{Hit, Surface, World, time_of};

/// Light is sampled at each surface, so rays that gather do not count it again.
const LIGHTS: LightSampling = LightSampling::Direct;
/// Sets of random numbers of a ray: the last bits of the light's choice at its end and whether to go on, which light and
/// where on it, and the ray's own direction.
const SETS_PER_RAY: u32 = 3;
/// The most surfaces one behind the other, where mirrors or the tail would never end.
const MAX_DEPTH: u32 = 1024;
/// Rays of a bounce that are in memory at once, about.
const BATCH: u64 = 1 << 16;

/// The rays of a bounce, and their memory, which the next one uses again.
#[derive(Default)]
pub(crate) struct Generation {
    nodes: Vec<Node>,
    rays: Vec<Ray>,
    hits: Vec<Hit>,
    times: Vec<f32>,
    shadow_queue: ShadowQueue,
}

/// A ray in the tree of rays.
#[derive(Clone, Copy)]
struct Node {
    path: Path,
    /// Its number in the tree; child `k` of node `n` is about `rays n + 1 + k`, as in a heap.
    number: u32,
    /// Bounces that are left for the surface that it hits.
    bounces: u32,
    /// The solids that it is in, if any absorbs.
    media: Media,
}

/// Writes the radiance along each camera ray; gives the number of further rays.
pub(super) fn radiance(
    world: &World,
    options: &MonteCarloOptions,
    batch: &RayBatch,
    [parents, children]: &mut [Generation; 2],
    radiance: &mut [Vec3],
) -> u64 {
    radiance.fill(Vec3::ZERO);
    let times = batch.times;
    let gather = Gather { world, times, options, hemisphere: Hemisphere::new(options.sampling, options.rays) };
    let mut traced = 0;
    // Few enough camera rays at once that the last bounce fits into memory.
    let together = (BATCH / (options.rays_per_sample() + 1)).max(1) as usize;
    for first in (0..batch.rays.len()).step_by(together) {
        parents.clear();
        for index in first..batch.rays.len().min(first + together) {
            let path = Path::from_camera(index as u32, batch.density);
            let node = Node { path, number: 0, bounces: options.bounces, media: Media::default() };
            parents.push(node, batch.rays[index]);
            parents.hits.push(batch.hits[index]);
        }
        for _ in 0..MAX_DEPTH {
            children.clear();
            for ((node, ray), hit) in parents.nodes.iter().zip(&parents.rays).zip(&parents.hits) {
                let index = node.path.index as usize;
                let (sampler, radiance) = (&batch.samplers[index], &mut radiance[index]);
                if !world.has_absorption() || !hit.is_hit() {
                    gather.branch(node, ray, hit, sampler, children, radiance);
                    continue;
                }
                let (mut node, boundary) = (*node, world.boundary(ray, hit));
                let arrival = Arrival { world, media: node.media, boundary };
                let (rays, shadow_rays) = (children.nodes.len(), children.shadow_queue.len());
                node.path.throughput *= arrival.transmittance(hit.t);
                gather.branch(&node, ray, hit, sampler, children, radiance);
                children.shadow_queue.dim(shadow_rays, |ray| arrival.transmittance_of(ray));
                for (child, ray) in children.nodes[rays..].iter_mut().zip(&children.rays[rays..]) {
                    child.media = arrival.onwards(ray.direction);
                }
            }
            traced += children.shadow_queue.resolve(world, batch.times, radiance);
            if children.nodes.is_empty() {
                break;
            }
            traced += children.trace(world, batch.times);
            std::mem::swap(parents, children);
        }
    }
    traced
}

impl Generation {
    fn clear(&mut self) {
        self.nodes.clear();
        self.rays.clear();
        self.hits.clear();
    }

    fn push(&mut self, node: Node, ray: Ray) {
        self.nodes.push(node);
        self.rays.push(ray);
    }

    /// There are times of all camera rays, or none.
    fn trace(&mut self, world: &World, times: &[f32]) -> u64 {
        self.hits.resize(self.rays.len(), Hit::MISS);
        self.times.clear();
        if !times.is_empty() {
            self.times.extend(self.nodes.iter().map(|node| times[node.path.index as usize]));
        }
        world.intersect_many_at(&self.rays, &self.times, &mut self.hits);
        let mut traced = self.rays.len() as u64;
        let Self { nodes: paths, rays, hits, .. } = self;
        for crossing in (PathsAtPanes { world, times, paths, rays, hits, traced: &mut traced }).pass() {
            if let Some(pane) = crossing.mirrored {
                let Node { path, media, .. } = &mut self.nodes[crossing.source];
                path.throughput *= media.transmittance(world, pane.t);
            }
        }
        traced
    }
}

impl AsMut<Path> for Node {
    fn as_mut(&mut self) -> &mut Path {
        &mut self.path
    }
}

/// The shared data of all surfaces.
struct Gather<'a> {
    world: &'a World,
    /// The times of all camera rays, or empty.
    times: &'a [f32],
    options: &'a MonteCarloOptions,
    hemisphere: Hemisphere,
}

impl Gather<'_> {
    /// Collects the light at the end of a ray, and sends out the rays that gather there.
    fn branch(
        &self,
        node: &Node,
        ray: &Ray,
        hit: &Hit,
        sampler: &Sampler,
        children: &mut Generation,
        radiance: &mut Vec3,
    ) {
        let (world, path) = (self.world, &node.path);
        let how = (LIGHTS, SkyPart::All);
        let until = (hit.t, time_of(self.times, path.index as usize));
        lights_on_the_way(world, how, path, ray, until, |_, light| *radiance += path.throughput * light);
        if !hit.is_hit() {
            *radiance += path.throughput * sky(world, how, path, (ray, &world.lights.sky.view(ray.direction)));
            return;
        }
        let surface = world.surface_at(hit);
        *radiance += path.throughput * emission(world, how, path, &surface, ray, hit);

        let mut surface = surface.facing(ray.direction);
        let scattering = world.scattering(&mut surface);
        let set = node.first_set();
        let [finer, chance] = sampler.uniform2(set).to_array();
        let u_light = sampler.uniform2(set.wrapping_add(1));
        let choice = unit_double(Vec2::new(u_light.x, finer));
        for shadow_ray in sample_direct(world, &surface, &scattering, how, (choice, u_light.y)) {
            children.shadow_queue.push(path.index, path.throughput, shadow_ray);
        }
        if node.bounces > 0 {
            self.gather(node, &surface, &scattering, sampler, children);
        }
        let child = node.child(self.options.rays, 0);
        let Some(bounce) = scattering.sample(child.direction_numbers(sampler)) else { return };
        let mut throughput = path.throughput * bounce.weight;
        if bounce.density < f32::INFINITY {
            // It would be one of the rays that gather, if there are any; else it begins or continues the tail.
            let (0, Some(survival)) = (node.bounces, self.options.tail) else { return };
            let survival = survive(survival, throughput);
            if chance >= survival {
                return;
            }
            throughput /= survival;
        }
        let sky_probability = sky_probability(world, &surface, SkyPart::All);
        let is_mirrored = bounce.density == f32::INFINITY;
        let normal = if is_mirrored { path.normal_mirrored() } else { surface.receiver().packed() };
        let path = Path { throughput, density: bounce.density, sky_probability, normal, ..*path };
        children.push(Node { path, ..child }, leave(&surface, bounce.direction));
    }

    /// Sends rays out for what the surface scatters, but for mirrors and clear glass: over strata of the hemisphere if that is
    /// diffuse light alone, else where the closure scatters to.
    fn gather(
        &self,
        node: &Node,
        surface: &Surface,
        scattering: &Scattering<Closure>,
        sampler: &Sampler,
        children: &mut Generation,
    ) {
        let is_matte = self.world.kind(surface.prim_id) == Kind::Matte;
        let throughput = node.path.throughput / self.hemisphere.rays() as f32;
        if throughput == Vec3::ZERO || (is_matte && surface.diffuse == Vec3::ZERO) {
            return;
        }
        let (frame, normal) = (surface.frame(), surface.receiver().packed());
        let sky_probability = sky_probability(self.world, surface, SkyPart::All);
        for number in 0..self.hemisphere.rays() {
            let child = node.child(self.options.rays, number);
            let u = child.direction_numbers(sampler);
            let (direction, weight) = if is_matte {
                let (local, weight) = self.hemisphere.direction(number, u);
                let direction = surface.above(frame.to_world(local));
                let reflected = if scattering.shading().bumps().are_there() {
                    let (f_cos, density) = scattering.eval(direction);
                    f_cos / density.max(f32::MIN_POSITIVE)
                } else {
                    surface.diffuse
                };
                (direction, weight * reflected)
            } else {
                match scattering.sample(u) {
                    Some(bounce) if bounce.density < f32::INFINITY => (bounce.direction, bounce.weight),
                    _ => continue,
                }
            };
            // Any finite density will do, for all that light samples can find is left to them.
            let path = Path { throughput: throughput * weight, density: 0.0, sky_probability, normal, ..node.path };
            children.push(Node { path, bounces: node.bounces - 1, ..child }, leave(surface, direction));
        }
    }
}

impl Node {
    /// Child `k` of `rays`. The factor is odd, or the numbers of long chains of mirrors would come to rest at one.
    fn child(&self, rays: u32, k: u32) -> Self {
        Self { number: self.number.wrapping_mul(rays | 1).wrapping_add(1 + k), ..*self }
    }

    fn first_set(&self) -> u32 {
        FIRST_SET.wrapping_add(self.number.wrapping_mul(SETS_PER_RAY))
    }

    fn direction_numbers(&self, sampler: &Sampler) -> Vec2 {
        sampler.uniform2(self.first_set().wrapping_add(2))
    }
}

fn leave(surface: &Surface, direction: Vec3) -> Ray {
    Ray::new(surface.origin_towards(direction), direction)
}
