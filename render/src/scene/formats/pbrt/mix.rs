//! The material `mix`: pbrt chooses one of two materials at random; here they become one material.
//!
//! Each weight of a lobe is the mean of both weights, and each other input the mean weighted by how much of its lobe
//! the two have: so the roughness of a metal does not change when it is mixed with a matte surface. Mixes of diffuse
//! surfaces are exact.
//!
//! Deviations: a metal and a matte surface share `base_color`, and so its mean; textures are replaced by their means.

use super::Reader;
use super::parameters::Parameters;
use super::placed::Definition;
use super::textures::Tex;
use crate::material::Inputs;
use crate::scene::nearest::suggestion;
use crate::scene::{Input, Material, SceneError};

impl Reader<'_> {
    /// `Material "mix"`; `None` if neither material is seen.
    pub(super) fn mixed(&mut self, parameters: &Parameters) -> Result<Option<Material>, SceneError> {
        let at = parameters.get("materials").map_or(&parameters.at, |found| &found.at);
        let Some([first, second]) = parameters.texts("materials")? else {
            let problem = "a mix does not name two materials";
            return Err(at.error(problem, "write `\"string materials\" [ \"one\" \"other\" ]`"));
        };
        let part = |name: &String| {
            let number = self.material_names.get(name);
            match number.map(|&number| &self.materials[number]) {
                Some(Definition::Surface(material)) => Ok(Some((**material).clone())),
                Some(Definition::Interface) => Ok(None),
                Some(Definition::Awaited(..)) | None => {
                    let is_defined = |number: &usize| !matches!(self.materials[*number], Definition::Awaited(..));
                    let names = self.material_names.iter().filter(|(_, number)| is_defined(number));
                    let known: Vec<&str> = names.map(|(name, _)| name.as_str()).collect();
                    let remedy = match known.is_empty() {
                        true => format!("define it before: `MakeNamedMaterial {name:?} \"string type\" \"diffuse\"`"),
                        false => suggestion(name, &known),
                    };
                    Err(at.error(format!("there is no material {name:?} to be mixed"), remedy))
                }
            }
        };
        let (first, second) = (part(first)?, part(second)?);
        let amount = self.number(parameters, "amount", 0.5)?;
        if matches!(amount, Tex::Image { .. }) {
            self.note(&parameters.at, "the picture that mixes materials is a constant of its mean");
        }
        let amount = self.mean(&amount).x;
        let (first, second) = match (first, second) {
            (first, _) if amount <= 0.0 => return Ok(first),
            (_, second) if amount >= 1.0 => return Ok(second),
            (Some(first), Some(second)) => (first, second),
            (first, second) => {
                self.note(&parameters.at, "a mix with an interface is the other material alone");
                return Ok(first.or(second));
            }
        };
        let [a, b] = [&first, &second].map(|material| material.mean_inputs(&self.textures.list));
        let is_diffuse = [&first, &second].iter().all(|it| it.texture_maps().next().is_none())
            && [a, b].iter().all(|it| *it == Inputs { base_color: it.base_color, ..Inputs::default() });
        if !is_diffuse {
            self.note(&parameters.at, "a mix of materials is one material in between, textures count by their means");
        }
        let heavier = if amount > 0.5 { second } else { first };
        let inputs = between(&a, &b, amount);
        Ok(Some(Material { inputs, tangent_rotation: heavier.tangent_rotation, ..Material::default() }))
    }
}

/// `1 - amount` of the first and `amount` of the second.
fn between(first: &Inputs, second: &Inputs, amount: f32) -> Inputs {
    let mut mixed = if amount > 0.5 { *second } else { *first };
    for input in Input::ALL {
        let [a, b] = [(first, 1.0 - amount), (second, amount)].map(|(inputs, part)| part * share(input, inputs));
        // Inputs that neither uses do not matter.
        let (a, b) = if a + b > 0.0 { (a, b) } else { (1.0 - amount, amount) };
        input.set(&mut mixed, (input.get(first) * a + input.get(second) * b) / (a + b));
    }
    mixed
}

/// How much of the surface an input is about.
fn share(input: Input, inputs: &Inputs) -> f32 {
    let metal = inputs.base_metalness;
    let dielectric = 1.0 - metal;
    let opaque = dielectric * (1.0 - inputs.transmission_weight);
    match input {
        Input::BaseColor => metal + opaque * (1.0 - inputs.diffuse_transmission_weight),
        Input::MetalEdgeColor => metal,
        Input::SpecularRoughness | Input::SpecularAnisotropy => metal + dielectric * inputs.specular_weight,
        Input::SpecularColor | Input::SpecularIor => dielectric * inputs.specular_weight,
        Input::SpecularWeight | Input::TransmissionWeight => dielectric,
        Input::TransmissionColor => dielectric * inputs.transmission_weight,
        Input::BaseDiffuseRoughness | Input::DiffuseTransmissionWeight => opaque,
        Input::DiffuseTransmissionColor => opaque * inputs.diffuse_transmission_weight,
        Input::CoatColor | Input::CoatRoughness | Input::CoatIor => inputs.coat_weight,
        _ => 1.0,
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;

    #[test]
    fn lobes_keep_what_only_they_have() {
        let matte = Inputs { base_color: Vec3::X, ..Inputs::default() };
        let metal = Inputs { base_color: Vec3::Y, base_metalness: 1.0, specular_roughness: 0.125, ..Inputs::default() };
        let mixed = between(&matte, &metal, 0.25);
        assert_eq!((mixed.base_metalness, mixed.specular_roughness), (0.25, 0.125));
        assert_eq!(mixed.base_color, Vec3::new(0.75, 0.25, 0.0));
        let glass = Inputs { specular_weight: 1.0, transmission_weight: 1.0, specular_ior: 1.75, ..Inputs::default() };
        let mixed = between(&glass, &matte, 0.75);
        assert_eq!((mixed.transmission_weight, mixed.specular_weight, mixed.specular_ior), (0.25, 0.25, 1.75));
        assert_eq!(mixed.base_color, Vec3::X);
    }
}
