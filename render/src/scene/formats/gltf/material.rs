//! Materials: metallic-roughness and specular-glossiness with the extensions that Khronos has ratified for surfaces,
//! taken to the inputs of one closure.
//!
//! | glTF | input |
//! | --- | --- |
//! | `baseColor`, vertex colours | `base_color`; alpha gives the opacity |
//! | `metallic`, `roughness` | `base_metalness`, `specular_roughness` |
//! | `KHR_materials_specular`, `_ior` | `specular_weight`, `specular_color`, `specular_ior`; an index of 0 is an infinite one |
//! | `KHR_materials_pbrSpecularGlossiness` | a dielectric whose `specular_color` gives its F0, roughness 1 - glossiness |
//! | `KHR_materials_transmission`, `_volume` | `transmission_weight`, tinted by the base colour; `absorption` |
//! | `KHR_materials_diffuse_transmission` | `diffuse_transmission_weight`, `diffuse_transmission_color` |
//! | `KHR_materials_clearcoat`, `_sheen` | `coat_…` with an index of 1.5, and normals of its own; `fuzz_…` |
//! | `KHR_materials_iridescence`, `_anisotropy` | `thin_film_…`; anisotropy as glTF defines it |
//! | `KHR_materials_unlit` | emission of the base colour, and nothing else |
//!
//! Transmission without a volume is a thin wall, as the specification has it; but in a file that Blender wrote it is a
//! solid, since Blender has no thin walls and writes no volume for its glass. A solid's base colour tints light once
//! for entering and leaving, so its square root applies at each surface, as rasterizers and Cycles do.
//!
//! Deviations: `occlusionTexture` and a volume's thickness are not used, as light is traced.

mod khr_materials;

use ::gltf::json::material::{AlphaMode, NormalTexture};
use ::gltf::json::texture::Info;
use ::gltf::json::validation::Checked;
use glam::{Vec2, Vec3};

use super::Document;
use super::extensions::{self, Extensions};
use super::texture::{Reference, Textures};
use crate::material::Inputs;
use crate::scene::formats::notes::Notes;
use crate::scene::{Channel, ColorSpace, Input, Material, NormalMap, Opacity, SceneError, Texture, TextureMap};

use ColorSpace::{Linear, Srgb};

/// The file's materials in its order, and the textures that they use.
pub(super) fn read(document: &Document, notes: &mut Notes) -> Result<(Vec<Material>, Vec<Texture>), SceneError> {
    let mut textures = Textures::default();
    let mut materials = Vec::with_capacity(document.root.materials.len());
    for (index, source) in document.root.materials.iter().enumerate() {
        let name = source.name.clone().unwrap_or_default();
        let place = if name.is_empty() { format!("material {index}") } else { format!("material {index} ({name:?})") };
        let inputs = Inputs { specular_weight: 1.0, ..Inputs::default() };
        let material = Material { name, inputs, emits_both_sides: source.double_sided, ..Material::default() };
        let mut reader = Reader { document, place: &place, textures: &mut textures, notes, material };
        reader.read(source)?;
        materials.push(reader.material);
    }
    Ok((materials, textures.list))
}

/// Reads one material.
struct Reader<'a> {
    document: &'a Document<'a>,
    /// The material's name in errors.
    place: &'a str,
    textures: &'a mut Textures,
    notes: &'a mut Notes,
    material: Material,
}

impl Reader<'_> {
    fn read(&mut self, source: &::gltf::json::Material) -> Result<(), SceneError> {
        let (document, place) = (self.document, self.place);
        let objects = source.extensions.as_ref().map(|extensions| &extensions.others);
        let mut extensions = Extensions::new(document, place, objects);
        match extensions.take("KHR_materials_pbrSpecularGlossiness")? {
            Some(base) => self.specular_glossiness(source, &base)?,
            None => self.metallic_roughness(source)?,
        }
        self.material.normal_map = self.normal_map("normalTexture", source.normal_texture.as_ref())?;
        let strength: extensions::EmissiveStrength =
            extensions.take("KHR_materials_emissive_strength")?.unwrap_or_default();
        self.emission(source, strength.emissive_strength)?;
        if source.occlusion_texture.is_some() {
            self.notes.add("occlusionTexture is not used, as light is traced", place);
        }
        if let Some(it) = extensions.take("KHR_materials_specular")? {
            self.specular(&it)?;
        }
        let ior = extensions.take::<extensions::Ior>("KHR_materials_ior")?.unwrap_or_default().ior;
        self.ior(ior)?;
        self.transmission(extensions.take("KHR_materials_transmission")?, extensions.take("KHR_materials_volume")?)?;
        if let Some(it) = extensions.take("KHR_materials_diffuse_transmission")? {
            self.diffuse_transmission(&it)?;
        }
        if let Some(it) = extensions.take("KHR_materials_clearcoat")? {
            self.clearcoat(&it)?;
        }
        if let Some(it) = extensions.take("KHR_materials_sheen")? {
            self.sheen(&it)?;
        }
        if let Some(it) = extensions.take("KHR_materials_iridescence")? {
            self.iridescence(&it)?;
        }
        if let Some(it) = extensions.take("KHR_materials_anisotropy")? {
            self.anisotropy(&it)?;
        }
        if let Some(extensions::Dispersion { dispersion }) = extensions.take("KHR_materials_dispersion")? {
            self.material.dispersion = self.in_range("dispersion", dispersion, 0.0, f32::MAX)?;
        }
        if extensions.take::<extensions::Presence>("KHR_materials_unlit")?.is_some() {
            self.unlit();
        }
        for name in extensions.rest() {
            self.notes.add(format!("{name} is not read"), place);
        }
        Ok(())
    }

    fn metallic_roughness(&mut self, source: &::gltf::json::Material) -> Result<(), SceneError> {
        let base = &source.pbr_metallic_roughness;
        self.base_color(source, "baseColorFactor", base.base_color_factor.0, base.base_color_texture.as_ref())?;
        self.number(Input::BaseMetalness, "metallicFactor", base.metallic_factor.0)?;
        self.number(Input::SpecularRoughness, "roughnessFactor", base.roughness_factor.0)?;
        let map = self.texture("metallicRoughnessTexture", base.metallic_roughness_texture.as_ref(), Linear)?;
        self.vary(Input::SpecularRoughness, map.as_ref(), Channel::G);
        self.vary(Input::BaseMetalness, map.as_ref(), Channel::B);
        Ok(())
    }

    fn specular_glossiness(
        &mut self,
        source: &::gltf::json::Material,
        base: &extensions::SpecularGlossiness,
    ) -> Result<(), SceneError> {
        self.base_color(source, "diffuseFactor", base.diffuse_factor, base.diffuse_texture.as_ref())?;
        let f0 = Vec3::from(base.specular_factor.map(|it| it.clamp(0.0, 1.0)));
        self.color(Input::SpecularColor, "specularFactor", (f0 / DIELECTRIC_F0).to_array())?;
        let glossiness = self.in_range("glossinessFactor", base.glossiness_factor, 0.0, 1.0)?;
        self.material.inputs.specular_roughness = 1.0 - glossiness;
        let info = base.specular_glossiness_texture.as_ref();
        let color = self.texture("specularGlossinessTexture", info, Srgb)?;
        self.vary(Input::SpecularColor, color.as_ref(), Channel::Rgb);
        if let Some(map) = color {
            self.material.add_map(map, Input::SpecularRoughness, Channel::A, 1.0);
        }
        Ok(())
    }

    /// Base colour and opacity.
    fn base_color(
        &mut self,
        source: &::gltf::json::Material,
        name: &str,
        [r, g, b, alpha]: [f32; 4],
        info: Option<&Info>,
    ) -> Result<(), SceneError> {
        self.color(Input::BaseColor, name, [r, g, b])?;
        let map =
            self.texture(if name == "diffuseFactor" { "diffuseTexture" } else { "baseColorTexture" }, info, Srgb)?;
        self.vary(Input::BaseColor, map.as_ref(), Channel::Rgb);
        self.material.uses_vertex_colors = true;
        let cutoff = match source.alpha_mode {
            Checked::Valid(AlphaMode::Opaque) => return Ok(()),
            Checked::Invalid => {
                self.notes.add("alphaMode is none of OPAQUE, MASK and BLEND, and is taken for OPAQUE", self.place);
                return Ok(());
            }
            Checked::Valid(AlphaMode::Mask) => Some(source.alpha_cutoff.unwrap_or_default().0),
            Checked::Valid(AlphaMode::Blend) => None,
        };
        let value = self.in_range(&format!("{name}'s alpha"), alpha, 0.0, 1.0)?;
        self.material.opacity = Opacity { value, map: map.map(|map| (map, Channel::A)), cutoff };
        Ok(())
    }

    /// A normal map in the slot called `slot`.
    fn normal_map(&mut self, slot: &str, normal: Option<&NormalTexture>) -> Result<Option<NormalMap>, SceneError> {
        let Some(normal) = normal else { return Ok(None) };
        let others = normal.extensions.as_ref().map(|extensions| &extensions.others);
        let transform = extensions::texture_transform(others);
        let reference = Reference::new(normal.index, normal.tex_coord, transform.as_ref());
        let user = format!("{}, {slot}", self.place);
        let map = self.textures.map(self.document, reference, Linear, &user, self.notes)?;
        let scale = self.in_range(&format!("{slot}'s scale"), normal.scale, f32::MIN, f32::MAX)?;
        Ok(map.map(|texture| NormalMap { texture, scale: Vec2::splat(scale) }))
    }

    fn emission(&mut self, source: &::gltf::json::Material, strength: f32) -> Result<(), SceneError> {
        let emission = Vec3::from(source.emissive_factor.0) * strength;
        if !emission.is_finite() || emission.min_element() < 0.0 || strength < 0.0 {
            let problem = "its emission is negative or not finite";
            return Err(self.document.error(self.place, problem, "write numbers that are 0 or more"));
        }
        self.material.emission = emission;
        let map = self.texture("emissiveTexture", source.emissive_texture.as_ref(), Srgb)?;
        self.material.emission_map = map.filter(|_| emission != Vec3::ZERO);
        Ok(())
    }

    /// A texture in the slot called `slot`.
    fn texture(
        &mut self,
        slot: &str,
        info: Option<&Info>,
        space: ColorSpace,
    ) -> Result<Option<TextureMap>, SceneError> {
        let Some(info) = info else { return Ok(None) };
        let user = format!("{}, {slot}", self.place);
        self.textures.map(self.document, info, space, &user, self.notes)
    }

    fn vary(&mut self, input: Input, map: Option<&TextureMap>, channel: Channel) {
        if let Some(map) = map {
            self.material.add_map(map.clone(), input, channel, 0.0);
        }
    }

    fn number(&mut self, input: Input, name: &str, value: f32) -> Result<(), SceneError> {
        let range = input.range();
        let value = self.in_range(name, value, range.least, range.greatest)?;
        input.set(&mut self.material.inputs, Vec3::splat(value));
        Ok(())
    }

    fn color(&mut self, input: Input, name: &str, value: [f32; 3]) -> Result<(), SceneError> {
        let range = input.range();
        let mut color = Vec3::ZERO;
        for channel in 0..3 {
            color[channel] = self.in_range(name, value[channel], range.least, range.greatest)?;
        }
        input.set(&mut self.material.inputs, color);
        Ok(())
    }

    /// The value, clamped with a warning.
    fn in_range(&mut self, name: &str, value: f32, least: f32, greatest: f32) -> Result<f32, SceneError> {
        if !value.is_finite() {
            let problem = format!("its {name} is not a finite number");
            return Err(self.document.error(self.place, problem, "write a number in the range of 32-bit floats"));
        }
        if value < least || value > greatest {
            let range =
                if greatest == f32::MAX { format!("below {least}") } else { format!("outside {least} to {greatest}") };
            self.notes.add(format!("{name} is {range} and is clamped"), self.place);
        }
        Ok(value.clamp(least, greatest))
    }
}

/// Reflectance at normal incidence of a refractive index of 1.5.
const DIELECTRIC_F0: f32 = 0.04;
