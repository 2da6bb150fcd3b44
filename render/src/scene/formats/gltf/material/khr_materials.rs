//! Khronos's extensions of materials: each to the inputs that it is about.

use glam::Vec3;

use super::{DIELECTRIC_F0, Reader};
use crate::material::Inputs;
use crate::scene::formats::gltf::extensions;
use crate::scene::{Channel, CoatNormal, ColorSpace, GltfAnisotropy, Input, SceneError};

use ColorSpace::{Linear, Srgb};

impl Reader<'_> {
    pub(super) fn specular(&mut self, it: &extensions::Specular) -> Result<(), SceneError> {
        self.number(Input::SpecularWeight, "specularFactor", it.specular_factor)?;
        self.color(Input::SpecularColor, "specularColorFactor", it.specular_color_factor)?;
        let weight = self.texture("specularTexture", it.specular_texture.as_ref(), Linear)?;
        self.vary(Input::SpecularWeight, weight.as_ref(), Channel::A);
        let color = self.texture("specularColorTexture", it.specular_color_texture.as_ref(), Srgb)?;
        self.vary(Input::SpecularColor, color.as_ref(), Channel::Rgb);
        Ok(())
    }

    pub(super) fn ior(&mut self, ior: f32) -> Result<(), SceneError> {
        if ior == 0.0 {
            // An infinite index: F0 is the specular colour itself.
            self.material.inputs.specular_color /= DIELECTRIC_F0;
            return Ok(());
        }
        self.number(Input::SpecularIor, "ior", ior)
    }

    pub(super) fn transmission(
        &mut self,
        transmission: Option<extensions::Transmission>,
        volume: Option<extensions::Volume>,
    ) -> Result<(), SceneError> {
        let is_volume = volume.as_ref().is_some_and(|volume| volume.thickness_factor > 0.0);
        self.material.inputs.thin_walled = !is_volume && !self.document.is_from_blender();
        if let Some(it) = transmission {
            self.number(Input::TransmissionWeight, "transmissionFactor", it.transmission_factor)?;
            let map = self.texture("transmissionTexture", it.transmission_texture.as_ref(), Linear)?;
            self.vary(Input::TransmissionWeight, map.as_ref(), Channel::R);
            self.material.base_color_tints_transmission = true;
        }
        let Some(it) = volume.filter(|_| is_volume) else { return Ok(()) };
        if it.thickness_texture.is_some() {
            self.notes.add("thicknessTexture is not used, as light is traced", self.place);
        }
        let distance = it.attenuation_distance;
        if distance.is_nan() || distance <= 0.0 {
            let problem = format!("its attenuationDistance is {distance}");
            return Err(self.document.error(self.place, problem, "write a distance that is more than 0"));
        }
        let mut color = Vec3::ZERO;
        for channel in 0..3 {
            color[channel] = self.in_range("attenuationColor", it.attenuation_color[channel], 0.0, 1.0)?;
        }
        self.material.inputs.absorption = match self.document.is_from_blender() {
            // It writes the colour and the density of its absorption, which is `(1 - colour) × density`.
            true => (Vec3::ONE - color) / distance,
            // An opaque colour counts as nearly black after the distance.
            false => -color.max(Vec3::splat(1e-6)).map(f32::ln) / distance,
        };
        Ok(())
    }

    pub(super) fn diffuse_transmission(&mut self, it: &extensions::DiffuseTransmission) -> Result<(), SceneError> {
        self.number(Input::DiffuseTransmissionWeight, "diffuseTransmissionFactor", it.diffuse_transmission_factor)?;
        let color = it.diffuse_transmission_color_factor;
        self.color(Input::DiffuseTransmissionColor, "diffuseTransmissionColorFactor", color)?;
        let info = it.diffuse_transmission_texture.as_ref();
        let weight = self.texture("diffuseTransmissionTexture", info, Linear)?;
        self.vary(Input::DiffuseTransmissionWeight, weight.as_ref(), Channel::A);
        let info = it.diffuse_transmission_color_texture.as_ref();
        let color = self.texture("diffuseTransmissionColorTexture", info, Srgb)?;
        self.vary(Input::DiffuseTransmissionColor, color.as_ref(), Channel::Rgb);
        Ok(())
    }

    pub(super) fn clearcoat(&mut self, it: &extensions::Clearcoat) -> Result<(), SceneError> {
        self.number(Input::CoatWeight, "clearcoatFactor", it.clearcoat_factor)?;
        // Blender leaves out what is its own default.
        let is_default = self.document.is_from_blender() && it.clearcoat_roughness_texture.is_none();
        let roughness = it.clearcoat_roughness_factor.unwrap_or(if is_default { BLENDER_COAT_ROUGHNESS } else { 0.0 });
        self.number(Input::CoatRoughness, "clearcoatRoughnessFactor", roughness)?;
        self.material.inputs.coat_ior = 1.5;
        let weight = self.texture("clearcoatTexture", it.clearcoat_texture.as_ref(), Linear)?;
        self.vary(Input::CoatWeight, weight.as_ref(), Channel::R);
        let roughness = self.texture("clearcoatRoughnessTexture", it.clearcoat_roughness_texture.as_ref(), Linear)?;
        self.vary(Input::CoatRoughness, roughness.as_ref(), Channel::G);
        if it.clearcoat_factor > 0.0 {
            let map = self.normal_map("clearcoatNormalTexture", it.clearcoat_normal_texture.as_ref())?;
            self.material.coat_normal = match map {
                map if map == self.material.normal_map => CoatNormal::OfBase,
                Some(map) => CoatNormal::Map(map),
                None => CoatNormal::OfVertices,
            };
        }
        Ok(())
    }

    pub(super) fn sheen(&mut self, it: &extensions::Sheen) -> Result<(), SceneError> {
        let color = Vec3::from(it.sheen_color_factor);
        let weight = self.in_range("sheenColorFactor", color.max_element(), 0.0, 1.0)?;
        self.material.inputs.fuzz_weight = weight;
        self.color(Input::FuzzColor, "sheenColorFactor", if weight > 0.0 { color / weight } else { color }.to_array())?;
        self.number(Input::FuzzRoughness, "sheenRoughnessFactor", it.sheen_roughness_factor)?;
        let color = self.texture("sheenColorTexture", it.sheen_color_texture.as_ref(), Srgb)?;
        self.vary(Input::FuzzColor, color.as_ref(), Channel::Rgb);
        let roughness = self.texture("sheenRoughnessTexture", it.sheen_roughness_texture.as_ref(), Linear)?;
        self.vary(Input::FuzzRoughness, roughness.as_ref(), Channel::A);
        Ok(())
    }

    pub(super) fn iridescence(&mut self, it: &extensions::Iridescence) -> Result<(), SceneError> {
        self.number(Input::ThinFilmWeight, "iridescenceFactor", it.iridescence_factor)?;
        self.number(Input::ThinFilmIor, "iridescenceIor", it.iridescence_ior)?;
        self.number(Input::ThinFilmThickness, "iridescenceThicknessMaximum", it.iridescence_thickness_maximum)?;
        let least = self.in_range("iridescenceThicknessMinimum", it.iridescence_thickness_minimum, 0.0, f32::MAX)?;
        let weight = self.texture("iridescenceTexture", it.iridescence_texture.as_ref(), Linear)?;
        self.vary(Input::ThinFilmWeight, weight.as_ref(), Channel::R);
        let info = it.iridescence_thickness_texture.as_ref();
        if let Some(map) = self.texture("iridescenceThicknessTexture", info, Linear)? {
            self.material.add_map(map, Input::ThinFilmThickness, Channel::G, least);
        }
        Ok(())
    }

    pub(super) fn anisotropy(&mut self, it: &extensions::Anisotropy) -> Result<(), SceneError> {
        let strength = self.in_range("anisotropyStrength", it.anisotropy_strength, 0.0, 1.0)?;
        let rotation = self.in_range("anisotropyRotation", it.anisotropy_rotation, f32::MIN, f32::MAX)?;
        let map = self.texture("anisotropyTexture", it.anisotropy_texture.as_ref(), Linear)?;
        if strength > 0.0 {
            self.material.tangent_rotation = rotation;
            self.material.anisotropy =
                Some(GltfAnisotropy { strength, is_by_blender: self.document.is_from_blender(), map });
        }
        Ok(())
    }

    /// Shows the base colour and scatters nothing.
    pub(super) fn unlit(&mut self) {
        let material = &mut self.material;
        material.unlit = true;
        material.emission = material.inputs.base_color;
        material.emission_map = material.map_of(Input::BaseColor).map(|(map, _)| map.clone());
        material.inputs = Inputs { base_color: Vec3::ZERO, ..Inputs::default() };
        material.base_color_tints_transmission = false;
        (material.maps, material.normal_map, material.anisotropy) = (Vec::new(), None, None);
        material.coat_normal = CoatNormal::OfBase;
    }
}

/// The default of Blender's coat roughness.
const BLENDER_COAT_ROUGHNESS: f32 = 0.03;
