//! Materials: the factors of base colour and emission; mirrors, which are metals without roughness; glass
//! (`KHR_materials_transmission`, `KHR_materials_ior`).
//!
//! Deviations: glass bounds a solid, with `KHR_materials_volume` or without, and is smooth. What lets through half of
//! the light or more is glass, what lets through less is not. All other metals are matte.

use glam::Vec3;

use super::Document;
use crate::scene::model::count;
use crate::scene::{Material, SceneError, Specular};

/// The file's materials in its order.
pub(super) fn read(document: &Document, warnings: &mut Vec<String>) -> Result<Vec<Material>, SceneError> {
    let mut textures = 0;
    let mut materials = Vec::with_capacity(document.root.materials.len());
    for (index, material) in document.root.materials.iter().enumerate() {
        let place = format!("material {index}");
        let base = &material.pbr_metallic_roughness;
        textures += [
            base.base_color_texture.is_some(),
            base.metallic_roughness_texture.is_some(),
            material.normal_texture.is_some(),
            material.occlusion_texture.is_some(),
            material.emissive_texture.is_some(),
        ]
        .map(usize::from)
        .iter()
        .sum::<usize>();

        let [r, g, b, _] = base.base_color_factor.0;
        let colour = Vec3::new(r, g, b);
        let diffuse = colour.clamp(Vec3::ZERO, Vec3::ONE);
        if diffuse != colour {
            let path = document.path.display();
            warnings.push(format!("{path}: {place}: `baseColorFactor` is outside 0 to 1 and is clamped"));
        }

        let extension = material.extensions.as_ref().and_then(|extensions| extensions.emissive_strength.as_ref());
        let strength = extension.map_or(1.0, |extension| extension.emissive_strength.0);
        let emission = Vec3::from(material.emissive_factor.0) * strength;
        if !emission.is_finite() || emission.min_element() < 0.0 || strength < 0.0 {
            return Err(document.error(
                place,
                "its emission is negative or not finite",
                "write numbers that are 0 or more",
            ));
        }
        let specular = specular(material, diffuse);
        if matches!(specular, Specular::Glass { .. }) && base.roughness_factor.0 > 0.0 {
            warnings.push(format!("{}: {place}: rough glass is shown as smooth glass", document.path.display()));
        }
        materials.push(Material {
            name: material.name.clone().unwrap_or_default(),
            // Mirrors and glass leave nothing for it.
            diffuse: if specular == Specular::None { diffuse } else { Vec3::ZERO },
            specular,
            emission,
            emits_both_sides: material.double_sided,
            ..Material::default()
        });
    }
    if textures > 0 {
        let textures = count(textures, "texture is", "textures are");
        warnings.push(format!("{}: {textures} ignored", document.path.display()));
    }
    Ok(materials)
}

/// The mirror or the glass that a material of this base colour is.
fn specular(material: &::gltf::json::Material, color: Vec3) -> Specular {
    let base = &material.pbr_metallic_roughness;
    let extensions = material.extensions.as_ref();
    let transmission = extensions.and_then(|all| all.transmission.as_ref()).map_or(0.0, |it| it.transmission_factor.0);
    if base.metallic_factor.0 == 1.0 && base.roughness_factor.0 == 0.0 && base.metallic_roughness_texture.is_none() {
        return Specular::Mirror { reflectance: color };
    }
    if transmission < 0.5 || base.metallic_factor.0 == 1.0 {
        return Specular::None;
    }
    let ior = extensions.and_then(|all| all.ior.as_ref()).map_or(1.5, |it| it.ior.0);
    // An index of 0 stands for an infinite one, which reflects everything.
    match ior > 0.0 {
        true => Specular::Glass { ior, transmittance: color * transmission.min(1.0) },
        false => Specular::Mirror { reflectance: Vec3::ONE },
    }
}
