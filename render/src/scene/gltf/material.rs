//! Materials: base colour and emission with their textures; holes (`alphaMode`); mirrors, which are metals without roughness; glass
//! (`KHR_materials_transmission`, `KHR_materials_ior`).
//!
//! Deviations: glass bounds a solid, with `KHR_materials_volume` or without, and is smooth. What lets through half of
//! the light or more is glass, what lets through less is not. All other metals are matte. A mirror and glass have the
//! mean colour of their texture. What blends is opaque from one half on, and a hole below.

use ::gltf::json::material::AlphaMode;
use ::gltf::json::texture::Info;
use ::gltf::json::validation::Checked;
use glam::Vec3;

use super::Document;
use super::texture::Textures;
use crate::scene::count;
use crate::scene::{Cutout, Material, SceneError, Specular, Texture};

/// The file's materials in its order, and the textures that they use.
pub(super) fn read(
    document: &Document,
    warnings: &mut Vec<String>,
) -> Result<(Vec<Material>, Vec<Texture>), SceneError> {
    let (mut textures, mut ignored, mut blending) = (Textures::default(), 0, 0);
    let mut materials = Vec::with_capacity(document.root.materials.len());
    for (index, material) in document.root.materials.iter().enumerate() {
        let place = format!("material {index}");
        let base = &material.pbr_metallic_roughness;
        ignored += [
            base.metallic_roughness_texture.is_some(),
            material.normal_texture.is_some(),
            material.occlusion_texture.is_some(),
        ]
        .map(usize::from)
        .iter()
        .sum::<usize>();

        let [r, g, b, alpha] = base.base_color_factor.0;
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
        let mut map = |info: Option<&Info>| match info {
            Some(info) => textures.map(document, info, &place, warnings),
            None => Ok(None),
        };
        let mut diffuse_map = map(base.base_color_texture.as_ref())?;
        let emission_map = map(material.emissive_texture.as_ref())?.filter(|_| emission != Vec3::ZERO);
        let mean = diffuse_map.as_ref().map_or(Vec3::ONE, |map| textures.list[map.texture].mean().truncate());
        let cutout = match material.alpha_mode {
            Checked::Valid(AlphaMode::Mask) => {
                Some(Cutout { alpha, cutoff: material.alpha_cutoff.unwrap_or_default().0 })
            }
            Checked::Valid(AlphaMode::Blend) => {
                blending += 1;
                Some(Cutout { alpha, cutoff: 0.5 })
            }
            Checked::Valid(AlphaMode::Opaque) | Checked::Invalid => None,
        };
        let specular = specular(material, diffuse * mean);
        if specular != Specular::None && cutout.is_none() {
            diffuse_map = None;
        }
        if matches!(specular, Specular::Glass { .. }) && base.roughness_factor.0 > 0.0 {
            warnings.push(format!("{}: {place}: rough glass is shown as smooth glass", document.path.display()));
        }
        materials.push(Material {
            name: material.name.clone().unwrap_or_default(),
            // Mirrors and glass leave nothing for it.
            diffuse: if specular == Specular::None { diffuse } else { Vec3::ZERO },
            diffuse_map,
            specular,
            emission,
            emission_map,
            cutout,
            emits_both_sides: material.double_sided,
            ..Material::default()
        });
    }
    let path = document.path.display();
    if ignored > 0 {
        let ignored = count(ignored, "texture is", "textures are");
        warnings.push(format!("{path}: {ignored} ignored, which give neither colour nor light"));
    }
    if blending > 0 {
        let blending = count(blending, "material blends", "materials blend");
        warnings.push(format!("{path}: {blending}: shown as opaque from one half on, and as a hole below"));
    }
    warnings.extend(textures.warning(document));
    Ok((materials, textures.list))
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
