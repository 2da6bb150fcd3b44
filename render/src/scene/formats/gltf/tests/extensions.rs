//! The extensions of materials, variants, quantized meshes, and their errors.

use glam::Vec3;
use serde_json::{Value, json};

use super::*;
use crate::material::Inputs;
use crate::scene::Input;

/// The inputs of a material that has these extensions; what it warns of.
fn read(extensions: Value) -> (Material, Vec<String>) {
    let mut document = with("/meshes/0/primitives/0/material", json!(0));
    document["materials"] = json!([{"extensions": extensions}]);
    let mut scene = parse(document).unwrap();
    (scene.materials.remove(0), scene.warnings)
}

fn inputs(extensions: Value) -> Inputs {
    let (material, warnings) = read(extensions);
    assert!(warnings.is_empty(), "{warnings:?}");
    material.inputs
}

#[test]
fn every_extension_sets_its_inputs() {
    let it = inputs(json!({"KHR_materials_specular": {"specularFactor": 0.5, "specularColorFactor": [2, 1, 0]},
        "KHR_materials_ior": {"ior": 1.25}}));
    assert_eq!((it.specular_weight, it.specular_color, it.specular_ior), (0.5, Vec3::new(2.0, 1.0, 0.0), 1.25));
    let it = inputs(json!({"KHR_materials_clearcoat": {"clearcoatRoughnessFactor": 0.25},
        "KHR_materials_sheen": {"sheenColorFactor": [0.5, 0.25, 0], "sheenRoughnessFactor": 0.75}}));
    assert_eq!((it.coat_weight, it.coat_roughness, it.coat_ior), (0.0, 0.25, 1.5));
    assert_eq!((it.fuzz_weight, it.fuzz_color, it.fuzz_roughness), (0.5, Vec3::new(1.0, 0.5, 0.0), 0.75));
    let it = inputs(json!({"KHR_materials_iridescence": {"iridescenceFactor": 0.5},
        "KHR_materials_diffuse_transmission": {"diffuseTransmissionFactor": 0.25}}));
    assert_eq!((it.thin_film_weight, it.thin_film_ior, it.thin_film_thickness), (0.5, 1.3, 400.0));
    assert_eq!((it.diffuse_transmission_weight, it.diffuse_transmission_color), (0.25, Vec3::ONE));
    let it = inputs(json!({"KHR_materials_ior": {"ior": 0}}));
    assert_eq!((it.specular_ior, it.specular_color), (1.5, Vec3::splat(25.0)), "F0 is 1");
}

#[test]
fn glass_is_a_wall_or_has_a_volume() {
    let transmission = json!({"transmissionFactor": 0.75});
    let thin = inputs(json!({"KHR_materials_transmission": transmission}));
    assert_eq!((thin.transmission_weight, thin.thin_walled), (0.75, true));
    let volume = json!({"thicknessFactor": 1, "attenuationDistance": 2, "attenuationColor": [1, 0.5, 0.25]});
    let solid = inputs(json!({"KHR_materials_transmission": transmission, "KHR_materials_volume": volume}));
    assert!(!solid.thin_walled);
    // After the attenuation distance the colour is left.
    let left = (-2.0 * solid.absorption).map(f32::exp);
    assert!((left - Vec3::new(1.0, 0.5, 0.25)).abs().max_element() < 1e-6, "{left}");
    let mut document = with("/asset/generator", json!("Khronos glTF Blender I/O v5.0.21"));
    document["materials"] = json!([{"extensions": {"KHR_materials_transmission": transmission}}]);
    assert!(!parse(document).unwrap().materials[0].inputs.thin_walled, "Blender has no thin walls");
}

/// It writes its own colour and density of absorption, and leaves out its own default.
#[test]
fn blender_means_something_else_by_volumes_and_coats() {
    let by = |generator: &str, extensions: Value| {
        let mut document = with("/asset/generator", json!(generator));
        document["materials"] = json!([{"extensions": extensions}]);
        parse(document).unwrap().materials[0].inputs
    };
    let [blender, other] = ["Khronos glTF Blender I/O v5.0.21", "another"];
    let volume = json!({"thicknessFactor": 1, "attenuationDistance": 0.5, "attenuationColor": [1, 0.75, 0]});
    let volume = json!({"KHR_materials_transmission": {"transmissionFactor": 1}, "KHR_materials_volume": volume});
    assert_eq!(by(blender, volume.clone()).absorption, Vec3::new(0.0, 0.5, 2.0));
    assert!((by(other, volume).absorption.y + 2.0 * 0.75_f32.ln()).abs() < 1e-6);
    let coat = |roughness: Value| {
        let mut it = json!({"clearcoatFactor": 1});
        it.as_object_mut().unwrap().extend(roughness.as_object().unwrap().clone());
        [blender, other].map(|by_whom| by(by_whom, json!({"KHR_materials_clearcoat": it})).coat_roughness)
    };
    assert_eq!(coat(json!({})), [0.03, 0.0]);
    assert_eq!(coat(json!({"clearcoatRoughnessFactor": 0})), [0.0, 0.0]);
    assert_eq!(coat(json!({"clearcoatRoughnessFactor": 0.5})), [0.5, 0.5]);
}

#[test]
fn specular_glossiness_is_converted() {
    let base = json!({"diffuseFactor": [0.5, 0.25, 0, 1], "specularFactor": [0.4, 0.2, 0], "glossinessFactor": 0.75});
    let it = inputs(json!({"KHR_materials_pbrSpecularGlossiness": base}));
    assert_eq!((it.base_color, it.base_metalness), (Vec3::new(0.5, 0.25, 0.0), 0.0));
    assert_eq!(it.specular_roughness, 0.25);
    let f0 = 0.04 * it.specular_color;
    assert!((f0 - Vec3::new(0.4, 0.2, 0.0)).abs().max_element() < 1e-6, "{f0}");
}

#[test]
fn unlit_surfaces_emit_their_colour_and_dispersion_is_kept() {
    let (unlit, _) = read(json!({"KHR_materials_unlit": {}}));
    assert_eq!((unlit.unlit, unlit.emission, unlit.inputs.base_color), (true, Vec3::ONE, Vec3::ZERO));
    assert_eq!(unlit.map_of(Input::BaseColor), None);
    let (material, warnings) = read(json!({"KHR_materials_dispersion": {"dispersion": 0.5}}));
    assert_eq!(material.dispersion, 0.5);
    assert!(warnings.is_empty(), "{warnings:?}");
}

#[test]
fn wrong_numbers_are_clamped_or_refused_and_named() {
    let (material, warnings) = read(json!({"KHR_materials_ior": {"ior": 0.5},
        "KHR_materials_clearcoat": {"clearcoatRoughnessFactor": 7}}));
    assert_eq!((material.inputs.specular_ior, material.inputs.coat_roughness), (1.0, 1.0));
    assert_eq!(
        warnings,
        [
            "model.gltf: clearcoatRoughnessFactor is outside 0 to 1 and is clamped: material 0",
            "model.gltf: ior is outside 1 to 100 and is clamped: material 0",
        ]
    );
    let told = |material: Value| {
        let mut document = triangle();
        document["materials"] = json!([material]);
        problem(document)
    };
    let rough = told(json!({"name": "a", "pbrMetallicRoughness": {"roughnessFactor": 1e300}}));
    assert_eq!(rough, "material 0 (\"a\"): its roughnessFactor is not a finite number");
    let wrong = told(json!({"extensions": {"KHR_materials_ior": {"ior": "glass"}}}));
    assert!(wrong.starts_with("material 0: its KHR_materials_ior is wrong: invalid type"), "{wrong}");
    let volume = json!({"thicknessFactor": 1, "attenuationDistance": 0});
    assert_eq!(
        told(json!({"extensions": {"KHR_materials_volume": volume}})),
        "material 0: its attenuationDistance is 0"
    );
}

#[test]
fn variants_name_materials_of_primitives() {
    let mut document = triangle();
    document["materials"] = json!([{"name": "oak"}, {"name": "steel"}]);
    document["extensions"] = json!({"KHR_materials_variants": {"variants": [{"name": "warm"}, {"name": "cold"}]}});
    let mappings = json!({"mappings": [{"material": 1, "variants": [1]}, {"material": 0, "variants": [0]}]});
    document["meshes"][0]["primitives"][0]["extensions"] = json!({"KHR_materials_variants": mappings});
    let mut scene = parse(document.clone()).unwrap();
    assert_eq!(scene.meshes[0].material, 2, "the default grey");
    assert!(scene.choose_variant("cold") && scene.meshes[0].material == 1);
    assert!(scene.choose_variant("warm") && scene.meshes[0].material == 0);
    assert!(!scene.choose_variant("hot"));
    let pointer = "/meshes/0/primitives/0/extensions/KHR_materials_variants/mappings/0";
    let told = problem(changed(document.clone(), &format!("{pointer}/material"), json!(2)));
    assert!(told.ends_with("its KHR_materials_variants refers to material 2, which does not exist"), "{told}");
    let told = problem(changed(document, &format!("{pointer}/variants"), json!([2])));
    assert!(told.ends_with("its KHR_materials_variants refers to variant 2, which does not exist"), "{told}");
}

#[test]
fn quantized_positions_are_numbers_or_parts() {
    let mut document = triangle();
    document["meshes"][0]["primitives"][0]["attributes"] = json!({"POSITION": 0});
    document["bufferViews"] = json!([{"buffer": 0, "byteLength": 24, "byteStride": 8}]);
    document["accessors"] = json!([{"bufferView": 0, "componentType": 5122, "count": 3, "type": "VEC3"}]);
    document["extensionsRequired"] = json!(["KHR_mesh_quantization"]);
    let shorts: [i16; 12] = [0, 0, 0, 0, 2, 0, 0, 0, 0, 32767, -32768, 0];
    let bytes: Vec<u8> = shorts.iter().flat_map(|number| number.to_le_bytes()).collect();
    let positions = |document: Value| parse_with(document, &bytes).unwrap().meshes.remove(0).positions;
    assert_eq!(positions(document.clone()), [Vec3::ZERO, Vec3::X * 2.0, Vec3::new(0.0, 32767.0, -32768.0)]);
    document["accessors"][0]["normalized"] = json!(true);
    assert_eq!(positions(document.clone())[2], Vec3::new(0.0, 1.0, -1.0));
    document["extensionsRequired"] = json!([]);
    let told = told(parse_with(document, &bytes));
    assert_eq!(told, "accessor 0: it is VEC3 of short, and serves as POSITION");
}

#[test]
fn damaged_draco_data_are_told() {
    let mut document = triangle();
    let compression = json!({"bufferView": 0, "attributes": {"POSITION": 0}});
    document["meshes"][0]["primitives"][0]["extensions"] = json!({"KHR_draco_mesh_compression": compression});
    let told = problem(document.clone());
    assert!(told.starts_with("mesh 0, primitive 0: its Draco data cannot be read: "), "{told}");
    let pointer = "/meshes/0/primitives/0/extensions/KHR_draco_mesh_compression/bufferView";
    let told = problem(changed(document, pointer, json!(9)));
    assert_eq!(told, "mesh 0, primitive 0: it refers to bufferView 9, which does not exist");
}
