//! Metal, and a dielectric's reflection over diffuse reflection and transmission.
//!
//! The microfacets of metal and dielectric are the same, so their reflections are one lobe with the mean of both
//! reflectances. Multiple scattering between a metal's microfacets makes its lobe brighter by the [gain](energy::gain)
//! of both directions, tinted by the colour (Kulla and Conty 2017). Diffuse reflection gets the light that the
//! dielectric transmits: with `t(μ)` 1 less the albedo of its reflection and `t̄` the mean of `t`,
//!
//! `f = f_diffuse t(μ_o) t(μ_i) / t̄`,
//!
//! which is reciprocal and passes a white furnace test.
//!
//! Deviations: multiple scattering between a dielectric's microfacets is added to the diffuse light below, as it is too
//! little to be visible. Albedos of anisotropic microfacets are tabled as those of isotropic ones: exact at normal
//! incidence and halfway between the axes, and otherwise off by a few percent at grazing angles with strong anisotropy.

use std::f32::consts::FRAC_1_PI;

use bytemuck::Zeroable;
use glam::{Vec2, Vec3};
use halfdome_kernel::sampling::warp::{CosineHemisphere, Warp};

use super::column::{Blend, COSINES, Column, Node};
use super::energy;
use super::eon::Eon;
use super::film::Film;
use super::fresnel::{Dielectric, Metal};
use super::ggx::Ggx;
use super::lobes::{Choice, Energy, Lobes, Parts, choose, mean};
use super::reflection::{Chosen, Reflection, Side};
use super::{Event, Inputs};

/// See [`Kind::Glossy`](super::Kind::Glossy).
#[derive(Clone, Copy, Debug)]
pub struct Glossy {
    reflection: Reflection,
    film: Option<Film>,
    /// Albedo of the microfacets' reflection where all is reflected, the gain of metal, and the albedo with Fresnel's reflectance.
    full: Blend<2>,
    gain: Blend<2>,
    fresnel: Blend<4>,
    transmitted: Vec3,
    /// `t̄`.
    below_mean: f32,
    /// What is chosen of diffuse light: mean albedo, and the share of transmission.
    diffuse_energy: f32,
    through: f32,
    /// The mean of what microfacets lose where all is reflected.
    lost_mean: f32,
}

/// A cosine between a direction and the microfacets that it sees, which represents all of them where films are tabled.
#[inline]
fn typical_cos(cos: f32, alpha: f32) -> f32 {
    (cos + alpha) / (1.0 + alpha)
}

impl Glossy {
    /// A closure with another metalness than the inputs'.
    #[inline]
    pub fn with_metalness(inputs: &Inputs, metalness: f32) -> Self {
        let ggx = Ggx::new(inputs.specular_roughness, inputs.specular_anisotropy);
        let roughness = ggx.mean_roughness();
        let dielectric = Dielectric::new(inputs.specular_ior, false, inputs.specular_weight, inputs.specular_color);
        // A mirror loses nothing, whatever the table has for the least roughness.
        let full = if ggx.is_delta() { Blend::constant(1.0) } else { energy::full(roughness) };
        let gains = metalness > 0.0 && !ggx.is_delta();
        let gain = if gains { energy::gain(roughness) } else { Blend::constant(1.0) };
        let reflects = inputs.specular_weight > 0.0 && metalness < 1.0;
        let fresnel =
            if reflects { energy::reflection(roughness, inputs.specular_ior, false) } else { Blend::constant(0.0) };
        let mut glossy = Self {
            reflection: Reflection { ggx, metalness, dielectric, ..Reflection::zeroed() },
            film: Film::of(inputs),
            full,
            gain,
            fresnel,
            transmitted: inputs.diffuse_transmission_color * inputs.diffuse_transmission_weight,
            below_mean: 1.0 - dielectric.greatest_albedo(full.mean(), fresnel.mean()),
            diffuse_energy: 0.0,
            through: 0.0,
            lost_mean: (1.0 - full.mean()).max(0.0),
        };
        if glossy.film.is_some() {
            glossy.below_mean = glossy.below().mean();
        }
        glossy.reflection.diffuse_scale = (1.0 - metalness) / glossy.below_mean.max(f32::MIN_POSITIVE);
        glossy.set_base_color(inputs);
        glossy
    }

    /// Sets all that depends on the inputs' base colour; it is otherwise made from these inputs.
    #[inline]
    pub(super) fn set_base_color(&mut self, inputs: &Inputs) {
        let metalness = self.reflection.metalness;
        let metal = Metal::new(inputs.base_color, inputs.metal_edge_color);
        let color = inputs.base_color * (1.0 - inputs.diffuse_transmission_weight);
        let diffuse_energy = mean(color + self.transmitted);
        self.reflection.metal = metal;
        self.reflection.diffuse = Eon::new(color, inputs.base_diffuse_roughness);
        self.reflection.multiple = metal.multiple(self.lost_mean);
        self.diffuse_energy = (1.0 - metalness) * diffuse_energy;
        self.through = mean(self.transmitted) / diffuse_energy.max(f32::MIN_POSITIVE);
    }

    /// The parts without table lookups.
    #[inline]
    pub(crate) fn reflection(&self) -> &Reflection {
        &self.reflection
    }

    /// `t(μ)` and the gain.
    #[inline]
    pub(crate) fn left_at(&self, cos: f32) -> (f32, f32) {
        let node = Node::new(cos);
        (self.below_at(cos, self.full.at(node), self.fresnel.at(node)), self.gain_at(node))
    }

    /// The factor on metal's lobe for a direction.
    #[inline]
    fn gain_at(&self, node: Node) -> f32 {
        if self.reflection.metalness > 0.0 { self.gain.at(node) } else { 1.0 }
    }

    /// `t(μ)`, with both albedos at this cosine.
    #[inline]
    fn below_at(&self, cos: f32, full: f32, fresnel: f32) -> f32 {
        let dielectric = &self.reflection.dielectric;
        let mut below = 1.0 - dielectric.greatest_albedo(full, fresnel);
        if let Some(film) = &self.film {
            let cos = typical_cos(cos, self.reflection.ggx.alpha.x);
            let reflectance = dielectric.grazing * film.over_dielectric(cos, dielectric.eta).max_element();
            below += film.weight * (1.0 - reflectance * full - below);
        }
        below
    }

    /// What diffuse light is reflected and transmitted to a direction, for which `t(μ)` is `below`.
    #[inline]
    fn diffuse_from(&self, wo: Vec3, below: f32) -> Vec3 {
        let scale = self.reflection.diffuse_scale * self.below_mean * below;
        scale * (self.reflection.diffuse.albedo(wo) + self.transmitted)
    }

    /// `t(μ)` of all angles.
    #[inline]
    fn below(&self) -> Column {
        let (full, fresnel) = (self.full.column(), self.fresnel.column());
        Column::by_node(|k| self.below_at(COSINES.0[k], full.0[k], fresnel.0[k]))
    }

    /// Roughly how much is scattered. What goes about one direction is as a cover dims it.
    #[inline]
    pub(super) fn energy(&self) -> Energy {
        let metalness = self.reflection.metalness;
        let metal = metalness * self.reflection.metal.mean();
        let most = metal.max_element();
        let dielectric = 1.0 - metalness;
        let below = self.below();
        let glossy = if metalness > 0.0 && !self.reflection.is_delta() {
            let (gain, multiple) =
                (energy::dimmed_gain(self.reflection.ggx.mean_roughness()), mean(self.reflection.multiple));
            below.zip(&gain, |below, gain| most * (1.0 + multiple * (gain - 1.0)) + dielectric * (1.0 - below))
        } else {
            below.map(|below| most + dielectric * (1.0 - below))
        };
        let white = dielectric * (1.0 - self.below_mean);
        let tint = (metal + white) / (most + white).max(f32::MIN_POSITIVE);
        let all = mean(metal) + white + self.diffuse_energy * self.below_mean;
        let wide = below.map(|below| self.diffuse_energy * below + f32::MIN_POSITIVE);
        Energy { all, glossy, tint, wide }
    }

    #[inline]
    fn reflectance(&self, cos: f32, gain: f32) -> Vec3 {
        let reflectance = self.reflection.reflectance(cos, gain);
        let Some(film) = &self.film else { return reflectance };
        let Reflection { metal, dielectric, metalness, .. } = &self.reflection;
        let over_metal = film.over_metal(cos, metal.normal()) * self.reflection.gained(gain);
        let over_dielectric = dielectric.grazing * film.over_dielectric(cos, dielectric.eta);
        reflectance.lerp(over_dielectric.lerp(over_metal, *metalness), film.weight)
    }

    /// The tabled values of a direction with this cosine.
    #[inline]
    pub(crate) fn side(&self, cos: f32) -> Side {
        let node = Node::new(cos);
        let (full, fresnel) = (self.full.at(node), self.fresnel.at(node));
        self.side_by(cos, node, full, self.below_at(cos, full, fresnel))
    }

    /// The side by the albedo of microfacets and `t(μ)` at this cosine.
    #[inline]
    fn side_by(&self, cos: f32, node: Node, full: f32, below: f32) -> Side {
        let metalness = self.reflection.metalness;
        let mut glossy = (1.0 - metalness) * (1.0 - below);
        let wide = self.diffuse_energy * below;
        if metalness > 0.0 {
            glossy += metalness * mean(self.reflection.metal.at(cos) * self.all_of(full));
        }
        Side { below, gain: self.gain_at(node), glossy: glossy / (glossy + wide).max(f32::MIN_POSITIVE) }
    }

    /// What a metal's microfacets reflect at once and later, of what one of them does; the albedo of the first is `full`.
    #[inline]
    fn all_of(&self, full: f32) -> Vec3 {
        full + self.reflection.multiple * (1.0 - full).max(0.0)
    }

    /// The [`albedo`](super::Bsdf::albedo) and the [`side`](Self::side) of a direction.
    #[inline]
    pub(crate) fn seen_from(&self, wo: Vec3) -> (Vec3, Side) {
        let node = Node::new(wo.z);
        let (full, fresnel) = (self.full.at(node), self.fresnel.at(node));
        let below = self.below_at(wo.z, full, fresnel);
        (self.albedo_by(wo, node, (full, fresnel), below), self.side_by(wo.z, node, full, below))
    }

    /// The albedo, with those of the microfacets at this node, and `t(μ)`.
    #[inline]
    fn albedo_by(&self, wo: Vec3, node: Node, (full, fresnel): (f32, f32), below: f32) -> Vec3 {
        let Reflection { metal, dielectric, metalness, .. } = self.reflection;
        let mut albedo = self.diffuse_from(wo, below);
        if self.film.is_some() {
            let gain = full.max(f32::MIN_POSITIVE).recip();
            return albedo + full * self.reflectance(typical_cos(wo.z, self.reflection.ggx.alpha.x), gain);
        }
        if metalness > 0.0 {
            let (schlick, dip) = energy::metal_at(self.reflection.ggx.mean_roughness(), node);
            albedo += metalness * metal.albedo(full, schlick, dip) * (self.all_of(full) / full.max(f32::MIN_POSITIVE));
        }
        if metalness < 1.0 {
            albedo += (1.0 - metalness) * dielectric.albedo(full, fresnel);
        }
        albedo
    }
}

impl Lobes for Glossy {
    #[inline]
    fn new(inputs: &Inputs, _is_inside: bool) -> Self {
        Self::with_metalness(inputs, inputs.base_metalness)
    }

    #[inline]
    fn parts(&self, wo: Vec3, wi: Vec3) -> Parts {
        let it = &self.reflection;
        let (o, i) = (self.side(wo.z), self.side(wi.z.abs()));
        let through = |side: Side, cos: f32| (1.0 - side.glossy) * self.through * FRAC_1_PI * cos;
        if wi.z <= 0.0 {
            let diffuse = it.diffuse_scale * o.below * i.below;
            return Parts {
                wide: self.transmitted * (diffuse * FRAC_1_PI * -wi.z),
                density: through(o, -wi.z),
                reverse_density: through(i, wo.z),
                ..Parts::default()
            };
        }
        let lobe = it.lobe(wo, wi);
        Parts {
            glossy: lobe.f_cos * self.reflectance(lobe.cos, o.gain * i.gain),
            wide: it.wide((wo, o), (wi, i)),
            density: it.density((wo, o), wi, lobe.half) - through(o, wi.z),
            reverse_density: it.density((wi, i), wo, lobe.half) - through(i, wo.z),
        }
    }

    #[inline]
    fn choose(&self, wo: Vec3, u: Vec2) -> Option<Choice> {
        let o = self.side(wo.z);
        let mut rest = u;
        if !choose(&mut rest.x, o.glossy) && self.through > 0.0 {
            let is_through = choose(&mut rest.x, self.through);
            let wi = CosineHemisphere.map(rest);
            return Some(if is_through {
                Choice::new(-wi, Event::DIFFUSE | Event::TRANSMISSION)
            } else {
                Choice::new(wi, Event::DIFFUSE | Event::REFLECTION)
            });
        }
        let Chosen { wi, is_glossy } = self.reflection.choose((wo, o), u);
        if is_glossy && self.reflection.is_delta() {
            return Some(Choice::delta(wi, self.reflectance(wo.z, 1.0) / o.glossy, Event::REFLECTION));
        }
        let lobe = if is_glossy { Event::GLOSSY } else { Event::DIFFUSE };
        (wi.z > 0.0).then_some(Choice::new(wi, lobe | Event::REFLECTION))
    }

    fn mirror_reflectance(&self, wo: Vec3) -> Vec3 {
        if self.reflection.is_delta() { self.reflectance(wo.z, 1.0) } else { Vec3::ZERO }
    }

    fn albedo(&self, wo: Vec3) -> Vec3 {
        self.seen_from(wo).0
    }

    #[inline]
    fn diffuse_albedo(&self, wo: Vec3) -> Vec3 {
        self.diffuse_from(wo, self.left_at(wo.z).0)
    }

    #[inline]
    fn transmits(&self) -> bool {
        self.reflection.diffuse_scale > 0.0 && self.through > 0.0
    }
}
