//! The hash of a material.

use glam::Affine2;

use super::fnv::Fnv;
use crate::scene::{
    BumpMap, CoatNormal, GltfAnisotropy, Input, InputMap, Material, NormalMap, Opacity, Target, TextureMap,
};

impl Fnv {
    /// All but its name and light group.
    pub(super) fn material(&mut self, material: &Material) {
        let Material { name: _, inputs, maps, uses_vertex_colors, base_color_tints_transmission: tints, .. } = material;
        let Material { tangent_rotation, anisotropy, normal_map, bump_map, opacity, unlit, dispersion, .. } = material;
        let Material { emission, emission_map, emits_both_sides, coat_normal, .. } = material;
        Input::ALL.iter().for_each(|input| self.vector(input.get(inputs)));
        self.vector(inputs.absorption);
        [inputs.thin_walled, *uses_vertex_colors, *tints, *unlit].into_iter().for_each(|flag| self.word(flag.into()));
        self.count(maps.len());
        for InputMap { texture, targets } in maps {
            self.map(Some(texture));
            self.count(targets.len());
            for &Target { input, channel, zero } in targets {
                [input as u32, channel as u32, zero.to_bits()].into_iter().for_each(|word| self.word(word));
            }
        }
        self.floats(&[*tangent_rotation, *dispersion]);
        if let Some(GltfAnisotropy { strength, is_by_blender, map }) = anisotropy {
            self.word((*is_by_blender).into());
            self.floats(&[*strength]);
            self.map(map.as_ref());
        }
        if let Some(NormalMap { texture, scale }) = normal_map {
            self.map(Some(texture));
            self.floats(&scale.to_array());
        }
        match coat_normal {
            CoatNormal::OfBase => {}
            CoatNormal::OfVertices => self.word(1),
            CoatNormal::Map(NormalMap { texture, scale }) => {
                self.word(2);
                self.map(Some(texture));
                self.floats(&scale.to_array());
            }
        }
        if let Some(BumpMap { texture, channel, height }) = bump_map {
            self.map(Some(texture));
            self.word(*channel as u32);
            self.floats(&[*height]);
        }
        let Opacity { value, map, cutoff } = opacity;
        self.floats(&[*value, cutoff.unwrap_or(-1.0)]);
        self.map(map.as_ref().map(|(map, _)| map));
        self.word(map.as_ref().map_or(0, |&(_, channel)| channel as u32));
        self.vector(*emission);
        self.word((*emits_both_sides).into());
        self.map(emission_map.as_ref());
    }

    fn map(&mut self, map: Option<&TextureMap>) {
        self.word(map.is_some().into());
        if let Some(TextureMap { texture, set, transform: Affine2 { matrix2, translation }, wrap, filter, space }) = map
        {
            self.count(*texture);
            self.floats(&matrix2.to_cols_array());
            self.floats(&translation.to_array());
            [*set, wrap[0] as u32, wrap[1] as u32, *filter as u32, *space as u32]
                .into_iter()
                .for_each(|word| self.word(word));
        }
    }
}
