//! How much of what shines from infinitely far away reaches the surfaces that a picture shows, estimated.
//!
//! In a room the sky and the sun could send more to each point than all lamps, but walls stand in between, and the lamps would
//! get a few samples in a hundred. So their weights are multiplied by the part of the points that they reach: of those that
//! the camera sees and those that these see, by the cosine. It says how often a light is chosen, not what it is worth, so that a
//! poor estimate makes noise and no bias.

use glam::Vec2;
use halfdome_kernel::sampling::warp::{CosineHemisphere, Warp};
use halfdome_kernel::sampling::{Pattern, Sampler};
use halfdome_kernel::{Hit, Ray};

use super::{Surface, World};
use crate::camera::Camera;
use crate::light::SkyPart;

/// Camera rays, along each side of the picture.
const SIDE: u32 = 32;
/// What lies in the shadow nearly everywhere counts as if it reached this part of the points.
const LEAST: f32 = 0.05;

impl World {
    /// Tells the lights how far they reach.
    pub(super) fn estimate_light_visibility(&mut self) {
        if !self.lights.has_distant() {
            return;
        }
        let camera = Camera::new(&self.camera, SIDE, SIDE);
        let rays: Vec<Ray> =
            (0..SIDE * SIDE).map(|i| camera.ray((i % SIDE) as f32 + 0.5, (i / SIDE) as f32 + 0.5)).collect();
        let seen = self.surfaces_along(&rays);
        let (rays, next) = self.scatter(&seen, 0);
        let (further, last) = self.scatter(&next, 1);
        let scattered = rays + further;
        if scattered == 0 {
            return;
        }
        let escapes = scattered - next.len() - last.len();
        let open = escapes as f32 / scattered as f32;
        let points: Vec<Surface> = seen.into_iter().chain(next).collect();
        let directional: Vec<f32> = (0..self.lights.directional_count())
            .map(|i| {
                let towards = self.lights.towards_directional(i);
                self.reached(points.iter().map(|point| (point, towards)))
            })
            .collect();
        let sky = [SkyPart::All, SkyPart::Bright, SkyPart::Sun].map(|part| {
            let directions = points.iter().zip(0..).map(|(point, number)| {
                let u = Sampler::new(Pattern::Sobol, 0, 2, number).uniform2(0);
                (point, self.lights.sky.sample(&point.receiver(), part, u).direction)
            });
            self.reached(directions)
        });
        self.lights.set_visibility(&directional, sky, open);
    }

    /// The part of the points that are lit from the direction beside each, among those whose front it is on.
    fn reached<'a>(&self, directions: impl Iterator<Item = (&'a Surface<'a>, glam::Vec3)>) -> f32 {
        let rays: Vec<Ray> = directions
            .filter(|(point, direction)| {
                point.normal.dot(*direction) > 0.0 && point.shading_normal.dot(*direction) > 0.0
            })
            .map(|(point, direction)| Ray::new(point.origin_towards(direction), direction))
            .collect();
        let mut occluded = vec![false; rays.len()];
        self.occluded_many(&rays, &mut occluded);
        let free = occluded.iter().filter(|occluded| !**occluded).count();
        if rays.is_empty() { 1.0 } else { (free as f32 / rays.len() as f32).max(LEAST) }
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
