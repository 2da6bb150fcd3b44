//! `KHR_materials_variants`: other materials for primitives, by name.

use ::gltf::json::Value;
use ::gltf::json::mesh::Primitive;
use serde::Deserialize;

use super::Document;
use crate::scene::{SceneError, Variant};

const NAME: &str = "KHR_materials_variants";

#[derive(Deserialize)]
struct Root {
    variants: Vec<Named>,
}

#[derive(Deserialize)]
struct Named {
    name: String,
}

#[derive(Deserialize)]
struct Mappings {
    mappings: Vec<Mapping>,
}

#[derive(Deserialize)]
struct Mapping {
    material: usize,
    variants: Vec<usize>,
}

/// The file's variants, without materials yet.
pub(super) fn names(document: &Document) -> Result<Vec<Variant>, SceneError> {
    let extensions = document.root.extensions.as_ref();
    let Some(value) = extensions.and_then(|extensions| extensions.others.get(NAME)) else { return Ok(Vec::new()) };
    let Root { variants } = parse(document, "the file", value)?;
    Ok(variants.into_iter().map(|Named { name }| Variant { name, materials: Vec::new() }).collect())
}

/// Adds what the primitive at `place`, which is mesh `mesh` of the scene, has for variants.
pub(super) fn add(
    document: &Document,
    primitive: &Primitive,
    place: &str,
    mesh: usize,
    variants: &mut [Variant],
) -> Result<(), SceneError> {
    let extensions = primitive.extensions.as_ref();
    let Some(value) = extensions.and_then(|extensions| extensions.others.get(NAME)) else { return Ok(()) };
    let Mappings { mappings } = parse(document, place, value)?;
    for Mapping { material, variants: numbers } in mappings {
        let materials = document.root.materials.len();
        if material >= materials {
            let problem = format!("its {NAME} refers to material {material}, which does not exist");
            return Err(document.error(place, problem, "refer to one that the file has, counted from 0"));
        }
        for number in numbers {
            let Some(variant) = variants.get_mut(number) else {
                let problem = format!("its {NAME} refers to variant {number}, which does not exist");
                return Err(document.error(place, problem, "refer to one that the file has, counted from 0"));
            };
            variant.materials.push((mesh, material));
        }
    }
    Ok(())
}

fn parse<T: serde::de::DeserializeOwned>(document: &Document, place: &str, value: &Value) -> Result<T, SceneError> {
    T::deserialize(value).map_err(|error| {
        let remedy = format!("write it as the specification of {NAME} has it");
        document.error(place, format!("its {NAME} is wrong: {error}"), remedy)
    })
}
