//! The interface of a transparent dielectric, rough or smooth, with an inside or as a thin wall.
//!
//! Walter, Marschner, Li and Torrance, "Microfacet models for refraction through rough surfaces" (2007). For basic radiance
//! the half vector is along `n_o wo + n_i wi`, and with `d` the square of its length
//!
//! `f = |wo·h| |wi·h| / (|wo_z| |wi_z|) n_i² (1 - F) G₂ D / d`.
//!
//! A microfacet is sampled first, then reflection with the probability of its own `F`: inside, some microfacets reflect
//! everything and others next to nothing.
//!
//! A thin wall's two faces reflect `2F/(1 + F)`, all inner reflections summed; the rest is transmitted straight on,
//! spread like the reflection.
//!
//! Light that microfacets scatter out of these lobes is in separable lobes on both sides (after Kulla and Conty 2017): with
//! `K` what is lost at an angle, `K̄` its mean on a side, and `T` the mean transmittance from outside, light that is lost
//! from side `a` goes on to side `b` with the part `τ_a = T/n_a² min(1, K̄_b/K̄_a)` of it (`n` 1 outside):
//!
//! `f_r = (1 - τ_a) K_a(μ_o) K_a(μ_i) / (π K̄_a)`, `f_t = τ_a K_a(μ_o) K_b(μ_i) / (π K̄_b)`,
//!
//! which loses nothing and is reciprocal.

use std::f32::consts::FRAC_1_PI;

use glam::{Vec2, Vec3};
use halfdome_kernel::sampling::warp::{CosineHemisphere, Warp};

use super::column::{Blend, Node};
use super::energy;
use super::film::Film;
use super::fresnel::{self, Dielectric};
use super::ggx::{Ggx, half, reflect};
use super::lobes::{Choice, Lobes, Parts, choose, mean};
use super::{Event, Inputs};

/// Reflection and transmission of an interface.
#[derive(Clone, Copy, Debug)]
pub(super) struct Glass {
    ggx: Ggx,
    film: Option<Film>,
    tint: Vec3,
    here: Side,
    beyond: Side,
    /// `(1 - τ)/K̄` here, and `τ` here by `K̄` beyond.
    reflected_scale: f32,
    through_scale: f32,
}

/// The data of one side of the interface.
#[derive(Clone, Copy, Debug)]
struct Side {
    index: f32,
    is_thin: bool,
    fresnel: Dielectric,
    /// Albedo of reflection where all is reflected, with Fresnel's reflectance, and that of reflection and refraction.
    full: Blend<2>,
    reflection: Blend<4>,
    all: Blend<4>,
    /// `τ`.
    through: f32,
}

/// A refractive index this near to 1 has no half vector that rounding spares.
const LEAST_INDEX: f32 = 1.001;

/// How much finer the digits are that choose between reflection and transmission than those that draw the microfacet.
const FINER: f32 = 1024.0;

impl Side {
    #[inline]
    fn new(inputs: &Inputs, is_inside: bool, ggx: &Ggx) -> Self {
        let Inputs { specular_ior: ior, specular_weight: weight, specular_color, thin_walled, .. } = *inputs;
        let ior = ior.max(LEAST_INDEX);
        let is_inside = is_inside && !thin_walled;
        let roughness = ggx.mean_roughness();
        let full = energy::full(roughness);
        let all = if ggx.is_delta() {
            Blend::constant(1.0)
        } else if thin_walled {
            full.widen()
        } else {
            energy::glass(roughness, ior, is_inside)
        };
        Self {
            index: if is_inside { ior } else { 1.0 },
            is_thin: thin_walled,
            fresnel: Dielectric::new(ior, is_inside, weight, specular_color),
            full,
            reflection: energy::reflection(roughness, ior, is_inside),
            all,
            through: 0.0,
        }
    }

    /// The mean of `K`.
    #[inline]
    fn lost_mean(&self) -> f32 {
        (1.0 - self.all.mean()).max(1e-6)
    }

    /// `K(μ)`, the probability of the separable lobes.
    #[inline]
    fn lost(&self, cos: f32) -> f32 {
        (1.0 - self.all.at(Node::new(cos))).max(0.0)
    }

    /// `K(μ)`, and the albedo of reflection, the greatest of the three colours.
    #[inline]
    fn albedos(&self, cos: f32) -> (f32, f32) {
        let node = Node::new(cos);
        let full = self.full.at(node);
        let reflected = self.fresnel.greatest_albedo(full, self.reflection.at(node));
        let reflected = if self.is_thin { 2.0 * reflected * full / (full + reflected) } else { reflected };
        ((1.0 - self.all.at(node)).max(0.0), reflected)
    }
}

/// A direction seen from the other side, or in the mirror of a thin wall.
#[inline]
fn turned(w: Vec3) -> Vec3 {
    Vec3::new(w.x, w.y, -w.z)
}

/// The probability of reflection for a microfacet with this reflectance and transmittance.
#[inline]
fn reflection_probability(reflected: Vec3, transmitted: Vec3) -> f32 {
    let [reflected, transmitted] = [reflected, transmitted].map(mean);
    reflected / (reflected + transmitted).max(f32::MIN_POSITIVE)
}

impl Glass {
    /// Roughly how much is scattered.
    #[inline]
    pub(super) fn energy(&self) -> f32 {
        0.1 + 0.9 * mean(self.tint)
    }

    /// Reflected and transmitted light, and the cosine of the refracted direction.
    #[inline]
    fn split(&self, cos: f32) -> (Vec3, Vec3, f32) {
        let (reflected, cos_beyond) = self.here.fresnel.at(cos);
        if cos_beyond == 0.0 && !self.here.is_thin {
            return (Vec3::ONE, Vec3::ZERO, 0.0);
        }
        let reflected = self.covered(reflected, if self.here.index > 1.0 { cos_beyond } else { cos });
        (reflected, self.transmitted(reflected), cos_beyond)
    }

    /// Reflection with the film, which light from inside meets at the angle outside, and by both faces of a thin wall.
    #[inline]
    fn covered(&self, mut reflected: Vec3, cos_outside: f32) -> Vec3 {
        if let Some(film) = &self.film {
            let ior = self.here.index.max(self.beyond.index).max(self.here.fresnel.eta);
            let covered = self.here.fresnel.grazing * film.over_dielectric(cos_outside, ior);
            reflected = reflected.lerp(covered, film.weight);
        }
        if self.here.is_thin { 2.0 * reflected / (1.0 + reflected) } else { reflected }
    }

    #[inline]
    fn transmitted(&self, reflected: Vec3) -> Vec3 {
        self.tint * (1.0 - reflected.max_element())
    }

    /// Through a thin wall: what it would reflect to the mirror image of `wi`. `forth` and `back`: the probabilities
    /// that microfacets scatter, not the separable lobes.
    #[inline]
    fn through_wall(&self, wo: Vec3, wi: Vec3, parts: &mut Parts, forth: f32, back: f32) {
        let wi = turned(wi);
        let (h, cos) = half(wo, wi);
        let (reflected, transmitted, _) = self.split(cos);
        let d = 0.25 * self.ggx.d(h);
        parts.glossy = transmitted * (d * self.ggx.g2(wo, wi) / wo.z);
        let probability = 1.0 - reflection_probability(reflected, transmitted);
        parts.density += forth * probability * d * self.ggx.g1(wo) / wo.z;
        parts.reverse_density += back * probability * d * self.ggx.g1(wi) / wi.z;
    }

    /// Through a microfacet.
    #[inline]
    fn refracted(&self, wo: Vec3, wi: Vec3, parts: &mut Parts, forth: f32, back: f32) {
        let sum = self.here.index * wo + self.beyond.index * wi;
        let d2 = sum.length_squared();
        let h = sum * (1f32.copysign(sum.z) / d2.sqrt().max(f32::MIN_POSITIVE));
        let (cos_o, cos_i) = (wo.dot(h), -wi.dot(h));
        if cos_o <= 0.0 || cos_i <= 0.0 {
            return;
        }
        // Computed from both cosines, as deriving one from the other is inaccurate near total reflection.
        let reflectance = fresnel::of_refraction(cos_o, cos_i, self.here.fresnel.eta);
        let cos_outside = if self.here.index > 1.0 { cos_i } else { cos_o };
        let reflected = self.covered(self.here.fresnel.stretch(reflectance), cos_outside.min(1.0));
        let transmitted = self.transmitted(reflected);
        let (here, beyond) = (self.here.index * self.here.index, self.beyond.index * self.beyond.index);
        let jacobian = self.ggx.d(h) * cos_o * cos_i / d2;
        parts.glossy = transmitted * (jacobian * beyond * self.ggx.g2(wo, wi) / wo.z);
        let probability = 1.0 - reflection_probability(reflected, transmitted);
        parts.density += forth * probability * jacobian * beyond * self.ggx.g1(wo) / wo.z;
        parts.reverse_density += back * probability * jacobian * here * self.ggx.g1(wi) / -wi.z;
    }

    /// The direction beyond a microfacet; `None` where reflection is total.
    #[inline]
    fn refract(&self, wo: Vec3, h: Vec3) -> Option<Vec3> {
        if self.here.is_thin {
            return Some(turned(reflect(wo, h)));
        }
        let cos = wo.dot(h).clamp(0.0, 1.0);
        let (_, _, cos_beyond) = self.split(cos);
        let eta = self.here.fresnel.eta;
        (cos_beyond > 0.0).then(|| ((cos / eta - cos_beyond) * h - wo / eta).normalize())
    }
}

impl Lobes for Glass {
    #[inline]
    fn new(inputs: &Inputs, is_inside: bool) -> Self {
        let ggx = Ggx::new(inputs.specular_roughness, inputs.specular_anisotropy);
        let is_thin = inputs.thin_walled;
        let ior = inputs.specular_ior.max(LEAST_INDEX);
        let [mut here, mut beyond] = [is_inside, !is_inside].map(|is_inside| Side::new(inputs, is_inside, &ggx));
        let [mean_here, mean_beyond] = [&here, &beyond].map(Side::lost_mean);
        let smooth = energy::reflection(0.0, ior, false);
        let reflectance = if is_thin { smooth.column().map(|f| 2.0 * f / (1.0 + f)).mean() } else { smooth.mean() };
        let through = |index: f32, ratio: f32| (1.0 - reflectance) / (index * index) * ratio.min(1.0);
        here.through = through(here.index, mean_beyond / mean_here);
        beyond.through = through(beyond.index, mean_here / mean_beyond);
        Self {
            ggx,
            film: Film::of(inputs),
            tint: inputs.transmission_color,
            here,
            beyond,
            reflected_scale: (1.0 - here.through) / mean_here,
            through_scale: here.through / mean_beyond,
        }
    }

    #[inline]
    fn parts(&self, wo: Vec3, wi: Vec3) -> Parts {
        if self.ggx.is_delta() {
            return Parts::default();
        }
        let lost_o = self.here.lost(wo.z);
        if wi.z > 0.0 {
            let lost_i = self.here.lost(wi.z);
            let (h, cos) = half(wo, wi);
            let (reflected, transmitted, _) = self.split(cos);
            let probability = reflection_probability(reflected, transmitted);
            let d = 0.25 * self.ggx.d(h);
            let wide = (1.0 - self.here.through) * FRAC_1_PI;
            let density = |lost: f32, w: Vec3, cos: f32| {
                lost * wide * cos + (1.0 - lost) * probability * d * self.ggx.g1(w) / w.z
            };
            return Parts {
                glossy: reflected * (d * self.ggx.g2(wo, wi) / wo.z),
                wide: Vec3::splat(self.reflected_scale * lost_o * lost_i * FRAC_1_PI * wi.z),
                density: density(lost_o, wo, wi.z),
                reverse_density: density(lost_i, wi, wo.z),
            };
        }
        let lost_i = self.beyond.lost(-wi.z);
        let mut parts = Parts {
            glossy: Vec3::ZERO,
            wide: self.tint * (self.through_scale * lost_o * lost_i * FRAC_1_PI * -wi.z),
            density: lost_o * self.here.through * FRAC_1_PI * -wi.z,
            reverse_density: lost_i * self.beyond.through * FRAC_1_PI * wo.z,
        };
        let (forth, back) = (1.0 - lost_o, 1.0 - lost_i);
        if self.here.is_thin {
            self.through_wall(wo, wi, &mut parts, forth, back);
        } else {
            self.refracted(wo, wi, &mut parts, forth, back);
        }
        parts
    }

    #[inline]
    fn choose(&self, wo: Vec3, mut u: Vec2) -> Option<Choice> {
        if choose(&mut u.x, self.here.lost(wo.z)) {
            let is_through = choose(&mut u.x, self.here.through);
            let cosine = CosineHemisphere.map(u);
            return Some(if is_through {
                Choice::new(-cosine, Event::DIFFUSE | Event::TRANSMISSION)
            } else {
                Choice::new(cosine, Event::DIFFUSE | Event::REFLECTION)
            });
        }
        let is_delta = self.ggx.is_delta();
        let h = if is_delta { Vec3::Z } else { self.ggx.sample_normal(wo, u) };
        let (reflected, transmitted, _) = self.split(wo.dot(h).clamp(0.0, 1.0));
        let probability = reflection_probability(reflected, transmitted);
        let digits = if is_delta { u.x } else { (FINER * u.x).fract() };
        let is_reflected = digits < probability;
        let (wi, side) = if is_reflected {
            (Some(reflect(wo, h)).filter(|wi| wi.z > 0.0), Event::REFLECTION)
        } else {
            (self.refract(wo, h).filter(|wi| wi.z < 0.0), Event::TRANSMISSION)
        };
        if is_delta {
            let weight = if is_reflected { reflected / probability } else { transmitted / (1.0 - probability) };
            return wi.map(|wi| Choice::delta(wi, weight, side));
        }
        wi.map(|wi| Choice::new(wi, Event::GLOSSY | side))
    }

    fn mirror_reflectance(&self, wo: Vec3) -> Vec3 {
        if self.ggx.is_delta() { self.split(wo.z).0 } else { Vec3::ZERO }
    }

    /// Of the tints of reflection as if microfacets reflected what the surface as a whole does.
    fn albedo(&self, wo: Vec3) -> Vec3 {
        let (lost, reflected) = self.here.albedos(wo.z);
        let (color, _, _) = self.split(wo.z);
        let wide = Vec3::splat(1.0 - self.here.through) + self.here.through * self.tint;
        color * (reflected / color.max_element().max(f32::MIN_POSITIVE))
            + (1.0 - lost - reflected).max(0.0) * self.tint
            + lost * wide
    }

    #[inline]
    fn diffuse_albedo(&self, _wo: Vec3) -> Vec3 {
        Vec3::ZERO
    }

    #[inline]
    fn transmits(&self) -> bool {
        !self.ggx.is_delta()
    }
}
