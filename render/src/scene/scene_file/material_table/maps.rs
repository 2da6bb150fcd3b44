//! Maps of materials: a picture's name, or a table of one.

use std::path::PathBuf;

use glam::Vec2;
use toml::de::DeValue;

use super::Reader;
use crate::scene::error::SceneError;
use crate::scene::material::{Channel, NormalMap};
use crate::scene::nearest::suggestion;
use crate::scene::scene_file::toml_text::{Entry, entries, value_of};
use crate::scene::scene_file::value::Value;
use crate::scene::texture::{ColorSpace, TextureFilter, TextureMap, Wrap};

/// A texture file with all that may be said of it.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct MapFile {
    pub(super) file: PathBuf,
    pub(super) channel: Option<Channel>,
    pub(super) set: u32,
    pub(super) wrap: Wrap,
    pub(super) filter: TextureFilter,
    pub(super) space: Option<ColorSpace>,
    pub(super) scale: Vec2,
    pub(super) offset: Vec2,
    pub(super) rotation: f32,
    pub(super) zero: f32,
    pub(super) strength: f32,
    pub(super) green_is_down: bool,
    pub(super) height: f32,
}

impl MapFile {
    pub(super) fn normal_map(&self, texture: TextureMap) -> NormalMap {
        let scale = self.strength * Vec2::new(1.0, if self.green_is_down { -1.0 } else { 1.0 });
        NormalMap { texture, scale }
    }
}

/// Keys of a map.
const MAP_KEYS: [&str; 13] = [
    "file", "channel", "set", "wrap", "filter", "space", "scale", "offset", "rotation", "zero", "strength", "green",
    "height",
];

const CHANNELS: [(&str, Channel); 5] =
    [("rgb", Channel::Rgb), ("r", Channel::R), ("g", Channel::G), ("b", Channel::B), ("a", Channel::A)];
const WRAPS: [(&str, Wrap); 3] = [("repeat", Wrap::Repeat), ("mirror", Wrap::Mirror), ("clamp", Wrap::Clamp)];
const FILTERS: [(&str, TextureFilter); 2] =
    [("bilinear", TextureFilter::Bilinear), ("nearest", TextureFilter::Nearest)];
const SPACES: [(&str, ColorSpace); 2] = [("srgb", ColorSpace::Srgb), ("linear", ColorSpace::Linear)];

impl Reader<'_> {
    pub(super) fn map(&self, entry: &Entry<'_>) -> Result<Box<MapFile>, SceneError> {
        let mut map = MapFile {
            file: PathBuf::new(),
            channel: None,
            set: 0,
            wrap: Wrap::Repeat,
            filter: TextureFilter::Bilinear,
            space: None,
            scale: Vec2::ONE,
            offset: Vec2::ZERO,
            rotation: 0.0,
            zero: 0.0,
            strength: 1.0,
            green_is_down: false,
            height: 1.0,
        };
        match entry.value {
            DeValue::String(_) => map.file = self.0.file(entry)?,
            DeValue::Table(table) => {
                for part in entries(table) {
                    self.map_part(&mut map, &part)?;
                }
            }
            _ => return self.0.wrong(entry, "the name of a file, or { file = \"…\", … }"),
        }
        if map.file.as_os_str().is_empty() {
            return self.0.wrong(entry, "{ file = \"…\", … }");
        }
        Ok(Box::new(map))
    }

    fn map_part(&self, map: &mut MapFile, part: &Entry<'_>) -> Result<(), SceneError> {
        match part.name {
            "file" => map.file = self.0.file(part)?,
            "channel" => map.channel = Some(self.0.one_of(part, &CHANNELS)?),
            "set" => map.set = self.one_of_numbers(part)?,
            "wrap" => map.wrap = self.0.one_of(part, &WRAPS)?,
            "filter" => map.filter = self.0.one_of(part, &FILTERS)?,
            "space" => map.space = Some(self.0.one_of(part, &SPACES)?),
            "scale" => map.scale = self.0.pair(part, "two numbers, across and down")?,
            "offset" => map.offset = self.0.pair(part, "two numbers, across and down")?,
            "rotation" => map.rotation = self.0.number(part, f32::MIN, f32::MAX)?,
            "zero" => map.zero = self.0.number(part, 0.0, f32::MAX)?,
            "strength" => map.strength = self.0.number(part, f32::MIN, f32::MAX)?,
            "green" => map.green_is_down = self.0.one_of(part, &[("up", false), ("down", true)])?,
            "height" => map.height = self.0.number(part, f32::MIN, f32::MAX)?,
            name => {
                let problem = format!("unknown key {name:?} of a map");
                return Err(self.0.error(part.at.start, problem, suggestion(name, &MAP_KEYS)));
            }
        }
        Ok(())
    }

    fn one_of_numbers(&self, entry: &Entry<'_>) -> Result<u32, SceneError> {
        match value_of(entry.value) {
            Value::Integer(set @ 0..=1) => Ok(set as u32),
            _ => self.0.wrong(entry, "0 or 1, the number of a set of texture coordinates"),
        }
    }
}
