//! What integrators without closures read of a material: diffuse reflection, perfect mirrors and clear glass.

use glam::Vec3;

use super::{Cutout, Input, Material, Specular};
use crate::scene::texture::Texture;

impl Material {
    /// Fills these fields of a material whose inputs are complete.
    pub(crate) fn complete_matte(&mut self, textures: &[Texture]) {
        let color = self.inputs.base_color;
        let map = self.map_of(Input::BaseColor).map(|(map, _)| map.clone());
        self.cutout = (!self.opacity.is_whole())
            .then(|| Cutout { alpha: self.opacity.value, cutoff: self.opacity.cutoff.unwrap_or(0.5) });
        let mean = map.as_ref().map_or(Vec3::ONE, |map| textures[map.texture].mean().truncate());
        self.specular = self.smooth(color * mean);
        self.diffuse = if self.specular == Specular::None { color } else { Vec3::ZERO };
        self.diffuse_map = map.filter(|_| self.specular == Specular::None || self.cutout.is_some());
    }

    /// The mirror or the glass that a material of this base colour is.
    fn smooth(&self, color: Vec3) -> Specular {
        let inputs = &self.inputs;
        let is_rough = inputs.specular_roughness > 0.0 || self.map_of(Input::SpecularRoughness).is_some();
        if inputs.base_metalness == 1.0 && !is_rough {
            return Specular::Mirror { reflectance: color };
        }
        if inputs.transmission_weight < 0.5 || inputs.base_metalness == 1.0 {
            return Specular::None;
        }
        // An infinite index reflects everything.
        match inputs.specular_color.max_element() > 1.0 {
            false => Specular::Glass { ior: inputs.specular_ior, transmittance: color * inputs.transmission_weight },
            true => Specular::Mirror { reflectance: Vec3::ONE },
        }
    }
}
