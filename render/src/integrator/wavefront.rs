//! All paths of a batch, side by side: rays → hits → a step of each path → shadow rays and next rays.

use bytemuck::{Pod, Zeroable};
use glam::{Vec2, Vec3};
use halfdome_kernel::sampling::warp::{CosineHemisphere, Warp};
use halfdome_kernel::sampling::{Address, Sampler, unit_double};
use halfdome_kernel::{Hit, Isa, Ray, Task};

use super::CameraRays;
use super::block::{LANES, Shadows};
use crate::estimator::Connection;
use crate::world::{Surface, World};

/// What paths do at their surfaces: all that one integrator has to itself.
pub(super) trait Walk {
    /// The greatest number of hits on a path.
    fn max_depth(&self) -> u32;

    /// Takes all paths from their hit number `depth` to their next ray, and removes those that have ended. Light that
    /// they find on the way is added to `radiance`, and light that waits for a shadow ray to the connections.
    fn advance(&mut self, wave: &mut Wavefront, camera: &CameraRays, depth: u32, radiance: &mut [Vec3]);

    /// Sees the rays of each step before they are traced.
    fn watch(&mut self, _wave: &Wavefront) {}
}

/// Paths that take their steps one by one.
pub(super) struct OneByOne<'w, S> {
    pub world: &'w World,
    pub step: S,
}

/// The step of one path.
pub(super) trait Step {
    /// The greatest number of hits on a path.
    fn max_depth(&self) -> u32;

    /// Takes a path from its hit to its next ray, or ends it. Light that it finds on the way is added to `radiance`, and
    /// light that waits for a shadow ray to `connections`.
    fn step(
        &mut self,
        path: Path,
        arrival: &Arrival,
        connections: &mut Connections,
        radiance: &mut Vec3,
    ) -> Option<(Path, Ray)>;
}

impl<S: Step> Walk for OneByOne<'_, S> {
    fn max_depth(&self) -> u32 {
        self.step.max_depth()
    }

    fn advance(&mut self, wave: &mut Wavefront, camera: &CameraRays, depth: u32, radiance: &mut [Vec3]) {
        wave.draw(self.world, camera, depth);
        self.world.isa().run(Advance { wave, step: &mut self.step, radiance });
    }
}

/// A path that is under way, in eight words.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub(super) struct Path {
    /// Its camera ray.
    pub index: u32,
    /// What the light that it finds from here on is multiplied by.
    pub throughput: Vec3,
    /// Density per solid angle of its last bounce; infinite after mirrors and glass, and for the camera's ray.
    pub density: f32,
    /// The density with which sampling the sky would have taken the same direction.
    pub sky_density: f32,
    /// The triangle of its last bounce, if light was sampled there by [`prospect`](crate::estimator::prospect); else
    /// [`Hit::NO_PRIM`].
    pub from: u32,
    /// Makes a row of it.
    pub unused: u32,
}

/// Where a path has arrived.
pub(super) struct Arrival<'a> {
    pub ray: &'a Ray,
    pub hit: &'a Hit,
    pub numbers: Numbers,
}

/// Random numbers for a surface on a path.
#[derive(Clone, Copy)]
pub(super) struct Numbers {
    on_light: Vec2,
    /// Where the path goes on.
    pub onwards: Vec2,
    /// The direction about the normal that `onwards` means by the cosine.
    pub cosine: Vec3,
}

/// Paths: element `i` of each list belongs to the same one, and finished ones are gone.
#[derive(Default)]
pub(crate) struct Wavefront {
    pub(super) paths: Vec<Path>,
    pub(super) rays: Vec<Ray>,
    pub(super) hits: Vec<Hit>,
    /// Of all camera rays, by their numbers.
    pub(super) addresses: Vec<Address>,
    /// Of the paths, where numbers are drawn for all at once.
    drawn: Vec<Address>,
    on_light: Vec<Vec2>,
    onwards: Vec<Vec2>,
    cosine: Vec<Vec3>,
    pub(super) connections: Connections,
}

/// Sets of random numbers that a path uses at a surface: on the light, for the next direction, and for going on.
pub(super) const SETS_PER_SURFACE: u32 = 3;

/// The first set of random numbers for hit number `depth`.
pub(super) fn first_set(camera: &CameraRays, depth: u32) -> u32 {
    camera.first_set + (depth - 1) * SETS_PER_SURFACE
}

/// Light that arrives if its shadow ray is free.
#[derive(Default)]
pub(crate) struct Connections {
    /// How many wait: the first of each list.
    len: usize,
    shadows: Vec<Ray>,
    pending: Vec<Pending>,
    occluded: Vec<bool>,
}

/// What it adds to which camera ray's.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
struct Pending {
    index: u32,
    light: Vec3,
}

impl Path {
    /// The path that begins with the camera ray of this number, whose direction had this density.
    pub(super) fn from_camera(index: u32, density: f32) -> Self {
        Self { index, throughput: Vec3::ONE, density, sky_density: 0.0, from: Hit::NO_PRIM, unused: 0 }
    }

    /// Goes on from a surface that mirrors or refracts; ends where it scatters, or absorbs.
    #[inline]
    pub(super) fn through(self, surface: &Surface, arrival: &Arrival) -> Option<(Self, Ray)> {
        let bounce = surface.sample(arrival.ray.direction, arrival.numbers.onwards)?;
        if bounce.density != f32::INFINITY {
            return None;
        }
        let next = Self { throughput: self.throughput * bounce.weight, density: bounce.density, ..self };
        Some((next, Ray::new(surface.origin_towards(bounce.direction), bounce.direction)))
    }
}

impl Numbers {
    /// Two numbers that say which light is sampled, and where on it. The first has its last bits from the next
    /// direction's: as neither enters the other's term of the sum, that makes no bias.
    #[inline]
    pub(super) fn light(&self) -> (f64, f32) {
        (light_choice(self.on_light, self.onwards), self.on_light.y)
    }
}

/// The number that says which light is sampled.
#[inline(always)]
pub(super) fn light_choice(on_light: Vec2, onwards: Vec2) -> f64 {
    unit_double(Vec2::new(on_light.x, onwards.x))
}

impl Wavefront {
    /// Follows paths from the camera's rays on until all have ended, and writes the light that each finds; gives the
    /// number of rays traced.
    pub(super) fn follow(
        &mut self,
        world: &World,
        camera: &CameraRays,
        walk: &mut impl Walk,
        radiance: &mut [Vec3],
    ) -> u64 {
        radiance.fill(Vec3::ZERO);
        self.start(camera);
        let mut traced = 0;
        for depth in 1..=walk.max_depth() {
            walk.advance(self, camera, depth, radiance);
            walk.watch(self);
            traced += self.connections.resolve(world, radiance);
            if self.paths.is_empty() {
                break;
            }
            world.intersect_many(&self.rays, &mut self.hits);
            traced += self.rays.len() as u64;
        }
        traced
    }

    /// Starts a path with each camera ray, in the memory of the paths before.
    fn start(&mut self, camera: &CameraRays) {
        self.paths.clear();
        self.paths.extend((0..camera.rays.len() as u32).map(|index| Path::from_camera(index, camera.density)));
        self.rays.clear();
        self.rays.extend_from_slice(camera.rays);
        self.hits.clear();
        self.hits.extend_from_slice(camera.hits);
        self.addresses.clear();
        self.addresses.extend(camera.samplers.iter().map(Sampler::address));
    }

    /// Draws the numbers that all paths use at hit number `depth`.
    fn draw(&mut self, world: &World, camera: &CameraRays, depth: u32) {
        let Some(sampler) = camera.samplers.first() else { return };
        let (isa, count) = (world.isa(), self.paths.len());
        let first_set = first_set(camera, depth);
        self.drawn.clear();
        self.drawn.extend(self.paths.iter().map(|path| self.addresses[path.index as usize]));
        let draw = |set: u32, numbers: &mut Vec<Vec2>| {
            numbers.resize(count, Vec2::ZERO);
            sampler.fill2(isa, first_set + set, &self.drawn, numbers);
        };
        draw(0, &mut self.on_light);
        draw(1, &mut self.onwards);
        self.cosine.resize(count, Vec3::Z);
        CosineHemisphere.map_many(isa, &self.onwards, &mut self.cosine);
    }

    /// Lets all paths take a step.
    #[inline(always)]
    fn advance(&mut self, step: &mut impl Step, radiance: &mut [Vec3]) {
        let mut kept = 0;
        for i in 0..self.paths.len() {
            let numbers = Numbers { on_light: self.on_light[i], onwards: self.onwards[i], cosine: self.cosine[i] };
            let (path, arrival) = (self.paths[i], Arrival { ray: &self.rays[i], hit: &self.hits[i], numbers });
            let next = step.step(path, &arrival, &mut self.connections, &mut radiance[path.index as usize]);
            if let Some((path, ray)) = next {
                (self.paths[kept], self.rays[kept]) = (path, ray);
                kept += 1;
            }
        }
        self.keep(kept);
    }

    /// Keeps the first paths, those that go on.
    pub(super) fn keep(&mut self, count: usize) {
        self.paths.truncate(count);
        self.rays.truncate(count);
        self.hits.truncate(count);
    }

    /// The numbers of the paths' camera rays.
    pub(super) fn indices(&self) -> impl Iterator<Item = usize> {
        self.paths.iter().map(|path| path.index as usize)
    }
}

/// All paths' step, as a task: compiled for each instruction set, as there is no batch that it
/// could be.
struct Advance<'a, S> {
    wave: &'a mut Wavefront,
    step: &'a mut S,
    radiance: &'a mut [Vec3],
}

impl<S: Step> Task for Advance<'_, S> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        self.wave.advance(self.step, self.radiance);
    }
}

impl Connections {
    /// Lets a connection wait, whose light is worth `throughput` to the camera ray `index`.
    #[inline]
    pub(super) fn push(&mut self, index: u32, throughput: Vec3, connection: Connection) {
        self.make_room(1);
        self.shadows[self.len] = connection.shadow;
        self.pending[self.len] = Pending { index, light: throughput * connection.radiance };
        self.len += 1;
    }

    /// Lets the light of the first `count` shadow rays of a block wait, of those that have any.
    #[inline(always)]
    pub(super) fn extend(&mut self, isa: Isa, shadows: &Shadows, count: usize) {
        self.make_room(LANES);
        self.len += shadows.keep(isa, count, &mut self.shadows[self.len..], &mut self.pending[self.len..]);
    }

    /// Makes room for `count` more. What was there is not cleared, for it is written over.
    #[inline(always)]
    fn make_room(&mut self, count: usize) {
        if self.shadows.len() < self.len + count {
            self.shadows.resize(2 * self.len + count, Ray::zeroed());
            self.pending.resize(2 * self.len + count, Pending::zeroed());
        }
    }

    /// Adds the light whose shadow rays are free; gives their number.
    pub(super) fn resolve(&mut self, world: &World, radiance: &mut [Vec3]) -> u64 {
        let count = std::mem::take(&mut self.len);
        self.occluded.resize(count, false);
        world.occluded_many(&self.shadows[..count], &mut self.occluded);
        for (Pending { index, light }, occluded) in self.pending.iter().zip(&self.occluded) {
            // Adding nothing is quicker than a branch that nobody can foresee.
            radiance[*index as usize] += if *occluded { Vec3::ZERO } else { *light };
        }
        count as u64
    }

    /// The shadow rays that wait, with the numbers of their camera rays.
    pub(super) fn waiting(&self) -> impl Iterator<Item = (usize, &Ray)> {
        self.pending[..self.len].iter().map(|pending| pending.index as usize).zip(&self.shadows)
    }
}
