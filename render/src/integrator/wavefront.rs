//! All paths of a batch, side by side: rays → hits → a step of each path → shadow rays and next rays.

mod order;

use bytemuck::Zeroable;
use glam::{Vec2, Vec3};
use halfdome_kernel::sampling::warp::{CosineHemisphere, Warp};
use halfdome_kernel::sampling::{SampleId, Sampler};
use halfdome_kernel::{Ray, Task};

use super::RayBatch;
use super::media::{Arrival, Media};
use super::panes::{Crossing, PathsAtPanes};
use super::shadow_queue::ShadowQueue;
use super::state::{Path, u_light_choice};
use crate::bsdf::Scattering;
use crate::estimator::lit_at;
use crate::material::Closure;
use crate::world::{Hit, MIDDLE, Surface, World};

/// The step of paths at their surfaces, which differs between integrators.
pub(super) trait WavefrontStep {
    /// The greatest number of hits on a path.
    fn max_depth(&self) -> u32;

    /// Takes all paths from their hit number `depth` to their next ray, and removes those that have ended. Light that
    /// they find on the way is added to `radiance`, and light that waits for a shadow ray to the shadow queue.
    fn advance(&mut self, wave: &mut Wavefront, batch: &RayBatch, depth: u32, radiance: &mut [Vec3]);

    /// Sees the rays of each step before they are traced.
    fn watch(&mut self, _wave: &Wavefront) {}

    /// Sees which shadow rays are free, after they are traced.
    fn resolved(&mut self, _wave: &Wavefront) {}
}

/// Paths that take their steps one by one.
pub(super) struct ScalarSteps<'w, S> {
    pub world: &'w World,
    pub step: S,
}

/// The step of one path.
pub(super) trait VertexStep {
    /// The greatest number of hits on a path.
    fn max_depth(&self) -> u32;

    /// Takes a path from its hit to its next ray, or ends it. Light that it finds on the way is added to `radiance`,
    /// and light that waits for a shadow ray to `shadow_queue`.
    fn step(
        &mut self,
        path: Path,
        vertex: &PathVertex,
        shadow_queue: &mut ShadowQueue,
        radiance: &mut Vec3,
    ) -> Option<(Path, Ray)>;
}

impl<S: VertexStep> WavefrontStep for ScalarSteps<'_, S> {
    fn max_depth(&self) -> u32 {
        self.step.max_depth()
    }

    fn advance(&mut self, wave: &mut Wavefront, batch: &RayBatch, depth: u32, radiance: &mut [Vec3]) {
        wave.draw(self.world, batch, depth);
        wave.note_crossings(self.world, batch.times);
        self.world.isa().run(Advance { world: self.world, wave, step: &mut self.step, radiance });
    }
}

/// The hit of a path.
pub(super) struct PathVertex<'a> {
    pub ray: &'a Ray,
    pub hit: &'a Hit,
    /// The transmittance of solids and panes on the way there; the path's throughput includes it.
    pub transmittance: Vec3,
    /// Whether a pane on the way has reflected the path, so that its density is infinite now.
    pub is_mirrored: bool,
    /// The path's time.
    pub time: f32,
    pub numbers: Numbers,
}

/// Random numbers for a surface on a path.
#[derive(Clone, Copy)]
pub(super) struct Numbers {
    u_light: Vec2,
    /// The continuation of the path.
    pub u_direction: Vec2,
    /// The direction about the normal that `onwards` means by the cosine.
    pub cosine: Vec3,
}

/// Paths: element `i` of each list belongs to the same one, and finished ones are gone.
#[derive(Default)]
pub(crate) struct Wavefront {
    pub(super) paths: Vec<Path>,
    pub(super) rays: Vec<Ray>,
    pub(super) hits: Vec<Hit>,
    /// The times of the paths, if anything moves.
    times: Vec<f32>,
    /// The solids that the paths are in, if any absorbs.
    pub(super) media: Vec<Media>,
    /// The media of the continuing paths.
    pub(super) next_media: Vec<Media>,
    /// The paths' numbers, sorted by the kind of closure that they have hit; last come those that hit nothing.
    pub(super) order: Vec<u32>,
    /// The continuing paths, while the others are still needed, and their rays.
    next_paths: Vec<Path>,
    next_rays: Vec<Ray>,
    /// The paths that were aimed at secondary lights in this step, which continue behind the others, and their media.
    pub(super) aimed: Vec<(Ray, Path)>,
    pub(super) aimed_media: Vec<Media>,
    /// The addresses of all camera rays, by index.
    pub(super) addresses: Vec<SampleId>,
    /// The addresses of the paths, where numbers are drawn for all at once.
    drawn: Vec<SampleId>,
    u_light: Vec<Vec2>,
    u_direction: Vec<Vec2>,
    cosine: Vec<Vec3>,
    pub(super) shadow_queue: ShadowQueue,
    /// By path, what panes have left of its light in this step, and whether they have reflected it; empty if none has met any.
    crossed: Vec<(Vec3, bool)>,
    /// The number of rays that were traced in between, for paths and shadow rays at panes.
    pub(super) traced_at_panes: u64,
}

/// Sets of random numbers that a path uses at a surface: on the light, for the next direction, and for going on.
pub(super) const SETS_PER_SURFACE: u32 = 3;

/// The first set of random numbers for hit number `depth`.
pub(super) fn first_set(batch: &RayBatch, depth: u32) -> u32 {
    batch.first_set + (depth - 1) * SETS_PER_SURFACE
}

impl Path {
    /// Goes on from a surface that mirrors or refracts; ends where it scatters, or absorbs.
    #[inline]
    pub(super) fn through(
        self,
        surface: &Surface,
        scattering: &Scattering<Closure>,
        vertex: &PathVertex,
    ) -> Option<(Self, Ray)> {
        let bounce = scattering.sample(vertex.numbers.u_direction)?;
        if bounce.density != f32::INFINITY {
            return None;
        }
        let (throughput, normal) = (self.throughput * bounce.weight, self.normal_mirrored());
        let next = Self { throughput, density: bounce.density, normal, ..self };
        Some((next, Ray::new(surface.origin_towards(bounce.direction), bounce.direction)))
    }
}

impl Numbers {
    /// Two numbers that choose the light and a point on it. The first has its last bits from the next direction's: as
    /// neither enters the other's term of the sum, that makes no bias.
    #[inline]
    pub(super) fn light(&self) -> (f64, f32) {
        (u_light_choice(self.u_light, self.u_direction), self.u_light.y)
    }
}

impl Wavefront {
    /// Follows paths from the camera's rays on until all have ended, and writes the light that each finds; gives the
    /// number of rays traced.
    pub(super) fn follow(
        &mut self,
        world: &World,
        batch: &RayBatch,
        step: &mut impl WavefrontStep,
        radiance: &mut [Vec3],
    ) -> u64 {
        radiance.fill(Vec3::ZERO);
        self.start(world, batch);
        let mut traced = 0;
        for depth in 1..=step.max_depth() {
            step.advance(self, batch, depth, radiance);
            step.watch(self);
            traced += self.shadow_queue.resolve(world, batch.times, radiance);
            step.resolved(self);
            if self.paths.is_empty() {
                break;
            }
            self.times.clear();
            if !batch.times.is_empty() {
                self.times.extend(self.paths.iter().map(|path| batch.times[path.index as usize]));
            }
            world.intersect_many_at(&self.rays, &self.times, &mut self.hits);
            traced += self.rays.len() as u64;
        }
        traced + std::mem::take(&mut self.traced_at_panes)
    }

    /// Takes bounces and aimed paths straight through panes, or reflects them; gives what has happened to them.
    pub(super) fn pass_panes(&mut self, world: &World, times: &[f32]) -> Vec<Crossing> {
        let Self { paths, rays, hits, traced_at_panes: traced, .. } = self;
        let mut crossings = PathsAtPanes { world, times, paths, rays, hits, traced }.pass();
        for Crossing { source, factor, mirrored } in &mut crossings {
            if let Some(pane) = mirrored {
                let on_the_way = self.transmittance(world, *source, pane.t);
                self.paths[*source].throughput *= on_the_way;
                *factor *= on_the_way;
            }
        }
        crossings
    }

    /// The same, for steps of one path at a time.
    fn note_crossings(&mut self, world: &World, times: &[f32]) {
        let crossings = self.pass_panes(world, times);
        self.crossed.clear();
        if !crossings.is_empty() {
            self.crossed.resize(self.paths.len(), (Vec3::ONE, false));
        }
        for Crossing { source, factor, mirrored } in crossings {
            let (transmittance, is_mirrored) = &mut self.crossed[source];
            *transmittance *= factor;
            *is_mirrored |= mirrored.is_some();
        }
    }

    /// Starts a path with each camera ray, in the memory of the paths before.
    fn start(&mut self, world: &World, batch: &RayBatch) {
        self.paths.clear();
        self.paths.extend((0..batch.rays.len() as u32).map(|index| Path::from_camera(index, batch.density)));
        self.rays.clear();
        self.rays.extend_from_slice(batch.rays);
        self.hits.clear();
        self.hits.extend_from_slice(batch.hits);
        self.addresses.clear();
        self.addresses.extend(batch.samplers.iter().map(Sampler::address));
        self.times.clear();
        self.times.extend_from_slice(batch.times);
        self.media.clear();
        self.next_media.clear();
        if world.has_absorption() {
            self.media.resize(batch.rays.len(), Media::default());
        }
    }

    /// Draws the numbers that all paths use at hit number `depth`.
    fn draw(&mut self, world: &World, batch: &RayBatch, depth: u32) {
        let Some(sampler) = batch.samplers.first() else { return };
        let (isa, count) = (world.isa(), self.paths.len());
        let first_set = first_set(batch, depth);
        self.drawn.clear();
        self.drawn.extend(self.paths.iter().map(|path| self.addresses[path.index as usize]));
        let draw = |set: u32, numbers: &mut Vec<Vec2>| {
            numbers.resize(count, Vec2::ZERO);
            sampler.fill2(isa, first_set + set, &self.drawn, numbers);
        };
        draw(0, &mut self.u_light);
        draw(1, &mut self.u_direction);
        self.cosine.resize(count, Vec3::Z);
        CosineHemisphere.map_many(isa, &self.u_direction, &mut self.cosine);
    }

    /// Lets all paths take a step.
    #[inline(always)]
    fn advance(&mut self, world: &World, step: &mut impl VertexStep, radiance: &mut [Vec3]) {
        let mut kept = 0;
        for i in 0..self.paths.len() {
            let numbers =
                Numbers { u_light: self.u_light[i], u_direction: self.u_direction[i], cosine: self.cosine[i] };
            let (mut path, ray, hit) = (self.paths[i], &self.rays[i], &self.hits[i]);
            let waiting = self.shadow_queue.len();
            let media = self.media.get(i).filter(|_| hit.is_hit());
            let arrival = media.map(|media| Arrival { world, media: *media, boundary: world.boundary(ray, hit) });
            let transmittance = arrival.map_or(Vec3::ONE, |arrival| arrival.transmittance(hit.t));
            path.throughput *= transmittance;
            let time = self.times.get(i).copied().unwrap_or(MIDDLE);
            let (by_panes, is_mirrored) = self.crossed.get(i).copied().unwrap_or((Vec3::ONE, false));
            let transmittance = transmittance * by_panes;
            let vertex = PathVertex { ray, hit, transmittance, is_mirrored, time, numbers };
            let next = step.step(path, &vertex, &mut self.shadow_queue, &mut radiance[path.index as usize]);
            if let Some(arrival) = arrival {
                self.shadow_queue.dim(waiting, |ray| arrival.transmittance_of(ray));
                if let Some((_, ray)) = &next {
                    self.media[kept] = arrival.onwards(ray.direction);
                }
            }
            if let Some((path, ray)) = next {
                (self.paths[kept], self.rays[kept]) = (path, ray);
                kept += 1;
            }
        }
        self.keep(kept);
    }

    /// The transmittance over a distance along a path.
    pub(super) fn transmittance(&self, world: &World, path: usize, distance: f32) -> Vec3 {
        self.media.get(path).map_or(Vec3::ONE, |media| media.transmittance(world, distance))
    }

    /// Lets paths that were aimed at a triangle and have come to another one find nothing.
    pub(super) fn lose_aimed(&mut self, world: &World) {
        for ((path, hit), ray) in self.paths.iter_mut().zip(&mut self.hits).zip(&self.rays) {
            if !path.is_aimed() {
                continue;
            }
            let at = lit_at(world, ray, hit);
            if at.is_none_or(|(at, _)| path.target != at.part.cell.prim_id + 1) {
                path.throughput = Vec3::ZERO;
                *hit = Hit::MISS;
            }
        }
    }

    /// Reserves room for `count` more continuing paths after the first `kept`.
    #[inline(always)]
    pub(super) fn next_places(&mut self, kept: usize, count: usize) -> (&mut [Ray], &mut [Path]) {
        if self.next_rays.len() < kept + count {
            self.next_rays.resize(kept + count, Ray::zeroed());
            self.next_paths.resize(kept + count, Path::zeroed());
        }
        (&mut self.next_rays[kept..], &mut self.next_paths[kept..])
    }

    /// Replaces all paths by the first continuing ones, and those that were aimed.
    pub(super) fn keep_next(&mut self, count: usize) {
        let mut aimed = std::mem::take(&mut self.aimed);
        let (rays, paths) = self.next_places(count, aimed.len());
        for ((ray, path), aimed) in rays.iter_mut().zip(paths).zip(&aimed) {
            (*ray, *path) = *aimed;
        }
        let count = count + aimed.len();
        aimed.clear();
        self.aimed = aimed;
        self.next_media.append(&mut self.aimed_media);
        std::mem::swap(&mut self.rays, &mut self.next_rays);
        std::mem::swap(&mut self.paths, &mut self.next_paths);
        std::mem::swap(&mut self.media, &mut self.next_media);
        self.next_media.clear();
        // There may be more aimed paths than there were paths.
        self.hits.resize(count.max(self.hits.len()), Hit::MISS);
        self.keep(count);
    }

    /// Keeps the first paths, which continue.
    pub(super) fn keep(&mut self, count: usize) {
        self.paths.truncate(count);
        self.rays.truncate(count);
        self.hits.truncate(count);
        self.media.truncate(count);
    }

    /// The numbers of the paths' camera rays.
    pub(super) fn indices(&self) -> impl Iterator<Item = usize> {
        self.paths.iter().map(|path| path.index as usize)
    }
}

/// All paths' step, as a task: compiled for each instruction set, as there is no batch that it
/// could be.
struct Advance<'a, S> {
    world: &'a World,
    wave: &'a mut Wavefront,
    step: &'a mut S,
    radiance: &'a mut [Vec3],
}

impl<S: VertexStep> Task for Advance<'_, S> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        self.wave.advance(self.world, self.step, self.radiance);
    }
}
