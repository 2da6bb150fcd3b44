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

mod apply;
mod maps;

use std::path::Path;

use glam::Vec3;
use toml::de::{DeTable, DeValue};

use super::table_reader::TableReader;
use super::toml_text::{Entry, entries, value_of};
use super::value::Value;
use crate::scene::error::SceneError;
use crate::scene::material::Input;
use crate::scene::nearest::suggestion;
pub(super) use apply::apply;
use maps::MapFile;

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
}

#[cfg(test)]
mod tests;
