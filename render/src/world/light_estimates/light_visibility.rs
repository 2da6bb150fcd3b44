//! An estimate of the part of the visible surfaces that lights at infinity reach.
//!
//! In a room the unoccluded sky and sun would outweigh all lamps, but walls block them, and the lamps would get few
//! samples. So their weights are multiplied by the fraction of points that they reach, among camera hits and the hits
//! of cosine-distributed rays from there. This only affects the probability of a light, so a poor estimate causes noise
//! but no bias.

use halfdome_kernel::Ray;
use halfdome_kernel::sampling::{Pattern, Sampler};

use super::seen_points::SeenPoints;
use crate::light::SkyPart;
use crate::world::{Surface, World};

/// The least visibility, for lights that are occluded nearly everywhere.
const MIN_VISIBILITY: f32 = 0.05;

impl World {
    /// Tells the lights how far they reach.
    pub(crate) fn estimate_light_visibility(&mut self, points: &SeenPoints) {
        if !self.lights.has_distant() {
            return;
        }
        let open = points.escaped;
        let points: Vec<Surface> = points.all(self).collect();
        let directional: Vec<f32> = (0..self.lights.directional_count())
            .map(|i| {
                let towards = self.lights.towards_directional(i);
                self.reached(points.iter().map(|point| (point, towards)), |ray| self.beyond_glass(ray))
            })
            .collect();
        let sky = [SkyPart::All, SkyPart::Bright, SkyPart::Sun].map(|part| {
            let directions = points.iter().zip(0..).map(|(point, number)| {
                let u = Sampler::new(Pattern::Sobol, 0, 2, number).uniform2(0);
                (point, self.lights.sky.sample(&point.receiver(), part, u).direction)
            });
            // Those among bounces look through panes.
            self.reached(directions, |ray| if part == SkyPart::Bright { self.beyond_glass(ray) } else { ray })
        });
        self.lights.set_visibility(&directional, sky, open);
    }

    /// The part of the points that are lit from the direction beside each, among those whose front it is on; `rest` is
    /// that of a ray that anything may block.
    fn reached<'a>(
        &self,
        directions: impl Iterator<Item = (&'a Surface<'a>, glam::Vec3)>,
        rest: impl Fn(Ray) -> Ray,
    ) -> f32 {
        let rays: Vec<Ray> = directions
            .filter(|(point, direction)| {
                point.normal.dot(*direction) > 0.0 && point.shading_normal.dot(*direction) > 0.0
            })
            .map(|(point, direction)| rest(Ray::new(point.origin_towards(direction), direction)))
            .collect();
        let mut occluded = vec![false; rays.len()];
        self.occluded_many(&rays, &mut occluded);
        let free = occluded.iter().filter(|occluded| !**occluded).count();
        if rays.is_empty() { 1.0 } else { (free as f32 / rays.len() as f32).max(MIN_VISIBILITY) }
    }
}
