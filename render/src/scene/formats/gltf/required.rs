//! Extensions that files require or use: which are read, which stand in the way, which are told of.

use std::path::Path;

use ::gltf::json::Root;

use crate::scene::formats::notes::Notes;
use crate::scene::{Place, SceneError};

/// What is read, or is here for programs that edit the file.
const KNOWN: [&str; 25] = [
    "EXT_lights_ies",
    "EXT_mesh_gpu_instancing",
    "EXT_meshopt_compression",
    "EXT_texture_webp",
    "KHR_draco_mesh_compression",
    "KHR_lights_punctual",
    "KHR_materials_anisotropy",
    "KHR_materials_clearcoat",
    "KHR_materials_diffuse_transmission",
    "KHR_materials_dispersion",
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
    "KHR_materials_iridescence",
    "KHR_materials_pbrSpecularGlossiness",
    "KHR_materials_sheen",
    "KHR_materials_specular",
    "KHR_materials_transmission",
    "KHR_materials_unlit",
    "KHR_materials_variants",
    "KHR_materials_volume",
    "KHR_mesh_quantization",
    "KHR_texture_basisu",
    "KHR_texture_transform",
    "KHR_xmp",
    "KHR_xmp_json_ld",
];

/// Those whose geometry is not where accessors and nodes say: files with them are read, but not edited.
pub(super) const NOT_EDITED: [&str; 3] =
    ["EXT_mesh_gpu_instancing", "EXT_meshopt_compression", "KHR_draco_mesh_compression"];

/// Refuses extensions that the file requires and that would change its shape; those about surfaces are left to the
/// notes.
pub(super) fn check_required(path: &Path, root: &Root) -> Result<(), SceneError> {
    const HARMLESS: [&str; 4] = ["KHR_animation_", "KHR_materials_", "KHR_texture_", "EXT_texture_"];
    let is_known = |name: &&str| KNOWN.contains(name) || HARMLESS.iter().any(|prefix| name.starts_with(prefix));
    let required = root.extensions_required.iter().map(String::as_str);
    let refused: Vec<&str> = required.filter(|name| !is_known(name)).collect();
    if refused.is_empty() {
        return Ok(());
    }
    let (names, remedy) = (refused.join(", "), "export the model without these extensions");
    let problem = format!("the file requires {names}, which cannot be read");
    Err(SceneError::new(path, Place::Part("extensionsRequired".to_owned()), problem, remedy))
}

/// Notes the extensions that the file uses and that are not read.
pub(super) fn note_extensions(root: &Root, notes: &mut Notes) {
    for name in root.extensions_used.iter().chain(&root.extensions_required) {
        if !KNOWN.contains(&name.as_str()) {
            notes.add_unless_told(&format!("{name} is not read"));
        }
    }
}
