//! From the statements of a material to its inputs, when all of them are read.

use std::path::Path;

use glam::{Vec2, Vec3};

use super::map::Map;
use super::{Gloss, Statements};
use crate::material::Inputs;
use crate::scene::texture::{Problem, TextureStore};
use crate::scene::{BumpMap, Channel, ColorSpace, Input, Material, NormalMap, Opacity, TextureMap};

/// The index of refraction of glass that does not say.
const GLASS_IOR: f32 = 1.5;

impl Statements {
    pub(super) fn finish(
        self,
        path: &Path,
        is_blender: bool,
        textures: &mut TextureStore,
        warnings: &mut Vec<String>,
    ) -> Material {
        let has_map = |key: &str| self.maps.iter().any(|map| map.key == key);
        let emission = self.emission.unwrap_or(if has_map("map_ke") { Vec3::ONE } else { Vec3::ZERO });
        // What a material leaves out is ours to choose: matte grey, but black for one that emits.
        let missing = match (has_map("map_kd"), emission == Vec3::ZERO) {
            (true, _) => Vec3::ONE,
            (false, true) => Vec3::splat(0.5),
            (false, false) => Vec3::ZERO,
        };
        let greatest_exponent = self.gloss.exponent;
        let mut finish =
            Finish { path, is_blender, textures, warnings, greatest_exponent, material: Material::default() };
        let material = &mut finish.material;
        material.name.clone_from(&self.name);
        material.emission = emission;
        material.inputs.base_color = self.diffuse.unwrap_or(missing);
        finish.reflection(&self);
        finish.layers(&self);
        for map in &self.maps {
            finish.map(map);
        }
        finish.material
    }
}

struct Finish<'a, 't> {
    path: &'a Path,
    is_blender: bool,
    textures: &'a mut TextureStore<'t>,
    warnings: &'a mut Vec<String>,
    /// `Ns`, which its map scales.
    greatest_exponent: f32,
    material: Material,
}

impl Finish<'_, '_> {
    fn warn(&mut self, what: &str) {
        self.warnings.push(format!("{}: material {:?}: {what}", self.path.display(), self.material.name));
    }

    /// Reflection and transmission, as the illumination model or the physically based keys have them.
    fn reflection(&mut self, it: &Statements) {
        let Gloss { specular, exponent, model, .. } = it.gloss;
        let ior = self.ior(it);
        let inputs = &mut self.material.inputs;
        inputs.specular_ior = ior;
        if it.roughness.is_some() || it.metalness.is_some() {
            inputs.specular_weight = 1.0;
            inputs.specular_roughness = it.roughness.unwrap_or(0.5);
            inputs.base_metalness = it.metalness.unwrap_or(0.0);
            if self.is_blender {
                // Its `Tf` is the weight of transmission.
                inputs.transmission_weight = it.filter.map_or(0.0, |filter| filter.x);
                self.material.base_color_tints_transmission = true;
            }
            return;
        }
        let f0 = if self.is_blender { 0.08 * specular } else { specular };
        let roughness = if self.is_blender { blender_roughness(exponent) } else { phong_roughness(exponent) };
        match model {
            3 if self.is_blender => {
                inputs.specular_weight = 1.0;
                inputs.specular_roughness = roughness;
                inputs.base_metalness = it.ambient.map_or(1.0, |ambient| ambient.x.clamp(0.0, 1.0));
            }
            3 | 5 if specular != Vec3::ZERO => {
                inputs.specular_roughness = 0.0;
                if inputs.base_color == Vec3::ZERO {
                    (inputs.base_color, inputs.base_metalness) = (specular, 1.0);
                } else {
                    reflect(inputs, specular);
                }
            }
            4 | 6 | 7 => {
                inputs.specular_weight = 1.0;
                inputs.specular_roughness = 0.0;
                inputs.transmission_weight = 1.0;
                inputs.transmission_color = it.gloss.transmittance;
            }
            0 | 1 => {}
            _ => {
                inputs.specular_roughness = roughness;
                if f0 != Vec3::ZERO {
                    reflect(inputs, f0);
                }
            }
        }
    }

    /// The index of refraction, that of glass where it says none or an impossible one.
    fn ior(&mut self, it: &Statements) -> f32 {
        let (ior, model) = (it.gloss.ior, it.gloss.model);
        let is_glass = matches!(model, 4 | 6 | 7);
        if !it.has_ior || (ior == 1.0 && !is_glass) {
            return GLASS_IOR;
        }
        if ior <= 0.0 && is_glass {
            self.warn(&format!("an index of refraction of {ior} is no glass's; {GLASS_IOR} is used"));
        } else if ior > 0.0 && ior < 1.0 && is_glass {
            self.warn(&format!("an index of refraction of {ior} is below 1; 1 is used"));
        }
        if ior <= 0.0 { GLASS_IOR } else { ior.clamp(1.0, 100.0) }
    }

    fn layers(&mut self, it: &Statements) {
        let inputs = &mut self.material.inputs;
        inputs.fuzz_weight = it.sheen;
        (inputs.coat_weight, inputs.coat_roughness) = (it.coat, it.coat_roughness);
        if it.coat > 0.0 {
            inputs.coat_ior = GLASS_IOR;
        }
        inputs.specular_anisotropy = it.anisotropy;
        self.material.tangent_rotation = it.rotation * core::f32::consts::TAU;
        if inputs.transmission_weight == 0.0 {
            self.material.opacity.value = it.gloss.opacity;
        }
    }

    fn map(&mut self, map: &Map) {
        let space = match map.key.as_str() {
            "map_kd" | "map_ks" | "map_ke" => ColorSpace::Srgb,
            "map_d" | "map_ns" | "map_pr" | "map_pm" | "map_ps" | "map_pc" | "map_pcr" | "map_bump" | "bump"
            | "norm" => ColorSpace::Linear,
            key => return self.warn(&format!("`{key}` is not read")),
        };
        match map.load(self.path, space, self.textures) {
            Ok(texture) => self.use_map(map, texture),
            Err(Problem { problem, remedy }) => {
                self.warn(&format!("`{}` is left out: {problem} ({remedy})", map.key));
            }
        }
    }

    fn use_map(&mut self, map: &Map, texture: TextureMap) {
        let number = map.channel.unwrap_or(Channel::R);
        let material = &mut self.material;
        match map.key.as_str() {
            "map_kd" => material.add_map(texture, Input::BaseColor, Channel::Rgb, 0.0),
            "map_ks" => material.add_map(texture, Input::SpecularColor, Channel::Rgb, 0.0),
            "map_ke" => material.emission_map = Some(texture),
            "map_d" => {
                let has_alpha = self.textures.list[texture.texture].mean().w < 1.0;
                let channel = map.channel.unwrap_or(if has_alpha { Channel::A } else { Channel::R });
                material.opacity = Opacity { map: Some((texture, channel)), ..material.opacity.clone() };
            }
            "map_ns" => self.exponent(texture),
            "map_pr" => self.scaled(texture, Input::SpecularRoughness, number),
            "map_pm" => self.scaled(texture, Input::BaseMetalness, number),
            "map_ps" => self.scaled(texture, Input::FuzzWeight, number),
            "map_pc" => self.scaled(texture, Input::CoatWeight, number),
            "map_pcr" => self.scaled(texture, Input::CoatRoughness, number),
            "norm" => self.normals(texture, map.multiplier),
            _ if self.is_blender || self.textures.list[texture.texture].looks_like_normals() => {
                self.normals(texture, map.multiplier);
            }
            _ => material.bump_map = Some(BumpMap { texture, channel: number, height: map.multiplier }),
        }
    }

    /// A map of an input whose factor is 1 if not given.
    fn scaled(&mut self, texture: TextureMap, input: Input, channel: Channel) {
        if matches!(input, Input::SpecularRoughness | Input::BaseMetalness) {
            self.material.inputs.specular_weight = 1.0;
        }
        if input.get(&self.material.inputs) == Vec3::ZERO || input == Input::SpecularRoughness {
            input.set(&mut self.material.inputs, Vec3::ONE);
        }
        self.material.add_map(texture, input, channel, 0.0);
    }

    fn normals(&mut self, texture: TextureMap, scale: f32) {
        self.material.normal_map = Some(NormalMap { texture, scale: Vec2::splat(scale) });
    }

    /// Exponents become roughness texel by texel; Blender's are roughness already.
    fn exponent(&mut self, mut texture: TextureMap) {
        if !self.is_blender {
            let greatest = self.greatest_exponent;
            let roughness = self.textures.list[texture.texture].mapped_red(|part| phong_roughness(part * greatest));
            texture.texture = self.textures.add(roughness);
        }
        self.material.inputs.specular_roughness = 1.0;
        self.material.add_map(texture, Input::SpecularRoughness, Channel::R, 0.0);
    }
}

/// Gives a dielectric this reflectance at normal incidence, whatever its index.
fn reflect(inputs: &mut Inputs, f0: Vec3) {
    let own = ((inputs.specular_ior - 1.0) / (inputs.specular_ior + 1.0)).powi(2);
    if own < 1e-4 {
        inputs.specular_ior = GLASS_IOR;
        return reflect(inputs, f0);
    }
    inputs.specular_weight = 1.0;
    inputs.specular_color = f0 / own;
}

/// α = √(2 / (Ns + 2)), and α is roughness squared.
fn phong_roughness(exponent: f32) -> f32 {
    (2.0 / (exponent.max(0.0) + 2.0)).sqrt().sqrt()
}

/// The roughness of which Blender makes `Ns`.
fn blender_roughness(exponent: f32) -> f32 {
    1.0 - (exponent / 1000.0).clamp(0.0, 1.0).sqrt()
}
