//! Accessors and primitives.

use ::gltf::json::mesh::Mode;
use glam::{Vec2, Vec3};
use serde_json::json;

use super::*;
use crate::scene::formats::gltf::attributes::triangles;

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
fn points_and_lines_are_skipped_if_they_have_no_radius() {
    for mode in 0..4 {
        let scene = parse(with("/meshes/0/primitives/0/mode", json!(mode))).unwrap();
        assert!(scene.meshes.is_empty());
        assert_eq!(
            scene.warnings,
            ["model.gltf: 1 primitive of points or lines is skipped: --point-radius shows them"]
        );
    }
    let shown = |document| {
        let options = LoadOptions { point_radius: Some(0.125), ..LoadOptions::default() };
        parse_as(document, &triangle_bytes(), &options)
    };
    let (ball, tube) = (320, 24);
    for (mode, expected) in [(0, 3 * ball), (2, 3 * (ball + tube)), (3, 3 * ball + 2 * tube)] {
        let scene = shown(with("/meshes/0/primitives/0/mode", json!(mode))).unwrap();
        assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
        let mesh = one_mesh(scene);
        assert_eq!(mesh.triangles.len(), expected, "mode {mode}");
        assert!(mesh.origin.is_none() && mesh.texcoords.len() == mesh.positions.len());
        let reach = mesh.positions.iter().fold(0.0f32, |reach, p| reach.max(p.max_element()));
        assert!((reach - 1.125).abs() < 0.01, "{reach}");
    }
    // Two ends each; what is over belongs to no line. Indices are checked.
    let lines = |mode: u32, indices: Value| {
        let mut document = with("/meshes/0/primitives/0/mode", json!(mode));
        document["meshes"][0]["primitives"][0]["indices"] = indices;
        document
    };
    assert_eq!(one_mesh(shown(lines(1, json!(3))).unwrap()).triangles.len(), 2 * ball + tube);
    let mut wrong = lines(0, json!(3));
    wrong["accessors"][3]["count"] = json!(1);
    wrong["accessors"][3]["byteOffset"] = json!(2);
    assert_eq!(one_mesh(shown(wrong.clone()).unwrap()).triangles.len(), ball);
    wrong["accessors"][0]["count"] = json!(2);
    wrong["accessors"][1]["count"] = json!(2);
    wrong["accessors"][2]["count"] = json!(2);
    assert_eq!(told(shown(wrong)), "accessor 3: it holds the index 2, but mesh 0, primitive 0 has 2 vertices");
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
        ("/accessors/1/count", json!(2), "mesh 0, primitive 0: it has 3 positions but 2 normals"),
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
