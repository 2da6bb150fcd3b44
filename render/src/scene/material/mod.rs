//! Materials as described by files: constants, their maps, and properties outside the closure.

mod input;
mod kind;
mod maps;
mod presets;

use glam::{Vec3, Vec4};

pub use input::Input;
pub use maps::{BumpMap, Channel, CoatNormal, GltfAnisotropy, InputMap, NormalMap, Opacity, Target};

use super::{Texture, TextureMap};
use crate::material::Inputs;

/// The scattering and emission of a surface.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// The file's own name for it, or empty.
    pub name: String,
    /// The light group that its emission is in, or empty: then that of the mesh's name.
    pub light_group: String,

    /// The inputs of its closure, where no map says otherwise.
    pub inputs: Inputs,
    /// The maps that vary them, each texture once.
    pub maps: Vec<InputMap>,
    /// Whether the colours of a mesh's vertices multiply `base_color`, and their alpha the opacity.
    pub uses_vertex_colors: bool,
    /// Whether `base_color` is the colour of transmitted light too, in place of [`Inputs::transmission_color`]: of a
    /// thin wall as it is, of a solid its square root, since light goes in and out.
    pub base_color_tints_transmission: bool,
    /// By how much the tangent is turned about the normal, in radians, counter-clockwise: where `specular_anisotropy`
    /// points.
    pub tangent_rotation: f32,
    /// Anisotropy as glTF has it, in place of [`Inputs::specular_anisotropy`].
    pub anisotropy: Option<GltfAnisotropy>,
    /// The normal or bump map, if any.
    pub normal_map: Option<NormalMap>,
    /// The same by heights.
    pub bump_map: Option<BumpMap>,
    /// The normal map of its coat.
    pub coat_normal: CoatNormal,
    /// The opacity.
    pub opacity: Opacity,
    /// Whether it scatters nothing and shows a colour, which is its emission, whatever the light.
    pub unlit: bool,
    /// `20 / V_d`, with `V_d` Abbe's number of solid glass; 0 for none. Shown by path tracing.
    pub dispersion: f32,
    /// Emitted radiance; zero for most surfaces.
    pub emission: Vec3,
    /// The factor on emission, likewise.
    pub emission_map: Option<TextureMap>,
    /// Whether the back emits too; the front alone by default, as in glTF, pbrt and Mitsuba.
    pub emits_both_sides: bool,
}

impl Default for Material {
    /// A matte grey, for faces that name no material.
    fn default() -> Self {
        Self {
            name: String::new(),
            light_group: String::new(),
            inputs: Inputs::default(),
            maps: Vec::new(),
            uses_vertex_colors: false,
            base_color_tints_transmission: false,
            tangent_rotation: 0.0,
            anisotropy: None,
            normal_map: None,
            bump_map: None,
            coat_normal: CoatNormal::OfBase,
            opacity: Opacity::default(),
            unlit: false,
            dispersion: 0.0,
            emission: Vec3::ZERO,
            emission_map: None,
            emits_both_sides: false,
        }
    }
}

impl Material {
    /// The material with the mean of each texture in the texture's place.
    pub(crate) fn without_maps(&self, textures: &[Texture]) -> Self {
        let mean = |map: &Option<TextureMap>| {
            map.as_ref().map_or(Vec3::ONE, |map| textures[map.texture].mean_in(map.space).truncate())
        };
        Self {
            inputs: self.mean_inputs(textures),
            maps: Vec::new(),
            anisotropy: None,
            emission: self.emission * mean(&self.emission_map),
            emission_map: None,
            ..self.clone()
        }
    }

    /// The inputs with the mean of each texture in the texture's place.
    pub fn mean_inputs(&self, textures: &[Texture]) -> Inputs {
        self.inputs_by(|map| textures[map.texture].mean_in(map.space), Vec3::ONE)
    }

    /// The inputs where no map varies them and vertices have no colours.
    pub(crate) fn even_inputs(&self) -> Inputs {
        self.inputs_by(|_| Vec4::ONE, Vec3::ONE)
    }

    /// The greatest values that inputs can take, whatever the texels: what decides on a closure's kind.
    pub fn greatest_inputs(&self) -> Inputs {
        let mut inputs = self.inputs;
        for target in self.maps.iter().flat_map(|map| &map.targets) {
            let value = target.input.get(&inputs).max(Vec3::splat(target.zero));
            target.input.set(&mut inputs, value);
        }
        if self.anisotropy.is_some() {
            inputs.specular_anisotropy = 1.0;
        }
        inputs
    }

    /// The inputs, with texels as `lookup` finds them, and `base_color` multiplied by the colour of the vertices.
    #[inline]
    pub(super) fn inputs_by(&self, lookup: impl Fn(&TextureMap) -> Vec4, vertex_color: Vec3) -> Inputs {
        let mut inputs = self.inputs;
        for map in &self.maps {
            map.apply(lookup(&map.texture), &mut inputs);
        }
        if let Some(anisotropy) = &self.anisotropy {
            let strength = anisotropy.map.as_ref().map_or(1.0, |map| lookup(map).z);
            anisotropy.apply(strength, &mut inputs);
        }
        inputs.base_color *= vertex_color;
        if self.base_color_tints_transmission {
            let color = inputs.base_color;
            inputs.transmission_color = if inputs.thin_walled { color } else { color.map(f32::sqrt) };
        }
        inputs
    }

    /// Lets a part of a texture vary an input. Inputs with the same lookup share it.
    pub fn add_map(&mut self, texture: TextureMap, input: Input, channel: Channel, zero: f32) {
        self.remove_map(input);
        let target = Target { input, channel, zero };
        match self.maps.iter_mut().find(|map| map.texture == texture) {
            Some(map) => map.targets.push(target),
            None => self.maps.push(InputMap { texture, targets: vec![target] }),
        }
    }

    /// Leaves an input at its constant.
    pub fn remove_map(&mut self, input: Input) {
        self.maps.iter_mut().for_each(|map| map.targets.retain(|target| target.input != input));
        self.maps.retain(|map| !map.targets.is_empty());
    }

    /// The map of an input.
    pub fn map_of(&self, input: Input) -> Option<(&TextureMap, Target)> {
        let with_input = |map: &'_ InputMap| map.targets.iter().copied().find(|target| target.input == input);
        self.maps.iter().find_map(|map| with_input(map).map(|target| (&map.texture, target)))
    }

    /// All its uses of textures.
    pub fn texture_maps(&self) -> impl Iterator<Item = &TextureMap> {
        let inputs = self.maps.iter().map(|map| &map.texture);
        let others = [
            self.emission_map.as_ref(),
            self.opacity.map.as_ref().map(|(map, _)| map),
            self.normal_map.as_ref().map(|map| &map.texture),
            self.bump_map.as_ref().map(|map| &map.texture),
            self.anisotropy.as_ref().and_then(|anisotropy| anisotropy.map.as_ref()),
            self.coat_normal.map().map(|map| &map.texture),
        ];
        inputs.chain(others.into_iter().flatten())
    }

    /// The same, to be changed.
    pub(crate) fn texture_maps_mut(&mut self) -> impl Iterator<Item = &mut TextureMap> {
        let inputs = self.maps.iter_mut().map(|map| &mut map.texture);
        let others = [
            self.emission_map.as_mut(),
            self.opacity.map.as_mut().map(|(map, _)| map),
            self.normal_map.as_mut().map(|map| &mut map.texture),
            self.bump_map.as_mut().map(|map| &mut map.texture),
            self.anisotropy.as_mut().and_then(|anisotropy| anisotropy.map.as_mut()),
            match &mut self.coat_normal {
                CoatNormal::Map(map) => Some(&mut map.texture),
                CoatNormal::OfBase | CoatNormal::OfVertices => None,
            },
        ];
        inputs.chain(others.into_iter().flatten())
    }

    /// Whether shading asks for a tangent that follows the texture coordinates, and of which set of these.
    pub(crate) fn tangent_set(&self) -> Option<u32> {
        let normal = self.normal_map.as_ref().or(self.coat_normal.map()).map(|map| map.texture.set);
        let anisotropy = self.anisotropy.as_ref().and_then(|it| it.map.as_ref()).map(|map| map.set);
        normal.or(anisotropy).or((self.greatest_inputs().specular_anisotropy > 0.0).then_some(0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::ColorSpace;

    #[test]
    fn inputs_with_the_same_lookup_share_it() {
        let (color, number) =
            (TextureMap::default(), TextureMap { space: ColorSpace::Linear, ..TextureMap::default() });
        let mut material = Material::default();
        material.add_map(color.clone(), Input::BaseColor, Channel::Rgb, 0.0);
        material.add_map(number.clone(), Input::SpecularRoughness, Channel::G, 0.0);
        material.add_map(number.clone(), Input::BaseMetalness, Channel::B, 0.0);
        assert_eq!(material.maps.len(), 2);
        let (map, target) = material.map_of(Input::BaseMetalness).unwrap();
        assert_eq!((map, target.channel), (&number, Channel::B));
        // An input has one map at most.
        material.add_map(color, Input::BaseMetalness, Channel::R, 0.0);
        assert_eq!(material.map_of(Input::BaseMetalness).unwrap().1.channel, Channel::R);
        material.remove_map(Input::BaseColor);
        material.remove_map(Input::BaseMetalness);
        assert_eq!(material.maps.len(), 1);
        assert_eq!(material.map_of(Input::BaseColor), None);
    }

    #[test]
    fn a_solid_is_tinted_by_half_at_each_surface() {
        let inputs = Inputs { base_color: Vec3::new(0.25, 1.0, 0.0), transmission_weight: 1.0, ..Inputs::default() };
        let mut material = Material { inputs, base_color_tints_transmission: true, ..Material::default() };
        assert_eq!(material.mean_inputs(&[]).transmission_color, Vec3::new(0.5, 1.0, 0.0));
        material.inputs.thin_walled = true;
        assert_eq!(material.mean_inputs(&[]).transmission_color, Vec3::new(0.25, 1.0, 0.0));
        material.base_color_tints_transmission = false;
        assert_eq!(material.mean_inputs(&[]).transmission_color, Vec3::ONE);
    }

    #[test]
    fn means_and_greatest_values_stand_for_textures() {
        let texture = Texture::new(2, 1, vec![[0, 51, 255, 255], [0, 153, 255, 255]]);
        let map = TextureMap { space: ColorSpace::Linear, ..TextureMap::default() };
        let inputs = Inputs { specular_roughness: 0.5, base_metalness: 1.0, ..Inputs::default() };
        let mut material = Material { inputs, ..Material::default() };
        material.add_map(map.clone(), Input::SpecularRoughness, Channel::G, 1.0);
        material.add_map(map, Input::BaseMetalness, Channel::R, 0.0);
        let mean = material.mean_inputs(&[texture]);
        assert!((mean.specular_roughness - 0.8).abs() < 1e-6 && mean.base_metalness == 0.0, "{mean:?}");
        let greatest = material.greatest_inputs();
        assert_eq!((greatest.specular_roughness, greatest.base_metalness), (1.0, 1.0));
    }
}
