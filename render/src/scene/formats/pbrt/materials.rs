//! Materials, as inputs of our closures.
//!
//! | pbrt | inputs |
//! | --- | --- |
//! | `diffuse` | `base_color` |
//! | `coateddiffuse` | a dielectric over `base_color`, which is darkened as below |
//! | `conductor` | a metal with the reflectance of `eta` and `k` at 0° and 82°, or of `reflectance` |
//! | `coatedconductor` | the same under a coat |
//! | `dielectric`, `thindielectric` | glass, solid or a thin wall |
//! | `diffusetransmission` | diffuse reflection and transmission |
//! | `mix` | one material in between (`mix.rs`) |
//!
//! Roughness: pbrt's α is √`roughness` with `remaproughness` and `roughness` without; ours is `specular_roughness²`.
//!
//! Under a coat, diffuse light is reflected back by the coat's inside, which our layers do not model. With the mean
//! reflectance `F` of the inside, the transmittance `t` of the coat's medium in each direction and the albedo `ρ` of
//! the base, the sum over all reflections is `ρ' = t² ρ (1 - F) / (1 - t² ρ F)`. `base_color` is set to it.
//!
//! Deviations: media (`albedo`, `g`) between layers are left out; a coat does not darken the metal below it. Rough
//! surfaces include multiple scattering between microfacets, which pbrt loses: 8% at α = 0.25.

use glam::Vec3;

use super::Reader;
use super::parameters::Parameters;
use super::spectrum::Spectrum;
use super::textures::Tex;
use crate::material::fresnel::{complex_index_colors, dielectric};
use crate::scene::nearest::suggestion;
use crate::scene::{BumpMap, Channel, ColorSpace, Input, Material, NormalMap, SceneError, TextureMap};

const KNOWN: [&str; 8] = [
    "coatedconductor",
    "coateddiffuse",
    "conductor",
    "dielectric",
    "diffuse",
    "diffusetransmission",
    "mix",
    "thindielectric",
];

/// Materials of pbrt-v4 without a counterpart.
const OTHERS: [&str; 3] = ["hair", "measured", "subsurface"];

/// Materials of pbrt-v3 with other names in pbrt-v4.
const OF_V3: [&str; 13] = [
    "disney",
    "fourier",
    "glass",
    "kdsubsurface",
    "matte",
    "metal",
    "mirror",
    "none",
    "plastic",
    "shinymetal",
    "substrate",
    "translucent",
    "uber",
];

impl Reader<'_> {
    /// A material of this kind; `None` for one that is not seen.
    pub(super) fn material(&mut self, kind: &str, parameters: &Parameters) -> Result<Option<Material>, SceneError> {
        let mut material = Material::matte(Vec3::splat(0.5));
        match kind {
            "" | "interface" => return Ok(None),
            "mix" => return self.mixed(parameters),
            "diffuse" => {
                let reflectance = self.color(parameters, "reflectance", Vec3::splat(0.5))?;
                self.set(&mut material, Input::BaseColor, &reflectance, None);
            }
            "coateddiffuse" => self.coated_diffuse(&mut material, parameters)?,
            "conductor" => self.conductor(&mut material, parameters, "")?,
            "coatedconductor" => {
                self.conductor(&mut material, parameters, "conductor.")?;
                self.ignore_media(parameters);
                material.inputs.coat_weight = 1.0;
                material.inputs.coat_ior = self.index_of_refraction(parameters, "interface.eta")?;
                let roughness = self.number(parameters, "interface.roughness", 0.0)?;
                let remaps = parameters.flag("remaproughness", true)?;
                self.set(&mut material, Input::CoatRoughness, &roughness, Some(&|value| to_roughness(value, remaps)));
            }
            "dielectric" | "thindielectric" => {
                let inputs = &mut material.inputs;
                (inputs.specular_weight, inputs.transmission_weight) = (1.0, 1.0);
                inputs.thin_walled = kind == "thindielectric";
                inputs.specular_ior = self.index_of_refraction(parameters, "eta")?;
                let eta = Spectrum::read(parameters, "eta", self.files, &self.folder)?;
                material.dispersion = eta.map_or(0.0, |eta| eta.dispersion());
                self.roughness(&mut material, parameters, "")?;
            }
            "diffusetransmission" => self.diffuse_transmission(&mut material, parameters)?,
            _ if OTHERS.contains(&kind) => {
                self.note(&parameters.at, &format!("a material {kind:?} is not read; grey instead"));
                parameters.unused().for_each(|unused| parameters.ignore(&[&unused.name]));
            }
            _ if OF_V3.contains(&kind) => {
                return Err(super::of_v3(&parameters.at, &format!("the material {kind:?}")));
            }
            _ => {
                let problem = format!("there is no material of type {kind:?}");
                return Err(parameters.at.error(problem, suggestion(kind, &KNOWN)));
            }
        }
        self.bumps(&mut material, parameters)?;
        Ok(Some(material))
    }

    fn coated_diffuse(&mut self, material: &mut Material, parameters: &Parameters) -> Result<(), SceneError> {
        let reflectance = self.color(parameters, "reflectance", Vec3::splat(0.5))?;
        let eta = self.index_of_refraction(parameters, "eta")?;
        let thickness = parameters.float("thickness", 0.01)?;
        self.ignore_media(parameters);
        material.inputs.specular_weight = 1.0;
        material.inputs.specular_ior = eta;
        self.roughness(material, parameters, "")?;
        let (inside, through) = (inner_reflectance(eta), diffuse_transmittance(thickness));
        let darken = |color: Vec3| {
            let there_and_back = color.min(Vec3::ONE) * through * through;
            there_and_back * (1.0 - inside) / (1.0 - there_and_back * inside)
        };
        self.set(material, Input::BaseColor, &reflectance, Some(&darken));
        Ok(())
    }

    fn conductor(&mut self, material: &mut Material, parameters: &Parameters, prefix: &str) -> Result<(), SceneError> {
        let name = |name: &str| format!("{prefix}{name}");
        // pbrt asks for `reflectance` without the prefix.
        let reflectance = if parameters.has("reflectance") { "reflectance" } else { &name("reflectance") };
        material.inputs.base_metalness = 1.0;
        if parameters.has(reflectance) {
            let color = self.color(parameters, reflectance, Vec3::ONE)?;
            if let Tex::Constant(color) = color {
                // As pbrt does: n = 1, and the k that reflects so much.
                let color = color.clamp(Vec3::ZERO, Vec3::splat(0.9999));
                let k = 2.0 * (color / (1.0 - color)).map(f32::sqrt);
                material.inputs.metal_edge_color = complex_index_colors(Vec3::ONE, k)[1].min(Vec3::ONE);
            }
            self.set(material, Input::BaseColor, &color, None);
        } else {
            let [eta, k] = ["eta", "k"].map(|part| self.metal_index(parameters, &name(part), part));
            let [normal, edge] = complex_index_colors(eta?, k?);
            material.inputs.base_color = normal.clamp(Vec3::ZERO, Vec3::ONE);
            material.inputs.metal_edge_color = edge.clamp(Vec3::ZERO, Vec3::ONE);
        }
        self.roughness(material, parameters, prefix)
    }

    fn metal_index(&mut self, parameters: &Parameters, name: &str, part: &str) -> Result<Vec3, SceneError> {
        let copper = Spectrum::Named(format!("metal-Cu-{part}"));
        let given = Spectrum::read(parameters, name, self.files, &self.folder)?;
        let index = given.as_ref().unwrap_or(&copper).metal_index();
        if index.is_none() {
            self.note(&parameters.at, &format!("the spectrum `{name}` is not read; that of copper instead"));
        }
        Ok(index.or(copper.metal_index()).unwrap_or(Vec3::ONE))
    }

    fn diffuse_transmission(&mut self, material: &mut Material, parameters: &Parameters) -> Result<(), SceneError> {
        let scale = parameters.float("scale", 1.0)?;
        let reflectance = self.color(parameters, "reflectance", Vec3::splat(0.25))?;
        let transmittance = self.color(parameters, "transmittance", Vec3::splat(0.25))?;
        // Our colours are weighted: reflection by 1 - w, transmission by w.
        let [r, t] = [&reflectance, &transmittance].map(|tex| self.mean(tex).max_element());
        let weight = if r + t > 0.0 { t / (r + t) } else { 0.0 };
        material.inputs.diffuse_transmission_weight = weight;
        let part = |weight: f32| move |color: Vec3| if weight > 0.0 { color * scale / weight } else { Vec3::ZERO };
        self.set(material, Input::BaseColor, &reflectance, Some(&part(1.0 - weight)));
        self.set(material, Input::DiffuseTransmissionColor, &transmittance, Some(&part(weight)));
        Ok(())
    }

    fn index_of_refraction(&mut self, parameters: &Parameters, name: &str) -> Result<f32, SceneError> {
        let Some(spectrum) = Spectrum::read(parameters, name, self.files, &self.folder)? else { return Ok(1.5) };
        match spectrum.refractive_index() {
            // pbrt means an interface without effect.
            Some(index) => Ok(if index == 0.0 { 1.0 } else { index.clamp(1.0, 100.0) }),
            None => {
                self.note(&parameters.at, &format!("the spectrum `{name}` is not read; 1.5 instead"));
                Ok(1.5)
            }
        }
    }

    fn roughness(&mut self, material: &mut Material, parameters: &Parameters, prefix: &str) -> Result<(), SceneError> {
        let remaps = parameters.flag("remaproughness", true)?;
        let name = |name: &str| format!("{prefix}{name}");
        let both = self.number(parameters, &name("roughness"), 0.0)?;
        let mut along = |axis: &str| match parameters.has(&name(axis)) {
            true => self.number(parameters, &name(axis), 0.0),
            false => Ok(both.clone()),
        };
        let (u, v) = (along("uroughness")?, along("vroughness")?);
        let convert = |value: Vec3| to_roughness(value, remaps);
        if let (Tex::Constant(u), Tex::Constant(v)) = (&u, &v)
            && u != v
        {
            let [u, v] = [u, v].map(|value| convert(*value).x.powi(2));
            let inputs = &mut material.inputs;
            inputs.specular_roughness = (0.5 * (u * u + v * v)).sqrt().sqrt();
            inputs.specular_anisotropy = 1.0 - u.min(v) / u.max(v);
            material.tangent_rotation = if v > u { core::f32::consts::FRAC_PI_2 } else { 0.0 };
            return Ok(());
        }
        if u != v {
            self.note(&parameters.at, "of two textures of roughness, that along u is used");
        }
        self.set(material, Input::SpecularRoughness, &u, Some(&convert));
        Ok(())
    }

    fn bumps(&mut self, material: &mut Material, parameters: &Parameters) -> Result<(), SceneError> {
        if let Tex::Image { map, scale } = self.number(parameters, "displacement", 0.0)? {
            material.bump_map = Some(BumpMap { texture: map, channel: Channel::R, height: scale.x });
        }
        if let Some(name) = parameters.text("normalmap")?.map(str::to_owned)
            && let Some(texture) = self.load_image(&name, parameters)
        {
            let texture = TextureMap { texture, space: ColorSpace::Linear, ..TextureMap::default() };
            material.normal_map = Some(NormalMap { texture, scale: glam::Vec2::ONE });
        }
        Ok(())
    }

    /// Layers' parameters that are about how they are computed, or about media between them.
    fn ignore_media(&mut self, parameters: &Parameters) {
        parameters.ignore(&["maxdepth", "nsamples", "thickness"]);
        if ["albedo", "g"].iter().any(|name| parameters.get(name).is_some()) {
            self.note(&parameters.at, "media between layers (`albedo`, `g`) are not read");
        }
    }
}

/// Converts pbrt's roughness to ours, whose square is α.
fn to_roughness(value: Vec3, remaps: bool) -> Vec3 {
    value
        .max(Vec3::ZERO)
        .map(|roughness| if remaps { roughness.sqrt().sqrt() } else { roughness.sqrt() })
        .min(Vec3::ONE)
}

/// How much of diffuse light a dielectric reflects on its inside: `2 ∫ F(c) c dc`.
fn inner_reflectance(eta: f32) -> f32 {
    cosine_mean(|cos| dielectric(cos, eta.recip()).0)
}

/// How much of diffuse light a layer lets through that lets `exp(-thickness / cos θ)` through.
fn diffuse_transmittance(thickness: f32) -> f32 {
    cosine_mean(|cos| (-thickness.max(0.0) / cos).exp())
}

fn cosine_mean(function: impl Fn(f32) -> f32) -> f32 {
    const STEPS: u32 = 1000;
    let at = |step: u32| (step as f32 + 0.5) / STEPS as f32;
    (0..STEPS).map(|step| 2.0 * at(step) * function(at(step))).sum::<f32>() / STEPS as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn means_over_the_hemisphere() {
        // Egan and Hilgeman's table of internal reflectance: 0.5963 for an index of 1.5.
        assert!((inner_reflectance(1.5) - 0.5963).abs() < 1e-3, "{}", inner_reflectance(1.5));
        assert!(inner_reflectance(1.0) < 1e-6);
        // 2 E₃(0.01).
        assert!((diffuse_transmittance(0.01) - 0.98055).abs() < 1e-3, "{}", diffuse_transmittance(0.01));
        assert!((to_roughness(Vec3::splat(0.0625), true).x - 0.5).abs() < 1e-6);
        assert!((to_roughness(Vec3::splat(0.25), false).x - 0.5).abs() < 1e-6);
    }
}
