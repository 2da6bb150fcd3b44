//! A few points of surfaces that paths come to: those that the camera sees, and those that these see by the cosine.

use glam::Vec2;
use halfdome_kernel::sampling::warp::{CosineHemisphere, Warp};
use halfdome_kernel::sampling::{Pattern, Sampler};
use halfdome_kernel::{Hit, Ray};

use super::{Surface, World};
use crate::camera::FilmPoint;

/// Camera rays, along each side of the picture.
const SIDE: u32 = 32;

/// Such points, whose normals face whoever sees them.
pub(super) struct SeenPoints<'w> {
    seen: Vec<Surface<'w>>,
    next: Vec<Surface<'w>>,
    last: Vec<Surface<'w>>,
    /// The part of scattered rays that leave the scene.
    pub escaped: f32,
}

impl SeenPoints<'_> {
    /// Those from which rays were scattered.
    pub(super) fn all(&self) -> impl Iterator<Item = &Surface<'_>> {
        self.seen.iter().chain(&self.next)
    }

    /// Those that scattered rays met.
    pub(super) fn scattered(&self) -> impl Iterator<Item = &Surface<'_>> {
        self.next.iter().chain(&self.last)
    }
}

impl World {
    /// Points that paths come to; `None` if the camera sees nothing.
    pub(super) fn seen_points(&self) -> Option<SeenPoints<'_>> {
        let camera = self.camera_on(SIDE, SIDE);
        let pixels = (0..SIDE * SIDE).map(|i| FilmPoint::middle(i % SIDE, i / SIDE));
        let rays: Vec<Ray> = pixels.filter_map(|pixel| camera.central_ray(&pixel)).collect();
        let seen = self.surfaces_along(&rays);
        let (rays, next) = self.scatter(&seen, 0);
        let (further, last) = self.scatter(&next, 1);
        let scattered = rays + further;
        let escaped = (scattered - next.len() - last.len()) as f32 / scattered as f32;
        (scattered > 0).then_some(SeenPoints { seen, next, last, escaped })
    }

    /// Sends a ray by the cosine from each point; gives their number, and where they hit something.
    fn scatter(&self, points: &[Surface], set: u32) -> (usize, Vec<Surface<'_>>) {
        let ray = |(point, number): (&Surface, u32)| {
            let u: Vec2 = Sampler::new(Pattern::Sobol, 0, 1, number).uniform2(set);
            let direction = point.frame().to_world(CosineHemisphere.map(u));
            (point.normal.dot(direction) > 0.0).then(|| Ray::new(point.origin_towards(direction), direction))
        };
        let rays: Vec<Ray> = points.iter().zip(0..).filter_map(ray).collect();
        (rays.len(), self.surfaces_along(&rays))
    }

    /// The surfaces that rays hit, facing them.
    fn surfaces_along(&self, rays: &[Ray]) -> Vec<Surface<'_>> {
        let mut hits = vec![Hit::MISS; rays.len()];
        self.intersect_many(rays, &mut hits);
        let hits = hits.iter().zip(rays).filter(|(hit, _)| hit.is_hit());
        hits.map(|(hit, ray)| self.surface_at(hit).facing(ray.direction)).collect()
    }
}
