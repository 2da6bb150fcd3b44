//! `[[material]]` in scene files: OpenPBR's parameters for a material of the model, or for a new one.
//!
//! ```toml
//! [[material]]
//! name = "floor"                     # of the model; or a new one, for the meshes that are named
//! meshes = ["Floor", "Stairs"]
//! base_color = [0.8, 0.7, 0.6]       # linear; any input of a closure by its name
//! specular_roughness = 0.4
//! base_color_map = "wood.png"        # multiplies it; relative to the folder of this file
//! specular_roughness_map = { file = "wood.png", channel = "g", wrap = "clamp", set = 1, scale = [2, 2] }
//! geometry_normal_map = { file = "wood_n.png", strength = 0.5, green = "down" }
//! geometry_coat_normal_map = "flakes_n.png"
//! geometry_bump_map = { file = "height.png", height = 0.01 }
//! geometry_opacity = 0.5             # with geometry_opacity_cutoff it is a mask
//! geometry_thin_walled = true
//! emission_color = [1, 0.5, 0.2]
//! emission_luminance = 10            # W/(m² sr), as all radiance here
//! light_group = "key"                # of its emission; by default the mesh's name
//! transmission_depth = 0.1           # where transmission_color is reached inside; without it the surface is tinted
//! transmission_dispersion_abbe_number = 36   # of solid glass: how little it spreads colours
//! ```
//!
//! Inputs that are not named keep the model's values. A map of `"none"` removes the model's; without one of its own a
//! coat has the base's normals, with `"none"` those of the vertices.

use std::path::{Path, PathBuf};

use glam::{Affine2, Vec2, Vec3};
use toml::de::{DeTable, DeValue};

use super::error::{Place, SceneError};
use super::files::Disk;
use super::files::Recorded;
use super::material::{BumpMap, Channel, CoatNormal, Input, Material, NormalMap, Opacity};
use super::nearest::suggestion;
use super::table_reader::TableReader;
use super::texture::{ColorSpace, TextureFilter, TextureMap, TextureStore, Wrap};
use super::toml_text::{Entry, entries, value_of};
use super::value::Value;
use super::{Scene, description::Mesh};

/// A `[[material]]` table.
#[derive(Clone, Debug, PartialEq)]
pub struct MaterialTable {
    name: String,
    line: usize,
    meshes: Vec<String>,
    changes: Vec<(usize, Change)>,
}

/// The input of a key.
#[derive(Clone, Debug, PartialEq)]
enum Change {
    Input(Input, Vec3),
    Map(Target, Box<MapFile>),
    Opacity(f32),
    Cutoff(f32),
    ThinWalled(bool),
    EmissionColor(Vec3),
    EmissionLuminance(f32),
    TransmissionDepth(f32),
    AbbeNumber(f32),
    LightGroup(String),
    /// Degrees.
    TangentRotation(f32),
    NoMap(Target),
}

/// The input of a map.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Target {
    Input(Input),
    Emission,
    Opacity,
    Normal,
    CoatNormal,
    Bump,
}

/// A texture file with all that may be said of it.
#[derive(Clone, Debug, PartialEq)]
struct MapFile {
    file: PathBuf,
    channel: Option<Channel>,
    set: u32,
    wrap: Wrap,
    filter: TextureFilter,
    space: Option<ColorSpace>,
    scale: Vec2,
    offset: Vec2,
    rotation: f32,
    zero: f32,
    strength: f32,
    green_is_down: bool,
    height: f32,
}

impl MapFile {
    fn normal_map(&self, texture: TextureMap) -> NormalMap {
        let scale = self.strength * Vec2::new(1.0, if self.green_is_down { -1.0 } else { 1.0 });
        NormalMap { texture, scale }
    }
}

/// Keys besides the inputs and their maps.
const KEYS: [&str; 18] = [
    "light_group",
    "name",
    "meshes",
    "geometry_opacity",
    "geometry_opacity_map",
    "geometry_opacity_cutoff",
    "geometry_thin_walled",
    "geometry_normal_map",
    "geometry_coat_normal_map",
    "geometry_bump_map",
    "geometry_tangent_rotation",
    "emission_color",
    "emission_color_map",
    "emission_luminance",
    "transmission_depth",
    "transmission_dispersion_abbe_number",
    "base_weight",
    "specular_anisotropy",
];

/// Keys of a map.
const MAP_KEYS: [&str; 13] = [
    "file", "channel", "set", "wrap", "filter", "space", "scale", "offset", "rotation", "zero", "strength", "green",
    "height",
];

/// The tables in an array called `material`, of a scene file at `path` with this text.
pub(super) fn read(path: &Path, text: &str, tables: &DeValue<'_>, at: usize) -> Result<Vec<MaterialTable>, SceneError> {
    let reader = Reader(TableReader { path, text, name: "material" });
    reader.0.tables(tables, at, |table, at| reader.table(table, at))
}

struct Reader<'a>(TableReader<'a>);

impl Reader<'_> {
    fn table(&self, table: &DeTable<'_>, at: usize) -> Result<MaterialTable, SceneError> {
        let line = self.0.line(at);
        let mut it = MaterialTable { name: String::new(), line, meshes: Vec::new(), changes: Vec::new() };
        for entry in entries(table) {
            let line = self.0.line(entry.at.start);
            match entry.name {
                "name" => it.name = self.0.text_of(&entry)?,
                "meshes" => it.meshes = self.names(&entry)?,
                _ => it.changes.push((line, self.change(&entry)?)),
            }
        }
        if it.name.is_empty() {
            return Err(self.0.error(
                at,
                "this material has no name",
                "write name = \"…\" with the model's name for it",
            ));
        }
        Ok(it)
    }

    fn change(&self, entry: &Entry<'_>) -> Result<Change, SceneError> {
        let unit = |least: f32, greatest: f32| self.0.number(entry, least, greatest);
        Ok(match entry.name {
            "geometry_opacity" => Change::Opacity(unit(0.0, 1.0)?),
            "geometry_opacity_cutoff" => Change::Cutoff(unit(0.0, 1.0)?),
            "geometry_thin_walled" => Change::ThinWalled(self.0.flag(entry)?),
            "geometry_tangent_rotation" => Change::TangentRotation(unit(f32::MIN, f32::MAX)?),
            "emission_color" => Change::EmissionColor(self.0.color(entry, 0.0, f32::MAX)?),
            "emission_luminance" => Change::EmissionLuminance(unit(0.0, f32::MAX)?),
            "light_group" => Change::LightGroup(self.0.text_of(entry)?),
            "transmission_depth" => Change::TransmissionDepth(unit(f32::MIN_POSITIVE, f32::MAX)?),
            "transmission_dispersion_abbe_number" => Change::AbbeNumber(unit(1.0, f32::MAX)?),
            "geometry_normal_map" => self.map_change(Target::Normal, entry)?,
            "geometry_coat_normal_map" => self.map_change(Target::CoatNormal, entry)?,
            "geometry_bump_map" => self.map_change(Target::Bump, entry)?,
            "geometry_opacity_map" => self.map_change(Target::Opacity, entry)?,
            "emission_color_map" => self.map_change(Target::Emission, entry)?,
            name => {
                let (input, is_map) = name.strip_suffix("_map").map_or((name, false), |input| (input, true));
                let Some(input) = Input::ALL.into_iter().find(|it| it.name() == input) else {
                    let known: Vec<&str> = Input::ALL.iter().map(|it| it.name()).chain(KEYS).collect();
                    let problem = format!("unknown key {name:?} in [[material]]");
                    return Err(self.0.error(entry.at.start, problem, suggestion(name, &known)));
                };
                if is_map {
                    return self.map_change(Target::Input(input), entry);
                }
                let range = input.range();
                match input.is_color() {
                    true => Change::Input(input, self.0.color(entry, range.least, range.greatest)?),
                    false => Change::Input(input, Vec3::splat(self.0.number(entry, range.least, range.greatest)?)),
                }
            }
        })
    }

    fn names(&self, entry: &Entry<'_>) -> Result<Vec<String>, SceneError> {
        let Value::List(values) = value_of(entry.value) else { return self.0.wrong(entry, "a list of names") };
        let name = |value| match value {
            Value::Text(text) => Ok(text),
            _ => self.0.wrong(entry, "a list of names"),
        };
        values.into_iter().map(name).collect()
    }

    fn map_change(&self, target: Target, entry: &Entry<'_>) -> Result<Change, SceneError> {
        let is_none = matches!(entry.value, DeValue::String(text) if text == "none");
        Ok(if is_none { Change::NoMap(target) } else { Change::Map(target, self.map(entry)?) })
    }

    fn map(&self, entry: &Entry<'_>) -> Result<Box<MapFile>, SceneError> {
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

const CHANNELS: [(&str, Channel); 5] =
    [("rgb", Channel::Rgb), ("r", Channel::R), ("g", Channel::G), ("b", Channel::B), ("a", Channel::A)];
const WRAPS: [(&str, Wrap); 3] = [("repeat", Wrap::Repeat), ("mirror", Wrap::Mirror), ("clamp", Wrap::Clamp)];
const FILTERS: [(&str, TextureFilter); 2] =
    [("bilinear", TextureFilter::Bilinear), ("nearest", TextureFilter::Nearest)];
const SPACES: [(&str, ColorSpace); 2] = [("srgb", ColorSpace::Srgb), ("linear", ColorSpace::Linear)];

/// Does to the scene what the tables of the scene file at `path` say. Those whose names are `used` may be new ones.
pub(super) fn apply(tables: &[MaterialTable], used: &[&str], path: &Path, scene: &mut Scene) -> Result<(), SceneError> {
    let files = Recorded::new(&Disk);
    let mut store = TextureStore::new(&files, core::mem::take(&mut scene.textures));
    for table in tables {
        let number = table.material(used, path, scene)?;
        for (line, change) in &table.changes {
            let material = &mut scene.materials[number];
            material.change(change, &mut store).map_err(|(problem, remedy)| {
                let problem = format!("material {:?}: {problem}", table.name);
                SceneError::new(path, Place::Line(*line), problem, remedy)
            })?;
        }
    }
    scene.textures = store.list;
    scene.files.extend(files.into_paths());
    Ok(())
}

impl MaterialTable {
    /// The number of the material that is meant, which becomes that of the meshes that are named.
    fn material(&self, used: &[&str], path: &Path, scene: &mut Scene) -> Result<usize, SceneError> {
        let error = |problem, remedy| Err(SceneError::new(path, Place::Line(self.line), problem, remedy));
        let known = scene.materials.iter().position(|material| material.name == self.name);
        if known.is_none() && self.meshes.is_empty() && !used.contains(&self.name.as_str()) {
            let names: Vec<&str> = scene.materials.iter().map(|material| material.name.as_str()).collect();
            let problem = format!("the model has no material {:?}", self.name);
            return error(problem, format!("a new one names its meshes = [\"…\"]; {}", suggestion(&self.name, &names)));
        }
        let number = known.unwrap_or_else(|| {
            let inputs = crate::material::Inputs { specular_weight: 1.0, ..Default::default() };
            scene.materials.push(Material { name: self.name.clone(), inputs, ..Material::default() });
            scene.materials.len() - 1
        });
        for name in &self.meshes {
            let named = |mesh: &&mut Mesh| mesh.name == *name;
            let mut found = false;
            for mesh in scene.meshes.iter_mut().filter(named) {
                (mesh.material, found) = (number, true);
            }
            if !found {
                let names: Vec<&str> = scene.meshes.iter().map(|mesh| mesh.name.as_str()).collect();
                let problem = format!("material {:?}: the model has no mesh {name:?}", self.name);
                return error(problem, suggestion(name, &names));
            }
        }
        Ok(number)
    }
}

impl Material {
    fn change(&mut self, change: &Change, store: &mut TextureStore) -> Result<(), (String, String)> {
        match *change {
            Change::Input(input, value) => {
                input.set(&mut self.inputs, value);
                match input {
                    Input::TransmissionColor => self.base_color_tints_transmission = false,
                    Input::SpecularAnisotropy | Input::SpecularRoughness => self.anisotropy = None,
                    _ => {}
                }
            }
            Change::LightGroup(ref group) => self.light_group = group.clone(),
            Change::Opacity(value) => self.opacity.value = value,
            Change::Cutoff(cutoff) => self.opacity.cutoff = Some(cutoff),
            Change::ThinWalled(thin) => self.inputs.thin_walled = thin,
            Change::EmissionColor(color) => {
                let luminance = self.emission.max_element();
                self.emission = color * if luminance > 0.0 { luminance } else { 1.0 };
            }
            Change::EmissionLuminance(luminance) => {
                let greatest = self.emission.max_element();
                let color = if greatest > 0.0 { self.emission / greatest } else { Vec3::ONE };
                self.emission = color * luminance;
            }
            Change::TransmissionDepth(depth) => {
                let color = self.inputs.transmission_color.max(Vec3::splat(1e-6));
                self.inputs.absorption = -color.map(f32::ln) / depth;
                (self.inputs.transmission_color, self.base_color_tints_transmission) = (Vec3::ONE, false);
            }
            Change::AbbeNumber(abbe) => self.dispersion = 20.0 / abbe,
            Change::TangentRotation(degrees) => self.tangent_rotation = degrees.to_radians(),
            Change::NoMap(target) => self.remove(target),
            Change::Map(target, ref map) => self.map(target, map, store)?,
        }
        Ok(())
    }

    fn remove(&mut self, target: Target) {
        match target {
            Target::Input(input) => self.remove_map(input),
            Target::Emission => self.emission_map = None,
            Target::Opacity => self.opacity.map = None,
            Target::Normal => self.normal_map = None,
            Target::CoatNormal => self.coat_normal = CoatNormal::OfVertices,
            Target::Bump => self.bump_map = None,
        }
    }

    fn map(&mut self, target: Target, map: &MapFile, store: &mut TextureStore) -> Result<(), (String, String)> {
        let texture = store.load(&map.file).map_err(|it| (it.problem, it.remedy))?;
        let is_color = matches!(target, Target::Emission) || matches!(target, Target::Input(input) if input.is_color());
        let space = map.space.unwrap_or(if is_color { ColorSpace::Srgb } else { ColorSpace::Linear });
        let transform = Affine2::from_scale_angle_translation(map.scale, -map.rotation.to_radians(), map.offset);
        let texture = TextureMap { texture, set: map.set, transform, wrap: [map.wrap; 2], filter: map.filter, space };
        let channel = map.channel.unwrap_or(if is_color { Channel::Rgb } else { Channel::R });
        match target {
            Target::Input(input) => self.add_map(texture, input, channel, map.zero),
            Target::Emission => self.emission_map = Some(texture),
            Target::Opacity => {
                let map = Some((texture, map.channel.unwrap_or(Channel::A)));
                self.opacity = Opacity { map, ..self.opacity.clone() };
            }
            Target::Normal => self.normal_map = Some(map.normal_map(texture)),
            Target::CoatNormal => self.coat_normal = CoatNormal::Map(map.normal_map(texture)),
            Target::Bump => self.bump_map = Some(BumpMap { texture, channel, height: map.height }),
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests;
