//! A material as a `[[material]]` table of a scene file.

use std::fmt::Write as _;

use glam::Vec3;

use crate::material::Inputs;
use crate::scene::material::{CoatNormal, Input, Material};
use crate::scene::texture::{ColorSpace, Texture, TextureMap};

impl Material {
    /// The table: colour, gloss, and values that differ from those of plain diffuse reflection; in comments what a
    /// model's own textures vary, since these have no file that could be named.
    pub fn to_toml(&self, textures: &[Texture]) -> String {
        let mut text = format!("[[material]]\nname = {}\n", quoted(&self.name));
        let mut line = |key: &str, value: String| {
            // Writing to a string cannot fail.
            let _ = writeln!(text, "{key} = {value}");
        };
        let plain = Inputs::default();
        let has_gloss = self.inputs.specular_weight > 0.0 || self.inputs.base_metalness > 0.0;
        let is_shown = |input: Input| match input {
            Input::BaseColor | Input::SpecularWeight => true,
            Input::SpecularRoughness | Input::BaseMetalness => has_gloss,
            _ => false,
        };
        for input in Input::ALL {
            let value = input.get(&self.inputs);
            if value != input.get(&plain) || is_shown(input) {
                line(input.name(), if input.is_color() { color(value) } else { number(value.x) });
            }
        }
        if self.inputs.thin_walled && self.inputs.transmission_weight > 0.0 {
            line("geometry_thin_walled", "true".to_owned());
        }
        if self.tangent_rotation != 0.0 {
            line("geometry_tangent_rotation", number(self.tangent_rotation.to_degrees()));
        }
        if self.coat_normal == CoatNormal::OfVertices && self.inputs.coat_weight > 0.0 && self.tilts_normals() {
            line("geometry_coat_normal_map", quoted("none"));
        }
        if self.opacity.value != 1.0 {
            line("geometry_opacity", number(self.opacity.value));
        }
        if let Some(cutoff) = self.opacity.cutoff {
            line("geometry_opacity_cutoff", number(cutoff));
        }
        if self.emission != Vec3::ZERO {
            let luminance = self.emission.max_element();
            line("emission_color", color(self.emission / luminance));
            line("emission_luminance", number(luminance));
        }
        if self.dispersion > 0.0 {
            line("transmission_dispersion_abbe_number", number(20.0 / self.dispersion));
        }
        for comment in self.comments(textures) {
            let _ = writeln!(text, "# {comment}");
        }
        text
    }

    /// What the table cannot say.
    fn comments(&self, textures: &[Texture]) -> Vec<String> {
        let mut comments = Vec::new();
        let mut map = |what: &str, map: &TextureMap| comments.push(format!("{what}: {}", described(map, textures)));
        for it in &self.maps {
            for target in &it.targets {
                map(&format!("{}_map, {}", target.input.name(), target.channel.name()), &it.texture);
            }
        }
        if let Some((texture, channel)) = &self.opacity.map {
            map(&format!("geometry_opacity_map, {}", channel.name()), texture);
        }
        if let Some(it) = &self.emission_map {
            map("emission_color_map", it);
        }
        if let Some(it) = &self.normal_map {
            map(&format!("geometry_normal_map, strength {}", it.scale.x), &it.texture);
        }
        if let Some(it) = self.coat_normal.map() {
            map(&format!("geometry_coat_normal_map, strength {}", it.scale.x), &it.texture);
        }
        if let Some(it) = &self.bump_map {
            map(&format!("geometry_bump_map, height {}", it.height), &it.texture);
        }
        if let Some(it) = &self.anisotropy {
            comments.push(format!("KHR_materials_anisotropy of strength {}", it.strength));
        }
        let absorption = self.inputs.absorption;
        if absorption != Vec3::ZERO {
            comments.push(format!("absorbs {} a unit of length inside", color(absorption)));
        }
        if self.base_color_tints_transmission && self.inputs.transmission_weight > 0.0 {
            comments.push("transmitted light has the base colour".to_owned());
        }
        if self.unlit {
            comments.push("unlit: its emission is its base colour".to_owned());
        }
        comments
    }
}

fn described(map: &TextureMap, textures: &[Texture]) -> String {
    let texture = &textures[map.texture];
    let (width, height) = texture.size();
    let (channels, bits) = (texture.channels(), texture.bits());
    let space = if map.space == ColorSpace::Srgb { "sRGB" } else { "linear" };
    format!("texture {}, {width}x{height}, {channels} x {bits} bits, {space}, set {}", map.texture, map.set)
}

fn number(value: f32) -> String {
    let text = format!("{value:?}");
    // TOML has no `1e-7` without a fraction before it, but takes what Rust writes otherwise.
    if text.contains('e') { format!("{value:.9}") } else { text }
}

fn color(value: Vec3) -> String {
    format!("[{}]", value.to_array().map(number).join(", "))
}

/// A TOML string.
fn quoted(text: &str) -> String {
    let mut quoted = String::from("\"");
    for letter in text.chars() {
        match letter {
            '"' | '\\' => quoted.extend(['\\', letter]),
            letter if letter.is_control() => _ = write!(quoted, "\\u{:04X}", letter as u32),
            letter => quoted.push(letter),
        }
    }
    quoted + "\""
}
