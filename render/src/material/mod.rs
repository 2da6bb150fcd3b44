//! Scattering of light at a surface point: the closures (BSDFs) of materials.
//!
//! A material's inputs at a point, after textures, are [`Inputs`]. A [`Closure`] is made from them for one path and one
//! bounce, with three functions for integrators: [`eval`](Bsdf::eval) gives the value and the density for two
//! directions, [`sample`](Bsdf::sample) a next direction with its weight, and [`albedo`](Bsdf::albedo) the total
//! reflectance. There is no scene, no texture and no ray in this module.
//!
//! Directions are unit vectors in the shading frame and point away from the surface: z is the shading normal on the side
//! of `wo` (so `wo.z > 0`), x the tangent along which anisotropic highlights are shortest or longest, and y completes
//! the frame. [`Inputs`] lists the stack of layers.
//!
//! # Mirrors without a special case
//!
//! A path tracer usually counts emission at depth 0 or after a mirror only, as other surfaces get it by sampling the
//! lights. Here no such case is needed, as the density of a delta function *is* infinite where it is not zero:
//!
//! - `sample` gives a mirror's direction with the density `∞`;
//! - `eval` gives no light and the density 0, the delta function's value anywhere else;
//! - multiple importance sampling weights each technique by its density, and `∞` exceeds that of every light.
//!
//! So light that a mirror reflects has the weight 1, and light that was sampled at the mirror the weight 0, by the same
//! arithmetic as at any other surface. Depth 0 is no exception: a pinhole camera is one more delta function. No
//! integrator tests whether a surface is a mirror. A microfacet lobe is a delta function where both of its α are below
//! [`DELTA_ALPHA`].
//!
//! # Basic radiance
//!
//! Paths carry basic radiance, `L/n²`, which refraction does not change (Nicodemus 1963), instead of `L`, which grows
//! by the square of the refractive index on the way in and shrinks by it on the way out. Both are equal in air, and
//! basic radiance needs no rescaling at interfaces; a camera inside of glass shows `L/n²`. Weights are then the same
//! for radiance and importance. With `n` the refractive index on the side of each direction,
//!
//! `f(wo, wi) / n(wi)² = f(wi, wo) / n(wo)²`.
//!
//! # Deviations
//!
//! Layers do not widen the lobes below them, and a coat does not darken its base by reflecting light back to it.
//! Multiple scattering between microfacets is a separable lobe (Kulla and Conty 2017).

use glam::{Vec2, Vec3};

mod albedo_integral;
mod bump_shadowing;
mod closure;
mod column;
mod energy;
mod eon;
pub mod film;
pub mod fresnel;
pub mod ggx;
mod glass;
mod glossy;
mod layered;
mod lobes;
mod matte;
mod reflection;
mod shading;
mod sheen;
mod transmissive;

pub(crate) use bump_shadowing::BumpShadowing;
pub use closure::Closure;
pub(crate) use closure::Prepared;
pub use glossy::Glossy;
pub use layered::Layered;
pub use matte::Matte;
pub(crate) use reflection::{Reflection, Side};
pub use shading::{Shading, bent_normal};
pub use transmissive::Transmissive;

/// A microfacet lobe whose α are both below this is a delta function.
pub const DELTA_ALPHA: f32 = 1e-4;

/// A material's inputs at one point, after textures: all colours linear, all numbers finite and in their range.
///
/// The names are OpenPBR's (Academy Software Foundation 2024), and so is the stack, from the top:
///
/// - fuzz, over
/// - coat, over
/// - a mix by `base_metalness` of metal and dielectric; the dielectric is a specular reflection over a mix by
///   `transmission_weight` of glass and diffuse reflection; and diffuse reflection is mixed with diffuse transmission by
///   `diffuse_transmission_weight`.
///
/// Opacity, emission and normal maps belong to the scene's material.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Inputs {
    /// Albedo of diffuse reflection, and the metal's reflectance at normal incidence; 0 to 1.
    pub base_color: Vec3,
    /// Roughness of diffuse reflection, 0 (Lambert) to 1: EON, Portsmouth, Kutz and Hill 2024.
    pub base_diffuse_roughness: f32,
    /// 0 (dielectric) to 1 (metal).
    pub base_metalness: f32,
    /// The metal's reflectance at 82° as a part of what Schlick's formula gives there, 0 to 1: white is Schlick's
    /// formula itself (Kutz, Hašan and Edmondson 2021). OpenPBR's `specular_color` on a metal.
    pub metal_edge_color: Vec3,
    /// Scales the dielectric's reflectance at all angles, 0 to 1; 0 is no reflection. As `KHR_materials_specular`'s
    /// `specularFactor` does (OpenPBR's keeps the reflectance at grazing angles).
    pub specular_weight: f32,
    /// Scales the dielectric's reflectance at normal incidence, which is then clamped to 1; at grazing angles it stays
    /// white. 0 and above. As `KHR_materials_specular`'s `specularColorFactor` does.
    pub specular_color: Vec3,
    /// Roughness `r` of metal, dielectric reflection and transmission, 0 to 1: α = r².
    pub specular_roughness: f32,
    /// 0 to 1: `α_y = (1 - a) α_x`, `α_x² + α_y² = 2 r⁴` (OpenPBR), both limited to 1. Which way it points is the
    /// tangent's matter.
    pub specular_anisotropy: f32,
    /// Refractive index inside by that outside, 1 and above.
    pub specular_ior: f32,
    /// The part of the dielectric that is glass instead of opaque, 0 to 1.
    pub transmission_weight: f32,
    /// The tint of transmitted light, 0 to 1.
    pub transmission_color: Vec3,
    /// Whether the surface is a sheet without an inside: light goes straight through, and `is_inside` has no meaning.
    pub thin_walled: bool,
    /// Absorption coefficient inside, in one by the scene's unit of length, 0 and above. Closures leave it alone:
    /// integrators apply `exp(-absorption × distance)` (Beer-Lambert) to paths inside.
    pub absorption: Vec3,
    /// The part of diffuse light that leaves on the other side, 0 to 1.
    pub diffuse_transmission_weight: f32,
    /// Albedo of diffuse transmission, 0 to 1.
    pub diffuse_transmission_color: Vec3,
    /// The coverage of the clear coat, 0 to 1.
    pub coat_weight: f32,
    /// The tint of light that crosses the coat in and out at normal incidence, 0 to 1.
    pub coat_color: Vec3,
    /// Roughness of the coat, 0 to 1.
    pub coat_roughness: f32,
    /// Refractive index of the coat, 1 and above.
    pub coat_ior: f32,
    /// Normal of the coat: a unit vector in the shading frame, on the viewer's side. OpenPBR's `geometry_coat_normal`.
    pub coat_normal: Vec3,
    /// The coverage of fuzz (sheen), 0 to 1.
    pub fuzz_weight: f32,
    /// Albedo of the fuzz, 0 to 1.
    pub fuzz_color: Vec3,
    /// Roughness of the fuzz, 0 to 1.
    pub fuzz_roughness: f32,
    /// The coverage of the base by a thin film, under the coat, 0 to 1.
    pub thin_film_weight: f32,
    /// Thickness of the film in nanometres, 0 and above.
    pub thin_film_thickness: f32,
    /// Refractive index of the film, 1 and above.
    pub thin_film_ior: f32,
}

impl Inputs {
    /// Diffuse reflection of a half, and nothing else; whatever is given a weight then has the default of OpenPBR.
    pub const DEFAULT: Self = Self {
        base_color: Vec3::splat(0.5),
        base_diffuse_roughness: 0.0,
        base_metalness: 0.0,
        metal_edge_color: Vec3::ONE,
        specular_weight: 0.0,
        specular_color: Vec3::ONE,
        specular_roughness: 0.3,
        specular_anisotropy: 0.0,
        specular_ior: 1.5,
        transmission_weight: 0.0,
        transmission_color: Vec3::ONE,
        thin_walled: false,
        absorption: Vec3::ZERO,
        diffuse_transmission_weight: 0.0,
        diffuse_transmission_color: Vec3::ONE,
        coat_weight: 0.0,
        coat_color: Vec3::ONE,
        coat_roughness: 0.0,
        coat_ior: 1.6,
        coat_normal: Vec3::Z,
        fuzz_weight: 0.0,
        fuzz_color: Vec3::ONE,
        fuzz_roughness: 0.5,
        thin_film_weight: 0.0,
        thin_film_thickness: 500.0,
        thin_film_ior: 1.4,
    };
}

impl Default for Inputs {
    fn default() -> Self {
        Self::DEFAULT
    }
}

/// Which closure inputs need, from cheap to dear. Paths are sorted by it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Kind {
    /// Lambert's diffuse reflection alone.
    Matte,
    /// Metal, and a reflection over rough diffuse reflection.
    Glossy,
    /// Transmissive materials: glass, thin walls, diffuse transmission.
    Transmissive,
    /// Whatever has a coat, fuzz or a thin film.
    Layered,
}

impl Kind {
    /// How many there are.
    pub const COUNT: usize = 4;

    /// The kind that these inputs need. Of a material with textures: the kind of the greatest values that its inputs can
    /// take; a closure of that kind is right for all lesser ones.
    pub fn of(inputs: &Inputs) -> Self {
        if inputs.coat_weight > 0.0 || inputs.fuzz_weight > 0.0 || inputs.thin_film_weight > 0.0 {
            Self::Layered
        } else if inputs.transmission_weight > 0.0 || inputs.diffuse_transmission_weight > 0.0 {
            Self::Transmissive
        } else if inputs.base_metalness > 0.0 || inputs.specular_weight > 0.0 || inputs.base_diffuse_roughness > 0.0 {
            Self::Glossy
        } else {
            Self::Matte
        }
    }
}

/// The event of a sampled path: one lobe, and one side.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Event(u8);

impl Event {
    /// A wide lobe: diffuse light, fuzz, light between microfacets.
    pub const DIFFUSE: Self = Self(1);
    /// A rough reflection or refraction.
    pub const GLOSSY: Self = Self(2);
    /// A delta function: a mirror, clear glass.
    pub const SPECULAR: Self = Self(4);
    /// On the side of `wo`.
    pub const REFLECTION: Self = Self(8);
    /// On the other side.
    pub const TRANSMISSION: Self = Self(16);

    /// Whether all flags of `other` are set.
    #[inline]
    pub fn contains(self, other: Self) -> bool {
        self.0 & other.0 == other.0
    }
}

impl std::ops::BitOr for Event {
    type Output = Self;

    #[inline]
    fn bitor(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }
}

/// The result of [`Bsdf::eval`] for a pair of directions, without delta functions.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Evaluation {
    /// `f(wo, wi) |cos θi|`, by which basic radiance from `wi` is multiplied.
    pub f_cos: Vec3,
    /// Density per solid angle with which `sample` gives `wi` for `wo`.
    pub density: f32,
    /// Density per solid angle with which `sample` gives `wo` for `wi`; on the other side of the surface, if `wi` is.
    pub reverse_density: f32,
}

/// The result of [`Bsdf::sample`]: the continuation of a path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// Unit vector, in the shading frame.
    pub wi: Vec3,
    /// The factor on the path's throughput: `f |cos θi| / density`.
    pub weight: Vec3,
    /// Density per solid angle of `wi`; infinite for a delta function.
    pub density: f32,
    /// The lobe that was chosen, and its side.
    pub event: Event,
}

/// A bidirectional scattering distribution function at a point.
pub trait Bsdf {
    /// For inputs of this kind or a lesser one. `is_inside`: whether `wo` is on the inner side, behind the surface's
    /// geometric normal.
    fn new(inputs: &Inputs, is_inside: bool) -> Self;

    /// The value for light from `wi` to `wo`; `wo.z > 0`, `wi` on either side.
    fn eval(&self, wo: Vec3, wi: Vec3) -> Evaluation;

    /// The part of [`eval`](Self::eval)'s `f |cos θi|` that rough reflections and refractions have; the others are wide.
    fn glossy(&self, _wo: Vec3, _wi: Vec3) -> Vec3 {
        Vec3::ZERO
    }

    /// The next direction of a path; `None` if it is absorbed, which happens too where a microfacet's reflection points
    /// below the horizon. `u` is in [0, 1)².
    fn sample(&self, wo: Vec3, u: Vec2) -> Option<Sample>;

    /// The reflectance of its delta functions about the shading normal: the part of light from `wo`'s mirror direction
    /// that reaches `wo`.
    fn mirror_reflectance(&self, wo: Vec3) -> Vec3;

    /// The part of uniform light around the surface that reaches `wo`.
    fn albedo(&self, wo: Vec3) -> Vec3;

    /// The albedo of diffuse reflection alone, as attenuated by the layers above it.
    fn diffuse_albedo(&self, wo: Vec3) -> Vec3;

    /// Whether light from behind the surface is scattered to `wo`, delta functions left aside.
    fn transmits(&self) -> bool;
}

#[cfg(test)]
mod tests;
