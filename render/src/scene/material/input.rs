//! The inputs of a material that may have a map, each with its name, its place in [`Inputs`] and its range.

use glam::Vec3;

use crate::material::Inputs;

/// An input of a closure that a texture may vary.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[expect(missing_docs, reason = "they are the fields of `Inputs`, where they are described")]
pub enum Input {
    BaseColor,
    BaseDiffuseRoughness,
    BaseMetalness,
    MetalEdgeColor,
    SpecularWeight,
    SpecularColor,
    SpecularRoughness,
    SpecularAnisotropy,
    SpecularIor,
    TransmissionWeight,
    TransmissionColor,
    DiffuseTransmissionWeight,
    DiffuseTransmissionColor,
    CoatWeight,
    CoatColor,
    CoatRoughness,
    CoatIor,
    FuzzWeight,
    FuzzColor,
    FuzzRoughness,
    ThinFilmWeight,
    ThinFilmThickness,
    ThinFilmIor,
}

/// An input's value in [`Inputs`].
pub(crate) enum Slot<'a> {
    Color(&'a mut Vec3),
    Number(&'a mut f32),
}

/// The least and greatest value of an input, channel by channel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Range {
    pub(crate) least: f32,
    pub(crate) greatest: f32,
}

const UNIT: Range = Range { least: 0.0, greatest: 1.0 };
const POSITIVE: Range = Range { least: 0.0, greatest: f32::MAX };
/// Refractive indices. No known solid comes near 10 in visible light; metals are given by their colour.
const IOR: Range = Range { least: 1.0, greatest: 100.0 };

impl Input {
    /// All inputs, in the order of the layers, the base first.
    pub const ALL: [Self; 23] = [
        Self::BaseColor,
        Self::BaseDiffuseRoughness,
        Self::BaseMetalness,
        Self::MetalEdgeColor,
        Self::SpecularWeight,
        Self::SpecularColor,
        Self::SpecularRoughness,
        Self::SpecularAnisotropy,
        Self::SpecularIor,
        Self::TransmissionWeight,
        Self::TransmissionColor,
        Self::DiffuseTransmissionWeight,
        Self::DiffuseTransmissionColor,
        Self::CoatWeight,
        Self::CoatColor,
        Self::CoatRoughness,
        Self::CoatIor,
        Self::FuzzWeight,
        Self::FuzzColor,
        Self::FuzzRoughness,
        Self::ThinFilmWeight,
        Self::ThinFilmThickness,
        Self::ThinFilmIor,
    ];

    /// The name in scene files: OpenPBR's where it has such an input.
    pub fn name(self) -> &'static str {
        match self {
            Self::BaseColor => "base_color",
            Self::BaseDiffuseRoughness => "base_diffuse_roughness",
            Self::BaseMetalness => "base_metalness",
            Self::MetalEdgeColor => "metal_edge_color",
            Self::SpecularWeight => "specular_weight",
            Self::SpecularColor => "specular_color",
            Self::SpecularRoughness => "specular_roughness",
            Self::SpecularAnisotropy => "specular_roughness_anisotropy",
            Self::SpecularIor => "specular_ior",
            Self::TransmissionWeight => "transmission_weight",
            Self::TransmissionColor => "transmission_color",
            Self::DiffuseTransmissionWeight => "diffuse_transmission_weight",
            Self::DiffuseTransmissionColor => "diffuse_transmission_color",
            Self::CoatWeight => "coat_weight",
            Self::CoatColor => "coat_color",
            Self::CoatRoughness => "coat_roughness",
            Self::CoatIor => "coat_ior",
            Self::FuzzWeight => "fuzz_weight",
            Self::FuzzColor => "fuzz_color",
            Self::FuzzRoughness => "fuzz_roughness",
            Self::ThinFilmWeight => "thin_film_weight",
            Self::ThinFilmThickness => "thin_film_thickness",
            Self::ThinFilmIor => "thin_film_ior",
        }
    }

    /// Its place.
    pub(crate) fn slot(self, inputs: &mut Inputs) -> Slot<'_> {
        match self {
            Self::BaseColor => Slot::Color(&mut inputs.base_color),
            Self::BaseDiffuseRoughness => Slot::Number(&mut inputs.base_diffuse_roughness),
            Self::BaseMetalness => Slot::Number(&mut inputs.base_metalness),
            Self::MetalEdgeColor => Slot::Color(&mut inputs.metal_edge_color),
            Self::SpecularWeight => Slot::Number(&mut inputs.specular_weight),
            Self::SpecularColor => Slot::Color(&mut inputs.specular_color),
            Self::SpecularRoughness => Slot::Number(&mut inputs.specular_roughness),
            Self::SpecularAnisotropy => Slot::Number(&mut inputs.specular_anisotropy),
            Self::SpecularIor => Slot::Number(&mut inputs.specular_ior),
            Self::TransmissionWeight => Slot::Number(&mut inputs.transmission_weight),
            Self::TransmissionColor => Slot::Color(&mut inputs.transmission_color),
            Self::DiffuseTransmissionWeight => Slot::Number(&mut inputs.diffuse_transmission_weight),
            Self::DiffuseTransmissionColor => Slot::Color(&mut inputs.diffuse_transmission_color),
            Self::CoatWeight => Slot::Number(&mut inputs.coat_weight),
            Self::CoatColor => Slot::Color(&mut inputs.coat_color),
            Self::CoatRoughness => Slot::Number(&mut inputs.coat_roughness),
            Self::CoatIor => Slot::Number(&mut inputs.coat_ior),
            Self::FuzzWeight => Slot::Number(&mut inputs.fuzz_weight),
            Self::FuzzColor => Slot::Color(&mut inputs.fuzz_color),
            Self::FuzzRoughness => Slot::Number(&mut inputs.fuzz_roughness),
            Self::ThinFilmWeight => Slot::Number(&mut inputs.thin_film_weight),
            Self::ThinFilmThickness => Slot::Number(&mut inputs.thin_film_thickness),
            Self::ThinFilmIor => Slot::Number(&mut inputs.thin_film_ior),
        }
    }

    /// The range of its values.
    pub(crate) fn range(self) -> Range {
        match self {
            Self::SpecularIor | Self::CoatIor | Self::ThinFilmIor => IOR,
            Self::SpecularColor | Self::ThinFilmThickness => POSITIVE,
            _ => UNIT,
        }
    }

    /// Whether it is a colour; otherwise it is one number.
    pub fn is_color(self) -> bool {
        matches!(self.slot(&mut Inputs::default()), Slot::Color(_))
    }

    /// Its value; one number three times over.
    pub(crate) fn get(self, inputs: &Inputs) -> Vec3 {
        match self.slot(&mut inputs.clone()) {
            Slot::Color(color) => *color,
            Slot::Number(number) => Vec3::splat(*number),
        }
    }

    /// Sets it, of one number the first channel, within its range.
    pub(crate) fn set(self, inputs: &mut Inputs, value: Vec3) {
        let Range { least, greatest } = self.range();
        match self.slot(inputs) {
            Slot::Color(color) => *color = value.clamp(Vec3::splat(least), Vec3::splat(greatest)),
            Slot::Number(number) => *number = value.x.clamp(least, greatest),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_input_has_a_name_and_a_slot_of_its_own_and_a_default_in_its_range() {
        let mut names: Vec<_> = Input::ALL.iter().map(|input| input.name()).collect();
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), Input::ALL.len());
        for input in Input::ALL {
            let mut inputs = Inputs::default();
            let before = input.get(&inputs);
            assert!(
                before
                    .to_array()
                    .into_iter()
                    .all(|number| number >= input.range().least && number <= input.range().greatest),
                "{input:?}"
            );
            // Another value that is in every range.
            let other = Vec3::splat(if before.x == 1.0 { 0.25 } else { 1.0 }).max(Vec3::splat(input.range().least));
            let other = if other == before { other * 2.0 } else { other };
            input.set(&mut inputs, other);
            let changed: Vec<_> =
                Input::ALL.iter().filter(|it| it.get(&inputs) != it.get(&Inputs::default())).collect();
            assert_eq!(changed, [&input]);
        }
    }

    #[test]
    fn values_are_kept_in_their_range() {
        let mut inputs = Inputs::default();
        Input::SpecularRoughness.set(&mut inputs, Vec3::splat(-1.0));
        Input::BaseColor.set(&mut inputs, Vec3::new(-1.0, 0.5, 7.0));
        Input::SpecularIor.set(&mut inputs, Vec3::ZERO);
        assert_eq!(inputs.specular_roughness, 0.0);
        assert_eq!(inputs.base_color, Vec3::new(0.0, 0.5, 1.0));
        assert_eq!(inputs.specular_ior, 1.0);
    }
}
