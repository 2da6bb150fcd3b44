//! Texture statements: a key, options, and a file's name, which may hold spaces.

use std::path::Path;

use glam::{Affine2, Vec2};

use crate::scene::formats::statement::Statement;
use crate::scene::texture::{Problem, TextureStore};
use crate::scene::{Channel, ColorSpace, SceneError, TextureMap, Wrap};

/// The contents of a texture statement.
pub(super) struct Map {
    /// In lower case, as exporters differ.
    pub(super) key: String,
    file: String,
    /// `-bm`.
    pub(super) multiplier: f32,
    /// `-imfchan`.
    pub(super) channel: Option<Channel>,
    scale: Vec2,
    offset: Vec2,
    clamp: bool,
}

/// Whether a statement names a texture.
pub(super) fn is_map(keyword: &str) -> bool {
    let keyword = keyword.to_ascii_lowercase();
    keyword.starts_with("map_") || matches!(keyword.as_str(), "bump" | "disp" | "decal" | "refl" | "norm")
}

impl Map {
    pub(super) fn read(keyword: &str, statement: &Statement) -> Result<Self, SceneError> {
        let mut map = Self {
            key: keyword.to_ascii_lowercase(),
            file: String::new(),
            multiplier: 1.0,
            channel: None,
            scale: Vec2::ONE,
            offset: Vec2::ZERO,
            clamp: false,
        };
        let text = statement.name();
        let mut rest = text.as_str();
        while let Some(option) = word(rest).filter(|word| word.len() > 1 && word.starts_with('-')) {
            rest = after(rest, option);
            match option {
                "-s" => map.scale = vector(&mut rest, 1.0),
                "-o" => map.offset = vector(&mut rest, 0.0),
                "-t" => _ = vector(&mut rest, 0.0),
                "-mm" => (0..2).for_each(|_| _ = number(&mut rest)),
                _ => {
                    let value = word(rest).unwrap_or_default();
                    rest = after(rest, value);
                    match option {
                        "-bm" => map.multiplier = statement.number(value.as_bytes())?,
                        "-clamp" => map.clamp = value == "on",
                        "-imfchan" => map.channel = channel(value),
                        _ => {}
                    }
                }
            }
        }
        // Exporters on Windows write backslashes.
        map.file = rest.trim().replace('\\', "/");
        if map.file.is_empty() {
            return Err(statement.error(format!("`{keyword}` names no file"), "write the name of a texture file"));
        }
        Ok(map)
    }

    /// Reads the texture, which is sought relative to the folder of `mtl`, and without its own folder if it is not
    /// there.
    pub(super) fn load(
        &self,
        mtl: &Path,
        space: ColorSpace,
        textures: &mut TextureStore,
    ) -> Result<TextureMap, Problem> {
        let folder = mtl.parent().unwrap_or(Path::new(""));
        let (named, name) = (folder.join(&self.file), self.file.rsplit('/').next().unwrap_or_default());
        let here = folder.join(name);
        let path = if !textures.contains(&named) && textures.contains(&here) { here } else { named };
        let texture = textures.load(&path)?;
        // Offsets count upwards in MTL; v has been turned already.
        let flip = Affine2::from_scale_angle_translation(Vec2::new(1.0, -1.0), 0.0, Vec2::Y);
        let transform = flip * Affine2::from_scale_angle_translation(self.scale, 0.0, self.offset) * flip;
        let wrap = [if self.clamp { Wrap::Clamp } else { Wrap::Repeat }; 2];
        Ok(TextureMap { texture, transform, wrap, space, ..TextureMap::default() })
    }
}

fn word(text: &str) -> Option<&str> {
    text.split_whitespace().next()
}

/// What follows a word of the text, which begins with it after blanks.
fn after<'a>(text: &'a str, word: &str) -> &'a str {
    text.trim_start()[word.len()..].trim_start()
}

fn number(text: &mut &str) -> Option<f32> {
    let first = word(text)?;
    let number = first.parse().ok().filter(|number: &f32| number.is_finite())?;
    *text = after(text, first);
    Some(number)
}

/// One to three numbers, of which the third does not count.
fn vector(text: &mut &str, default: f32) -> Vec2 {
    let x = number(text).unwrap_or(default);
    let y = number(text).unwrap_or(default);
    number(text);
    Vec2::new(x, y)
}

fn channel(name: &str) -> Option<Channel> {
    match name {
        "r" => Some(Channel::R),
        "g" => Some(Channel::G),
        "b" => Some(Channel::B),
        "m" => Some(Channel::A),
        _ => None,
    }
}
