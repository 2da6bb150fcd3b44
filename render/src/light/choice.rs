//! Chooses a light for a receiver: first a kind of light, then one of that kind, by one random number, in proportion to
//! estimated contributions ([`Weights`]).
//!
//! Many receivers descend a tree step by step together, as a step depends on the receiver's previous one, but not on
//! those of others.

use halfdome_kernel::sampling::ONE_MINUS_EPSILON;

use super::tree::cluster::Lane;
use super::tree::{self, Descent, Pick, RootWeights, Tree};
use super::{LightSampler, Receiver, SkyPart, few};

/// A light that was chosen.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SampledLight {
    /// The number of its light.
    pub index: u32,
    /// The probability of choosing it.
    pub probability: f32,
    /// The rescaled remainder of the number that chose it, in [0, 1): if the numbers are evenly spread, so are the
    /// remainders of each light.
    pub rest: f32,
}

/// The weight of each kind of light for a receiver.
pub(crate) struct Weights {
    triangles: RootWeights,
    points: RootWeights,
    triangles_sum: f32,
    points_sum: f32,
    directional: f32,
    sky: f32,
}

impl Weights {
    /// The sum: an estimate of irradiance, as luminance.
    #[inline(always)]
    pub(crate) fn total(&self) -> f32 {
        (self.triangles_sum + self.points_sum) + (self.directional + self.sky)
    }

    /// The probability with which the sky is chosen.
    #[inline(always)]
    pub(crate) fn sky_probability(&self) -> f32 {
        if self.sky > 0.0 { self.sky / self.total() } else { 0.0 }
    }
}

/// A choice among all lights, step by step.
#[derive(Clone, Copy, Debug)]
pub(crate) enum LightChoice {
    /// No light reaches the receiver.
    None,
    /// Nothing is left to choose.
    Made(SampledLight),
    /// Among triangles, which have this part of all.
    Triangles(Descent, f32),
    /// Among points and spots.
    Points(Descent, f32),
}

impl LightSampler {
    /// The weights of lights for a receiver, with this part of the sky.
    #[inline(always)]
    pub(crate) fn weigh(&self, receiver: &Receiver, part: SkyPart) -> Weights {
        let (mut triangles, mut points) = (RootWeights::default(), RootWeights::default());
        let (mut triangles_sum, mut points_sum) = (0.0, 0.0);
        if let Some(tree) = &self.triangles {
            triangles = tree.root_weights(receiver);
            triangles_sum = tree::total(&triangles);
        }
        if let Some(tree) = &self.points {
            points = tree.root_weights(receiver);
            points_sum = tree::total(&points);
        }
        let directional = self.directional.rows(receiver).map(|row| tree::sum(&row)).sum();
        let sky = self.sky.weight(receiver, part);
        Weights { triangles, points, triangles_sum, points_sum, directional, sky }
    }

    /// The approximate unoccluded irradiance by lights that have a place.
    pub(crate) fn lamp_irradiance(&self, receiver: &Receiver) -> f32 {
        let triangles = self.triangles.as_ref().map_or(0.0, |tree| tree.frontier(receiver).total);
        triangles + self.points.as_ref().map_or(0.0, |tree| tree.frontier(receiver).total)
    }

    /// The approximate unoccluded irradiance by all lights and this part of the sky, better than [`weigh`](Self::weigh) knows
    /// it, and one of them, chosen by its part of that by numbers in [0, 1).
    pub(crate) fn choose_closely(&self, receiver: &Receiver, part: SkyPart, [kind, u]: [f32; 2]) -> Option<(f32, u32)> {
        let triangles = self.triangles.as_ref().map(|tree| (tree, tree.frontier(receiver)));
        let points = self.points.as_ref().map(|tree| (tree, tree.frontier(receiver)));
        let directional: f32 = self.directional.rows(receiver).map(|row| tree::sum(&row)).sum();
        let triangles_sum = triangles.as_ref().map_or(0.0, |(_, frontier)| frontier.total);
        let points_sum = points.as_ref().map_or(0.0, |(_, frontier)| frontier.total);
        let sky = self.sky.weight(receiver, part);
        let total = (triangles_sum + points_sum) + (directional + sky);
        let place = kind * total;
        let index = match (triangles, points) {
            _ if total <= 0.0 => return None,
            (Some((tree, frontier)), _) if place < triangles_sum => tree.choose_beyond(receiver, &frontier, u).index,
            (_, Some((tree, frontier))) if place < triangles_sum + points_sum => {
                self.first_point() + tree.choose_beyond(receiver, &frontier, u).index
            }
            _ if place < total - sky || sky == 0.0 => {
                let pick = self.choose_directional(receiver, directional, f64::from(u * directional));
                self.first_distant() + pick.index
            }
            _ => self.sky_number(),
        };
        Some((total, index))
    }

    /// Chooses a light for a receiver with these weights, by a number in [0, 1), of double precision as there may be
    /// millions. `None` if no light reaches it.
    #[inline(always)]
    pub(crate) fn choose(&self, receiver: &Receiver, weights: &Weights, u: f64) -> Option<SampledLight> {
        let mut choice = self.begin(receiver, weights, u);
        while self.descend(receiver, &mut choice) {}
        self.end(&choice)
    }

    /// The first step of [`choose`](Self::choose). Many receivers choose step by step together, as a step depends on
    /// the receiver's previous one, but not on those of others.
    #[inline(always)]
    pub(crate) fn begin(&self, receiver: &Receiver, weights: &Weights, u: f64) -> LightChoice {
        let total = weights.total();
        if total <= 0.0 {
            return LightChoice::None;
        }
        if !self.few.is_empty() && weights.sky == 0.0 {
            let [a, b, c, d, ..] = weights.triangles[0];
            let (index, probability, rest) = few::choose([a, b, c, d], few::coarse(u));
            return LightChoice::Made(SampledLight { index, probability, rest });
        }
        let mut place = u * f64::from(total);
        let kinds = [weights.triangles_sum, weights.points_sum, weights.directional, weights.sky];
        // The last of those that have any, if rounding led behind all of them.
        let (mut kind, mut start, mut end) = (0, 0.0, 0.0);
        for (i, &weight) in kinds.iter().enumerate() {
            if place >= end && weight > 0.0 {
                (kind, start) = (i, end);
            }
            end += f64::from(weight);
        }
        place = (place - start).max(0.0);
        let part = kinds[kind] / total;
        let rest = (place / f64::from(kinds[kind])).min(1.0 - f64::EPSILON / 2.0);
        match (kind, &self.triangles, &self.points) {
            (0, Some(tree), _) => LightChoice::Triangles(tree.begin(&weights.triangles, rest), part),
            (1, _, Some(tree)) => LightChoice::Points(tree.begin(&weights.points, rest), part),
            (2, ..) => {
                let pick = self.choose_directional(receiver, weights.directional, place);
                LightChoice::Made(self.picked(&pick, self.first_distant(), part))
            }
            _ => {
                let pick = Pick { index: 0, probability: 1.0, rest };
                LightChoice::Made(self.picked(&pick, self.lights.len() as u32 - 1, part))
            }
        }
    }

    /// The next step, if there is one.
    #[inline(always)]
    pub(crate) fn descend(&self, receiver: &Receiver, choice: &mut LightChoice) -> bool {
        match (choice, &self.triangles, &self.points) {
            (LightChoice::Triangles(descent, _), Some(tree), _) => tree.descend(receiver, descent),
            (LightChoice::Points(descent, _), _, Some(tree)) => tree.descend(receiver, descent),
            _ => false,
        }
    }

    /// The choice after the last step.
    #[inline(always)]
    pub(crate) fn end(&self, choice: &LightChoice) -> Option<SampledLight> {
        match (choice, &self.triangles, &self.points) {
            (LightChoice::Made(light), ..) => Some(*light),
            (LightChoice::Triangles(descent, part), Some(tree), _) => Some(self.picked(&tree.end(descent), 0, *part)),
            (LightChoice::Points(descent, part), _, Some(tree)) => {
                Some(self.picked(&tree.end(descent), self.first_point(), *part))
            }
            _ => None,
        }
    }

    /// What was picked from the lights that begin at number `first`, whose part of all is `part`.
    #[inline(always)]
    fn picked(&self, pick: &Pick, first: u32, part: f32) -> SampledLight {
        let rest = (pick.rest as f32).min(ONE_MINUS_EPSILON);
        SampledLight { index: first + pick.index, probability: part * pick.probability, rest }
    }

    /// Lights are triangles, then points, then those that are distant, then the sky.
    #[inline(always)]
    pub(super) fn first_point(&self) -> u32 {
        self.triangles.as_ref().map_or(0, Tree::len) as u32
    }

    #[inline(always)]
    pub(super) fn first_distant(&self) -> u32 {
        self.first_point() + self.points.as_ref().map_or(0, Tree::len) as u32
    }

    /// The directional light that lies at this place if all lie side by side.
    fn choose_directional(&self, receiver: &Receiver, sum: f32, mut place: f64) -> Pick {
        let mut chosen: Option<(usize, Lane, f64)> = None;
        for (number, weights) in self.directional.rows(receiver).enumerate() {
            let width = tree::sum(&weights);
            if width > 0.0 && (chosen.is_none() || place >= 0.0) {
                chosen = Some((number, weights, place));
            }
            place -= f64::from(width);
        }
        let (row, weights, place) = chosen.unwrap_or((0, [1.0; tree::WIDTH], 0.0));
        let (lane, rest) = tree::pick(&weights, place);
        Pick { index: (row * tree::WIDTH + lane) as u32, probability: weights[lane] / sum, rest }
    }
}
