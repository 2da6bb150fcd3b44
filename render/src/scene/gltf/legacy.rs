//! What integrators without closures read of a material: diffuse reflection, perfect mirrors and clear glass.

use ::gltf::json::material::AlphaMode;
use ::gltf::json::validation::Checked;
use glam::Vec3;

use crate::scene::{Cutout, Input, Material, Specular, Texture};

/// Fills these fields of a material whose inputs are complete.
pub(super) fn complete(source: &::gltf::json::Material, material: &mut Material, textures: &[Texture]) {
    let color = material.inputs.base_color;
    let map = material.map_of(Input::BaseColor).map(|(map, _)| map.clone());
    material.cutout = match source.alpha_mode {
        Checked::Valid(AlphaMode::Opaque) | Checked::Invalid => None,
        _ => Some(Cutout { alpha: material.opacity.value, cutoff: material.opacity.cutoff.unwrap_or(0.5) }),
    };
    let mean = map.as_ref().map_or(Vec3::ONE, |map| textures[map.texture].mean().truncate());
    material.specular = specular(material, color * mean);
    material.diffuse = if material.specular == Specular::None { color } else { Vec3::ZERO };
    material.diffuse_map = map.filter(|_| material.specular == Specular::None || material.cutout.is_some());
}

/// The mirror or the glass that a material of this base colour is.
fn specular(material: &Material, color: Vec3) -> Specular {
    let inputs = &material.inputs;
    let is_rough = inputs.specular_roughness > 0.0 || material.map_of(Input::SpecularRoughness).is_some();
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
