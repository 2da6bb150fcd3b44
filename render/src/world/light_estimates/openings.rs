//! Finds the openings through which surfaces see the sky: windows, doors, gaps.
//!
//! From points that paths come to, rays by the cosine go out. Where one escapes beside others that are blocked, it has
//! crossed an opening about as far away as the places where its neighbours ended, which are on the wall around it. Such
//! points are divided into spheres. How much of each is free is then tried from all points.

use glam::Vec3;
use halfdome_kernel::sampling::warp::{CosineHemisphere, Warp};
use halfdome_kernel::sampling::{Pattern, Sampler};
use halfdome_kernel::{Aabb, Ray};
use rayon::prelude::*;

use super::seen_points::SeenPoints;
use crate::light::Openings;
use crate::world::{Hit, Surface, World};

/// Points from which openings are looked for, at most, and rays from each.
const POINTS: usize = 768;
const RAYS: u32 = 64;
/// Where a greater part of rays escapes, bounces find the sky.
const MOST_OPEN: f32 = 0.4;
/// Neighbours that say how far away an opening is, and the least cosine between them and the ray.
const NEIGHBORS: usize = 3;
const MIN_COS: f32 = 0.5;
/// Spheres with a smaller part of the points are left to bounces.
const LEAST_PART: f32 = 0.004;
/// How many times as often as bounces directions through openings must reach the sky.
const GAIN: f32 = 2.0;
/// The seed of the points' numbers, and of those of openings.
const SALT: u32 = 0x4f50_0000;
/// Rays that one thread traces at once.
const CHUNK: usize = 4096;

impl World {
    /// Tells the sky where it is seen.
    pub(crate) fn find_openings(&mut self, points: &SeenPoints) {
        let is_closed = points.escaped <= 0.0 && !self.has_clear_glass();
        if self.lights.sky.mean() == Vec3::ZERO || is_closed || points.escaped > MOST_OPEN {
            return;
        }
        let surfaces: Vec<Surface> = points.all(self).filter(|surface| !surface.material.is_glass()).collect();
        let step = surfaces.len().div_ceil(POINTS).max(1);
        let some: Vec<&Surface> = surfaces.iter().step_by(step).collect();
        let found =
            some.par_iter().enumerate().map(|(number, surface)| self.points_in_openings(surface, number as u32));
        let found = found.collect::<Vec<_>>().concat();
        // About, as some rays go below the surface.
        let open = found.len() as f32 / (some.len() as f32 * RAYS as f32);
        let openings = self.tried(&surfaces, &spheres(found), GAIN * open);
        if let Some(openings) = openings {
            self.lights.sky.set_openings(openings);
        }
    }

    /// Points of openings that a surface sees.
    fn points_in_openings(&self, surface: &Surface, number: u32) -> Vec<Vec3> {
        let frame = surface.frame();
        let ray = |i| {
            let u = Sampler::new(Pattern::Sobol, 0, SALT + number, i).uniform2(0);
            let direction = frame.to_world(CosineHemisphere.map(u));
            (surface.normal.dot(direction) > 0.0).then(|| Ray::new(surface.origin_towards(direction), direction))
        };
        let rays: Vec<Ray> = (0..RAYS).filter_map(ray).collect();
        let mut hits = vec![Hit::MISS; rays.len()];
        let beyond_glass: Vec<Ray> = rays.iter().map(|ray| self.beyond_glass(*ray)).collect();
        self.intersect_many(&beyond_glass, &mut hits);
        let ends = beyond_glass.iter().zip(hits).map(|(ray, hit)| hit.is_hit().then(|| ray.at(hit.t)));
        let (blocked, escaped): (Vec<_>, Vec<_>) = rays.iter().zip(ends).partition(|(_, end)| end.is_some());
        if escaped.len() as f32 > MOST_OPEN * rays.len() as f32 {
            return Vec::new();
        }
        let point = |(ray, _): (&Ray, Option<Vec3>)| {
            // The nearest ones by angle, in order.
            let mut nearest = [(MIN_COS, 0.0_f32); NEIGHBORS];
            for (other, end) in &blocked {
                let distance = end.map_or(0.0, |end| end.distance(other.origin));
                let mut next = (ray.direction.dot(other.direction), distance);
                for place in &mut nearest {
                    if next.0 > place.0 {
                        std::mem::swap(place, &mut next);
                    }
                }
            }
            let depth = nearest.iter().fold(0.0_f32, |depth, (_, t)| depth.max(*t));
            (depth > 0.0).then(|| ray.at(depth))
        };
        escaped.into_iter().filter_map(point).collect()
    }

    /// These openings with the part of directions through each that reach the sky, unless a smaller part of all than
    /// `least` does.
    fn tried(&self, surfaces: &[Surface], spheres: &[(Vec3, f32)], least: f32) -> Option<Openings> {
        let around = |bounds: Aabb, surface: &Surface| bounds.union(&Aabb::around(&[surface.position]));
        let mut openings = Openings::new(spheres, surfaces.iter().fold(Aabb::EMPTY, around));
        let (mut tries, mut rays) = (Vec::new(), Vec::new());
        for (number, surface) in (0..).zip(surfaces) {
            let receiver = surface.receiver();
            let cell = openings.grid_mut().cell(surface.position);
            for opening in 0..openings.count() {
                let cone = openings.cone(opening, surface.position);
                let (weight, u) =
                    (cone.weight(&receiver), Sampler::new(Pattern::Sobol, 0, SALT + opening as u32, number));
                let direction = cone.direction(u.uniform2(1));
                if weight > 0.0 && surface.normal.dot(direction) > 0.0 {
                    rays.push(self.beyond_glass(Ray::new(surface.origin_towards(direction), direction)));
                    tries.push((cell, opening, weight));
                }
            }
        }
        let mut occluded = vec![false; rays.len()];
        rays.par_chunks(CHUNK).zip(occluded.par_chunks_mut(CHUNK)).for_each(|(rays, occluded)| {
            self.occluded_many(rays, occluded);
        });
        // Of each opening, everywhere and in each cell: how many directions are free, of how many.
        let mut everywhere = [[0.0_f32; 2]; Openings::MOST];
        let mut cells = vec![[[0.0_f32; 2]; Openings::MOST]; openings.grid_mut().len()];
        let tries = tries.into_iter().zip(occluded).map(|(place, occluded)| (place, f32::from(u8::from(!occluded))));
        for ((cell, opening, _), free) in tries.clone() {
            for [sum, all] in [&mut everywhere[opening], &mut cells[cell][opening]] {
                (*sum, *all) = (*sum + free, *all + 1.0);
            }
        }
        for (number, cell) in cells.into_iter().enumerate() {
            let parts = openings.grid_mut().cell_mut(number);
            for (opening, [free, all]) in cell.into_iter().enumerate() {
                // As if one more had been tried, with the success that it has everywhere.
                let [mean, count] = everywhere[opening];
                parts[opening] = (free + (mean + 0.01) / (count + 1.0)) / (all + 1.0);
            }
        }
        let (mut reached, mut sum) = (0.0, 0.0);
        for ((cell, opening, weight), free) in tries {
            let weight = weight * openings.grid_mut().cell_mut(cell)[opening];
            (reached, sum) = (reached + weight * free, sum + weight);
        }
        (reached > least * sum).then_some(openings)
    }
}

/// Spheres around points: these are halved across the longest side of their box, where they are many and far apart.
fn spheres(points: Vec<Vec3>) -> Vec<(Vec3, f32)> {
    let least = (points.len() as f32 * LEAST_PART).max(2.0) as usize;
    let mut groups = vec![Group::new(points)];
    while groups.len() < Openings::MOST {
        let costs = groups.iter().enumerate().filter(|(_, group)| group.points.len() >= 2 * least);
        let worst = costs.map(|(i, group)| (i, group.cost())).max_by(|a, b| a.1.total_cmp(&b.1));
        let Some((worst, _)) = worst.filter(|(_, cost)| *cost > 0.0) else { break };
        let Group { points, middle, axis, .. } = groups.swap_remove(worst);
        let (low, high) = points.into_iter().partition(|point: &Vec3| point[axis] < middle[axis]);
        groups.extend([low, high].map(Group::new));
    }
    groups.iter().filter(|group| group.points.len() >= least).map(|group| (group.middle, group.radius)).collect()
}

/// Points in a sphere.
struct Group {
    points: Vec<Vec3>,
    /// The middle of their box.
    middle: Vec3,
    /// The distance of the farthest from there.
    radius: f32,
    /// The box's longest axis.
    axis: usize,
}

impl Group {
    fn new(points: Vec<Vec3>) -> Self {
        let bounds = points.iter().fold(Aabb::EMPTY, |bounds, point| bounds.union(&Aabb::around(&[*point])));
        let middle = bounds.center();
        let radius = points.iter().fold(0.0_f32, |radius, point| radius.max(point.distance(middle)));
        Self { radius, middle, axis: (bounds.max - bounds.min).max_position(), points }
    }

    fn cost(&self) -> f32 {
        self.points.len() as f32 * self.radius * self.radius
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_of_two_windows_are_in_spheres_of_their_own() {
        let window = |x: f32| (0..200).map(move |i| Vec3::new(x, (i % 20) as f32 * 0.05, (i / 20) as f32 * 0.1));
        let points: Vec<Vec3> = window(0.0).chain(window(9.0)).collect();
        let spheres = spheres(points.clone());
        assert!(spheres.len() > 8 && spheres.len() <= Openings::MOST, "{spheres:?}");
        assert!(spheres.iter().all(|(center, radius)| (center.x == 0.0 || center.x == 9.0) && *radius < 0.4));
        let is_covered = |point: &Vec3| spheres.iter().any(|(center, radius)| center.distance(*point) <= *radius);
        assert!(points.iter().all(is_covered));
    }

    #[test]
    fn points_that_cannot_be_divided_are_one_sphere_and_few_are_none() {
        assert_eq!(spheres(vec![Vec3::ONE; 50]), [(Vec3::ONE, 0.0)]);
        assert_eq!(spheres(vec![Vec3::ONE]), []);
        assert_eq!(spheres(Vec::new()), []);
    }
}
