//! A ray of its own for each pixel.

use std::sync::Arc;

use glam::Vec3;

use super::FilmPoint;
use crate::scene::RayTable;

/// The least angle that a pixel counts for where neighbours have the same ray.
const MIN_ANGLE: f32 = 1e-4;

/// The rays, for a film of their size, or of another, which takes some of them.
#[derive(Clone, Debug)]
pub(super) struct Table {
    rays: Arc<RayTable>,
    size: (u32, u32),
}

impl Table {
    pub(super) fn new(rays: Arc<RayTable>, size: (u32, u32)) -> Self {
        Self { rays, size }
    }

    /// Origin and direction of a pixel's ray; a sample's place in the pixel does not matter.
    pub(super) fn ray(&self, film: &FilmPoint) -> [Vec3; 2] {
        let (x, y) = self.place(film);
        self.at(x, y)
    }

    /// The pixel of the table.
    fn place(&self, film: &FilmPoint) -> (u32, u32) {
        let RayTable { width, height, .. } = *self.rays;
        let scaled = |at: u32, from: u32, to: u32| {
            let scaled = (2 * u64::from(at) + 1) * u64::from(to) / (2 * u64::from(from));
            scaled.min(u64::from(to) - 1) as u32
        };
        (scaled(film.pixel.0, self.size.0, width), scaled(film.pixel.1, self.size.1, height))
    }

    fn at(&self, x: u32, y: u32) -> [Vec3; 2] {
        self.rays.rays[y as usize * self.rays.width as usize + x as usize]
    }

    /// How far apart, at a distance, the rays of a pixel and of its neighbours are.
    pub(super) fn pixel_width(&self, film: &FilmPoint, distance: f32) -> f32 {
        let (x, y) = self.place(film);
        let end = |[origin, direction]: [Vec3; 2]| origin + direction * distance;
        let beside = |at: u32, count: u32| if at + 1 < count { Some(at + 1) } else { at.checked_sub(1) };
        let here = end(self.at(x, y));
        let right = beside(x, self.rays.width).map(|x| end(self.at(x, y)).distance(here));
        let below = beside(y, self.rays.height).map(|y| end(self.at(x, y)).distance(here));
        let width = match (right, below) {
            (Some(right), Some(below)) => (right * below).sqrt(),
            (one, other) => one.or(other).unwrap_or(0.0),
        };
        width.max(MIN_ANGLE * distance)
    }
}
