//! Selects secondary lights: triangles lit so strongly that they are sampled like lights.
//!
//! A triangle counts as lit if lights give one of its sides many times the mean radiance that bounces of the picture's
//! paths find, and if it is so small that bounces rarely hit it. The brightest ones are kept, if that pays: if their
//! light causes much of the variance, and most of the rays sent to them arrive. As this only affects sampling, an error
//! costs time but causes no bias.

use std::f32::consts::{FRAC_1_PI, PI};

use glam::{Vec2, Vec3};
use halfdome_kernel::Ray;
use halfdome_kernel::sampling::warp::{Triangle as TriangleWarp, UniformHemisphere, Warp};
use halfdome_kernel::sampling::{Frame, Pattern, Sampler};
use rayon::prelude::*;

use super::seen_points::SeenPoints;
use crate::light::{Reach, Receiver, SecondaryLights, TriangleLight, area};
use crate::world::{Hit, World};

/// A secondary light is at least this many times as bright as the mean.
const FIERCE: f32 = 8.0;
/// The largest part of the total area for one such triangle, and for all of them.
const SMALL: f64 = 1e-3;
const ALL_SMALL: f64 = 0.02;
/// The part of their power that is kept, and the greatest number of triangles.
const KEPT_POWER: f64 = 0.995;
const MAX_TRIANGLES: usize = 1 << 11;
/// Their share of the scene's light, times their brightness relative to the mean, is about the variance that they cause
/// in bounces. Below this value bounces suffice.
const MIN_GAIN: f32 = 0.5;
/// The least part of rays towards them that must be unoccluded.
const MIN_UNOCCLUDED: f32 = 0.3;
/// From this multiple of the mean irradiance on paths always sample them: found by trial.
const AIM_FROM: f32 = 8.0;
/// Rays that measure how far the light of a triangle reaches.
const REACH_RAYS: u32 = 512;

impl World {
    /// Finds the secondary lights.
    pub(crate) fn find_secondary_lights(&mut self, points: &SeenPoints) {
        let Some(lit) = self.secondary_lights_that_pay(points) else { return };
        for &prim_id in lit.prims() {
            if std::mem::replace(&mut self.triangle_records[prim_id as usize].is_plain, 0) != 0 {
                self.plain_lit.push(prim_id);
            }
        }
        self.lights.lit = lit;
    }

    /// Removes all secondary lights.
    pub(crate) fn forget_secondary_lights(&mut self) {
        for prim_id in self.plain_lit.drain(..) {
            self.triangle_records[prim_id as usize].is_plain = 1;
        }
        self.lights.lit = SecondaryLights::default();
    }

    /// The triangles that are worth sampling.
    fn secondary_lights_that_pay(&self, points: &SeenPoints) -> Option<SecondaryLights> {
        // Distant lights do not light small triangles strongly.
        let mean = if self.lights.has_lamps() { self.mean_reflected(points) } else { 0.0 };
        let lit = if mean > 0.0 { self.fiercest(FIERCE * mean) } else { Vec::new() };
        if lit.is_empty() {
            return None;
        }
        // By power.
        let radiance = (sum(&lit, |light| light.radiance * light.radiance) / sum(&lit, |light| light.radiance)) as f32;
        let reach = lit.par_iter().map(|(prim_id, light)| self.reach(*prim_id, light)).collect();
        let mut lit = SecondaryLights::new(lit, reach, self.triangle_records.len());
        let [received, reached] = self.mean_received(&lit, points);
        // The mean radiance of bounces, and the share and the relative brightness of secondary lights.
        let found = mean + received * FRAC_1_PI;
        let (part, fierceness) = (received * FRAC_1_PI / found, radiance / found);
        lit.aim_from(AIM_FROM * PI * found, PI * mean);
        (part * fierceness >= MIN_GAIN && received >= MIN_UNOCCLUDED * reached).then_some(lit)
    }

    /// Triangles that reflect at least so much, with what they are as lights, as many as are to be aimed at.
    fn fiercest(&self, least: f32) -> Vec<(u32, TriangleLight)> {
        let areas: Vec<f32> = self.still_records().par_iter().map(|record| area(&record.corners)).collect();
        let all: f64 = areas.iter().map(|&area| f64::from(area)).sum();
        let is_small = |area: f32| area > 0.0 && f64::from(area) < SMALL * all;
        let mut lit: Vec<(u32, TriangleLight)> = areas
            .into_par_iter()
            .enumerate()
            .filter(|&(_, area)| is_small(area))
            .filter_map(|(prim, area)| Some((prim as u32, self.lit(prim as u32, area, least)?)))
            .collect();
        // Of equals the first.
        lit.sort_by(|(a, first), (b, second)| second.radiance.total_cmp(&first.radiance).then(a.cmp(b)));
        let most = KEPT_POWER * sum(&lit, |light| light.radiance);
        let (mut area, mut power) = (0.0, 0.0);
        let kept = lit.iter().take(MAX_TRIANGLES).take_while(|(_, light)| {
            let is_needed = power < most;
            area += f64::from(light.area);
            power += f64::from(light.area * light.radiance);
            is_needed && area < ALL_SMALL * all
        });
        let kept = kept.count();
        lit.truncate(kept);
        lit
    }

    /// The mean irradiance that secondary lights cause where paths come, and what it would be if aimed rays met nothing
    /// else.
    fn mean_received(&self, lit: &SecondaryLights, points: &SeenPoints) -> [f32; 2] {
        let (mut received, mut reached, mut count) = (0.0, 0.0, 0);
        for point in points.all(self) {
            let receiver = Receiver::new(point.position, point.normal, false);
            let (each, chosen) = lit.representatives(&receiver);
            for prim_id in chosen {
                let middle = self.surface(prim_id, 1.0 / 3.0, 1.0 / 3.0);
                let vector = point.position - middle.position;
                if !lit.may_reach(prim_id, vector.normalize_or(Vec3::Z), vector.length()) {
                    continue;
                }
                reached += each;
                let end = middle.end_from(point.position);
                if !self.occluded(&Ray::between(point.origin_towards(-vector), end)) {
                    received += each;
                }
            }
            count += 1;
        }
        [received, reached].map(|sum| sum / count.max(1) as f32)
    }

    /// The reach of a secondary light's light; misses count as far.
    fn reach(&self, prim_id: u32, light: &TriangleLight) -> Reach {
        let sampler = |number| Sampler::new(Pattern::Sobol, 0, prim_id, number);
        let ray = |number: u32| {
            let ([.., x, y], v) = (sampler(number).uniform4(1), sampler(number).uniform2(2));
            let point = TriangleWarp.map(Vec2::new(x, y));
            let side = if light.both_sides && number % 2 == 1 { -light.normal } else { light.normal };
            let direction = Frame::from_normal(side).to_world(UniformHemisphere.map(v));
            Ray::new(self.surface(prim_id, point.x, point.y).origin_towards(direction), direction)
        };
        let rays: Vec<Ray> = (0..REACH_RAYS).map(ray).collect();
        let mut hits = vec![Hit::MISS; rays.len()];
        self.intersect_many(&rays, &mut hits);
        // A miss is as far away as anything.
        Reach::of(rays.iter().zip(&hits).map(|(ray, hit)| (ray.direction, hit.t)))
    }
}

/// The sum of a quantity of all lights, times area.
fn sum(lights: &[(u32, TriangleLight)], of: impl Fn(&TriangleLight) -> f32) -> f64 {
    lights.iter().map(|(_, light)| f64::from(of(light)) * f64::from(light.area)).sum()
}
