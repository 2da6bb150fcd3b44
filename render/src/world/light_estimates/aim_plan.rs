//! Chooses which secondary lights paths aim at, and whether that pays.
//!
//! A light tree chooses a few candidates for each point that paths come to, and shadow rays tell which of them can be
//! seen. What bounces find from part `i`, of radiance `Lᵢ` and with the irradiance `π mᵢ`, has about the variance
//! `mᵢ Lᵢ`. Aimed rays, which a path sends with the chance `c` and to that part with the probability `pᵢ`, leave
//! `mᵢ Lᵢ / (1 + c pᵢ Lᵢ / mᵢ)` of it by the balance heuristic. From this follow the variance and the time of paths with
//! and without aimed rays; the geometric mean over all points is compared, as few dark points have most of the variance.

use std::f32::consts::{FRAC_1_PI, PI};

use glam::Vec3;
use halfdome_kernel::Ray;
use rayon::prelude::*;

use super::bounces::View;
use super::seen_points::SeenPoints;
use crate::light::{Division, LitPart, Receiver, SecondaryLights};
use crate::world::{Surface, World};

/// Candidates have at least this multiple of the mean radiance that bounces find.
pub(super) const LEAST: f32 = 2.0;
/// Paths aim at parts of at least this fraction of the mean radiance of candidates, by the variance that they cause.
const BRIGHT: f32 = 1.0 / 16.0;
/// From this multiple of the mean irradiance on, paths always aim: found by trial. At images of lamps, which are hardly found
/// otherwise, they do from the typical irradiance on.
const AIM_FROM: f32 = 4.0;
/// Parts of this multiple of the mean radiance are fierce: bounces find them as fireflies.
const FIERCE: f32 = 8.0;
/// If paths aimed at each surface, their time would grow by about this multiple; the first if all parts are fierce, or
/// if most are images in mirrors.
const FIERCE_TIME: f32 = 1.5;
const AIMED_TIME: f32 = 3.5;
/// The greatest product of variance and time, relative to that without secondary lights; the second for large parts, and
/// the third for lamps in glass, of which the estimate is too hopeful: found by trial.
const MAX_PRODUCT: f32 = 0.9;
const MAX_LARGE_PRODUCT: f32 = 0.7;
const MAX_PRODUCT_OF_LAMPS: f32 = 0.5;
/// The variance of what the estimate does not know of, such as deeper bounces, relative to the squared radiance.
const UNKNOWN: f32 = 0.5;
/// By how much images in mirrors add to the variance at least, as the mean of logarithms, each of which counts up to the second.
const MIN_GROWTH: f32 = 0.5;
const MOST_GROWTH: f32 = 10.0;
/// One view of so many is asked for that.
const VIEW_STEP: usize = 4;
/// The part of the views' mean radiance that is added to each there, for light that was reflected before.
const LEAST_OF_MEAN: f32 = 0.25;
/// The least part of the variance of all candidates that images in mirrors cause.
const LEAST_IN_MIRRORS: f32 = 0.1;
/// Candidates that are chosen for each point.
const CHOICES: u32 = 32;
/// A part that no point sees in so many tries is left out.
const ENOUGH_TRIES: u32 = 8;
/// The greatest number of parts.
const MAX_PARTS: usize = 1 << 13;

/// What paths aim at.
pub(super) struct AimPlan {
    pub parts: Vec<LitPart>,
    /// The irradiance of all parts from which on each path aims.
    pub worth: f32,
    /// Whether they send most of the light, and are not fierce: then they are so large that many rays find them.
    pub are_large: bool,
}

/// A candidate that was chosen for a point.
struct Try {
    part: usize,
    /// The radiance of the part.
    radiance: f32,
    /// The irradiance over π that the try represents if the part can be seen.
    received: f32,
    is_seen: bool,
}

impl Try {
    /// The variance that it represents, relative to the radiance at the point.
    fn variance(&self, view: &View) -> f32 {
        if self.is_seen { self.radiance * self.received / view.radiance.powi(2) } else { 0.0 }
    }
}

impl World {
    /// Chooses among the candidates, where bounces find the radiance `mean`, and what is no candidate causes the
    /// variance `rest`, relative to the radiance at the views.
    pub(super) fn plan_aiming(
        &self,
        candidates: &SecondaryLights,
        views: &[View],
        (mean, rest): (f32, f32),
    ) -> Option<AimPlan> {
        let tries: Vec<Vec<Try>> = views.par_iter().map(|view| self.tries(candidates, view)).collect();
        let mut tried = vec![0; candidates.parts().len()];
        let mut variances = vec![0.0; tried.len()];
        let (mut variance, mut by_variance, mut through_glass, mut by_mirrors) = (0.0, 0.0, 0.0, 0.0);
        for (view, it) in views.iter().zip(&tries).flat_map(|(view, tries)| tries.iter().map(move |it| (view, it))) {
            tried[it.part] += 1;
            variances[it.part] += it.variance(view);
            variance += it.variance(view);
            by_variance += it.variance(view) * it.radiance;
            let part = &candidates.parts()[it.part];
            if self.is_in_mirror(part) {
                by_mirrors += it.variance(view);
            } else if self.lights.lamp_images.image(part.cell.prim_id).is_some() {
                through_glass += it.variance(view);
            }
        }
        if variance <= 0.0 || (by_mirrors > 0.0 && by_mirrors < LEAST_IN_MIRRORS * variance) {
            return None;
        }
        let least = (BRIGHT * by_variance / variance).max(LEAST * mean);
        let is_fierce = least >= FIERCE * mean;
        let received = |limit: f32| {
            let bright = tries.iter().flatten().filter(|it| it.is_seen && it.radiance >= limit);
            bright.map(|it| it.received).sum::<f32>() / views.len() as f32
        };
        let are_large = !is_fierce && received(least) > mean;
        let [are_in_glass, are_in_mirrors] = [through_glass, by_mirrors].map(|part| part > 0.5 * variance);
        let limits = if is_fierce { vec![least] } else { vec![least, FIERCE * mean] };
        let aimed_time = if is_fierce || are_in_mirrors { FIERCE_TIME } else { AIMED_TIME };
        let choice = |limit: f32| {
            let worth = match are_in_glass || are_in_mirrors {
                true => PI * (mean + typical(&tries, limit)),
                false => AIM_FROM * PI * (mean + received(limit)),
            };
            (product(&tries, views, rest + UNKNOWN, (limit, worth), aimed_time), limit, worth)
        };
        let choices = limits.into_iter().map(choice);
        let (product, limit, worth) = choices.min_by(|(a, ..), (b, ..)| a.total_cmp(b))?;
        let most = match (are_in_glass, are_large) {
            (true, _) => MAX_PRODUCT_OF_LAMPS,
            (_, true) => MAX_LARGE_PRODUCT,
            _ => MAX_PRODUCT,
        };
        if product > most {
            return None;
        }
        let is_kept = |&part: &usize| {
            let may_be_seen = variances[part] > 0.0 || tried[part] < ENOUGH_TRIES;
            may_be_seen && candidates.parts()[part].light.radiance >= limit
        };
        let mut kept: Vec<usize> = (0..tried.len()).filter(is_kept).collect();
        kept.sort_by(|&a, &b| variances[b].total_cmp(&variances[a]).then(a.cmp(&b)));
        kept.truncate(MAX_PARTS);
        let parts: Vec<LitPart> = kept.into_iter().map(|part| candidates.parts()[part].clone()).collect();
        (!parts.is_empty()).then_some(AimPlan { parts, worth, are_large })
    }

    /// Whether images of lamps in mirrors may cause so much of the variance at these points that it pays to sample them: a
    /// quick test, which most scenes with a polished floor fail.
    pub(super) fn mirrored_may_pay(&self, points: &SeenPoints) -> bool {
        let mut views = self.views(points);
        let mean = views.iter().map(|view| view.radiance).sum::<f32>() / views.len() as f32;
        views.iter_mut().for_each(|view| view.radiance += LEAST_OF_MEAN * mean);
        let parts = self.lights.lamp_images.parts().iter().filter(|part| self.is_in_mirror(part)).cloned().collect();
        let triangles = self.triangle_records.len() + self.lights.lamp_images.parts().len();
        let images = SecondaryLights::new(parts, |_| Division::WHOLE, triangles);
        let growth = |view: &View| {
            let seen = self.tries(&images, view).into_iter().filter(|it| it.is_seen);
            let variance = seen.map(|it| it.radiance * it.received).sum::<f32>();
            let rest = UNKNOWN * view.radiance.powi(2) + view.variance;
            if variance > 0.0 { (1.0 + variance / rest).ln().min(MOST_GROWTH) } else { 0.0 }
        };
        let growths: Vec<f32> = views.par_iter().step_by(VIEW_STEP).map(growth).collect();
        growths.iter().sum::<f32>() > MIN_GROWTH * growths.len() as f32
    }

    /// Whether a part is an image in a mirror.
    pub(super) fn is_in_mirror(&self, part: &LitPart) -> bool {
        self.lights.lamp_images.image(part.cell.prim_id).is_some_and(|image| image.mirror.is_some())
    }

    /// Some candidates for a point.
    fn tries(&self, candidates: &SecondaryLights, view: &View) -> Vec<Try> {
        let receiver = Receiver::new(view.point.position, view.point.normal, false);
        let (each, chosen) = candidates.representatives(&receiver, CHOICES);
        let try_part = |(part, lit): (usize, &LitPart)| Try {
            part,
            radiance: lit.light.radiance,
            received: each * FRAC_1_PI,
            is_seen: self.is_seen(lit, &view.point),
        };
        chosen.map(try_part).collect()
    }

    /// Whether nothing is between a point and the middle of a part.
    fn is_seen(&self, part: &LitPart, point: &Surface) -> bool {
        let prim_id = part.cell.prim_id;
        if self.lights.lamp_images.image(prim_id).is_some() {
            let way = part.light.corners.iter().sum::<Vec3>() / 3.0 - point.position;
            let lamp = self.image_along(&Ray::new(point.origin_towards(way), way));
            return lamp.is_some_and(|(id, _)| id == prim_id);
        }
        let place = part.cell.middle();
        let middle = self.surface(prim_id, place.x, place.y);
        let vector = middle.position - point.position;
        !self.occluded(&Ray::between(point.origin_towards(vector), middle.end_from(point.position)))
    }
}

/// The geometric mean of what those points receive from parts of this radiance on that see any.
fn typical(tries: &[Vec<Try>], limit: f32) -> f32 {
    let received = |tries: &Vec<Try>| {
        let seen = tries.iter().filter(|it| it.is_seen && it.radiance >= limit);
        seen.map(|it| it.received).sum::<f32>()
    };
    let logarithms: Vec<f32> = tries.iter().map(received).filter(|&it| it > 0.0).map(f32::ln).collect();
    if logarithms.is_empty() { 0.0 } else { (logarithms.iter().sum::<f32>() / logarithms.len() as f32).exp() }
}

/// The variance times the time of paths that aim at parts from a radiance on, always from an irradiance on, relative to
/// that of paths that do not aim.
fn product(tries: &[Vec<Try>], views: &[View], rest: f32, (limit, worth): (f32, f32), aimed_time: f32) -> f32 {
    let (mut logarithm, mut aimed) = (0.0, 0.0);
    for (view, tries) in views.iter().zip(tries) {
        let all: f32 = tries.iter().filter(|it| it.radiance >= limit).map(|it| it.received).sum();
        let chance = (all * PI / worth).min(1.0);
        let rest = rest + view.variance / view.radiance.powi(2);
        let (mut without, mut with) = (rest, rest);
        for it in tries {
            let aimed = if it.radiance >= limit { chance * it.radiance / all } else { 0.0 };
            without += it.variance(view);
            with += it.variance(view) / (1.0 + aimed);
        }
        logarithm += (with / without).ln();
        aimed += chance;
    }
    let count = views.len() as f32;
    (logarithm / count).exp() * (1.0 + aimed_time * aimed / count)
}
