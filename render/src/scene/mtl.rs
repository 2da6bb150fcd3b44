//! Wavefront MTL: `newmtl`, `Kd`, `Ke`, `Ks`, `Tf`, `Ns`, `Ni`, `d`, `Tr` (1 - `d`) and `illum`.
//!
//! The illumination models 3 and 5 are mirrors with the reflectance `Ks`, unless that is black; 4, 6 and 7 are glass with
//! the index `Ni` (1.5 if it is left out) and the transmittance `Tf` (white if it is left out). All others are matte.
//!
//! Deviations: texture maps are ignored, with a warning that counts them; so are all other statements, without one.
//! Reflectances and opacities outside 0..=1 are clamped with a warning. Colours as spectra or in CIE XYZ are refused.

use std::path::Path;

use glam::Vec3;

use super::error::count;
use super::statement::{Statement, statements};
use super::{Gloss, Material, SceneError, Specular};

/// Appends the materials in `bytes` to `materials`, and what was skipped or changed to `warnings`.
pub(super) fn read(
    path: &Path,
    bytes: &[u8],
    materials: &mut Vec<Material>,
    warnings: &mut Vec<String>,
) -> Result<(), SceneError> {
    let known = materials.len();
    let mut maps = 0;
    let (mut has_diffuse, mut has_ior) = (false, false);
    for statement in statements(path, bytes, "an MTL file") {
        let statement = statement?;
        let keyword = statement.keyword();
        if keyword == b"newmtl" {
            if let Some(finished) = materials[known..].last_mut() {
                make_specular(path, finished, has_ior, warnings);
            }
            // What a material leaves out is ours to choose: matte grey, but black for one that emits.
            materials.push(Material { name: statement.name(), ..Material::default() });
            (has_diffuse, has_ior) = (false, false);
            continue;
        }
        if is_map(keyword) {
            maps += 1;
            continue;
        }
        if !matches!(keyword, b"Kd" | b"Ke" | b"Ks" | b"Tf" | b"Ns" | b"Ni" | b"d" | b"Tr" | b"illum") {
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
            b"Tf" => gloss.transmittance = reflectance(&statement, warnings)?,
            b"Ke" => {
                material.emission = emission(&statement)?;
                if !has_diffuse && material.emission != Vec3::ZERO {
                    material.diffuse = Vec3::ZERO;
                }
            }
            b"Ns" => [gloss.exponent] = statement.numbers()?,
            b"Ni" => {
                [gloss.ior] = statement.numbers()?;
                has_ior = true;
            }
            b"d" => gloss.opacity = opacity(&statement, warnings)?,
            b"Tr" => gloss.opacity = 1.0 - opacity(&statement, warnings)?,
            _ => gloss.model = illumination_model(&statement)?,
        }
    }
    if let Some(last) = materials[known..].last_mut() {
        make_specular(path, last, has_ior, warnings);
    }
    if maps > 0 {
        let maps = count(maps, "texture map is", "texture maps are");
        warnings.push(format!("{}: {maps} ignored", path.display()));
    }
    Ok(())
}

/// Makes a material the mirror or glass that its illumination model stands for, now that all of it is read.
fn make_specular(path: &Path, material: &mut Material, has_ior: bool, warnings: &mut Vec<String>) {
    let Gloss { specular, transmittance, mut ior, model, .. } = material.gloss;
    let mut warn = |what: &str| warnings.push(format!("{}: material {:?}: {what}", path.display(), material.name));
    match model {
        3 | 5 if specular != Vec3::ZERO => {
            let rest = material.diffuse.min(Vec3::ONE - specular);
            if rest != material.diffuse {
                warn("`Kd` and `Ks` add up to more than 1; `Kd` is reduced");
            }
            (material.specular, material.diffuse) = (Specular::Mirror { reflectance: specular }, rest);
        }
        4 | 6 | 7 => {
            if has_ior && ior <= 0.0 {
                warn(&format!("an index of refraction of {ior} is no glass's; {GLASS_IOR} is used"));
            }
            if !has_ior || ior <= 0.0 {
                ior = GLASS_IOR;
            }
            (material.specular, material.diffuse) = (Specular::Glass { ior, transmittance }, Vec3::ZERO);
        }
        _ => {}
    }
}

/// The index of refraction of glass that does not say.
const GLASS_IOR: f32 = 1.5;

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
