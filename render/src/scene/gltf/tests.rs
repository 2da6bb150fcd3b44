use core::f32::consts::{FRAC_1_SQRT_2, FRAC_PI_3, FRAC_PI_4, FRAC_PI_6};

use glam::{Vec2, Vec3};
use serde_json::{Value, json};

use super::*;
use crate::scene::{CameraPose, Mesh, PunctualLight};

/// Three positions at byte 0, normals at 36, texture coordinates at 72, 16-bit indices 0 2 1 at 96.
fn triangle_bytes() -> Vec<u8> {
    let positions = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let normals = [[0.0, 0.0, 1.0], [0.0, 0.0, 2.0], [0.6, 0.0, 0.8]];
    let texcoords = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]];
    let floats = positions.iter().chain(&normals).flatten().chain(texcoords.iter().flatten());
    let mut bytes: Vec<u8> = floats.flat_map(|number: &f32| number.to_le_bytes()).collect();
    bytes.extend([0, 0, 2, 0, 1, 0, 0, 0]);
    bytes
}

/// A triangle on one node.
fn triangle() -> Value {
    json!({
        "asset": {"version": "2.0"},
        "bufferViews": [
            {"buffer": 0, "byteLength": 36},
            {"buffer": 0, "byteOffset": 36, "byteLength": 36},
            {"buffer": 0, "byteOffset": 72, "byteLength": 24},
            {"buffer": 0, "byteOffset": 96, "byteLength": 8}
        ],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"},
            {"bufferView": 1, "componentType": 5126, "count": 3, "type": "VEC3"},
            {"bufferView": 2, "componentType": 5126, "count": 3, "type": "VEC2"},
            {"bufferView": 3, "componentType": 5123, "count": 3, "type": "SCALAR"}
        ],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "NORMAL": 1, "TEXCOORD_0": 2}}]}],
        "nodes": [{"mesh": 0}]
    })
}

/// Reads `document` with `bytes` as its buffer, in a data URI.
fn parse_with(mut document: Value, bytes: &[u8]) -> Result<Scene, SceneError> {
    use base64::Engine;
    if document["buffers"].is_null() {
        let data = base64::engine::general_purpose::STANDARD_NO_PAD.encode(bytes);
        let uri = format!("data:application/octet-stream;base64,{data}");
        document["buffers"] = json!([{"byteLength": bytes.len(), "uri": uri}]);
    }
    read_json(Path::new("model.gltf"), document.to_string().as_bytes())
}

fn parse(document: Value) -> Result<Scene, SceneError> {
    parse_with(document, &triangle_bytes())
}

/// "place: problem" of an error.
fn told(outcome: Result<Scene, SceneError>) -> String {
    let error = outcome.unwrap_err();
    match error.place {
        Place::File => error.problem,
        Place::Line(line) => format!("line {line}: {}", error.problem),
        Place::Part(part) => format!("{part}: {}", error.problem),
    }
}

fn problem(document: Value) -> String {
    told(parse(document))
}

/// The triangle with `value` at a JSON pointer.
fn with(pointer: &str, value: Value) -> Value {
    changed(triangle(), pointer, value)
}

fn changed(mut document: Value, pointer: &str, value: Value) -> Value {
    let (parent, key) = pointer.rsplit_once('/').unwrap();
    let parent = document.pointer_mut(parent).unwrap();
    match key.parse::<usize>() {
        Ok(index) if parent.is_array() => parent[index] = value,
        _ => parent[key] = value,
    }
    document
}

fn one_mesh(scene: Scene) -> Mesh {
    let [mesh] = <[Mesh; 1]>::try_from(scene.meshes).unwrap();
    mesh
}

fn glb(document: &Value, binary: &[u8]) -> Vec<u8> {
    let mut json = document.to_string().into_bytes();
    json.resize(json.len().next_multiple_of(4), b' ');
    let word = |number: usize| (number as u32).to_le_bytes();
    let mut bytes = [b"glTF".as_slice(), &word(2), &word(28 + json.len() + binary.len())].concat();
    bytes.extend([&word(json.len()), b"JSON".as_slice(), &json, &word(binary.len()), b"BIN\0", binary].concat());
    bytes
}

/// A small valid GLB file, which uses much of what is read.
pub(in crate::scene) fn small_glb() -> Vec<u8> {
    let mut document = triangle();
    document["buffers"] = json!([{"byteLength": 104}]);
    document["meshes"][0]["primitives"][0]["indices"] = json!(3);
    document["meshes"][0]["primitives"][0]["material"] = json!(0);
    document["materials"] = json!([{"emissiveFactor": [1, 0, 0]}]);
    document["accessors"][0]["sparse"] = json!({
        "count": 1,
        "indices": {"bufferView": 3, "byteOffset": 2, "componentType": 5123},
        "values": {"bufferView": 0, "byteOffset": 24}
    });
    document["cameras"] = json!([{"type": "perspective", "perspective": {"yfov": 1, "znear": 1}}]);
    document["extensions"] = json!({"KHR_lights_punctual": {"lights": [{"type": "spot", "spot": {}}]}});
    document["nodes"] = json!([
        {"children": [1], "rotation": [0, 0, 0, 1]},
        {"mesh": 0, "camera": 0, "scale": [1, 1, -1], "extensions": {"KHR_lights_punctual": {"light": 0}}}
    ]);
    document["scenes"] = json!([{"nodes": [0]}]);
    document["scene"] = json!(0);
    glb(&document, &triangle_bytes())
}

#[test]
fn a_triangle() {
    let scene = parse(triangle()).unwrap();
    assert!(scene.warnings.is_empty());
    assert_eq!(scene.materials, [Material::default()]);
    let mesh = one_mesh(scene);
    assert_eq!(mesh.positions, [Vec3::ZERO, Vec3::X, Vec3::Y]);
    assert_eq!(mesh.normals, [Vec3::Z, Vec3::Z, Vec3::new(0.6, 0.0, 0.8)]);
    assert_eq!(mesh.texcoords, [Vec2::ZERO, Vec2::X, Vec2::Y]);
    assert_eq!((mesh.triangles, mesh.material), (vec![[0, 1, 2]], 0));
}

#[test]
fn indices_of_all_sizes() {
    let numbers = [0_u8, 2, 1];
    let stored: [(u32, Vec<u8>); 3] = [
        (5121, numbers.to_vec()),
        (5123, numbers.iter().flat_map(|&number| u16::from(number).to_le_bytes()).collect()),
        (5125, numbers.iter().flat_map(|&number| u32::from(number).to_le_bytes()).collect()),
    ];
    for (kind, indices) in stored {
        let mut document = with("/meshes/0/primitives/0/indices", json!(3));
        document["accessors"][3]["componentType"] = json!(kind);
        document["bufferViews"][3]["byteLength"] = json!(indices.len());
        let bytes = [&triangle_bytes()[..96], &indices].concat();
        assert_eq!(one_mesh(parse_with(document, &bytes).unwrap()).triangles, [[0, 2, 1]]);
    }
}

#[test]
fn strips_and_fans_keep_the_winding() {
    let ring = |mode: Mode| triangles(mode, &[5, 6, 7, 8, 9]);
    use ::gltf::json::mesh::Mode;
    use primitive::triangles;
    assert_eq!(ring(Mode::TriangleStrip), [[5, 6, 7], [6, 8, 7], [7, 8, 9]]);
    assert_eq!(ring(Mode::TriangleFan), [[6, 7, 5], [7, 8, 5], [8, 9, 5]]);
    assert_eq!(triangles(Mode::Triangles, &[5, 6, 7, 8, 9, 5]), [[5, 6, 7], [8, 9, 5]]);
    assert!(triangles(Mode::TriangleFan, &[1, 2]).is_empty());
    for mode in [5, 6] {
        let mesh = one_mesh(parse(with("/meshes/0/primitives/0/mode", json!(mode))).unwrap());
        assert_eq!(mesh.triangles.len(), 1);
    }
}

#[test]
fn points_and_lines_are_skipped() {
    for mode in 0..4 {
        let scene = parse(with("/meshes/0/primitives/0/mode", json!(mode))).unwrap();
        assert!(scene.meshes.is_empty());
        assert_eq!(scene.warnings, ["model.gltf: 1 primitive of points or lines is skipped"]);
    }
    let wrong = problem(with("/meshes/0/primitives/0/mode", json!(7)));
    assert_eq!(wrong, "mesh 0, primitive 0: its mode is unknown");
}

#[test]
fn strides_and_offsets() {
    // Vertices interleaved: position and texture coordinate in 20 bytes, after 4 bytes of something else.
    let (mut bytes, plain) = (vec![7; 4], triangle_bytes());
    for vertex in 0..3 {
        bytes.extend_from_slice(&plain[12 * vertex..12 * vertex + 12]);
        bytes.extend_from_slice(&plain[72 + 8 * vertex..80 + 8 * vertex]);
    }
    let mut document = triangle();
    document["bufferViews"] = json!([{"buffer": 0, "byteOffset": 4, "byteLength": 60, "byteStride": 20}]);
    document["accessors"] = json!([
        {"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"},
        {"bufferView": 0, "byteOffset": 12, "componentType": 5126, "count": 3, "type": "VEC2"}
    ]);
    document["meshes"][0]["primitives"][0]["attributes"] = json!({"POSITION": 0, "TEXCOORD_0": 1});
    let mesh = one_mesh(parse_with(document.clone(), &bytes).unwrap());
    assert_eq!(mesh.positions, [Vec3::ZERO, Vec3::X, Vec3::Y]);
    assert_eq!(mesh.texcoords, [Vec2::ZERO, Vec2::X, Vec2::Y]);
    document["bufferViews"][0]["byteStride"] = json!(8);
    assert_eq!(
        told(parse_with(document, &bytes)),
        "bufferView 0: its stride is 8 bytes, but an element of accessor 0 has 12"
    );
}

#[test]
fn normalised_texture_coordinates() {
    let bytes = [&triangle_bytes()[..72], &[0, 255, 51, 0, 255, 102]].concat();
    let mut document = triangle();
    document["bufferViews"][2]["byteLength"] = json!(6);
    document["accessors"][2] =
        json!({"bufferView": 2, "componentType": 5121, "normalized": true, "count": 3, "type": "VEC2"});
    let mesh = one_mesh(parse_with(document, &bytes).unwrap());
    assert_eq!(mesh.texcoords, [Vec2::Y, Vec2::new(0.2, 0.0), Vec2::new(1.0, 0.4)]);
}

#[test]
fn sparse_accessors() {
    let sparse = json!({
        "count": 1,
        "indices": {"bufferView": 3, "byteOffset": 2, "componentType": 5123},
        "values": {"bufferView": 1, "byteOffset": 12}
    });
    // Index 2 of the positions becomes (0, 0, 2).
    let document = with("/accessors/0/sparse", sparse.clone());
    assert_eq!(one_mesh(parse(document.clone()).unwrap()).positions, [Vec3::ZERO, Vec3::X, 2.0 * Vec3::Z]);
    let zeros = changed(document.clone(), "/accessors/0", {
        json!({"componentType": 5126, "count": 3, "type": "VEC3", "sparse": sparse})
    });
    assert_eq!(one_mesh(parse(zeros.clone()).unwrap()).positions, [Vec3::ZERO, Vec3::ZERO, 2.0 * Vec3::Z]);
    assert_eq!(
        problem(changed(zeros, "/accessors/0/count", json!(1_u64 << 60))),
        format!("accessor 0: it has {} elements and no bufferView", 1_u64 << 60)
    );
    let beyond = changed(document.clone(), "/accessors/0/count", json!(2));
    assert_eq!(problem(beyond), "accessor 0: a sparse index is 2, and it has 2 elements");
    let long = changed(document, "/accessors/0/sparse/count", json!(4));
    assert_eq!(problem(long), "accessor 0: its 4 elements need 8 bytes from byte 2 on, but bufferView 3 has 8");
}

#[test]
fn accessors_out_of_range() {
    let cases = [
        (
            "/accessors/0/count",
            json!(4),
            "accessor 0: its 4 elements need 48 bytes from byte 0 on, but bufferView 0 has 36",
        ),
        (
            "/accessors/0/byteOffset",
            json!(4),
            "accessor 0: its 3 elements need 36 bytes from byte 4 on, but bufferView 0 has 36",
        ),
        ("/accessors/0/bufferView", json!(9), "accessor 0: it refers to bufferView 9, which does not exist"),
        ("/bufferViews/0/buffer", json!(1), "bufferView 0: it refers to buffer 1, which does not exist"),
        (
            "/bufferViews/0/byteOffset",
            json!(69),
            "bufferView 0: it goes from byte 69 for 36 bytes, but buffer 0 has 104",
        ),
        (
            "/bufferViews/0/byteOffset",
            json!(u64::MAX),
            "bufferView 0: it goes from byte 18446744073709551615 for 36 bytes, but buffer 0 has 104",
        ),
        ("/accessors/0/type", json!("VEC2"), "accessor 0: it is VEC2 of float, and serves as POSITION"),
        ("/accessors/1/componentType", json!(5122), "accessor 1: it is VEC3 of short, and serves as NORMAL"),
        ("/accessors/2/componentType", json!(5125), "accessor 2: it is VEC2 of unsigned int, and serves as TEXCOORD_0"),
        ("/accessors/2/componentType", json!(1), "accessor 2: it is VEC2 of unknown, and serves as TEXCOORD_0"),
        ("/accessors/1/count", json!(2), "mesh 0, primitive 0: it has 3 of POSITION, but 2 of NORMAL"),
        (
            "/meshes/0/primitives/0/attributes/POSITION",
            json!(8),
            "mesh 0, primitive 0: it refers to accessor 8, which does not exist",
        ),
        ("/meshes/0/primitives/0/attributes", json!({}), "mesh 0, primitive 0: it has no POSITION"),
        ("/meshes/0/primitives/0/indices", json!(0), "accessor 0: it is VEC3 of float, and serves as indices"),
        (
            "/meshes/0/primitives/0/material",
            json!(0),
            "mesh 0, primitive 0: it refers to material 0, which does not exist",
        ),
        ("/nodes/0/mesh", json!(1), "node 0: it refers to mesh 1, which does not exist"),
        ("/nodes/0/camera", json!(0), "node 0: it refers to camera 0, which does not exist"),
        ("/nodes/0/children", json!([3]), "node 0: it refers to node 3, which does not exist"),
        ("/scene", json!(0), "scene: it refers to scene 0, which does not exist"),
        ("/scenes", json!([{"nodes": [4]}]), "scene 0: it refers to node 4, which does not exist"),
        (
            "/nodes/0/extensions",
            json!({"KHR_lights_punctual": {"light": 0}}),
            "node 0: it refers to light 0, which does not exist",
        ),
    ];
    for (pointer, value, expected) in cases {
        let mut document = with(pointer, value);
        if pointer == "/scenes" {
            document["scene"] = json!(0);
        }
        assert_eq!(problem(document), expected);
    }
}

#[test]
fn wrong_vertices_and_indices() {
    let document = with("/meshes/0/primitives/0/indices", json!(3));
    let mut bytes = triangle_bytes();
    bytes[98] = 3;
    assert_eq!(
        told(parse_with(document.clone(), &bytes)),
        "accessor 3: it holds the index 3, but mesh 0, primitive 0 has 3 vertices"
    );
    let four = changed(document, "/accessors/3/count", json!(4));
    assert_eq!(problem(four), "mesh 0, primitive 0: its triangles have 4 corners together");
    bytes[12..16].copy_from_slice(&f32::INFINITY.to_le_bytes());
    assert_eq!(told(parse_with(triangle(), &bytes)), "mesh 0, primitive 0: the POSITION of vertex 1 is not finite");
}

#[test]
fn transforms_go_down_the_hierarchy() {
    let (sin, cos) = (FRAC_PI_4.sin(), FRAC_PI_4.cos());
    let mut document = triangle();
    document["nodes"] = json!([
        {"mesh": 0, "name": "leaf", "scale": [2, 3, 4]},
        // A quarter turn about z, then a translation.
        {"children": [0], "rotation": [0, 0, sin, cos], "translation": [10, 0, 0]},
        {"children": [1], "matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 5, 1]}
    ]);
    let mesh = one_mesh(parse(document).unwrap());
    assert_eq!(mesh.name, "leaf");
    let expected = [Vec3::new(10.0, 0.0, 5.0), Vec3::new(10.0, 2.0, 5.0), Vec3::new(7.0, 0.0, 5.0)];
    for (position, expected) in mesh.positions.iter().zip(expected) {
        assert!(position.distance(expected) < 1e-5, "{position} {expected}");
    }
    // The inverse transpose of the scale takes (0.6, 0, 0.8) to (0.3, 0, 0.2) up to length; x then turns into y.
    let expected = Vec3::new(0.0, 0.3, 0.2).normalize();
    assert!(mesh.normals[2].distance(expected) < 1e-6);
}

#[test]
fn mirrors_flip_the_winding() {
    let mesh = one_mesh(parse(with("/nodes/0/scale", json!([-1, 1, 1]))).unwrap());
    assert_eq!(mesh.positions[1], Vec3::NEG_X);
    assert_eq!(mesh.triangles, [[0, 2, 1]]);
    assert_eq!(mesh.normals, [Vec3::Z, Vec3::Z, Vec3::new(-0.6, 0.0, 0.8)]);
    let twice = one_mesh(parse(with("/nodes/0/scale", json!([-1, -1, 1]))).unwrap());
    assert_eq!(twice.triangles, [[0, 1, 2]]);
}

#[test]
fn flattening_keeps_the_normal_of_the_plane() {
    let mesh = one_mesh(parse(with("/nodes/0/scale", json!([2, 2, 0]))).unwrap());
    assert_eq!(mesh.normals, [Vec3::Z; 3]);
    let point = one_mesh(parse(with("/nodes/0/scale", json!([0, 0, 0]))).unwrap());
    assert!(point.normals.is_empty());
}

#[test]
fn the_default_scene_or_all_roots() {
    let mut document = triangle();
    document["nodes"] =
        json!([{"mesh": 0, "name": "a"}, {"mesh": 0, "name": "b", "children": [2]}, {"mesh": 0, "name": "c"}]);
    document["scenes"] = json!([{"nodes": [0]}, {"nodes": [1]}]);
    let names = |document: &Value| -> Vec<String> {
        parse(document.clone()).unwrap().meshes.into_iter().map(|mesh| mesh.name).collect()
    };
    assert_eq!(names(&document), ["a", "b", "c"]);
    document["scene"] = json!(1);
    assert_eq!(names(&document), ["b", "c"]);
}

#[test]
fn nodes_that_are_no_trees() {
    let nodes = |nodes: Value| problem(with("/nodes", nodes));
    assert_eq!(
        nodes(json!([{"children": [1]}, {"children": [0], "name": "loop"}, {"mesh": 0}])),
        "node 1 (\"loop\"): it is a descendant of itself"
    );
    assert_eq!(nodes(json!([{"children": [0]}])), "node 0: it is a descendant of itself");
    assert_eq!(
        nodes(json!([{"children": [2]}, {"children": [2]}, {"mesh": 0, "name": "x"}])),
        "node 2 (\"x\"): it is listed by both node 1 and node 0"
    );
    assert_eq!(nodes(json!([{"children": [1, 1]}, {}])), "node 1: node 0 lists it twice");
    let mut document = with("/nodes", json!([{"children": [1]}, {"mesh": 0}]));
    document["scene"] = json!(0);
    document["scenes"] = json!([{"nodes": [0, 1]}]);
    assert_eq!(problem(document.clone()), "node 1: it is listed by both scene 0 and node 0");
    document["scenes"] = json!([{"nodes": [0, 0]}]);
    assert_eq!(problem(document), "node 0: scene 0 lists it twice");
    assert_eq!(problem(with("/nodes/0/rotation", json!([0, 0, 0, 0]))), "node 0: its rotation is zero");
    assert_eq!(problem(with("/nodes/0/matrix", json!(vec![1; 16]))), "node 0: its matrix is not affine");
    assert_eq!(
        problem(
            with("/nodes/0/scale", json!([3e38, 3e38, 3e38]))
                .as_object()
                .map(|document| changed(json!(document), "/nodes/0/translation", json!([3e38, 0, 0])))
                .unwrap()
        ),
        "node 0: its transform takes mesh 0, primitive 0 out of the range of numbers"
    );
}

#[test]
fn deep_hierarchies_do_not_overflow_the_stack() {
    let mut nodes: Vec<Value> = (1..100_000).map(|child| json!({"children": [child]})).collect();
    nodes.push(json!({"mesh": 0}));
    assert_eq!(parse(with("/nodes", json!(nodes))).unwrap().meshes.len(), 1);
}

#[test]
fn materials() {
    let mut document = with("/meshes/0/primitives/0/material", json!(1));
    document["materials"] = json!([
        {"name": "red", "pbrMetallicRoughness": {"baseColorFactor": [1, 0.25, 0, 0.5], "baseColorTexture": {"index": 0}},
         "normalTexture": {"index": 0}},
        {"emissiveFactor": [1, 0.5, 0], "doubleSided": true,
         "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": 8}}}
    ]);
    let scene = parse(document.clone()).unwrap();
    let red = Material { name: "red".to_owned(), diffuse: Vec3::new(1.0, 0.25, 0.0), ..Material::default() };
    let lamp = Material {
        diffuse: Vec3::ONE,
        emission: Vec3::new(8.0, 4.0, 0.0),
        emits_both_sides: true,
        ..Material::default()
    };
    assert_eq!(scene.materials, [red, lamp]);
    assert_eq!(scene.warnings, ["model.gltf: 2 textures are ignored"]);
    assert_eq!(one_mesh(scene).material, 1);

    document["materials"][0] = json!({"pbrMetallicRoughness": {"baseColorFactor": [2, 0.25, -1, 1]}});
    let scene = parse(document.clone()).unwrap();
    assert_eq!(scene.materials[0].diffuse, Vec3::new(1.0, 0.25, 0.0));
    assert_eq!(scene.warnings, ["model.gltf: material 0: `baseColorFactor` is outside 0 to 1 and is clamped"]);
    document["materials"][1]["emissiveFactor"] = json!([0, -1, 0]);
    assert_eq!(problem(document), "material 1: its emission is negative or not finite");
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
    assert_eq!(scene.lights[0], PunctualLight::Point { position: here, intensity: Vec3::new(4.0, 2.0, 0.0) });
    let PunctualLight::Directional { direction, irradiance } = scene.lights[1] else { panic!() };
    assert!(direction.distance(Vec3::NEG_X) < 1e-6);
    assert_eq!(irradiance, Vec3::splat(3.0));
    let PunctualLight::Spot { position, direction, intensity, cos_inner, cos_outer } = scene.lights[2] else {
        panic!()
    };
    assert_eq!((position, intensity), (here, Vec3::ONE));
    assert!(direction.distance(Vec3::NEG_X) < 1e-6 && direction.is_normalized());
    assert!((cos_inner - 0.75_f32.sqrt()).abs() < 1e-6 && (cos_outer - 0.5).abs() < 1e-6);
    let PunctualLight::Spot { cos_inner, cos_outer, .. } = scene.lights[3] else { panic!() };
    assert!(cos_outer < cos_inner);
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
    let cone = json!({"type": "spot", "spot": {"innerConeAngle": 0.5, "outerConeAngle": 0.5}});
    assert_eq!(light(cone), "light 0: its cone goes from 0.5 to 0.5");
    let mut flat = lit(json!([{"type": "directional"}]));
    flat["nodes"][0]["scale"] = json!([1, 1, 0]);
    assert_eq!(problem(flat), "node 0: its scale leaves its light no direction");
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
        {"mesh": 0, "camera": 0},
        {"camera": 1, "name": "shot", "translation": [1, 2, 3], "scale": [5, 5, 5]},
        {"camera": 2}
    ]);
    let scene = parse(document.clone()).unwrap();
    let CameraPose { eye, target, up, vfov } = scene.camera.unwrap();
    assert_eq!((eye, target, up), (Vec3::new(1.0, 2.0, 3.0), Vec3::new(1.0, 2.0, 2.0), Vec3::Y));
    assert!((vfov - 60.0).abs() < 1e-4);
    assert_eq!(
        scene.warnings,
        [
            "model.gltf: camera 0 is not a perspective one and is skipped",
            "model.gltf: of 2 cameras, that of node 1 (\"shot\") is used",
        ]
    );
    let wide = changed(document.clone(), "/cameras/2/perspective/yfov", json!(4));
    assert_eq!(problem(wide), "camera 2: its yfov is 4 radians");
    let flat = changed(document, "/nodes/1/scale", json!([1, 0, 1]));
    assert_eq!(problem(flat), "node 1 (\"shot\"): its scale leaves its camera no direction");
    assert_eq!(parse(triangle()).unwrap().camera, None);
}

#[test]
fn skins_and_morph_targets_are_told() {
    let mut document = with("/nodes/0/skin", json!(0));
    document["meshes"][0]["primitives"][0]["targets"] = json!([{"POSITION": 1}]);
    assert_eq!(
        parse(document).unwrap().warnings,
        ["model.gltf: 1 mesh is shown without the skin", "model.gltf: 1 primitive is shown without the morph targets"]
    );
}

#[test]
fn required_extensions() {
    let required = |names: Value| with("/extensionsRequired", names);
    assert_eq!(
        problem(required(json!(["KHR_draco_mesh_compression", "KHR_lights_punctual", "KHR_mesh_quantization"]))),
        "extensionsRequired: the file requires KHR_draco_mesh_compression, KHR_mesh_quantization, which cannot be read"
    );
    assert_eq!(
        parse(required(json!(["KHR_texture_transform", "KHR_materials_unlit"]))).unwrap().warnings,
        ["model.gltf: the file asks for KHR_texture_transform, KHR_materials_unlit, which is left out"]
    );
}

#[test]
fn wrong_json_and_versions() {
    let wrong = |text: &str| told(read_json(Path::new("model.gltf"), text.as_bytes()));
    assert_eq!(wrong("{\n\"asset\": {\"version\": 2}}"), {
        "line 2: this is not valid glTF: invalid type: integer `2`, expected a string"
    });
    assert_eq!(wrong("{\n\n]"), "line 3: this is not valid glTF: key must be a string");
    assert_eq!(
        wrong("{\"asset\": {\"version\": \"1.0\"}, \"nodes\": {}}"),
        "asset: its version is \"1.0\", which is not 2"
    );
    assert_eq!(wrong("{}"), "asset: it tells no glTF version");
    assert_eq!(
        wrong("{\"asset\": {\"version\": \"2.0\"},\n\"nodes\": {}}"),
        "line 2: this is not valid glTF: invalid type: map, expected a sequence"
    );
}

#[test]
fn buffers() {
    let buffer = |buffer: Value| problem(with("/buffers", json!([buffer])));
    assert_eq!(buffer(json!({"byteLength": 1})), "buffer 0: it has no data");
    let relative = |uri: &str| buffer(json!({"byteLength": 1, "uri": uri}));
    for uri in ["http://host/a.bin", "/a.bin", "%2fa.bin", "file:a.bin", "C:\\a.bin", "a%2", "a%zz", ""] {
        assert_eq!(relative(uri), format!("buffer 0: `{uri}` is not a relative path"));
    }
    assert_eq!(relative("data:text/plain,abc"), "buffer 0: its data URI is not base64");
    assert_eq!(relative("data:;base64,a*=="), "buffer 0: its base64 is wrong: invalid symbol 42, offset 1.");
    assert_eq!(
        buffer(json!({"byteLength": 4, "uri": "data:;base64,AAAA"})),
        "buffer 0: it has 3 bytes, and should have 4"
    );

    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("my data.bin"), triangle_bytes()).unwrap();
    let external = |uri: &str| {
        let document = with("/buffers", json!([{"byteLength": 104, "uri": uri}]));
        read_json(&folder.path().join("model.gltf"), document.to_string().as_bytes())
    };
    assert_eq!(external("my%20data.bin").unwrap().triangle_count(), 1);
    assert_eq!(external("./my data.bin").unwrap().triangle_count(), 1);
    let error = external("lost.bin").unwrap_err();
    assert_eq!((error.file, error.problem.as_str()), (folder.path().join("lost.bin"), "no such file"));
}

#[test]
fn containers() {
    let file = |bytes: &[u8]| told(read_binary(Path::new("model.glb"), bytes));
    let whole = small_glb();
    assert!(read_binary(Path::new("model.glb"), &whole).is_ok());
    assert_eq!(file(&whole[..7]), "GLB container: the file is cut short: it ends after 7 bytes");
    assert_eq!(
        file(&whole[..whole.len() - 1]),
        format!("GLB container: the file is cut short: it announces {} bytes and has {}", whole.len(), whole.len() - 1)
    );
    let damaged = |place: usize, bytes: &[u8]| {
        let mut whole = whole.clone();
        whole[place..place + bytes.len()].copy_from_slice(bytes);
        file(&whole)
    };
    assert_eq!(damaged(4, &[1]), "GLB container: its version is 1, which is not 2");
    assert_eq!(damaged(12, &[255; 4]), "GLB container: the chunk at byte 12 goes beyond the end of the file");
    assert_eq!(damaged(16, b"BIN\0"), "GLB container: its first chunk is not JSON");
    assert_eq!(damaged(8, &12_u32.to_le_bytes()), "GLB container: it has no JSON chunk");
    assert!(damaged(20, b"}").starts_with("JSON chunk, byte "));
    let (mut document, binary) = (triangle(), triangle_bytes());
    document["buffers"] = json!([{"byteLength": 104}, {"byteLength": 104}]);
    assert_eq!(file(&glb(&document, &binary)), "buffer 1: it has no data");
    document["buffers"] = json!([{"byteLength": 105}]);
    assert_eq!(file(&glb(&document, &binary)), "buffer 0: it has 104 bytes, and should have 105");
}
