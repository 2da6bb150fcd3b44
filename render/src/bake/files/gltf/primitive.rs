//! A mesh's primitive with lightmap coordinates.

use serde_json::Value;

use super::data::Data;
use super::{Part, text};
use crate::scene::SceneError;
use crate::scene::formats::gltf::Document;

/// Holds all of a primitive's attributes in a form of its own, which would hide the new ones.
const DRACO: &str = "KHR_draco_mesh_compression";

/// The primitive of this text for one part of it; `is_all` if it is the only one. `place` names it in errors.
pub(super) fn with_lightmap(
    document: &Document,
    data: &mut Data,
    old: &str,
    part: &Part,
    is_all: bool,
    place: &str,
) -> Result<String, SceneError> {
    let mesh = part.mesh;
    let is_same = is_all
        && part.triangles == mesh.triangles
        && part.sources.len() == mesh.positions.len()
        && part.sources.iter().zip(0..).all(|(&source, vertex)| source == vertex);
    if is_same && part.uvs == mesh.lightmap_texcoords {
        return Ok(old.to_owned());
    }
    check_material(document, part)?;
    let mut new = old.to_owned();
    let mut attributes = text::member(old, "attributes").unwrap_or("{}").to_owned();
    if !is_same {
        attributes = gathered(document, data, &attributes, part, place)?;
        if let Some(targets) = text::member(old, "targets") {
            let targets = text::elements(targets).into_iter();
            let targets = targets.map(|target| gathered(document, data, target, part, place));
            let targets: Vec<String> = targets.collect::<Result<_, _>>()?;
            new = text::set(&new, "targets", &format!("[{}]", targets.join(",")));
        }
        let mirrored = mesh.origin.is_some_and(|origin| origin.mirrored);
        let in_order = |&[a, b, c]: &[u32; 3]| if mirrored { [a, c, b] } else { [a, b, c] };
        let indices = data.indices(part.triangles.iter().flat_map(in_order));
        new = text::set(&new, "indices", &indices.to_string());
        if text::member(&new, "mode").is_some() {
            const TRIANGLES: &str = "4";
            new = text::set(&new, "mode", TRIANGLES);
        }
    }
    let texcoords = data.texcoords(part.uvs).to_string();
    // Sets are numbered without gaps.
    if text::member(&attributes, "TEXCOORD_0").is_none() {
        attributes = text::set(&attributes, "TEXCOORD_0", &texcoords);
    }
    attributes = text::set(&attributes, "TEXCOORD_1", &texcoords);
    new = text::set(&new, "attributes", &attributes);
    if let Some(extensions) = text::member(&new, "extensions").filter(|all| text::member(all, DRACO).is_some()) {
        new = text::set(&new, "extensions", &text::without(extensions, DRACO));
    }
    Ok(new)
}

/// `attributes` with accessors of the part's vertices.
fn gathered(
    document: &Document,
    data: &mut Data,
    attributes: &str,
    part: &Part,
    place: &str,
) -> Result<String, SceneError> {
    let mut new = attributes.to_owned();
    for (name, index) in text::members(attributes) {
        // The lightmap's own are new.
        if let Ok(index) = index.parse()
            && name != "TEXCOORD_1"
        {
            let gathered = data.gather(document, index, part.sources, place, name == "POSITION")?;
            new = text::set(&new, &name, &gathered.to_string());
        }
    }
    Ok(new)
}

/// Refuses a material with textures that need the coordinates which the lightmap's replace.
fn check_material(document: &Document, part: &Part) -> Result<(), SceneError> {
    let Some(material) = document.root.materials.get(part.mesh.material) else { return Ok(()) };
    if !part.mesh.lightmap_texcoords.is_empty() && serde_json::to_value(material).is_ok_and(|it| uses_second_set(&it)) {
        return Err(document.error(
            format!("material {}", part.mesh.material),
            "it has a texture that uses TEXCOORD_1, which the lightmap needs",
            "let the texture use TEXCOORD_0, or make TEXCOORD_1 fit for a lightmap",
        ));
    }
    Ok(())
}

fn uses_second_set(value: &Value) -> bool {
    match value {
        Value::Object(members) => members.iter().any(|(name, value)| match name.as_str() {
            "texCoord" => *value == 1,
            "extras" => false,
            _ => uses_second_set(value),
        }),
        Value::Array(elements) => elements.iter().any(uses_second_set),
        _ => false,
    }
}
