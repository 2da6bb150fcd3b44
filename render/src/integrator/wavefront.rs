//! All paths of a batch, side by side, and the shadow rays that they wait for.

use glam::{Vec2, Vec3};
use halfdome_kernel::sampling::{Address, Sampler};
use halfdome_kernel::{Hit, Ray};

use super::CameraRays;
use crate::estimator::Connection;
use crate::world::{Surface, World};

/// A path that is under way.
#[derive(Clone, Copy, Debug)]
pub(super) struct Path {
    /// Its camera ray.
    pub index: usize,
    /// What the light that it finds from here on is multiplied by.
    pub throughput: Vec3,
    /// Density per solid angle of its last bounce; infinite after mirrors and glass, and for the camera's ray.
    pub density: f32,
    /// The density with which sampling the sky would have taken the same direction.
    pub sky_density: f32,
}

/// Paths: element `i` of each list belongs to the same one, and finished ones are gone.
#[derive(Default)]
pub(crate) struct Wavefront {
    paths: Vec<Path>,
    pub(super) rays: Vec<Ray>,
    hits: Vec<Hit>,
    addresses: Vec<Address>,
    numbers: [Vec<Vec2>; SETS_PER_SURFACE as usize],
    pub(super) connections: Connections,
}

/// Sets of random numbers that a path uses at a surface: which light and whether to go on, where on the light, and the
/// next direction.
pub(super) const SETS_PER_SURFACE: u32 = 3;

/// Light that arrives if its shadow ray is free.
#[derive(Default)]
pub(crate) struct Connections {
    shadows: Vec<Ray>,
    pending: Vec<(usize, Vec3)>,
    occluded: Vec<bool>,
}

impl Path {
    /// The path that begins with the camera ray of this number, whose direction had this density.
    pub(super) fn from_camera(index: usize, density: f32) -> Self {
        Self { index, throughput: Vec3::ONE, density, sky_density: 0.0 }
    }

    /// Goes on from a surface that mirrors or refracts; ends where it scatters, or absorbs.
    #[inline]
    pub(super) fn through(self, surface: &Surface, ray: &Ray, u: Vec2) -> Option<(Self, Ray)> {
        let bounce = surface.sample(ray.direction, u)?;
        if bounce.density != f32::INFINITY {
            return None;
        }
        let next = Self { throughput: self.throughput * bounce.weight, density: bounce.density, ..self };
        Some((next, Ray::new(surface.origin_towards(bounce.direction), bounce.direction)))
    }
}

impl Wavefront {
    /// Starts a path with each camera ray, in the memory of the paths before.
    pub(super) fn start(&mut self, camera: &CameraRays) {
        self.paths.clear();
        self.paths.extend((0..camera.rays.len()).map(|index| Path::from_camera(index, camera.density)));
        self.rays.clear();
        self.rays.extend_from_slice(camera.rays);
        self.hits.clear();
        self.hits.extend_from_slice(camera.hits);
        self.addresses.clear();
        self.addresses.extend(camera.samplers.iter().map(Sampler::address));
    }

    /// Draws the numbers that all paths use at their next surface, from set `first_set` on.
    fn draw(&mut self, world: &World, camera: &CameraRays, first_set: u32) {
        let Some(sampler) = camera.samplers.first() else { return };
        for (set, numbers) in (first_set..).zip(&mut self.numbers) {
            numbers.resize(self.addresses.len(), Vec2::ZERO);
            sampler.fill2(world.tree().isa(), set, &self.addresses, numbers);
        }
    }

    /// Lets `step` take each path from its hit number `depth` to its next ray, or end it.
    #[inline]
    pub(super) fn advance(
        &mut self,
        world: &World,
        camera: &CameraRays,
        depth: u32,
        mut step: impl FnMut(Path, &Ray, &Hit, [Vec2; SETS_PER_SURFACE as usize], &mut Connections) -> Option<(Path, Ray)>,
    ) {
        self.draw(world, camera, camera.first_set + (depth - 1) * SETS_PER_SURFACE);
        let mut kept = 0;
        for i in 0..self.paths.len() {
            let [first, second, third] = &self.numbers;
            let numbers = [first[i], second[i], third[i]];
            let next = step(self.paths[i], &self.rays[i], &self.hits[i], numbers, &mut self.connections);
            if let Some((path, ray)) = next {
                (self.paths[kept], self.rays[kept], self.addresses[kept]) = (path, ray, self.addresses[i]);
                kept += 1;
            }
        }
        self.paths.truncate(kept);
        self.rays.truncate(kept);
        self.hits.truncate(kept);
        self.addresses.truncate(kept);
    }

    /// Adds the light whose shadow rays are free; gives their number.
    pub(super) fn connect(&mut self, world: &World, radiance: &mut [Vec3]) -> u64 {
        self.connections.resolve(world, radiance)
    }

    /// Finds the paths' next hits; gives the number of rays.
    pub(super) fn trace(&mut self, world: &World) -> u64 {
        world.intersect_many(&self.rays, &mut self.hits);
        self.rays.len() as u64
    }

    /// Whether all paths have ended.
    pub(super) fn is_empty(&self) -> bool {
        self.paths.is_empty()
    }

    /// The numbers of the paths' camera rays.
    pub(super) fn indices(&self) -> impl Iterator<Item = usize> {
        self.paths.iter().map(|path| path.index)
    }
}

impl Connections {
    /// Lets a connection wait, whose light is worth `throughput` to the camera ray `index`.
    #[inline]
    pub(super) fn push(&mut self, index: usize, throughput: Vec3, connection: Connection) {
        self.pending.push((index, throughput * connection.radiance));
        self.shadows.push(connection.shadow);
    }

    /// Adds the light whose shadow rays are free; gives their number.
    pub(super) fn resolve(&mut self, world: &World, radiance: &mut [Vec3]) -> u64 {
        self.occluded.resize(self.shadows.len(), false);
        world.occluded_many(&self.shadows, &mut self.occluded);
        for ((index, light), occluded) in self.pending.iter().zip(&self.occluded) {
            if !occluded {
                radiance[*index] += *light;
            }
        }
        let traced = self.shadows.len() as u64;
        self.pending.clear();
        self.shadows.clear();
        traced
    }

    /// The shadow rays that wait, with the numbers of their camera rays.
    pub(super) fn waiting(&self) -> impl Iterator<Item = (usize, &Ray)> {
        self.pending.iter().map(|(index, _)| *index).zip(&self.shadows)
    }
}
