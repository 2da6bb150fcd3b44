//! Wavefront MTL (Ramey, Rose and Tyerman 1995) with the keys that Clara.io added for physically based materials.
//!
//! | MTL | input |
//! | --- | --- |
//! | `Kd`, `map_Kd` | `base_color` |
//! | `Ks`, `map_Ks` | reflectance at normal incidence: `specular_color` by the index of refraction |
//! | `Ns`, `map_Ns` | `specular_roughness`, by α = √(2 / (Ns + 2)) |
//! | `illum` 3, 5 | a mirror with the reflectance `Ks`, unless that is black |
//! | `illum` 4, 6, 7 | glass with the index `Ni` (1.5 if it is left out) and the transmittance `Tf` (white if left out) at each surface |
//! | `d`, `Tr` (1 - `d`), `map_d` | opacity, unless it is glass |
//! | `Ke`, `map_Ke` | emission |
//! | `Pr`, `Pm`, `map_Pr`, `map_Pm` | `specular_roughness`, `base_metalness`; with these, `Ni` gives the reflectance and `Ks` none |
//! | `Ps`, `Pc`, `Pcr`, `aniso`, `anisor` | `fuzz_weight`, `coat_weight`, `coat_roughness`, anisotropy and its turn (1 for all around) |
//! | `norm`; `bump`, `map_Bump` with `-bm` | normal map; bump map, in the model's unit of length, or a normal map if it looks like one |
//!
//! Files by Blender, recognised by their first line, are read with Blender's conventions: its `Ns` is `1000 (1 -
//! roughness)²`, its `Ks` of 0.5 is a reflectance of 4%, its `illum` 3 a metal with the metalness `Ka`, its bump maps
//! are normal maps.
//!
//! Deviations: `Ka` is ignored otherwise. Of a map's options `-s`, `-o`, `-bm`, `-clamp` and `-imfchan` are read. Maps
//! of other kinds are left out with a warning, all other statements without one. Reflectances and opacities outside
//! 0..=1 are clamped with a warning. Colours as spectra or in CIE XYZ are refused.

mod finish;
mod map;

use std::path::Path;

use glam::Vec3;

use super::blocks::Block;
use super::statement::{Statement, statements};
use crate::scene::texture::TextureStore;
use crate::scene::{Material, SceneError};
use map::Map;

/// `Ks`, `Tf`, `Ns`, `Ni`, `d` and `illum`; by default a surface without gloss.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Gloss {
    specular: Vec3,
    transmittance: Vec3,
    exponent: f32,
    ior: f32,
    opacity: f32,
    model: u32,
}

impl Default for Gloss {
    fn default() -> Self {
        Self { specular: Vec3::ZERO, transmittance: Vec3::ONE, exponent: 0.0, ior: 1.0, opacity: 1.0, model: 1 }
    }
}

/// What the statements of a material say; `None` for what they leave out.
#[derive(Default)]
struct Statements {
    name: String,
    gloss: Gloss,
    ambient: Option<Vec3>,
    diffuse: Option<Vec3>,
    emission: Option<Vec3>,
    has_ior: bool,
    /// `Tf`, if it is there.
    filter: Option<Vec3>,
    roughness: Option<f32>,
    metalness: Option<f32>,
    sheen: f32,
    coat: f32,
    coat_roughness: f32,
    anisotropy: f32,
    rotation: f32,
    maps: Vec<Map>,
}

/// Appends the materials in `bytes` to `materials`, their textures to `textures`, and what was skipped or changed to
/// `warnings`.
pub(super) fn read(
    path: &Path,
    bytes: &[u8],
    materials: &mut Vec<Material>,
    textures: &mut TextureStore,
    warnings: &mut Vec<String>,
) -> Result<(), SceneError> {
    let is_blender = bytes.trim_ascii_start().starts_with(b"# Blender");
    let mut current: Option<Statements> = None;
    for statement in statements(path, Block::whole(bytes), "an MTL file") {
        let statement = statement?;
        if statement.keyword() == b"newmtl" {
            let next = Statements { name: statement.name(), ..Statements::default() };
            if let Some(finished) = current.replace(next) {
                materials.push(finished.finish(path, is_blender, textures, warnings));
            }
            continue;
        }
        let keyword = String::from_utf8_lossy(statement.keyword()).into_owned();
        let is_map = map::is_map(&keyword);
        if !is_map && !KEYWORDS.contains(&keyword.as_str()) {
            continue;
        }
        let Some(material) = &mut current else {
            return Err(statement.error(
                format!("`{keyword}` stands before the first `newmtl`"),
                "begin each material with `newmtl` and its name",
            ));
        };
        if is_map {
            material.maps.push(Map::read(&keyword, &statement)?);
        } else {
            material.take(&keyword, &statement, warnings)?;
        }
    }
    if let Some(last) = current {
        materials.push(last.finish(path, is_blender, textures, warnings));
    }
    Ok(())
}

/// Statements that are read, besides maps.
const KEYWORDS: [&str; 17] =
    ["Ka", "Kd", "Ke", "Ks", "Tf", "Ns", "Ni", "d", "Tr", "illum", "Pr", "Pm", "Ps", "Pc", "Pcr", "aniso", "anisor"];

impl Statements {
    fn take(&mut self, keyword: &str, statement: &Statement, warnings: &mut Vec<String>) -> Result<(), SceneError> {
        let gloss = &mut self.gloss;
        match keyword {
            "Ka" => self.ambient = colour(statement).ok(),
            "Kd" => self.diffuse = Some(reflectance(statement, warnings)?),
            "Ks" => gloss.specular = reflectance(statement, warnings)?,
            "Tf" => {
                gloss.transmittance = reflectance(statement, warnings)?;
                self.filter = Some(gloss.transmittance);
            }
            "Ke" => self.emission = Some(emission(statement)?),
            "Ns" => {
                let [exponent] = statement.numbers()?;
                if exponent < 0.0 {
                    warnings
                        .push(statement.warning(format_args!("`Ns` is {exponent}, less than 0, and is taken for 0")));
                }
                gloss.exponent = exponent.max(0.0);
            }
            "Ni" => {
                [gloss.ior] = statement.numbers()?;
                self.has_ior = true;
            }
            "d" => gloss.opacity = part(statement, warnings)?,
            "Tr" => gloss.opacity = 1.0 - part(statement, warnings)?,
            "Pr" => self.roughness = Some(part(statement, warnings)?),
            "Pm" => self.metalness = Some(part(statement, warnings)?),
            "Ps" => self.sheen = part(statement, warnings)?,
            "Pc" => self.coat = part(statement, warnings)?,
            "Pcr" => self.coat_roughness = part(statement, warnings)?,
            "aniso" => self.anisotropy = part(statement, warnings)?,
            "anisor" => [self.rotation] = statement.numbers()?,
            _ => gloss.model = illumination_model(statement)?,
        }
        Ok(())
    }
}

/// Three numbers, or one that stands for all three.
fn colour(statement: &Statement) -> Result<Vec3, SceneError> {
    let other_space = match statement.words().next() {
        Some(b"spectral") => Some("spectral colours are not read"),
        Some(b"xyz") => Some("CIE XYZ colours are not read"),
        _ => None,
    };
    if let Some(problem) = other_space {
        return Err(statement.error(problem, "write three numbers, for red, green and blue"));
    }
    if statement.words().count() == 1 {
        return Ok(Vec3::splat(statement.numbers::<1>()?[0]));
    }
    statement.numbers().map(Vec3::from_array)
}

fn reflectance(statement: &Statement, warnings: &mut Vec<String>) -> Result<Vec3, SceneError> {
    let colour = colour(statement)?;
    let clamped = colour.clamp(Vec3::ZERO, Vec3::ONE);
    if clamped != colour {
        warnings.push(clamp_warning(statement));
    }
    Ok(clamped)
}

/// A number from 0 to 1.
fn part(statement: &Statement, warnings: &mut Vec<String>) -> Result<f32, SceneError> {
    // `d -halo 0.5` makes the opacity depend on the angle; its number is the opacity at the centre.
    let word = statement.words().find(|&word| word != b"-halo");
    let part = match word {
        Some(word) => statement.number(word)?,
        None => statement.numbers::<1>()?[0],
    };
    if !(0.0..=1.0).contains(&part) {
        warnings.push(clamp_warning(statement));
    }
    Ok(part.clamp(0.0, 1.0))
}

fn clamp_warning(statement: &Statement) -> String {
    let keyword = String::from_utf8_lossy(statement.keyword());
    statement.warning(format_args!("`{keyword}` is outside 0 to 1 and is clamped"))
}

fn emission(statement: &Statement) -> Result<Vec3, SceneError> {
    let colour = colour(statement)?;
    if colour.min_element() < 0.0 {
        return Err(statement.error("`Ke` is negative", "write the emitted radiance as numbers that are 0 or more"));
    }
    Ok(colour)
}

fn illumination_model(statement: &Statement) -> Result<u32, SceneError> {
    let [number] = statement.numbers()?;
    if number.fract() != 0.0 || !(0.0..=10.0).contains(&number) {
        return Err(
            statement.error(format!("there is no illumination model {number}"), "write a whole number from 0 to 10")
        );
    }
    Ok(number as u32)
}

#[cfg(test)]
mod tests;
