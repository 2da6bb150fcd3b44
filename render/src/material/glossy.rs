//! Metal, and a dielectric's reflection over diffuse reflection and transmission.
//!
//! The microfacets of metal and dielectric are the same, so their reflections are one lobe with the mean of both
//! reflectances. Light scattered between the metal's microfacets is a separable lobe (Kulla and Conty 2017). Diffuse light
//! gets what the dielectric leaves: with `t(μ)` 1 less the albedo of its reflection and `t̄` the mean of `t`,
//!
//! `f = f_diffuse t(μ_o) t(μ_i) / t̄`,
//!
//! which is reciprocal and leaves nothing of a white furnace.
//!
//! Deviations: what a dielectric's microfacets reflect to each other goes to the diffuse light below, as it is too little
//! to be seen. Albedos of anisotropic microfacets are tabled as those of isotropic ones: right at normal incidence and
//! halfway between the axes, and else off by some percent at grazing angles where anisotropy is strong.

use std::f32::consts::FRAC_1_PI;

use glam::{Vec2, Vec3};
use halfdome_kernel::sampling::warp::{CosineHemisphere, Warp};

use super::energy::{self, Column};
use super::eon::Eon;
use super::film::Film;
use super::fresnel::{Dielectric, Metal};
use super::ggx::{Ggx, half, reflect};
use super::lobes::{Choice, Lobes, Parts, choose, mean};
use super::{Event, Inputs};

/// See [`Kind::Glossy`](super::Kind::Glossy).
#[derive(Clone, Copy, Debug)]
pub struct Glossy {
    ggx: Ggx,
    roughness: f32,
    metalness: f32,
    metal: Metal,
    dielectric: Dielectric,
    film: Option<Film>,
    /// `t(μ)`.
    below: Column,
    diffuse: Eon,
    transmitted: Vec3,
    /// The weight of both by `t̄`, and `t̄`.
    diffuse_scale: f32,
    below_mean: f32,
    /// What is chosen of diffuse light: mean albedo, and the share of transmission.
    diffuse_energy: f32,
    through: f32,
    /// `1 - E(μ)` of the microfacets where all is reflected, and the metal's colour after more than one reflection by the
    /// mean of that.
    lost: Column,
    multiple: Vec3,
    multiple_energy: f32,
}

/// A cosine between a direction and the microfacets that it sees, which stands for all of them where films are tabled.
#[inline]
fn typical_cos(cos: f32, alpha: f32) -> f32 {
    (cos + alpha) / (1.0 + alpha)
}

/// What depends on one direction.
#[derive(Clone, Copy)]
struct Side {
    below: f32,
    lost: f32,
    /// The probability of the glossy lobe.
    glossy: f32,
}

impl Glossy {
    /// With another metalness than the inputs'.
    #[inline]
    pub fn with_metalness(inputs: &Inputs, metalness: f32) -> Self {
        let ggx = Ggx::new(inputs.specular_roughness, inputs.specular_anisotropy);
        let roughness = ggx.mean_roughness();
        let metal = Metal::new(inputs.base_color, inputs.metal_edge_color);
        let dielectric = Dielectric::new(inputs.specular_ior, false, inputs.specular_weight, inputs.specular_color);
        // A mirror loses nothing, whatever the table has for the least roughness.
        let full = if ggx.is_delta() { Column::ONE } else { energy::full(roughness) };
        let below = if inputs.specular_weight > 0.0 {
            let fresnel = energy::reflection(roughness, inputs.specular_ior, false);
            full.zip(&fresnel, |full, fresnel| 1.0 - dielectric.greatest_albedo(full, fresnel))
        } else {
            Column::ONE
        };
        let film = Film::of(inputs);
        let below = if let Some(film) = &film {
            let reflectances = Column::from_fn(|cos| {
                dielectric.grazing * film.over_dielectric(typical_cos(cos, ggx.alpha.x), dielectric.eta).max_element()
            });
            let covered = reflectances.zip(&full, |reflectance, full| 1.0 - reflectance * full);
            below.lerp(&covered, film.weight)
        } else {
            below
        };
        let below_mean = below.mean();
        let through = inputs.diffuse_transmission_weight;
        let color = inputs.base_color * (1.0 - through);
        let transmitted = inputs.diffuse_transmission_color * through;
        let diffuse_energy = mean(color + transmitted);
        let lost = full.map(|full| (1.0 - full).max(0.0));
        let lost_mean = lost.mean();
        let multiple = metal.multiple(lost_mean) * metalness;
        Self {
            ggx,
            roughness,
            metalness,
            metal,
            dielectric,
            film,
            below,
            diffuse: Eon::new(color, inputs.base_diffuse_roughness),
            transmitted,
            diffuse_scale: (1.0 - metalness) / below_mean.max(f32::MIN_POSITIVE),
            below_mean,
            diffuse_energy: (1.0 - metalness) * diffuse_energy,
            through: mean(transmitted) / diffuse_energy.max(f32::MIN_POSITIVE),
            lost,
            multiple: multiple / lost_mean.max(1e-6),
            multiple_energy: mean(multiple),
        }
    }

    /// Roughly how much is scattered about one direction, by angle, its tint, and how much in all.
    #[inline]
    pub(super) fn energy(&self) -> (Column, Vec3, f32) {
        let metal = self.metalness * self.metal.mean();
        let most = metal.max_element();
        let dielectric = 1.0 - self.metalness;
        let glossy = self.below.map(|below| most + dielectric * (1.0 - below));
        let white = dielectric * (1.0 - self.below_mean);
        let tint = (metal + white) / (most + white).max(f32::MIN_POSITIVE);
        (glossy, tint, mean(metal) + white + self.diffuse_energy * self.below_mean)
    }

    /// How much wide lobes scatter by angle, in any unit but 0.
    #[inline]
    pub(super) fn wide(&self) -> Column {
        self.below.zip(&self.lost, |below, lost| {
            self.diffuse_energy * below + self.multiple_energy * lost + f32::MIN_POSITIVE
        })
    }

    #[inline]
    fn reflectance(&self, cos: f32) -> Vec3 {
        let mut reflectance = Vec3::ZERO;
        if self.metalness > 0.0 {
            reflectance += self.metalness * self.metal.at(cos);
        }
        if self.metalness < 1.0 {
            reflectance += (1.0 - self.metalness) * self.dielectric.at(cos).0;
        }
        if let Some(film) = &self.film {
            let metal = film.over_metal(cos, self.metal.normal());
            let dielectric = self.dielectric.grazing * film.over_dielectric(cos, self.dielectric.eta);
            reflectance = reflectance.lerp(dielectric.lerp(metal, self.metalness), film.weight);
        }
        reflectance
    }

    #[inline]
    fn side(&self, cos: f32) -> Side {
        let mut side = Side { below: self.below.at(cos), lost: 0.0, glossy: 0.0 };
        let mut glossy = (1.0 - self.metalness) * (1.0 - side.below);
        let mut wide = self.diffuse_energy * side.below;
        if self.metalness > 0.0 {
            side.lost = self.lost.at(cos);
            glossy += self.metalness * (1.0 - side.lost) * mean(self.metal.at(cos));
            wide += self.multiple_energy * side.lost;
        }
        side.glossy = glossy / (glossy + wide).max(f32::MIN_POSITIVE);
        side
    }
}

impl Lobes for Glossy {
    #[inline]
    fn new(inputs: &Inputs, _is_inside: bool) -> Self {
        Self::with_metalness(inputs, inputs.base_metalness)
    }

    #[inline]
    fn parts(&self, wo: Vec3, wi: Vec3) -> Parts {
        let (o, i) = (self.side(wo.z), self.side(wi.z.abs()));
        let diffuse = self.diffuse_scale * o.below * i.below;
        let share = if wi.z < 0.0 { self.through } else { 1.0 - self.through };
        let mut parts = Parts {
            density: (1.0 - o.glossy) * share * FRAC_1_PI * wi.z.abs(),
            reverse_density: (1.0 - i.glossy) * share * FRAC_1_PI * wo.z,
            ..Parts::default()
        };
        if wi.z <= 0.0 {
            parts.wide = self.transmitted * (diffuse * FRAC_1_PI * -wi.z);
            return parts;
        }
        parts.wide = (diffuse * wi.z) * self.diffuse.f(wo, wi) + (o.lost * i.lost * FRAC_1_PI * wi.z) * self.multiple;
        if !self.ggx.is_delta() {
            let (h, cos) = half(wo, wi);
            let lobe = self.ggx.d(h) * self.ggx.g2(wo, wi) / (4.0 * wo.z);
            parts.glossy = lobe * self.reflectance(cos);
            parts.density += o.glossy * self.ggx.reflection_density(wo, h);
            parts.reverse_density += i.glossy * self.ggx.reflection_density(wi, h);
        }
        parts
    }

    #[inline]
    fn choose(&self, wo: Vec3, mut u: Vec2) -> Option<Choice> {
        if choose(&mut u.x, self.side(wo.z).glossy) {
            if self.ggx.is_delta() {
                let weight = self.reflectance(wo.z) / self.side(wo.z).glossy;
                return Some(Choice::delta(reflect(wo, Vec3::Z), weight, Event::REFLECTION));
            }
            let wi = reflect(wo, self.ggx.sample_reflection(wo, u));
            return (wi.z > 0.0).then_some(Choice::new(wi, Event::GLOSSY | Event::REFLECTION));
        }
        if choose(&mut u.x, self.through) {
            return Some(Choice::new(-CosineHemisphere.map(u), Event::DIFFUSE | Event::TRANSMISSION));
        }
        Some(Choice::new(CosineHemisphere.map(u), Event::DIFFUSE | Event::REFLECTION))
    }

    fn albedo(&self, wo: Vec3) -> Vec3 {
        let full = 1.0 - self.lost.at(wo.z);
        let mut albedo = self.diffuse_albedo(wo) + self.multiple * ((1.0 - full) * self.lost.mean());
        if self.film.is_some() {
            return albedo + full * self.reflectance(typical_cos(wo.z, self.ggx.alpha.x));
        }
        if self.metalness > 0.0 {
            let (schlick, dip) = energy::metal_at(self.roughness, wo.z);
            albedo += self.metalness * self.metal.albedo(full, schlick, dip);
        }
        if self.metalness < 1.0 {
            let fresnel = energy::reflection_at(self.roughness, self.dielectric.eta, false, wo.z);
            albedo += (1.0 - self.metalness) * self.dielectric.albedo(full, fresnel);
        }
        albedo
    }

    #[inline]
    fn diffuse_albedo(&self, wo: Vec3) -> Vec3 {
        let below = self.diffuse_scale * self.below_mean * self.below.at(wo.z);
        below * (self.diffuse.albedo(wo) + self.transmitted)
    }

    #[inline]
    fn transmits(&self) -> bool {
        self.diffuse_scale > 0.0 && self.through > 0.0
    }
}
