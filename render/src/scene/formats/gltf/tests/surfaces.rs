//! Materials, lights and cameras.

use core::f32::consts::{FRAC_1_SQRT_2, FRAC_PI_3, FRAC_PI_6};

use glam::Vec3;
use serde_json::{Value, json};

use super::*;
use crate::material::Inputs;
use crate::scene::{CameraPose, Clip, Optics, Projection, PunctualLight, SpotEdge};

#[test]
fn materials() {
    let mut document = with("/meshes/0/primitives/0/material", json!(1));
    document["materials"] = json!([
        {"name": "red", "pbrMetallicRoughness": {"baseColorFactor": [1, 0.25, 0, 0.5],
         "metallicRoughnessTexture": {"index": 0}},
         "normalTexture": {"index": 0}},
        {"emissiveFactor": [1, 0.5, 0], "doubleSided": true,
         "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": 8}}}
    ]);
    let told = problem(document.clone());
    assert_eq!(told, "material 0 (\"red\"), metallicRoughnessTexture: it refers to texture 0, which does not exist");
    document["materials"][0] = json!({"name": "red", "doubleSided": true, "occlusionTexture": {"index": 0},
        "pbrMetallicRoughness": {"baseColorFactor": [1, 0.25, 0, 0.5], "metallicFactor": 0.75, "roughnessFactor": 0.5}});
    let scene = parse(document.clone()).unwrap();
    let [red, lamp] = &scene.materials[..] else { panic!() };
    assert_eq!(
        (red.name.as_str(), red.inputs.base_color, red.emits_both_sides),
        ("red", Vec3::new(1.0, 0.25, 0.0), true)
    );
    assert!(red.opacity.is_whole(), "alpha does not count where nothing blends");
    let expected = Inputs {
        base_color: Vec3::new(1.0, 0.25, 0.0),
        base_metalness: 0.75,
        specular_weight: 1.0,
        specular_roughness: 0.5,
        thin_walled: true,
        ..Inputs::default()
    };
    assert_eq!(red.inputs, expected);
    assert_eq!((lamp.inputs.base_color, lamp.emission), (Vec3::ONE, Vec3::new(8.0, 4.0, 0.0)));
    assert_eq!((lamp.inputs.base_metalness, lamp.inputs.specular_roughness), (1.0, 1.0));
    let occlusion = "model.gltf: occlusionTexture is not used, as light is traced: material 0 (\"red\")";
    assert_eq!(scene.warnings, [occlusion]);
    assert_eq!(one_mesh(scene).material, 1);

    document["materials"][0] = json!({"pbrMetallicRoughness": {"baseColorFactor": [2, 0.25, -1, 1]}});
    let scene = parse(document.clone()).unwrap();
    assert_eq!(scene.materials[0].inputs.base_color, Vec3::new(1.0, 0.25, 0.0));
    assert_eq!(scene.warnings, ["model.gltf: baseColorFactor is outside 0 to 1 and is clamped: material 0"]);
    document["materials"][1]["emissiveFactor"] = json!([0, -1, 0]);
    assert_eq!(problem(document), "material 1: its emission is negative or not finite");
}

#[test]
fn mirrors_and_glass() {
    let mut document = with("/meshes/0/primitives/0/material", json!(0));
    let glass = |factor: f32, roughness: f32, extensions: Value| {
        let mut extensions = extensions;
        extensions["KHR_materials_transmission"] = json!({"transmissionFactor": factor});
        let base = json!({"baseColorFactor": [1, 0.5, 0.25, 1], "metallicFactor": 0, "roughnessFactor": roughness});
        json!({"pbrMetallicRoughness": base, "extensions": extensions})
    };
    document["materials"] = json!([
        {"pbrMetallicRoughness": {"baseColorFactor": [1, 0.5, 0.25, 1], "roughnessFactor": 0}},
        {"pbrMetallicRoughness": {"baseColorFactor": [1, 0.5, 0.25, 1], "roughnessFactor": 0, "metallicFactor": 0}},
        glass(1.0, 0.0, json!({"KHR_materials_ior": {"ior": 1.25}})),
        glass(0.5, 0.25, json!({})),
        glass(0.25, 0.0, json!({})),
    ]);
    let scene = parse(document).unwrap();
    let color = Vec3::new(1.0, 0.5, 0.25);
    let inputs = scene.materials.iter().map(|material| material.inputs);
    let surfaces: Vec<_> = inputs.map(|it| (it.base_metalness, it.transmission_weight, it.specular_ior)).collect();
    assert_eq!(surfaces, [(1.0, 0.0, 1.5), (0.0, 0.0, 1.5), (0.0, 1.0, 1.25), (0.0, 0.5, 1.5), (0.0, 0.25, 1.5),]);
    assert!(scene.materials.iter().all(|material| material.inputs.base_color == color));
    assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
}

/// The triangle with lights, one per node; nodes turn by a quarter about y, which takes -z to -x.
fn lit(lights: Value) -> Value {
    let nodes = lights.as_array().unwrap().iter().enumerate().map(|(index, _)| {
        json!({
            "translation": [1, 2, 3], "scale": [2, 2, 2], "rotation": [0, FRAC_1_SQRT_2, 0, FRAC_1_SQRT_2],
            "extensions": {"KHR_lights_punctual": {"light": index}}
        })
    });
    let nodes: Vec<Value> = nodes.collect();
    let mut document = with("/nodes", json!(nodes));
    document["extensions"] = json!({"KHR_lights_punctual": {"lights": lights}});
    document["extensionsRequired"] = json!(["KHR_lights_punctual"]);
    document
}

#[test]
fn lights() {
    let scene = parse(lit(json!([
        {"type": "point", "color": [1, 0.5, 0], "intensity": 4, "range": 9},
        {"type": "directional", "intensity": 3},
        {"type": "spot", "spot": {"innerConeAngle": FRAC_PI_6, "outerConeAngle": FRAC_PI_3}},
        {"type": "spot", "spot": {"innerConeAngle": 0, "outerConeAngle": 1e-6}}
    ])))
    .unwrap();
    assert_eq!(scene.warnings, ["model.gltf: 1 light has a range, which is ignored"]);
    let here = Vec3::new(1.0, 2.0, 3.0);
    assert_eq!(
        scene.lights[0],
        PunctualLight::Point { position: here, intensity: Vec3::new(4.0, 2.0, 0.0), radius: 0.0 }
    );
    let PunctualLight::Directional { direction, irradiance, .. } = scene.lights[1] else { panic!() };
    assert!(direction.distance(Vec3::NEG_X) < 1e-6);
    assert_eq!(irradiance, Vec3::splat(3.0));
    let PunctualLight::Spot { position, direction, intensity, cos_inner, cos_outer, .. } = scene.lights[2] else {
        panic!()
    };
    assert_eq!((position, intensity), (here, Vec3::ONE));
    assert!(direction.distance(Vec3::NEG_X) < 1e-6 && direction.is_normalized());
    assert!((cos_inner - 0.75_f32.sqrt()).abs() < 1e-6 && (cos_outer - 0.5).abs() < 1e-6);
    let PunctualLight::Spot { cos_inner, cos_outer, .. } = scene.lights[3] else { panic!() };
    assert!(cos_outer < cos_inner);
}

#[test]
fn cones_of_stretched_spots_are_told() {
    let warnings = |scale: [f32; 3], kind: &str| {
        let mut document = lit(json!([{"type": kind, "spot": {"outerConeAngle": FRAC_PI_3}}]));
        for node in document["nodes"].as_array_mut().unwrap() {
            node["scale"] = json!(scale);
        }
        parse(document).unwrap().warnings
    };
    assert_eq!(warnings([2.0, 2.0, -2.0], "spot"), [""; 0]);
    assert_eq!(warnings([1.0, 1.0, 0.5], "point"), [""; 0]);
    for scale in [[3.0, 1.0, 1.0], [1.0, 1.0, 0.5]] {
        let expected = "model.gltf: 1 spot has a node that is scaled unevenly: cones stay round, where Blender makes them \
                        ellipses";
        assert_eq!(warnings(scale, "spot"), [expected]);
    }
}

/// Blender writes a spot without blend so.
#[test]
fn a_cone_of_one_angle_has_a_hard_edge() {
    let cone = json!({"innerConeAngle": FRAC_PI_6, "outerConeAngle": FRAC_PI_6});
    let scene = parse(lit(json!([{"type": "spot", "spot": cone}]))).unwrap();
    let PunctualLight::Spot { cos_inner, cos_outer, .. } = scene.lights[0] else { panic!() };
    assert!((cos_inner - 0.75_f32.sqrt()).abs() < 1e-6 && cos_outer == cos_inner.next_down());
}

/// Blender writes `(1 - blend)` times the outer angle, and means a part of the way in the cosine.
#[test]
fn spots_by_blender_have_blenders_edge() {
    let spot = |inner: f32, generator: &str| {
        let mut document =
            lit(json!([{"type": "spot", "spot": {"innerConeAngle": inner, "outerConeAngle": FRAC_PI_3}}]));
        document["asset"]["generator"] = json!(generator);
        let PunctualLight::Spot { cos_inner, cos_outer, edge, .. } = parse(document).unwrap().lights[0] else {
            panic!()
        };
        assert!((cos_outer - 0.5).abs() < 1e-6);
        (cos_inner, edge)
    };
    for (blend, full_from) in [(0.0, 0.5), (0.15, 0.575), (0.5, 0.75), (1.0, 1.0)] {
        let (cos_inner, edge) = spot(FRAC_PI_3 * (1.0 - blend), "Khronos glTF Blender I/O v5.0.21");
        assert_eq!(edge, SpotEdge::Smooth);
        assert!((cos_inner - full_from).abs() < 1e-6, "blend {blend}: {cos_inner}, not {full_from}");
    }
    let (cos_inner, edge) = spot(FRAC_PI_6, "another program");
    assert!(edge == SpotEdge::Square && (cos_inner - 0.75_f32.sqrt()).abs() < 1e-6);
}

#[test]
fn scale_does_not_turn_lights_and_cameras() {
    let mut flat = lit(json!([{"type": "directional"}]));
    flat["nodes"][0]["scale"] = json!([1, 1, 0]);
    let scene = parse(flat).unwrap();
    let PunctualLight::Directional { direction, .. } = scene.lights[0] else { panic!() };
    assert!(direction.distance(Vec3::NEG_X) < 1e-6, "{direction}");
}

#[test]
fn wrong_lights() {
    let light = |light: Value| problem(lit(json!([light])));
    let negative = "light 0: its colour or intensity is negative or not finite";
    assert_eq!(light(json!({"type": "point", "intensity": -1})), negative);
    assert_eq!(light(json!({"type": "point", "color": [1, -1, 1]})), negative);
    assert_eq!(light(json!({"type": "point", "color": [-1, -1, -1], "intensity": -1})), negative);
    assert_eq!(light(json!({"type": "area"})), "light 0: its type is unknown");
    assert_eq!(light(json!({"type": "spot"})), "light 0: it is a spot light without `spot`");
    let cone = json!({"type": "spot", "spot": {"innerConeAngle": 0.5, "outerConeAngle": 0.25}});
    assert_eq!(light(cone), "light 0: its cone goes from 0.5 to 0.25");
    for (inner, outer) in [(-0.5, 0.5), (0.5, 1.75)] {
        let cone = json!({"type": "spot", "spot": {"innerConeAngle": inner, "outerConeAngle": outer}});
        assert_eq!(light(cone), format!("light 0: its cone goes from {inner} to {outer}"));
    }
}

#[test]
fn sizes_of_lights_are_in_their_extras() {
    let sized = |kind: &str, extras: Value| parse(lit(json!([{"type": kind, "extras": extras}])));
    for (angle, expected) in [(json!(0), 0.0), (json!(0.5), 0.25), (json!(3.125), 1.5625)] {
        let scene = sized("directional", json!({"angle": angle})).unwrap();
        let PunctualLight::Directional { half_angle, .. } = scene.lights[0] else { panic!() };
        assert_eq!(half_angle, expected);
    }
    let PunctualLight::Point { radius, .. } = sized("point", json!({"radius": 0.5})).unwrap().lights[0] else {
        panic!()
    };
    assert_eq!(radius, 0.5);
    for (kind, name, value, most) in [
        ("directional", "angle", json!(-0.5), "3.125"),
        ("directional", "angle", json!(3.25), "3.125"),
        ("directional", "angle", json!("wide"), "3.125"),
        ("point", "radius", json!(-1), "1e15"),
        ("point", "radius", json!(2e15), "1e15"),
    ] {
        let error = sized(kind, json!({name: value})).unwrap_err();
        let Place::Part(place) = &error.place else { panic!("{error}") };
        let told = (place.as_str(), error.problem.as_str(), error.remedy.as_str());
        let (problem, remedy) = (format!("extras.{name} is {value}"), format!("write a number from 0 to {most}"));
        assert_eq!(told, ("light 0", problem.as_str(), remedy.as_str()));
    }
}

#[test]
fn cameras() {
    let mut document = triangle();
    document["cameras"] = json!([
        {"type": "orthographic", "orthographic": {"xmag": 1, "ymag": 1, "znear": 0, "zfar": 1}},
        {"type": "perspective", "perspective": {"yfov": FRAC_PI_3, "znear": 1, "aspectRatio": 2}},
        {"type": "perspective", "perspective": {"yfov": 1, "znear": 1}}
    ]);
    document["nodes"] = json!([
        {"mesh": 0},
        {"camera": 1, "name": "shot", "translation": [1, 2, 3], "scale": [5, 5, 5]},
        {"camera": 2},
        {"camera": 0}
    ]);
    let scene = parse(document.clone()).unwrap();
    let CameraPose { eye, target, up, vfov } = scene.camera.unwrap();
    assert_eq!((eye, target, up), (Vec3::new(1.0, 2.0, 3.0), Vec3::new(1.0, 2.0, 2.0), Vec3::Y));
    assert!((vfov - 60.0).abs() < 1e-4);
    assert_eq!(
        scene.warnings,
        ["model.gltf: of 3 cameras, that of node 1 (\"shot\") is used; --model-camera NAME chooses another"]
    );
    document["cameras"][2]["name"] = json!("wide");
    let with = |camera: &str| {
        let options = LoadOptions { camera: Some(camera), ..LoadOptions::default() };
        parse_as(document.clone(), &triangle_bytes(), &options)
    };
    for (camera, expected) in [("shot", scene.camera), ("wide", None), ("1", scene.camera), ("2", None)] {
        let found = with(camera).unwrap();
        assert_eq!(found.camera == scene.camera, expected.is_some(), "{camera}");
        assert!(found.warnings.is_empty(), "{:?}", found.warnings);
    }
    assert!(matches!(with("3").unwrap().optics.projection, Projection::Orthographic { .. }));
    for (wrong, remedy) in [("4", "known are shot"), ("0", "known are shot"), ("Shot", "did you mean `shot`?")] {
        let error = with(wrong).unwrap_err().to_string();
        assert!(error.contains(&format!("no camera {wrong:?}")) && error.contains(remedy), "{error}");
    }
    let as_object = LoadOptions { is_object: true, ..LoadOptions::default() };
    assert!(parse_as(document.clone(), &triangle_bytes(), &as_object).unwrap().warnings.is_empty());
    assert_eq!((scene.optics, scene.camera_clip), (Optics::default(), Some(Clip { near: 1.0, far: f32::INFINITY })));
    let wide = changed(document.clone(), "/cameras/2/perspective/yfov", json!(4));
    assert_eq!(problem(wide), "camera 2: its yfov is 4 radians");
    let far = changed(document.clone(), "/nodes/1/translation", json!([0, 0, 1e9]));
    let far = parse(far).unwrap().camera.unwrap();
    assert_eq!((far.target - far.eye).normalize(), Vec3::NEG_Z);
    assert_eq!(scene.camera_aspect, Some(2.0));
    let flat = parse(changed(document, "/nodes/1/scale", json!([1, 0, 0]))).unwrap();
    assert_eq!(flat.camera.map(|pose| (pose.target, pose.up)), Some((target, up)));
    assert_eq!(parse(triangle()).unwrap().camera, None);
}

/// The magnifications are half of the view's extent.
#[test]
fn orthographic_cameras() {
    let mut document = triangle();
    document["cameras"] =
        json!([{"type": "orthographic", "orthographic": {"xmag": 3, "ymag": 1.5, "znear": 0.5, "zfar": 20}}]);
    document["nodes"] = json!([{"mesh": 0, "camera": 0, "translation": [1, 2, 3]}]);
    let scene = parse(document.clone()).unwrap();
    assert_eq!(scene.warnings, [""; 0]);
    assert_eq!(scene.optics, Optics { projection: Projection::Orthographic { height: 3.0 }, ..Optics::default() });
    let clip = Clip { near: 0.5, far: 20.0 };
    assert_eq!((scene.camera_aspect, scene.camera_clip), (Some(2.0), Some(clip)));
    assert_eq!(scene.camera.unwrap().target, Vec3::new(1.0, 2.0, 2.0));
    let none = changed(document.clone(), "/cameras/0/orthographic/ymag", json!(0));
    assert_eq!(problem(none), "camera 0: its xmag and ymag are 3 and 0");
    let bare = changed(document, "/cameras/0", json!({"type": "orthographic"}));
    assert_eq!(problem(bare), "camera 0: it is neither perspective nor orthographic");
}
