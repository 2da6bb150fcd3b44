//! Wavefront MTL: `newmtl`, `Kd`, `Ke`, `Ks`, `Ns`, `Ni`, `d`, `Tr` (1 - `d`) and `illum`.
//!
//! Deviations: texture maps are ignored, with a warning that counts them; so are all other statements, without one.
//! Reflectances and opacities outside 0..=1 are clamped with a warning. Colours as spectra or in CIE XYZ are refused.

use std::path::Path;

use glam::Vec3;

use super::model::count;
use super::statement::{Statement, statements};
use super::{Material, SceneError};

/// Appends the materials in `bytes` to `materials`, and what was skipped or changed to `warnings`.
pub(super) fn read(
    path: &Path,
    bytes: &[u8],
    materials: &mut Vec<Material>,
    warnings: &mut Vec<String>,
) -> Result<(), SceneError> {
    let known = materials.len();
    let mut maps = 0;
    let mut has_diffuse = false;
    for statement in statements(path, bytes, "an MTL file") {
        let statement = statement?;
        let keyword = statement.keyword();
        if keyword == b"newmtl" {
            // What a material leaves out is ours to choose: matte grey, but black for one that emits.
            materials.push(Material { name: statement.name(), ..Material::default() });
            has_diffuse = false;
            continue;
        }
        if is_map(keyword) {
            maps += 1;
            continue;
        }
        if !matches!(keyword, b"Kd" | b"Ke" | b"Ks" | b"Ns" | b"Ni" | b"d" | b"Tr" | b"illum") {
            continue;
        }
        let Some(material) = materials[known..].last_mut() else {
            let keyword = String::from_utf8_lossy(keyword);
            return Err(statement.error(
                format!("`{keyword}` stands before the first `newmtl`"),
                "begin each material with `newmtl` and its name",
            ));
        };
        let gloss = &mut material.gloss;
        match keyword {
            b"Kd" => {
                material.diffuse = reflectance(&statement, warnings)?;
                has_diffuse = true;
            }
            b"Ks" => gloss.specular = reflectance(&statement, warnings)?,
            b"Ke" => {
                material.emission = emission(&statement)?;
                if !has_diffuse && material.emission != Vec3::ZERO {
                    material.diffuse = Vec3::ZERO;
                }
            }
            b"Ns" => [gloss.exponent] = statement.numbers()?,
            b"Ni" => [gloss.ior] = statement.numbers()?,
            b"d" => gloss.opacity = opacity(&statement, warnings)?,
            b"Tr" => gloss.opacity = 1.0 - opacity(&statement, warnings)?,
            _ => gloss.model = illumination_model(&statement)?,
        }
    }
    if maps > 0 {
        let maps = count(maps, "texture map is", "texture maps are");
        warnings.push(format!("{}: {maps} ignored", path.display()));
    }
    Ok(())
}

fn is_map(keyword: &[u8]) -> bool {
    keyword.starts_with(b"map_") || matches!(keyword, b"bump" | b"disp" | b"decal" | b"refl" | b"norm")
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

fn opacity(statement: &Statement, warnings: &mut Vec<String>) -> Result<f32, SceneError> {
    // `d -halo 0.5` makes the opacity depend on the angle; its number is the opacity at the centre.
    let word = statement.words().find(|&word| word != b"-halo");
    let opacity = match word {
        Some(word) => statement.number(word)?,
        None => statement.numbers::<1>()?[0],
    };
    if !(0.0..=1.0).contains(&opacity) {
        warnings.push(clamp_warning(statement));
    }
    Ok(opacity.clamp(0.0, 1.0))
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
