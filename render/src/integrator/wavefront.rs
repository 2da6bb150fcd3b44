//! All paths of a batch, side by side, and the shadow rays that they wait for.

use glam::Vec3;
use halfdome_kernel::{Hit, Ray};

use super::CameraRays;
use crate::estimator::Connection;
use crate::world::World;

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
    pub(super) connections: Connections,
}

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
    }

    /// Lets `step` take each path from its hit to its next ray, or end it.
    #[inline]
    pub(super) fn advance(&mut self, mut step: impl FnMut(Path, &Ray, &Hit, &mut Connections) -> Option<(Path, Ray)>) {
        let mut kept = 0;
        for i in 0..self.paths.len() {
            let next = step(self.paths[i], &self.rays[i], &self.hits[i], &mut self.connections);
            if let Some((path, ray)) = next {
                (self.paths[kept], self.rays[kept]) = (path, ray);
                kept += 1;
            }
        }
        self.paths.truncate(kept);
        self.rays.truncate(kept);
        self.hits.truncate(kept);
    }

    /// Adds the light whose shadow rays are free; gives their number.
    pub(super) fn connect(&mut self, world: &World, radiance: &mut [Vec3]) -> u64 {
        self.connections.resolve(world, radiance)
    }

    /// Finds the paths' next hits; gives the number of rays.
    pub(super) fn trace(&mut self, world: &World) -> u64 {
        world.tree().intersect_many(&self.rays, &mut self.hits);
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
        world.tree().occluded_many(&self.shadows, &mut self.occluded);
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
