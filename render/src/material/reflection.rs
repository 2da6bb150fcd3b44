//! Reflection by microfacets over diffuse reflection, without table lookups: the code shared by one
//! [`Glossy`](super::Glossy) closure and by many in lanes.
//!
//! No function here has a branch, so that loops over them are vectorised. The tabled values for a direction are a
//! [`Side`].

use std::f32::consts::FRAC_1_PI;

use bytemuck::{Pod, Zeroable};
use glam::{Vec2, Vec3};
use halfdome_kernel::sampling::warp::{CosineHemisphere, Warp};

use super::eon::Eon;
use super::fresnel::{Dielectric, Metal};
use super::ggx::{Ggx, half, reflect};
use super::lobes::choose;

/// The microfacets of metal and dielectric, and what is below.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct Reflection {
    pub(super) ggx: Ggx,
    pub(super) metalness: f32,
    pub(super) metal: Metal,
    pub(super) dielectric: Dielectric,
    pub(super) diffuse: Eon,
    /// The weight of diffuse light by `t̄`.
    pub(super) diffuse_scale: f32,
    /// What further reflections leave of light that microfacets of the metal reflect more than once.
    pub(super) multiple: Vec3,
}

/// The tabled values of a direction.
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct Side {
    /// `t(μ)`.
    pub below: f32,
    /// What the metal's lobe is multiplied by for this direction.
    pub gain: f32,
    /// The probability of the glossy lobe.
    pub glossy: f32,
}

/// What microfacets reflect from one direction to another where all is reflected, their normal, and its cosine with both.
#[derive(Clone, Copy)]
pub(super) struct Lobe {
    pub f_cos: f32,
    pub half: Vec3,
    pub cos: f32,
}

/// A direction that was chosen.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Chosen {
    pub wi: Vec3,
    /// Whether microfacets reflect to it.
    pub is_glossy: bool,
}

impl Reflection {
    /// Whether it reflects as a mirror does.
    #[inline(always)]
    pub(crate) fn is_delta(&self) -> bool {
        self.ggx.is_delta()
    }

    /// The reflectance of a microfacet, with the gains of both directions.
    #[inline(always)]
    pub(super) fn reflectance(&self, cos: f32, gain: f32) -> Vec3 {
        let metal = self.metal.at(cos) * self.gained(gain);
        self.metalness * metal + (1.0 - self.metalness) * self.dielectric.at(cos).0
    }

    /// By how much a metal's lobe is brighter than without light that is reflected more than once.
    #[inline(always)]
    pub(super) fn gained(&self, gain: f32) -> Vec3 {
        1.0 + self.multiple * (gain - 1.0)
    }

    /// Nothing of a mirror, nor below the horizon.
    #[inline(always)]
    pub(super) fn lobe(&self, wo: Vec3, wi: Vec3) -> Lobe {
        let (half, cos) = half(wo, wi);
        let f_cos = self.ggx.d(half) * self.ggx.g2(wo, wi) / (4.0 * wo.z);
        Lobe { f_cos: if self.is_delta() | (wi.z <= 0.0) { 0.0 } else { f_cos }, half, cos }
    }

    /// `f |cos θi|` of diffuse light; nothing below the horizon.
    #[inline(always)]
    pub(super) fn wide(&self, (wo, o): (Vec3, Side), (wi, i): (Vec3, Side)) -> Vec3 {
        let cos = wi.z.max(0.0);
        let diffuse = self.diffuse_scale * o.below * i.below;
        (diffuse * cos) * self.diffuse.f(wo, wi)
    }

    /// The density per solid angle of `wi` where the microfacet's normal is `half`; 0 below the horizon.
    #[inline(always)]
    pub(super) fn density(&self, (wo, o): (Vec3, Side), wi: Vec3, half: Vec3) -> f32 {
        let glossy = o.glossy * self.ggx.reflection_density(wo, half);
        let glossy = if self.is_delta() | (wi.z <= 0.0) { 0.0 } else { glossy };
        (1.0 - o.glossy) * FRAC_1_PI * wi.z.max(0.0) + glossy
    }

    /// `f |cos θi|` of all but a mirror, and the density per solid angle of `wi`.
    #[inline(always)]
    pub(crate) fn eval(&self, wo: (Vec3, Side), wi: (Vec3, Side)) -> (Vec3, f32) {
        let lobe = self.lobe(wo.0, wi.0);
        let reflectance = self.reflectance(lobe.cos, wo.1.gain * wi.1.gain);
        (lobe.f_cos * reflectance + self.wide(wo, wi), self.density(wo, wi.0, lobe.half))
    }

    /// A direction from one of both lobes, which may point below the horizon.
    #[inline(always)]
    pub(crate) fn choose(&self, (wo, o): (Vec3, Side), mut u: Vec2) -> Chosen {
        let is_glossy = choose(&mut u.x, o.glossy);
        let half = self.ggx.sample_reflection(wo, u);
        let half = if self.is_delta() { Vec3::Z } else { half };
        let [glossy, wide] = [reflect(wo, half), CosineHemisphere.map(u)];
        let wi = if is_glossy { glossy } else { wide };
        Chosen { wi, is_glossy }
    }

    /// What the path is multiplied by that a mirror was chosen for.
    #[inline(always)]
    pub(crate) fn mirror_weight(&self, (wo, o): (Vec3, Side)) -> Vec3 {
        self.reflectance(wo.z, 1.0) / o.glossy
    }
}
