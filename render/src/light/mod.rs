//! All that emits and can be aimed at: emissive triangles, lights without a surface and the sky, chosen in proportion to
//! power.

mod ambient;
mod sky;

use std::f32::consts::FRAC_1_PI;
use std::f64::consts::PI;

use glam::{DVec3, Vec3};
use halfdome_kernel::sampling::{AliasEntry, AliasTable, ONE_MINUS_EPSILON};
use halfdome_kernel::{Aabb, Isa, Triangle};

pub(crate) use self::sky::SkyLight;
use crate::scene::{Material, PunctualLight};
use crate::settings::LightSampling;

/// The lights of a world.
#[derive(Debug)]
pub(crate) struct Lights {
    sources: Vec<Source>,
    /// `None` if nothing emits: what else could be wrong with weights is excluded.
    table: Option<AliasTable<Vec<AliasEntry>>>,
    /// The same with nothing of the sky but its glare, if there is a sky.
    lamps: Option<AliasTable<Vec<AliasEntry>>>,
    /// The part of all power that lamps and glare have.
    lamps_share: f32,
    /// For each `prim_id` the probability density per area with which [`choose`](Self::choose) gives a point of it.
    area_density: Vec<f32>,
    /// The probability with which it gives the sky.
    sky_probability: f32,
    /// What is near an emissive triangle lies in this box.
    surroundings: Aabb,
    /// An estimate of the mean radiance that surfaces receive and send.
    mean_radiance: Vec3,
}

/// One light.
#[derive(Clone, Debug)]
pub(crate) enum Source {
    /// An emissive triangle.
    Triangle(u32),
    /// A light without a surface.
    Punctual(PunctualLight),
    /// The sky.
    Sky,
}

/// A light that was chosen.
pub(crate) struct Choice<'l> {
    pub source: &'l Source,
    /// The probability of choosing it.
    pub probability: f32,
    /// What is left of the number by which it was chosen, in [0, 1): where the numbers are spread evenly, those of each
    /// light are, and points that they place on a lamp of several triangles are so over all of it.
    pub rest: f32,
}

/// Linear sRGB to luminance (Rec. 709).
fn luminance(rgb: Vec3) -> f64 {
    rgb.as_dvec3().dot(DVec3::new(0.2126, 0.7152, 0.0722))
}

impl Lights {
    /// The lights among `triangles`, whose materials `material` gives, `punctual`, and the sky; `bounds` are the scene's.
    pub(crate) fn new<'m>(
        triangles: &[Triangle],
        material: impl Fn(usize) -> &'m Material,
        punctual: Vec<PunctualLight>,
        sky: &SkyLight,
        bounds: Aabb,
    ) -> Self {
        let (sky, glare) = (sky.mean(), sky.mean_glare());
        let mean_radiance = ambient::mean_radiance(triangles, &material, &punctual, sky, bounds);
        let mut sources = Vec::new();
        let mut powers = Vec::new();
        let mut areas = Vec::new();
        let mut emitting = Aabb::EMPTY;
        for (prim_id, triangle) in triangles.iter().enumerate() {
            let material = material(prim_id);
            let area = area(triangle);
            if material.emission != Vec3::ZERO && area > 0.0 {
                let sides = if material.emits_both_sides { 2.0 } else { 1.0 };
                powers.push(PI * f64::from(area) * sides * brightness(material.emission));
                sources.push(Source::Triangle(prim_id as u32));
                areas.push(area);
                emitting = emitting.union(&Aabb::around(triangle));
            }
        }
        for light in punctual {
            powers.push(power(&light, bounds));
            sources.push(Source::Punctual(light));
        }
        if sky != Vec3::ZERO {
            powers.push(sky_power(sky, bounds));
            sources.push(Source::Sky);
        }
        // Beyond the radius of a disc as large as all of them a sample is worth no more than a hemisphere full of light.
        let reach = Vec3::splat((areas.iter().sum::<f32>() * FRAC_1_PI).sqrt());
        let surroundings = Aabb { min: emitting.min - reach, max: emitting.max + reach };
        // Relative to the greatest, so that none overflows.
        let greatest = powers.iter().copied().fold(f64::MIN_POSITIVE, f64::max);
        let weights: Vec<f32> = powers.iter().map(|power| (power / greatest) as f32).collect();
        let table = AliasTable::build(&weights, vec![AliasEntry::default(); weights.len()]).ok();
        let glare_power = sky_power(glare, bounds);
        let lamps = match sources.split_last() {
            Some((Source::Sky, lamps)) => {
                let mut weights = weights[..lamps.len()].to_vec();
                if glare != Vec3::ZERO {
                    weights.push((glare_power / greatest) as f32);
                }
                AliasTable::build(&weights, vec![AliasEntry::default(); weights.len()]).ok()
            }
            _ => None,
        };
        let mut area_density = Vec::new();
        if let Some(table) = &table
            && !areas.is_empty()
        {
            area_density = vec![0.0; triangles.len()];
            for (index, (source, area)) in sources.iter().zip(areas).enumerate() {
                if let Source::Triangle(prim_id) = source {
                    area_density[*prim_id as usize] = table.mass(index) / area;
                }
            }
        }
        let sky_probability = match (&table, sources.last()) {
            (Some(table), Some(Source::Sky)) => table.mass(sources.len() - 1),
            _ => 0.0,
        };
        let dim = if glare == Vec3::ZERO { 1.0 } else { 1.0 - glare_power / sky_power(sky, bounds) };
        let lamps_share = 1.0 - sky_probability * dim as f32;
        Self { sources, table, lamps, lamps_share, area_density, sky_probability, surroundings, mean_radiance }
    }

    /// Chooses a light by a number in [0, 1), of double precision as there may be millions.
    #[inline]
    pub(crate) fn choose(&self, u: f64) -> Option<Choice<'_>> {
        let (index, probability, rest) = self.table.as_ref()?.sample(u);
        Some(Choice { source: &self.sources[index], probability, rest: as_rest(rest) })
    }

    /// Writes the number of the source that [`choose`](Self::choose) chooses by each of the numbers `u`, and what is left
    /// of `u`; whether there is any light.
    pub(crate) fn choose_many(&self, isa: Isa, u: &[f64], sources: &mut [u32], rests: &mut [f64]) -> bool {
        self.table.as_ref().map(|table| table.sample_many(isa, u, sources, rests)).is_some()
    }

    /// The choice of the source of this number, with what is left of the number by which it was chosen.
    pub(crate) fn choice(&self, source: usize, rest: f64) -> Option<Choice<'_>> {
        let probability = self.table.as_ref()?.mass(source);
        Some(Choice { source: self.sources.get(source)?, probability, rest: as_rest(rest) })
    }

    /// All lights, by their numbers.
    pub(crate) fn sources(&self) -> &[Source] {
        &self.sources
    }

    /// Chooses a lamp, or the sky for its glare, by a number in [0, 1); and by how much less often
    /// [`choose`](Self::choose) gives it, with the probability that is in the choice.
    #[inline]
    pub(crate) fn choose_lamp(&self, u: f64) -> Option<(Choice<'_>, f32)> {
        if self.sky_probability == 0.0 {
            return self.choose(u).map(|choice| (choice, 1.0));
        }
        let (index, among_lamps, rest) = self.lamps.as_ref()?.sample(u);
        let probability = self.table.as_ref()?.mass(index);
        let rest = as_rest(rest);
        Some((Choice { source: &self.sources[index], probability, rest }, probability / among_lamps))
    }

    /// Whether a surface emits.
    pub(crate) fn has_emitters(&self) -> bool {
        !self.area_density.is_empty()
    }

    /// How lamps are found from a point whose light besides theirs is known. An emissive triangle may be so near to it that
    /// samples of its area, whose density per solid angle falls with the square of the distance, are better combined with
    /// scattered rays; elsewhere such rays would find nothing.
    #[inline]
    pub(crate) fn techniques_at(&self, point: Vec3) -> LightSampling {
        let are_near = (point.cmpge(self.surroundings.min) & point.cmple(self.surroundings.max)).all();
        if are_near { LightSampling::Mis } else { LightSampling::Direct }
    }

    /// The density per area with which points of triangle `prim_id` are chosen.
    #[inline]
    pub(crate) fn area_density(&self, prim_id: u32) -> f32 {
        self.area_density.get(prim_id as usize).copied().unwrap_or(0.0)
    }

    /// The probability with which the sky is chosen.
    pub(crate) fn sky_probability(&self) -> f32 {
        self.sky_probability
    }

    /// By how much [`choose`](Self::choose) gives a lamp less often than [`choose_lamp`](Self::choose_lamp).
    pub(crate) fn lamps_share(&self) -> f32 {
        self.lamps_share
    }

    /// What a point is likely to receive from any direction, and to send: an estimate for all of the scene.
    pub(crate) fn mean_radiance(&self) -> Vec3 {
        self.mean_radiance
    }
}

/// What is left of a number, in [0, 1) as a single too.
#[inline(always)]
pub(crate) fn as_rest(rest: f64) -> f32 {
    (rest as f32).min(ONE_MINUS_EPSILON)
}

/// Area of a triangle.
fn area(triangle: &Triangle) -> f32 {
    let [a, b, c] = triangle.map(|p| p.as_dvec3());
    (0.5 * (b - a).cross(c - a).length()) as f32
}

/// Luminance, but never zero for what is not black: each light must have a chance.
fn brightness(rgb: Vec3) -> f64 {
    luminance(rgb).max(f64::from(rgb.max_element()) * 0.05)
}

/// The luminous power of a light without a surface; of a directional one, what it sends through the scene's sphere.
fn power(light: &PunctualLight, bounds: Aabb) -> f64 {
    let (color, extent) = flux(light, bounds);
    brightness(color) * extent
}

/// The same of the sky.
fn sky_power(sky: Vec3, bounds: Aabb) -> f64 {
    PI * brightness(sky) * 4.0 * PI * radius(bounds).powi(2)
}

/// A light's colour, and what it is multiplied by to give the light's power.
fn flux(light: &PunctualLight, bounds: Aabb) -> (Vec3, f64) {
    match light {
        PunctualLight::Point { intensity, .. } => (*intensity, 4.0 * PI),
        PunctualLight::Spot { intensity, cos_inner, cos_outer, .. } => {
            (*intensity, 2.0 * PI * (1.0 - 0.5 * f64::from(cos_inner + cos_outer)))
        }
        PunctualLight::Directional { irradiance, .. } => (*irradiance, PI * radius(bounds).powi(2)),
    }
}

/// The radius of the scene's sphere.
fn radius(bounds: Aabb) -> f64 {
    let diagonal = (bounds.max - bounds.min).as_dvec3().length();
    if bounds.is_empty() { 1.0 } else { 0.5 * diagonal }
}
