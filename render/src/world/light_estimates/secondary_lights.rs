//! Selects secondary lights: parts of surfaces that are lit so strongly that they are sampled like lights.
//!
//! A part is a small triangle, or a cell of a larger one that bounces have found lit. Candidates scatter more light than
//! bounces of the picture's paths find in the mean, light that was reflected before included: the undersides of blinds are
//! bright, too. Those that are worth it are [chosen](super::aim_plan). As this only affects sampling, an error costs time
//! but causes no bias.

use std::collections::{BTreeMap, BTreeSet};
use std::f32::consts::PI;

use glam::Vec2;
use halfdome_kernel::Ray;
use halfdome_kernel::sampling::warp::{Triangle as TriangleWarp, UniformHemisphere, Warp};
use halfdome_kernel::sampling::{Frame, Pattern, Sampler};
use rayon::prelude::*;

use super::aim_plan::{AimPlan, LEAST};
use super::bounces::{Bounce, INDIRECT_SALT, View};
use super::seen_points::SeenPoints;
use crate::light::{Division, LampImages, LitPart, Reach, SecondaryLights, TrianglePart, area};
use crate::world::{Hit, MIDDLE, World, interpolate};

/// The part of the total area from which on triangles are divided, if bounces find them lit.
const SMALL: f64 = 1e-3;
/// Parts of divided triangles, about, and the greatest number of cells along an edge.
const DIVIDED_PARTS: f64 = 512.0;
const MAX_SIDE: f64 = 256.0;
/// Triangles that cause a smaller share of the variance are not divided.
const LEAST_SHARE: f64 = 0.01;
/// The greatest number of small triangles that are looked at one by one.
const MAX_CANDIDATES: usize = 1 << 16;
/// Paths that estimate the indirect light of a triangle, at least.
const INDIRECT_PATHS: usize = 32;
/// The least variance of what bounces find of direct light, relative to the radiance where they come from. Below this
/// they suffice.
const MIN_VARIANCE: f32 = 3.0;
/// The mean radiance that bounces find is taken for no less than this part of that by direct light.
const LEAST_INDIRECT: f32 = 1e-2;
/// Values above this multiple of the mean are clamped in a mean of few.
const OUTLIER: f32 = 8.0;
/// Rays that measure how far the light of a part reaches: of all together, and the least and the most of each.
const REACH_RAYS: u32 = 1 << 17;
const LEAST_REACH_RAYS: u32 = 64;
const MOST_REACH_RAYS: u32 = 512;

/// What bounces find at a triangle.
#[derive(Default)]
struct Found {
    bounces: f64,
    /// Those of them that find it lit.
    lit: f64,
    /// The sum of squares of what these find, relative to the radiance where they come from.
    squares: f64,
    /// The radiance that it scatters, of light that was reflected before.
    indirect: f32,
}

impl World {
    /// Finds the secondary lights.
    pub(crate) fn find_secondary_lights(&mut self, points: &SeenPoints) {
        self.lights.lamp_images = self.find_lamp_images();
        if self.lights.lamp_images.are_mirrored() && !self.mirrored_may_pay(points) {
            self.lights.lamp_images = self.lights.lamp_images.without_mirrored();
        }
        match self.secondary_lights_that_pay(points) {
            Some(lit) => {
                if !lit.parts().iter().any(|part| self.is_in_mirror(part)) {
                    self.lights.lamp_images = self.lights.lamp_images.without_mirrored();
                }
                self.lights.lit = lit;
            }
            None => self.forget_secondary_lights(),
        }
    }

    /// Removes all secondary lights.
    pub(crate) fn forget_secondary_lights(&mut self) {
        self.lights.lit = SecondaryLights::default();
        self.lights.lamp_images = LampImages::default();
    }

    /// The parts that are worth sampling.
    fn secondary_lights_that_pay(&self, points: &SeenPoints) -> Option<SecondaryLights> {
        let mut views = self.views(points);
        let mut bounces = self.bounces(&views);
        let direct = mean_without_outliers(&bounces);
        let is_lit = |bounce: &&Bounce| bounce.direct >= LEAST * direct;
        let lit = bounces.iter().filter(is_lit).map(|it| (it.direct / (views[it.view].radiance + direct)).powi(2));
        let images = &self.lights.lamp_images;
        let bounces_suffice = direct <= 0.0 || lit.sum::<f32>() < MIN_VARIANCE * bounces.len() as f32;
        if bounces_suffice && images.is_empty() {
            return None;
        }
        self.add_indirect(&mut bounces);
        let mut mean = mean_without_outliers(&bounces);
        if !images.is_empty() {
            // Bounces find none of their light.
            let seen = views.iter().map(|view| view.radiance).sum::<f32>() / views.len() as f32;
            mean = mean.max(LEAST_INDIRECT * seen);
        }
        if mean <= 0.0 {
            return None;
        }
        // Their indirect light, about.
        views.iter_mut().for_each(|view| view.radiance += mean);
        let least = LEAST * mean;
        let (mut candidates, divisions) =
            if bounces_suffice { Default::default() } else { self.lit_surfaces(&views, &bounces, least) };
        candidates.extend_from_slice(images.parts());
        let division = |prim_id| divisions.get(&prim_id).copied().unwrap_or(Division::WHOLE);
        let triangles = self.triangle_records.len() + images.parts().len();
        let rest = bounces.iter().map(|it| (it.radiance().min(least) / views[it.view].radiance).powi(2)).sum::<f32>();
        let rest = rest / bounces.len() as f32;
        let plan = |candidates| {
            let candidates = SecondaryLights::new(candidates, division, triangles);
            self.plan_aiming(&candidates, &views, (mean, rest))
        };
        let without_mirrored = || {
            let others = candidates.iter().filter(|part| !self.is_in_mirror(part)).cloned().collect();
            images.are_mirrored().then(|| plan(others)).flatten()
        };
        let AimPlan { parts, worth, are_large } = plan(candidates.clone()).or_else(without_mirrored)?;
        let rays = (REACH_RAYS / parts.len() as u32).clamp(LEAST_REACH_RAYS, MOST_REACH_RAYS);
        let parts = parts.into_par_iter().map(|part| LitPart { reach: self.reach(&part, rays), ..part });
        let mut lit = SecondaryLights::new(parts.collect(), division, triangles);
        lit.aim_from(worth, PI * mean, are_large);
        Some(lit)
    }

    /// Parts of surfaces that scatter at least so much, and how triangles are divided into them.
    fn lit_surfaces(&self, views: &[View], bounces: &[Bounce], least: f32) -> (Vec<LitPart>, BTreeMap<u32, Division>) {
        let found = self.found(views, bounces, least);
        let smallest = SMALL * self.still_records().par_iter().map(|it| f64::from(area(&it.corners))).sum::<f64>();
        let divisions = self.divisions(&found, smallest);
        let small = self.small_candidates(&found, smallest, least);
        (self.candidates(&found, small, &divisions, least), divisions)
    }

    /// What bounces find at each triangle, where at least `least` is lit.
    fn found(&self, views: &[View], bounces: &[Bounce], least: f32) -> BTreeMap<u32, Found> {
        let mut hits: BTreeMap<u32, Vec<&Bounce>> = BTreeMap::new();
        for bounce in bounces {
            hits.entry(bounce.hit.prim_id).or_default().push(bounce);
        }
        hits.retain(|_, hits| hits.iter().any(|bounce| bounce.radiance() >= least));
        // Single bounces find much where the mean is little.
        let side = |bounce: &&Bounce| self.surface_at(&bounce.hit).facing(bounce.direction);
        let paths = |hits: &Vec<&Bounce>| hits.len().max(INDIRECT_PATHS);
        let from = hits.values().flat_map(|hits| hits.iter().cycle().take(paths(hits)).map(side));
        let indirect = self.indirect(from.collect(), INDIRECT_SALT);
        let mut first = 0;
        let triangle = |(prim, hits): (u32, Vec<&Bounce>)| {
            let count = paths(&hits);
            let indirect = indirect[first..first + count].iter().sum::<f32>() / count as f32;
            first += count;
            let mut found = Found { bounces: hits.len() as f64, indirect, ..Found::default() };
            for bounce in hits.iter().filter(|bounce| bounce.direct + indirect >= least) {
                found.lit += 1.0;
                found.squares += f64::from((bounce.direct + indirect) / views[bounce.view].radiance).powi(2);
            }
            (prim, found)
        };
        hits.into_iter().map(triangle).filter(|(_, found)| found.lit > 0.0).collect()
    }

    /// How triangles are divided from this area on: those where bounces find so much reflected light. The number of cells
    /// follows from the part of the variance of bounces that the triangle causes, and the part of it that is lit.
    fn divisions(&self, found: &BTreeMap<u32, Found>, smallest: f64) -> BTreeMap<u32, Division> {
        let all: f64 = found.values().map(|triangle| triangle.squares).sum();
        let is_divided = |prim: u32, triangle: &Found| {
            let record = self.still_records().get(prim as usize);
            let is_large = record.is_some_and(|record| f64::from(area(&record.corners)) >= smallest);
            is_large && triangle.squares > LEAST_SHARE * all
        };
        let division = |triangle: &Found| {
            let cells = DIVIDED_PARTS * triangle.squares / all * triangle.bounces / triangle.lit;
            Division::Congruent { side: cells.sqrt().clamp(1.0, MAX_SIDE) as u32 }
        };
        let divided = found.iter().filter(|(prim, triangle)| is_divided(**prim, triangle));
        divided.map(|(&prim, triangle)| (prim, division(triangle))).collect()
    }

    /// Smaller triangles of meshes of which bounces have found some lit, or that lamps close by may light so strongly. Of
    /// very many only those that bounces have found.
    fn small_candidates(&self, found: &BTreeMap<u32, Found>, smallest: f64, least: f32) -> Vec<u32> {
        let records = self.still_records();
        let lit_meshes: BTreeSet<u32> = found.keys().map(|&prim| self.triangle_records[prim as usize].mesh).collect();
        let may_be_lit = |&prim: &u32| {
            let record = &records[prim as usize];
            let area = area(&record.corners);
            let is_small = area > 0.0 && f64::from(area) < smallest;
            is_small && (lit_meshes.contains(&record.mesh) || self.may_be_lit_by_lamps(prim, least))
        };
        let mut small: Vec<u32> = (0..records.len() as u32).into_par_iter().filter(may_be_lit).collect();
        if small.len() > MAX_CANDIDATES {
            small.retain(|prim| found.contains_key(prim));
        }
        small
    }

    /// Parts of triangles that scatter at least so much.
    fn candidates(
        &self,
        found: &BTreeMap<u32, Found>,
        small: Vec<u32>,
        divisions: &BTreeMap<u32, Division>,
        least: f32,
    ) -> Vec<LitPart> {
        let small = small.into_par_iter().map(|prim| (prim, Division::WHOLE));
        let cells = small.chain(divisions.par_iter().map(|(&prim, &division)| (prim, division))).flat_map_iter(
            |(prim_id, division)| division.corners().into_iter().map(move |places| TrianglePart { prim_id, places }),
        );
        cells
            .filter_map(|cell| {
                let indirect = found.get(&cell.prim_id).map_or(0.0, |found| found.indirect);
                let light = self.lit(&cell, (indirect, least))?;
                Some(LitPart { cell, light, reach: Reach::default() })
            })
            .collect()
    }

    /// The reach of a part's light, by so many rays; misses count as far.
    fn reach(&self, part: &LitPart, count: u32) -> Reach {
        let LitPart { cell, light, .. } = part;
        let image = self.lights.lamp_images.image(cell.prim_id);
        let sampler = |number| Sampler::new(Pattern::Sobol, 0, cell.prim_id, number);
        let ray = |number: u32| {
            let ([.., x, y], v) = (sampler(number).uniform4(1), sampler(number).uniform2(2));
            let point = TriangleWarp.map(Vec2::new(x, y));
            let side = if light.both_sides && number % 2 == 1 { -light.normal } else { light.normal };
            let direction = Frame::from_normal(side).to_world(UniformHemisphere.map(v));
            let origin = match image.is_some() {
                true => interpolate(light.corners, [1.0 - point.x - point.y, point.x, point.y]),
                false => {
                    let place = cell.place(point);
                    self.surface(cell.prim_id, place.x, place.y).origin_towards(direction)
                }
            };
            Ray::new(origin, direction)
        };
        let rays: Vec<Ray> = (0..count).map(ray).collect();
        if let Some(mirror) = image.and_then(|image| image.mirror.as_ref()) {
            return Reach::of(rays.iter().map(|ray| (ray.direction, self.reach_from_mirror(mirror, ray))));
        }
        let mut hits = vec![Hit::MISS; rays.len()];
        self.intersect_many(&rays, &mut hits);
        if image.is_some() {
            let behind = |(hit, ray): (&mut Hit, &Ray)| *hit = self.straight_behind_glass(ray, hit, MIDDLE);
            hits.iter_mut().zip(&rays).for_each(behind);
        }
        // A miss is as far away as anything.
        Reach::of(rays.iter().zip(&hits).map(|(ray, hit)| (ray.direction, hit.t)))
    }
}

/// The mean radiance that bounces find, of which few may find very much.
fn mean_without_outliers(bounces: &[Bounce]) -> f32 {
    let mean =
        |most: f32| bounces.iter().map(|bounce| bounce.radiance().min(most)).sum::<f32>() / bounces.len().max(1) as f32;
    mean(OUTLIER * mean(f32::INFINITY))
}
