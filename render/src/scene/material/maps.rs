//! Maps: textures on the inputs of a material.
//!
//! An input with a map goes from a value at texel 0 (`zero`, mostly 0) to its constant at texel 1:
//! `value = zero × (1 - texel) + constant × texel`. With 0 that is the product that most formats define; glossiness (1
//! to roughness) and a film's thickness (minimum to maximum) are the same formula.

use glam::{Vec2, Vec3, Vec4};

use super::Input;
use crate::material::Inputs;
use crate::scene::TextureMap;

/// A texture and the inputs that it varies: one lookup serves them all.
#[derive(Clone, Debug, PartialEq)]
pub struct InputMap {
    /// The mapping.
    pub texture: TextureMap,
    /// The input that it varies.
    pub targets: Vec<Target>,
}

/// An input that a texture varies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Target {
    /// The input.
    pub input: Input,
    /// The part of the texel that counts.
    pub channel: Channel,
    /// The input's value where the texel is 0; where it is 1, the material's constant counts.
    pub zero: f32,
}

/// A part of a texel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Channel {
    /// Red, green and blue; of one number, red.
    #[default]
    Rgb,
    /// Red.
    R,
    /// Green.
    G,
    /// Blue.
    B,
    /// Alpha.
    A,
}

/// Normals in tangent space (MikkTSpace): red along the tangent, green along the bitangent, blue along the normal, each
/// from -1 at texel 0 to 1 at texel 1.
#[derive(Clone, Debug, PartialEq)]
pub struct NormalMap {
    /// Where it lies; in [`ColorSpace::Linear`](crate::scene::ColorSpace::Linear).
    pub texture: TextureMap,
    /// What the first two components are multiplied by; the second is negative where green points down in the picture.
    pub scale: Vec2,
}

/// The normal map of a coat.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum CoatNormal {
    /// The same as those of what it covers.
    #[default]
    OfBase,
    /// Nothing: they are those of the vertices.
    OfVertices,
    /// A map of its own.
    Map(NormalMap),
}

/// Heights over the surface, which turn its normals (Blinn 1978).
#[derive(Clone, Debug, PartialEq)]
pub struct BumpMap {
    /// The mapping.
    pub texture: TextureMap,
    /// Which part of the texel is the height.
    pub channel: Channel,
    /// The height, in the scene's unit of length, where the texel is 1.
    pub height: f32,
}

/// The opacity of a surface.
#[derive(Clone, Debug, PartialEq)]
pub struct Opacity {
    /// From 0, nothing, to 1, all of it. A vertex colour's alpha multiplies it.
    pub value: f32,
    /// The map that multiplies it.
    pub map: Option<(TextureMap, Channel)>,
    /// A mask: below this opacity there is a hole, from it on the surface is whole. Without one, a surface is there
    /// with the probability of its opacity.
    pub cutoff: Option<f32>,
}

/// `KHR_materials_anisotropy`: with roughness `r`, α along the tangent is `r² + (1 - r²) strength²`, across it `r²`.
/// Blender writes its own parameter for the strength, by which they are `r² / a` and `r² a` with
/// `a² = 1 - 0.9 strength`.
#[derive(Clone, Debug, PartialEq)]
pub struct GltfAnisotropy {
    /// 0 to 1.
    pub strength: f32,
    /// Whether the strength is Blender's parameter.
    pub is_by_blender: bool,
    /// Red and green turn the tangent, from -1 to 1 each along tangent and bitangent; blue multiplies the strength.
    pub map: Option<TextureMap>,
}

impl Default for Opacity {
    /// All of it.
    fn default() -> Self {
        Self { value: 1.0, map: None, cutoff: None }
    }
}

impl Channel {
    /// This part of a texel; of a single channel three times over.
    #[inline]
    pub(crate) fn of(self, texel: Vec4) -> Vec3 {
        match self {
            Self::Rgb => texel.truncate(),
            Self::R => Vec3::splat(texel.x),
            Self::G => Vec3::splat(texel.y),
            Self::B => Vec3::splat(texel.z),
            Self::A => Vec3::splat(texel.w),
        }
    }

    /// The name in scene files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Rgb => "rgb",
            Self::R => "r",
            Self::G => "g",
            Self::B => "b",
            Self::A => "a",
        }
    }
}

impl CoatNormal {
    /// The map, if it has one of its own.
    pub(crate) fn map(&self) -> Option<&NormalMap> {
        match self {
            Self::Map(map) => Some(map),
            Self::OfBase | Self::OfVertices => None,
        }
    }
}

impl InputMap {
    /// The effect of the texel on the constants.
    #[inline]
    pub(super) fn apply(&self, texel: Vec4, inputs: &mut Inputs) {
        for &Target { input, channel, zero } in &self.targets {
            let (constant, part) = (input.get(inputs), channel.of(texel));
            // In this form it is exact at both ends.
            input.set(inputs, zero * (1.0 - part) + constant * part);
        }
    }
}

impl Opacity {
    /// The opacity for a texel and a vertex colour's alpha, 0 to 1; 0 or 1 of a mask.
    #[inline]
    pub(crate) fn at(&self, texel: Vec4, alpha: f32) -> f32 {
        let opacity = self.before_cutoff(texel, alpha);
        match self.cutoff {
            Some(cutoff) if opacity < cutoff => 0.0,
            Some(_) => 1.0,
            None => opacity,
        }
    }

    #[inline]
    fn before_cutoff(&self, texel: Vec4, alpha: f32) -> f32 {
        let mapped = self.map.as_ref().map_or(1.0, |(_, channel)| channel.of(texel).x);
        (self.value * mapped * alpha).clamp(0.0, 1.0)
    }

    /// Whether mixtures of this texel and others that give the same opacity may give another than 0, or than 1.
    pub(crate) fn may_differ(&self, texel: Vec4) -> [bool; 2] {
        // More than mixing rounds.
        const ROUNDING: f32 = 1e-5;
        let opacity = self.before_cutoff(texel, 1.0);
        match self.cutoff {
            Some(cutoff) => [opacity >= cutoff - ROUNDING, opacity < cutoff + ROUNDING],
            None => [opacity > 0.0, opacity < 1.0],
        }
    }

    /// Whether the surface is there everywhere.
    pub fn is_whole(&self) -> bool {
        self.map.is_none() && self.at(Vec4::ONE, 1.0) == 1.0
    }
}

impl GltfAnisotropy {
    /// Roughness and anisotropy as [`Inputs`] have them, of a texel's strength.
    ///
    /// With `α_t` along and `α_b` across: `1 - a = α_b / α_t` and `2 r⁴ = α_t² + α_b²`.
    #[inline]
    pub(crate) fn apply(&self, texel_strength: f32, inputs: &mut Inputs) {
        let strength = (self.strength * texel_strength).clamp(0.0, 1.0);
        let alpha = inputs.specular_roughness * inputs.specular_roughness;
        let aspect = (1.0 - 0.9 * strength).sqrt();
        let [along, across] = match self.is_by_blender {
            true => [alpha / aspect, alpha * aspect].map(|alpha| alpha.min(1.0)),
            false => [alpha + (1.0 - alpha) * strength * strength, alpha],
        };
        if along > 0.0 {
            inputs.specular_anisotropy = 1.0 - across / along;
            inputs.specular_roughness = (0.5 * (along * along + across * across)).sqrt().sqrt();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn maps_go_from_zero_to_the_constant() {
        let targets = vec![
            Target { input: Input::SpecularRoughness, channel: Channel::G, zero: 1.0 },
            Target { input: Input::BaseColor, channel: Channel::Rgb, zero: 0.0 },
            Target { input: Input::ThinFilmThickness, channel: Channel::A, zero: 100.0 },
        ];
        let map = InputMap { texture: TextureMap::default(), targets };
        let constants = Inputs {
            specular_roughness: 0.2,
            base_color: Vec3::new(1.0, 0.5, 0.0),
            thin_film_thickness: 400.0,
            ..Inputs::default()
        };
        let mut inputs = constants;
        map.apply(Vec4::new(0.5, 0.25, 1.0, 0.5), &mut inputs);
        assert_eq!(inputs.base_color, Vec3::new(0.5, 0.125, 0.0));
        assert!((inputs.specular_roughness - 0.8).abs() < 1e-6);
        assert_eq!(inputs.thin_film_thickness, 250.0);
        let mut inputs = constants;
        map.apply(Vec4::ONE, &mut inputs);
        assert_eq!(inputs, constants);
    }

    #[test]
    fn masks_are_all_or_nothing_and_the_rest_is_in_between() {
        let map = Some((TextureMap::default(), Channel::A));
        let blend = Opacity { value: 0.8, map, cutoff: None };
        assert_eq!(blend.at(Vec4::new(1.0, 1.0, 1.0, 0.5), 0.5), 0.2);
        let mask = Opacity { cutoff: Some(0.4), ..blend.clone() };
        assert_eq!([0.4, 0.6].map(|alpha| mask.at(Vec4::splat(alpha), 1.0)), [0.0, 1.0]);
        assert!(Opacity::default().is_whole() && !blend.is_whole());
        assert!(!Opacity { value: 0.5, ..Opacity::default() }.is_whole());
        assert!(Opacity { value: 0.5, cutoff: Some(0.5), map: None }.is_whole());
    }

    /// The α of the extension's own formula, from the roughness and anisotropy that are made of it.
    #[test]
    fn gltf_anisotropy_keeps_both_alphas() {
        for (roughness, strength) in [(0.3_f32, 0.5_f32), (0.0, 1.0), (0.9, 0.1), (0.5, 0.0), (1.0, 1.0)] {
            let inputs = Inputs { specular_roughness: roughness, ..Inputs::default() };
            let (alpha, power) = (f64::from(roughness).powi(2), f64::from(strength));
            let aspect = (1.0 - 0.9 * power).sqrt();
            let [gltf, blender] =
                [[alpha + (1.0 - alpha) * power * power, alpha], [(alpha / aspect).min(1.0), alpha * aspect]];
            for (is_by_blender, [along, across]) in [(false, gltf), (true, blender)] {
                let mut inputs = inputs;
                GltfAnisotropy { strength, is_by_blender, map: None }.apply(1.0, &mut inputs);
                let (r, a) = (f64::from(inputs.specular_roughness), f64::from(inputs.specular_anisotropy));
                // OpenPBR: α_x = r² sqrt(2 / (1 + (1 - a)²)), α_y = (1 - a) α_x.
                let found = r * r * (2.0 / (1.0 + (1.0 - a).powi(2))).sqrt();
                assert!((found - along).abs() < 1e-6, "{roughness} {strength} {is_by_blender}");
                assert!(((1.0 - a) * found - across).abs() < 1e-6, "{roughness} {strength} {is_by_blender}");
            }
        }
    }
}
