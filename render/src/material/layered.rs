//! Fuzz over a clear coat over the rest.
//!
//! With `t(μ)` 1 less the albedo of what covers a lobe, a wide lobe below has the factor `t(μ_o) t(μ_i) / t̄`, as under
//! a dielectric's own reflection, and a lobe about one direction `min(t(μ_o), t(μ_i))`, which is exact for a mirror.
//! The energy that a rough lobe loses this way is scattered by a separable lobe. A coat's colour is absorbed along its
//! slanted path, `color^(1/(2 cos θ_coat))` on the way in and on the way out.
//!
//! Seen from inside, glass has its coat and fuzz on the other side: they attenuate transmitted light.
//!
//! A coat may have a normal of its own: then its lobe, and its transmittance to the base, use angles about that normal.
//!
//! Deviation: light that a coat reflects back into glass is lost.

use std::f32::consts::FRAC_1_PI;

use glam::{Vec2, Vec3};
use halfdome_kernel::sampling::Frame;
use halfdome_kernel::sampling::warp::{CosineHemisphere, Warp};

use super::column::Column;
use super::energy;
use super::fresnel::Dielectric;
use super::ggx::{Ggx, half, reflect};
use super::lobes::{Choice, Lobes, Parts, choose, mean};
use super::sheen::Sheen;
use super::{Event, Inputs, Transmissive};

/// See [`Kind::Layered`](super::Kind::Layered).
#[derive(Clone, Copy, Debug)]
pub struct Layered {
    base: Transmissive,
    coat: Ggx,
    /// The coat's own frame, if it is another one.
    coat_frame: Option<Frame>,
    coat_fresnel: Dielectric,
    coat_weight: f32,
    coat_color: Vec3,
    fuzz: Option<Sheen>,
    fuzz_color: Vec3,
    /// What fuzz leaves for the coat, and what both leave for the base.
    under_fuzz: Column,
    below: Column,
    below_mean: f32,
    /// The energy that lobes about one direction lose, its mean, and the colour of its scattering.
    lost: Column,
    lost_scale: Vec3,
    /// What is chosen of the lost light and of the base, under a cover that leaves all.
    lost_energy: f32,
    base_energy: f32,
    /// Whether `wo` is on the side of coat and fuzz.
    is_outside: bool,
    /// Whether both sides are.
    is_sheet: bool,
}

/// The probabilities of lobes for a direction: of fuzz, of the coat, of the lost light, and of the base.
#[derive(Clone, Copy)]
struct Shares {
    fuzz: f32,
    coat: f32,
    lost: f32,
    base: f32,
}

impl Layered {
    /// A direction in the coat's frame.
    #[inline]
    fn about_coat(&self, w: Vec3) -> Vec3 {
        self.coat_frame.as_ref().map_or(w, |frame| frame.to_local(w))
    }

    /// A direction of the coat's frame in that of the surface.
    #[inline]
    fn about_surface(&self, w: Vec3) -> Vec3 {
        self.coat_frame.as_ref().map_or(w, |frame| frame.to_world(w))
    }

    /// The coat's `f |cos θ|` and its density, from a direction in its own frame to one above the surface. What a tilted coat
    /// reflects to below the surface is mirrored to above it, as [`Shading`](super::Shading) does: so no light is lost.
    #[inline]
    fn coat_lobe(&self, from: Vec3, to: Vec3) -> (Vec3, f32) {
        let mut sum = (Vec3::ZERO, 0.0);
        let mirrored = self.coat_frame.is_some().then(|| Vec3::new(to.x, to.y, -to.z));
        for to in std::iter::once(to).chain(mirrored).map(|to| self.about_coat(to)) {
            if from.z > 0.0 && to.z > 0.0 {
                let (h, cos) = half(from, to);
                let lobe = self.coat.d(h) * self.coat.g2(from, to) / (4.0 * from.z);
                sum.0 += self.coat_fresnel.at(cos).0 * lobe;
                sum.1 += self.coat.reflection_density(from, h);
            }
        }
        sum
    }

    /// Where a direction leads that the coat reflects to, in its own frame.
    #[inline]
    fn off_coat(&self, w: Vec3) -> Vec3 {
        let w = self.about_surface(w);
        Vec3::new(w.x, w.y, w.z.abs())
    }

    #[inline]
    fn shares(&self, cos: f32) -> Shares {
        let under_fuzz = self.under_fuzz.at(cos);
        let below = self.below.at(cos);
        let fuzz = 1.0 - under_fuzz;
        let coat = (under_fuzz - below).max(0.0);
        let lost = self.lost.at(cos) * self.lost_energy;
        let base = below * self.base_energy;
        let sum = (fuzz + coat + lost + base).max(f32::MIN_POSITIVE);
        Shares { fuzz: fuzz / sum, coat: coat / sum, lost: lost / sum, base: base / sum }
    }

    /// The transmittance of the coat in one direction.
    #[inline]
    fn absorbed(&self, cos: f32) -> Vec3 {
        if self.coat_color == Vec3::ONE {
            return Vec3::ONE;
        }
        let eta = self.coat_fresnel.eta;
        let cos_coat = (1.0 - (1.0 - cos) * (1.0 + cos) / (eta * eta)).max(0.0).sqrt();
        let color = self.coat_color.map(|c| c.powf(0.5 / cos_coat));
        Vec3::ONE.lerp(color, self.coat_weight)
    }
}

impl Lobes for Layered {
    #[inline]
    fn new(inputs: &Inputs, is_inside: bool) -> Self {
        let base: Transmissive = Lobes::new(inputs, is_inside);
        let is_sheet = inputs.thin_walled || inputs.transmission_weight * (1.0 - inputs.base_metalness) == 0.0;
        let coat = Ggx::new(inputs.coat_roughness, 0.0);
        let coat_frame = (inputs.coat_normal != Vec3::Z).then(|| Frame::from_normal(inputs.coat_normal));
        let coat_fresnel = Dielectric::new(inputs.coat_ior, false, inputs.coat_weight, Vec3::ONE);
        let fuzz = (inputs.fuzz_weight > 0.0).then(|| Sheen::new(inputs.fuzz_roughness));
        let fuzz_color = inputs.fuzz_weight * inputs.fuzz_color;
        let fuzz_most = fuzz_color.max_element();
        let under_fuzz = fuzz.as_ref().map_or(Column::ONE, |fuzz| fuzz.albedo.map(|albedo| 1.0 - fuzz_most * albedo));
        let below = if inputs.coat_weight > 0.0 {
            let roughness = if coat.is_delta() { 0.0 } else { inputs.coat_roughness };
            let reflected = energy::reflection(roughness, inputs.coat_ior, false).column();
            under_fuzz.zip(&reflected, |under, reflected| under * (1.0 - inputs.coat_weight * reflected))
        } else {
            under_fuzz
        };
        let energy = base.energy();
        let base_ggx = Ggx::new(inputs.specular_roughness, inputs.specular_anisotropy);
        let lost = if base_ggx.is_delta() {
            Column::ZERO
        } else {
            energy::dimmed_under(&below, base_ggx.mean_roughness()).zip(&energy.glossy, |lost, glossy| lost * glossy)
        };
        let lost_mean = lost.mean();
        // As wide lobes below are not even: of the angles at which they are.
        let below_mean = below.zip(&energy.wide, |below, wide| below * wide).mean() / energy.wide.mean();
        Self {
            base,
            coat,
            coat_frame,
            coat_fresnel,
            coat_weight: inputs.coat_weight,
            coat_color: inputs.coat_color,
            fuzz,
            fuzz_color,
            under_fuzz,
            below,
            below_mean,
            lost,
            lost_scale: energy.tint / lost_mean.max(1e-6),
            lost_energy: mean(energy.tint),
            base_energy: energy.all.max(0.02),
            is_outside: is_sheet || !is_inside,
            is_sheet,
        }
    }

    fn parts(&self, wo: Vec3, wi: Vec3) -> Parts {
        let mut base = self.base.parts(wo, wi);
        let (coat_o, coat_i) = (self.about_coat(wo), self.about_coat(wi));
        let (cos_o, cos_i) = (coat_o.z.abs(), coat_i.z.abs());
        if wi.z <= 0.0 && !self.is_sheet {
            // Through glass, whose layers are on one side.
            let outside = if self.is_outside { cos_o } else { cos_i };
            let factor = self.below.at(outside) * self.absorbed(outside);
            base.glossy *= factor;
            base.wide *= factor;
            if self.is_outside {
                base.density *= self.shares(cos_o).base;
            } else {
                base.reverse_density *= self.shares(cos_i).base;
            }
            return base;
        }
        if !self.is_outside {
            return base;
        }
        let (o, i) = (self.shares(cos_o), self.shares(cos_i));
        let (below_o, below_i) = (self.below.at(cos_o), self.below.at(cos_i));
        let absorbed = self.absorbed(cos_o) * self.absorbed(cos_i);
        let mut parts = Parts {
            glossy: base.glossy * absorbed * below_o.min(below_i),
            wide: base.wide * absorbed * (below_o * below_i / self.below_mean.max(f32::MIN_POSITIVE)),
            density: o.base * base.density,
            reverse_density: i.base * base.reverse_density,
        };
        if wi.z <= 0.0 {
            return parts;
        }
        let (lost_o, lost_i) = (self.lost.at(cos_o), self.lost.at(cos_i));
        parts.wide += self.lost_scale * absorbed * (lost_o * lost_i * FRAC_1_PI * wi.z);
        parts.density += o.lost * FRAC_1_PI * wi.z;
        parts.reverse_density += i.lost * FRAC_1_PI * wo.z;
        if let Some(fuzz) = &self.fuzz {
            let (f, density, reverse_density) = fuzz.eval(wo, wi);
            parts.wide += self.fuzz_color * (f * wi.z);
            parts.density += o.fuzz * density;
            parts.reverse_density += i.fuzz * reverse_density;
        }
        if self.coat_weight > 0.0 && !self.coat.is_delta() {
            let under = self.under_fuzz.at(cos_o).min(self.under_fuzz.at(cos_i));
            let (f_cos, density) = self.coat_lobe(coat_o, wi);
            parts.glossy += f_cos * under;
            parts.density += o.coat * density;
            parts.reverse_density += i.coat * self.coat_lobe(coat_i, wo).1;
        }
        parts
    }

    fn choose(&self, wo: Vec3, mut u: Vec2) -> Option<Choice> {
        if !self.is_outside {
            let mut choice = self.base.choose(wo, u)?;
            if let Some(weight) = choice.delta.as_mut().filter(|_| choice.wi.z < 0.0) {
                let cos = self.about_coat(choice.wi).z.abs();
                *weight *= self.below.at(cos) * self.absorbed(cos);
            }
            return Some(choice);
        }
        let coat_o = self.about_coat(wo);
        let cos_o = coat_o.z.abs();
        let Shares { fuzz, coat, lost, .. } = self.shares(cos_o);
        if choose(&mut u.x, fuzz) {
            let wi = self.fuzz.as_ref()?.sample(wo, u);
            return (wi.z > 0.0).then(|| Choice::new(wi, Event::DIFFUSE | Event::REFLECTION));
        }
        let rest = 1.0 - fuzz;
        if choose(&mut u.x, coat / rest) {
            if self.coat.is_delta() {
                let weight = self.coat_fresnel.at(cos_o).0 * (self.under_fuzz.at(cos_o) / coat);
                let wi = self.off_coat(reflect(coat_o, Vec3::Z));
                return Some(Choice::delta(wi, weight, Event::REFLECTION));
            }
            let coat_i = reflect(coat_o, self.coat.sample_reflection(coat_o, u));
            let wi = self.off_coat(coat_i);
            return (coat_i.z > 0.0).then(|| Choice::new(wi, Event::GLOSSY | Event::REFLECTION));
        }
        let rest = rest - coat;
        if choose(&mut u.x, lost / rest) {
            return Some(Choice::new(CosineHemisphere.map(u), Event::DIFFUSE | Event::REFLECTION));
        }
        let mut choice = self.base.choose(wo, u)?;
        if let Some(weight) = choice.delta.as_mut() {
            let cos_i = self.about_coat(choice.wi).z.abs();
            let (below, absorbed) = if choice.wi.z > 0.0 || self.is_sheet {
                (self.below.at(cos_o).min(self.below.at(cos_i)), self.absorbed(cos_o) * self.absorbed(cos_i))
            } else {
                (self.below.at(cos_o), self.absorbed(cos_o))
            };
            *weight *= absorbed * (below / (rest - lost));
        }
        Some(choice)
    }

    /// Without a coat that has a normal of its own.
    fn mirror_reflectance(&self, wo: Vec3) -> Vec3 {
        let base = Lobes::mirror_reflectance(&self.base, wo);
        if !self.is_outside {
            return base;
        }
        let cos = self.about_coat(wo).z.abs();
        let absorbed = self.absorbed(cos);
        let is_mirror = self.coat_weight > 0.0 && self.coat.is_delta() && self.coat_frame.is_none();
        let coat = if is_mirror { self.coat_fresnel.at(cos).0 * self.under_fuzz.at(cos) } else { Vec3::ZERO };
        base * absorbed * absorbed * self.below.at(cos) + coat
    }

    /// The base's albedo, as if light came back at the angle of `wo`.
    fn albedo(&self, wo: Vec3) -> Vec3 {
        let base = Lobes::albedo(&self.base, wo);
        if !self.is_outside {
            return base;
        }
        let cos_o = self.about_coat(wo).z.abs();
        let coat = (self.under_fuzz.at(cos_o) - self.below.at(cos_o)).max(0.0);
        let fuzz = self.fuzz.as_ref().map_or(0.0, |fuzz| fuzz.albedo.at(wo.z));
        let absorbed = self.absorbed(cos_o);
        base * absorbed * absorbed * self.below.at(cos_o) + Vec3::splat(coat) + self.fuzz_color * fuzz
    }

    fn diffuse_albedo(&self, wo: Vec3) -> Vec3 {
        let base = Lobes::diffuse_albedo(&self.base, wo);
        if !self.is_outside {
            return base;
        }
        let cos_o = self.about_coat(wo).z.abs();
        let absorbed = self.absorbed(cos_o);
        base * absorbed * absorbed * self.below.at(cos_o)
    }

    #[inline]
    fn transmits(&self) -> bool {
        Lobes::transmits(&self.base)
    }
}
