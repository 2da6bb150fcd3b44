//! All that emits and can be aimed at: emissive triangles, delta lights and the sky, chosen in proportion to
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
pub(crate) struct LightSampler {
    lights: Vec<Light>,
    /// `None` if nothing emits: what else could be wrong with weights is excluded.
    table: Option<AliasTable<Vec<AliasEntry>>>,
    /// The same with nothing of the sky but its sun, if there is a sky.
    table_without_sky: Option<AliasTable<Vec<AliasEntry>>>,
    /// The part of all power that all but the sky have, and its sun.
    share_without_sky: f32,
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
pub(crate) enum Light {
    /// An emissive triangle.
    Triangle(u32),
    /// A delta light.
    Punctual(PunctualLight),
    /// The sky.
    Sky,
}

/// A light that was chosen.
pub(crate) struct SampledLight<'l> {
    pub light: &'l Light,
    /// The probability of choosing it.
    pub probability: f32,
    /// What is left of the number by which it was chosen, in [0, 1): where the numbers are spread evenly, those of each
    /// light are, and points that they place on an area light of several triangles are so over all of it.
    pub rest: f32,
}

/// Linear sRGB to luminance (Rec. 709).
fn luminance(rgb: Vec3) -> f64 {
    rgb.as_dvec3().dot(DVec3::new(0.2126, 0.7152, 0.0722))
}

impl LightSampler {
    /// The lights among `triangles`, whose materials `material` gives, `punctual`, and the sky; `bounds` are the scene's.
    pub(crate) fn new<'m>(
        triangles: &[Triangle],
        material: impl Fn(usize) -> &'m Material,
        punctual: Vec<PunctualLight>,
        sky: &SkyLight,
        bounds: Aabb,
    ) -> Self {
        let (sky, sun) = (sky.mean(), sky.mean_sun());
        let mean_radiance = ambient::mean_radiance(triangles, &material, &punctual, sky, bounds);
        let mut lights = Vec::new();
        let mut powers = Vec::new();
        let mut areas = Vec::new();
        let mut emitting = Aabb::EMPTY;
        for (prim_id, triangle) in triangles.iter().enumerate() {
            let material = material(prim_id);
            let area = area(triangle);
            if material.emission != Vec3::ZERO && area > 0.0 {
                let sides = if material.emits_both_sides { 2.0 } else { 1.0 };
                powers.push(PI * f64::from(area) * sides * brightness(material.emission));
                lights.push(Light::Triangle(prim_id as u32));
                areas.push(area);
                emitting = emitting.union(&Aabb::around(triangle));
            }
        }
        for light in punctual {
            powers.push(power(&light, bounds));
            lights.push(Light::Punctual(light));
        }
        if sky != Vec3::ZERO {
            powers.push(sky_power(sky, bounds));
            lights.push(Light::Sky);
        }
        // Beyond the radius of a disc as large as all of them a sample is worth no more than a hemisphere full of light.
        let reach = Vec3::splat((areas.iter().sum::<f32>() * FRAC_1_PI).sqrt());
        let surroundings = Aabb { min: emitting.min - reach, max: emitting.max + reach };
        // Relative to the greatest, so that none overflows.
        let greatest = powers.iter().copied().fold(f64::MIN_POSITIVE, f64::max);
        let weights: Vec<f32> = powers.iter().map(|power| (power / greatest) as f32).collect();
        let table = AliasTable::build(&weights, vec![AliasEntry::default(); weights.len()]).ok();
        let sun_power = sky_power(sun, bounds);
        let table_without_sky = match lights.split_last() {
            Some((Light::Sky, table_without_sky)) => {
                let mut weights = weights[..table_without_sky.len()].to_vec();
                if sun != Vec3::ZERO {
                    weights.push((sun_power / greatest) as f32);
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
            for (index, (light, area)) in lights.iter().zip(areas).enumerate() {
                if let Light::Triangle(prim_id) = light {
                    area_density[*prim_id as usize] = table.mass(index) / area;
                }
            }
        }
        let sky_probability = match (&table, lights.last()) {
            (Some(table), Some(Light::Sky)) => table.mass(lights.len() - 1),
            _ => 0.0,
        };
        let dim = if sun == Vec3::ZERO { 1.0 } else { 1.0 - sun_power / sky_power(sky, bounds) };
        let share_without_sky = 1.0 - sky_probability * dim as f32;
        Self {
            lights,
            table,
            table_without_sky,
            share_without_sky,
            area_density,
            sky_probability,
            surroundings,
            mean_radiance,
        }
    }

    /// Chooses a light by a number in [0, 1), of double precision as there may be millions.
    #[inline]
    pub(crate) fn choose(&self, u: f64) -> Option<SampledLight<'_>> {
        let (index, probability, rest) = self.table.as_ref()?.sample(u);
        Some(SampledLight { light: &self.lights[index], probability, rest: rest_as_f32(rest) })
    }

    /// Writes the index of the light that [`choose`](Self::choose) chooses by each of the numbers `u`, and what is left
    /// of `u`; whether there is any light.
    pub(crate) fn choose_many(&self, isa: Isa, u: &[f64], lights: &mut [u32], rests: &mut [f64]) -> bool {
        self.table.as_ref().map(|table| table.sample_many(isa, u, lights, rests)).is_some()
    }

    /// The choice of the light of this index, with what is left of the number by which it was chosen.
    pub(crate) fn choice(&self, light: usize, rest: f64) -> Option<SampledLight<'_>> {
        let probability = self.table.as_ref()?.mass(light);
        Some(SampledLight { light: self.lights.get(light)?, probability, rest: rest_as_f32(rest) })
    }

    /// All lights, by their numbers.
    pub(crate) fn lights(&self) -> &[Light] {
        &self.lights
    }

    /// Chooses a light other than the sky, or the sky for its sun, by a number in [0, 1); and by how much less often
    /// [`choose`](Self::choose) gives it, with the probability that is in the choice.
    #[inline]
    pub(crate) fn choose_without_sky(&self, u: f64) -> Option<(SampledLight<'_>, f32)> {
        if self.sky_probability == 0.0 {
            return self.choose(u).map(|choice| (choice, 1.0));
        }
        let (index, mass_without_sky, rest) = self.table_without_sky.as_ref()?.sample(u);
        let probability = self.table.as_ref()?.mass(index);
        let rest = rest_as_f32(rest);
        Some((SampledLight { light: &self.lights[index], probability, rest }, probability / mass_without_sky))
    }

    /// Whether a surface emits.
    pub(crate) fn has_emitters(&self) -> bool {
        !self.area_density.is_empty()
    }

    /// How area lights are found from a point whose indirect light is known. An emissive triangle may be so near to it that
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

    /// By how much [`choose`](Self::choose) gives a light other than the sky less often than [`choose_without_sky`](Self::choose_without_sky).
    pub(crate) fn share_without_sky(&self) -> f32 {
        self.share_without_sky
    }

    /// What a point is likely to receive from any direction, and to send: an estimate for all of the scene.
    pub(crate) fn mean_radiance(&self) -> Vec3 {
        self.mean_radiance
    }
}

/// What is left of a number, in [0, 1) as a single too.
#[inline(always)]
pub(crate) fn rest_as_f32(rest: f64) -> f32 {
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

/// The luminous power of a delta light; of a directional one, what it sends through the scene's sphere.
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
