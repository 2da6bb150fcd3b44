//! Textures: constants, pictures, products of both, checkerboards; and textures on material inputs.
//!
//! Texture coordinates count from a picture's lower edge in pbrt and from its upper one here; meshes have been turned,
//! so `uscale` and its like are turned, too. pbrt's procedural textures without a counterpart (`fbm`, `marble`) become
//! a constant, with a warning. A product of two pictures uses the mean of the second.

use std::collections::BTreeMap;

use glam::{Affine2, Vec2, Vec3};

use super::Reader;
use super::parameters::{Parameter, Parameters, Values};
use super::spectrum::Spectrum;
use crate::scene::nearest::suggestion;
use crate::scene::texture::Texels;
use crate::scene::{Channel, ColorSpace, Input, Material, SceneError, Texture, TextureFilter, TextureMap, Wrap};

/// A texture of either type; one number three times over.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Tex {
    Constant(Vec3),
    Image { map: TextureMap, scale: Vec3 },
}

/// Textures by their names.
#[derive(Default)]
pub(super) struct NamedTextures {
    float: BTreeMap<String, Tex>,
    spectrum: BTreeMap<String, Tex>,
}

/// A function of a texel's colour.
pub(super) type Convert<'a> = Option<&'a dyn Fn(Vec3) -> Vec3>;

/// pbrt's procedural textures.
const FORMULAS: [&str; 8] = ["bilerp", "directionmix", "dots", "fbm", "marble", "ptex", "windy", "wrinkled"];

const CLASSES: [&str; 5] = ["checkerboard", "constant", "imagemap", "mix", "scale"];

impl Reader<'_> {
    /// `Texture "name" "type" "class" ...`
    pub(super) fn define_texture(
        &mut self,
        name: String,
        kind: &str,
        class: &str,
        parameters: &Parameters,
    ) -> Result<(), SceneError> {
        let is_color = match kind {
            "spectrum" => true,
            "float" => false,
            _ => {
                let problem = format!("the texture {name:?} is of type {kind:?}");
                return Err(parameters.at.error(problem, "write \"float\" or \"spectrum\""));
            }
        };
        let value = |reader: &mut Self, name: &str, default: f32| match is_color {
            true => reader.color(parameters, name, Vec3::splat(default)),
            false => reader.number(parameters, name, default),
        };
        let texture = match class {
            "constant" => value(self, "value", 1.0)?,
            "imagemap" => self.image(parameters)?,
            "scale" => {
                let (tex, scale) = (value(self, "tex", 1.0)?, value(self, "scale", 1.0)?);
                self.product(tex, &scale, parameters)
            }
            "mix" => {
                let [first, second] = [("tex1", 0.0), ("tex2", 1.0)].map(|(name, default)| value(self, name, default));
                let (first, second, amount) = (first?, second?, self.number(parameters, "amount", 0.5)?);
                if [&first, &second, &amount].iter().any(|tex| matches!(tex, Tex::Image { .. })) {
                    self.note(&parameters.at, "a mix of pictures is a constant of their means");
                }
                let amount = self.mean(&amount);
                Tex::Constant(self.mean(&first) * (1.0 - amount) + self.mean(&second) * amount)
            }
            "checkerboard" => {
                let [first, second] = [("tex1", 1.0), ("tex2", 0.0)].map(|(name, default)| value(self, name, default));
                self.checkerboard(&first?, &second?, parameters)?
            }
            _ if FORMULAS.contains(&class) => {
                self.note(&parameters.at, &format!("a texture {class:?} is not read; a constant of 0.5 instead"));
                parameters.unused().for_each(|unused| parameters.ignore(&[&unused.name]));
                Tex::Constant(Vec3::splat(0.5))
            }
            _ => {
                let problem = format!("there is no texture of class {class:?}");
                return Err(parameters.at.error(problem, suggestion(class, &CLASSES)));
            }
        };
        self.warn_of_unused(parameters);
        let names = if is_color { &mut self.named_textures.spectrum } else { &mut self.named_textures.float };
        names.insert(name, texture);
        Ok(())
    }

    fn image(&mut self, parameters: &Parameters) -> Result<Tex, SceneError> {
        parameters.ignore(&["filter", "maxanisotropy"]);
        let Some(name) = parameters.text("filename")? else {
            return Err(parameters.at.error("an imagemap names no file", "write `\"string filename\" \"wood.png\"`"));
        };
        let scale = Vec3::splat(parameters.float("scale", 1.0)?);
        let inverts = parameters.flag("invert", false)?;
        let wrap = match parameters.text("wrap")?.unwrap_or("repeat") {
            "clamp" => Wrap::Clamp,
            "repeat" => Wrap::Repeat,
            other => {
                self.note(&parameters.at, &format!("`wrap` {other:?} is not read; pictures repeat"));
                Wrap::Repeat
            }
        };
        let space = match parameters.text("encoding")?.unwrap_or("sRGB") {
            "linear" => ColorSpace::Linear,
            encoding => {
                if encoding != "sRGB" {
                    self.note(&parameters.at, &format!("`encoding` {encoding:?} is taken for sRGB"));
                }
                ColorSpace::Srgb
            }
        };
        let transform = self.mapping(parameters)?;
        let name = name.to_owned();
        let Some(texture) = self.load_image(&name, parameters) else { return Ok(Tex::Constant(Vec3::splat(0.5))) };
        let map = TextureMap { texture, transform, wrap: [wrap; 2], space, ..TextureMap::default() };
        Ok(match inverts {
            true => self.baked(&map, &|texel| (1.0 - texel * scale).max(Vec3::ZERO)),
            false => Tex::Image { map, scale },
        })
    }

    /// The index of the picture in a file; `None`, with a warning, if it cannot be read.
    pub(super) fn load_image(&mut self, name: &str, parameters: &Parameters) -> Option<usize> {
        let path = self.resolve(name, &parameters.at);
        match self.textures.load(&path) {
            Ok(texture) => Some(texture),
            Err(problem) => {
                let what = format!("a texture is left out: {} ({})", problem.problem, problem.remedy);
                self.note(&parameters.at, &what);
                None
            }
        }
    }

    /// The transform from the meshes' texture coordinates to the picture.
    fn mapping(&mut self, parameters: &Parameters) -> Result<Affine2, SceneError> {
        let mapping = parameters.text("mapping")?.unwrap_or("uv");
        if mapping != "uv" {
            self.note(&parameters.at, &format!("the mapping {mapping:?} is not read; \"uv\" instead"));
            parameters.ignore(&["v1", "v2"]);
        }
        let scale = Vec2::new(parameters.float("uscale", 1.0)?, parameters.float("vscale", 1.0)?);
        let offset = Vec2::new(parameters.float("udelta", 0.0)?, parameters.float("vdelta", 0.0)?);
        if scale == Vec2::ONE && offset == Vec2::ZERO {
            return Ok(Affine2::IDENTITY);
        }
        let flip = Affine2::from_scale_angle_translation(Vec2::new(1.0, -1.0), 0.0, Vec2::Y);
        Ok(flip * Affine2::from_scale_angle_translation(scale, 0.0, offset) * flip)
    }

    /// Two by two texels, of which each is a square of side 1 in texture coordinates.
    fn checkerboard(&mut self, first: &Tex, second: &Tex, parameters: &Parameters) -> Result<Tex, SceneError> {
        if parameters.integer("dimension", 2)? != 2 {
            self.note(&parameters.at, "a checkerboard of 3 dimensions is not read; one of 2 instead");
        }
        if [first, second].iter().any(|tex| matches!(tex, Tex::Image { .. })) {
            self.note(&parameters.at, "a checkerboard of pictures is one of their means");
        }
        let [first, second] = [first, second].map(|tex| self.mean(tex).to_array());
        // pbrt's row of 0 <= v < 1 is the lower one.
        let texels = [second, first, first, second].concat();
        let texture = self.textures.add(Texture::from_texels(2, 2, 3, Texels::F32(texels)));
        let mapping = self.mapping(parameters)?;
        let flip = Affine2::from_scale_angle_translation(Vec2::new(1.0, -1.0), 0.0, Vec2::Y);
        let transform = flip * Affine2::from_scale(Vec2::splat(0.5)) * flip * mapping;
        let map = TextureMap { texture, transform, filter: TextureFilter::Nearest, ..TextureMap::default() };
        Ok(Tex::Image { map, scale: Vec3::ONE })
    }

    fn product(&mut self, first: Tex, second: &Tex, parameters: &Parameters) -> Tex {
        match (first, second) {
            (Tex::Constant(a), Tex::Constant(b)) => Tex::Constant(a * b),
            (Tex::Constant(factor), Tex::Image { map, scale }) => {
                Tex::Image { map: map.clone(), scale: factor * scale }
            }
            (Tex::Image { map, scale }, second) => {
                if matches!(second, Tex::Image { .. }) {
                    self.note(&parameters.at, "of a product of two pictures, the second is a constant of its mean");
                }
                Tex::Image { map, scale: scale * self.mean(second) }
            }
        }
    }

    /// The mean over the picture.
    pub(super) fn mean(&self, tex: &Tex) -> Vec3 {
        match tex {
            Tex::Constant(value) => *value,
            Tex::Image { map, scale } => self.textures.list[map.texture].mean_in(map.space).truncate() * scale,
        }
    }

    /// A colour that a texture may vary.
    pub(super) fn color(&mut self, parameters: &Parameters, name: &str, default: Vec3) -> Result<Tex, SceneError> {
        let Some(found) = parameters.get(name) else { return Ok(Tex::Constant(default)) };
        if found.kind == "texture" {
            return named(&self.named_textures.spectrum, found, "spectrum");
        }
        let spectrum = Spectrum::read(parameters, name, self.files, &self.folder)?;
        match spectrum.and_then(|spectrum| spectrum.reflectance()) {
            Some(color) => Ok(Tex::Constant(color)),
            None => {
                self.note(&found.at, &format!("the spectrum `{name}` is not read; {} instead", default.x));
                Ok(Tex::Constant(default))
            }
        }
    }

    /// A number that a texture may vary.
    pub(super) fn number(&mut self, parameters: &Parameters, name: &str, default: f32) -> Result<Tex, SceneError> {
        match parameters.get(name) {
            Some(found) if found.kind == "texture" => named(&self.named_textures.float, found, "float"),
            _ => Ok(Tex::Constant(Vec3::splat(parameters.float(name, default)?))),
        }
    }

    /// Sets an input of a material to a function of a texture.
    pub(super) fn set(&mut self, material: &mut Material, input: Input, tex: &Tex, convert: Convert) {
        let is_plain = |scale: &Vec3| convert.is_none() && scale.max_element() <= 1.0;
        let channel = if input.is_color() { Channel::Rgb } else { Channel::R };
        match tex {
            Tex::Constant(value) => input.set(&mut material.inputs, convert.map_or(*value, |convert| convert(*value))),
            Tex::Image { map, scale } if is_plain(scale) => {
                input.set(&mut material.inputs, *scale);
                material.add_map(map.clone(), input, channel, 0.0);
            }
            Tex::Image { map, scale } => {
                let Tex::Image { map, .. } = self.baked(map, &|texel| {
                    let value = texel * *scale;
                    convert.map_or(value, |convert| convert(value))
                }) else {
                    return;
                };
                input.set(&mut material.inputs, Vec3::ONE);
                material.add_map(map, input, channel, 0.0);
            }
        }
    }

    /// A picture with a function of each texel.
    fn baked(&mut self, map: &TextureMap, function: &dyn Fn(Vec3) -> Vec3) -> Tex {
        let texture = self.textures.list[map.texture].mapped(map.space, function);
        let texture = self.textures.add(texture);
        Tex::Image { map: TextureMap { texture, space: ColorSpace::Linear, ..map.clone() }, scale: Vec3::ONE }
    }
}

fn named(names: &BTreeMap<String, Tex>, found: &Parameter, kind: &str) -> Result<Tex, SceneError> {
    let name = match &found.values {
        Values::Words(words) => words.first().map_or("", String::as_str),
        _ => "",
    };
    names.get(name).cloned().ok_or_else(|| {
        let known: Vec<&str> = names.keys().map(String::as_str).collect();
        let remedy = match known.is_empty() {
            true => format!("define it before: `Texture {name:?} \"{kind}\" \"constant\"`"),
            false => suggestion(name, &known),
        };
        found.at.error(format!("`{}` names the {kind} texture {name:?}, which is not defined", found.name), remedy)
    })
}
