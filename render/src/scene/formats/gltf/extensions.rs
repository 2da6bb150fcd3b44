//! The extensions of materials, as their specifications have them, with their defaults.

use ::gltf::json::Value;
use ::gltf::json::extensions::texture::TextureTransform;
use ::gltf::json::material::NormalTexture;
use ::gltf::json::texture::Info;
use serde::Deserialize;
use serde::de::DeserializeOwned;

use super::Document;
use crate::scene::SceneError;

type Objects = ::serde_json::Map<String, Value>;

/// The extensions of one object, from which those that are known are taken one by one.
pub(super) struct Extensions<'a> {
    document: &'a Document<'a>,
    /// Their owner, for errors.
    place: &'a str,
    objects: Objects,
}

impl<'a> Extensions<'a> {
    pub(super) fn new(document: &'a Document<'a>, place: &'a str, objects: Option<&Objects>) -> Self {
        Self { document, place, objects: objects.cloned().unwrap_or_default() }
    }

    /// The extension called `name`, if it is there.
    pub(super) fn take<T: DeserializeOwned>(&mut self, name: &str) -> Result<Option<T>, SceneError> {
        let Some(value) = self.objects.remove(name) else { return Ok(None) };
        serde_json::from_value(value).map(Some).map_err(|error| {
            let remedy = format!("write it as the specification of {name} has it");
            self.document.error(self.place, format!("its {name} is wrong: {error}"), remedy)
        })
    }

    /// The names of the extensions that were not read.
    pub(super) fn rest(self) -> impl Iterator<Item = String> {
        self.objects.into_iter().map(|(name, _)| name)
    }
}

/// `KHR_materials_anisotropy`.
#[derive(Default, Deserialize)]
#[serde(default, rename_all = "camelCase")]
pub(super) struct Anisotropy {
    pub(super) anisotropy_strength: f32,
    pub(super) anisotropy_rotation: f32,
    pub(super) anisotropy_texture: Option<Info>,
}

/// `KHR_materials_clearcoat`.
#[derive(Default, Deserialize)]
#[serde(default, rename_all = "camelCase")]
pub(super) struct Clearcoat {
    pub(super) clearcoat_factor: f32,
    pub(super) clearcoat_texture: Option<Info>,
    pub(super) clearcoat_roughness_factor: Option<f32>,
    pub(super) clearcoat_roughness_texture: Option<Info>,
    pub(super) clearcoat_normal_texture: Option<NormalTexture>,
}

/// `KHR_materials_diffuse_transmission`.
#[derive(Deserialize)]
#[serde(default, rename_all = "camelCase")]
pub(super) struct DiffuseTransmission {
    pub(super) diffuse_transmission_factor: f32,
    pub(super) diffuse_transmission_texture: Option<Info>,
    pub(super) diffuse_transmission_color_factor: [f32; 3],
    pub(super) diffuse_transmission_color_texture: Option<Info>,
}

/// `KHR_materials_dispersion`.
#[derive(Default, Deserialize)]
#[serde(default)]
pub(super) struct Dispersion {
    pub(super) dispersion: f32,
}

/// `KHR_materials_emissive_strength`.
#[derive(Deserialize)]
#[serde(default, rename_all = "camelCase")]
pub(super) struct EmissiveStrength {
    pub(super) emissive_strength: f32,
}

/// `KHR_materials_ior`.
#[derive(Deserialize)]
#[serde(default)]
pub(super) struct Ior {
    pub(super) ior: f32,
}

/// `KHR_materials_iridescence`.
#[derive(Deserialize)]
#[serde(default, rename_all = "camelCase")]
pub(super) struct Iridescence {
    pub(super) iridescence_factor: f32,
    pub(super) iridescence_texture: Option<Info>,
    pub(super) iridescence_ior: f32,
    pub(super) iridescence_thickness_minimum: f32,
    pub(super) iridescence_thickness_maximum: f32,
    pub(super) iridescence_thickness_texture: Option<Info>,
}

/// `KHR_materials_pbrSpecularGlossiness`.
#[derive(Deserialize)]
#[serde(default, rename_all = "camelCase")]
pub(super) struct SpecularGlossiness {
    pub(super) diffuse_factor: [f32; 4],
    pub(super) diffuse_texture: Option<Info>,
    pub(super) specular_factor: [f32; 3],
    pub(super) glossiness_factor: f32,
    pub(super) specular_glossiness_texture: Option<Info>,
}

/// `KHR_materials_sheen`.
#[derive(Default, Deserialize)]
#[serde(default, rename_all = "camelCase")]
pub(super) struct Sheen {
    pub(super) sheen_color_factor: [f32; 3],
    pub(super) sheen_color_texture: Option<Info>,
    pub(super) sheen_roughness_factor: f32,
    pub(super) sheen_roughness_texture: Option<Info>,
}

/// `KHR_materials_specular`.
#[derive(Deserialize)]
#[serde(default, rename_all = "camelCase")]
pub(super) struct Specular {
    pub(super) specular_factor: f32,
    pub(super) specular_texture: Option<Info>,
    pub(super) specular_color_factor: [f32; 3],
    pub(super) specular_color_texture: Option<Info>,
}

/// `KHR_materials_transmission`.
#[derive(Default, Deserialize)]
#[serde(default, rename_all = "camelCase")]
pub(super) struct Transmission {
    pub(super) transmission_factor: f32,
    pub(super) transmission_texture: Option<Info>,
}

/// `KHR_materials_volume`.
#[derive(Deserialize)]
#[serde(default, rename_all = "camelCase")]
pub(super) struct Volume {
    pub(super) thickness_factor: f32,
    pub(super) thickness_texture: Option<Info>,
    pub(super) attenuation_distance: f32,
    pub(super) attenuation_color: [f32; 3],
}

/// An extension that is there or not, whatever it says.
#[derive(Deserialize)]
pub(super) struct Presence {}

impl Default for DiffuseTransmission {
    fn default() -> Self {
        Self {
            diffuse_transmission_factor: 0.0,
            diffuse_transmission_texture: None,
            diffuse_transmission_color_factor: [1.0; 3],
            diffuse_transmission_color_texture: None,
        }
    }
}

impl Default for EmissiveStrength {
    fn default() -> Self {
        Self { emissive_strength: 1.0 }
    }
}

impl Default for Ior {
    fn default() -> Self {
        Self { ior: 1.5 }
    }
}

impl Default for Iridescence {
    fn default() -> Self {
        Self {
            iridescence_factor: 0.0,
            iridescence_texture: None,
            iridescence_ior: 1.3,
            iridescence_thickness_minimum: 100.0,
            iridescence_thickness_maximum: 400.0,
            iridescence_thickness_texture: None,
        }
    }
}

impl Default for SpecularGlossiness {
    fn default() -> Self {
        Self {
            diffuse_factor: [1.0; 4],
            diffuse_texture: None,
            specular_factor: [1.0; 3],
            glossiness_factor: 1.0,
            specular_glossiness_texture: None,
        }
    }
}

impl Default for Specular {
    fn default() -> Self {
        Self {
            specular_factor: 1.0,
            specular_texture: None,
            specular_color_factor: [1.0; 3],
            specular_color_texture: None,
        }
    }
}

impl Default for Volume {
    fn default() -> Self {
        Self {
            thickness_factor: 0.0,
            thickness_texture: None,
            attenuation_distance: f32::INFINITY,
            attenuation_color: [1.0; 3],
        }
    }
}

/// The `KHR_texture_transform` of a texture reference that the crate `gltf` has no type for.
pub(super) fn texture_transform(objects: Option<&Objects>) -> Option<TextureTransform> {
    serde_json::from_value(objects?.get("KHR_texture_transform")?.clone()).ok()
}
