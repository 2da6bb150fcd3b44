//! The node hierarchy.

use core::f32::consts::FRAC_PI_4;

use glam::{Mat3, Vec3};
use serde_json::{Value, json};

use super::*;

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
fn blender_bends_normals_before_a_node_scales_them() {
    let space = |generator: &str, scale: [f32; 3]| {
        let mut document = with("/asset/generator", json!(generator));
        document["nodes"] = json!([{"mesh": 0, "scale": scale}]);
        one_mesh(parse(document).unwrap()).map_space
    };
    let [blender, other] = ["Khronos glTF Blender I/O v5.0.21", "another"];
    let scale = [2.0, 3.0, 0.5];
    assert_eq!(space(blender, scale), Some(Mat3::from_diagonal(Vec3::from(scale))));
    assert_eq!(space(blender, [3.0; 3]), None, "before and after are the same");
    assert_eq!(space(other, scale), None, "glTF bends them afterwards");
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

/// Blender's default export leaves lights and cameras out, and an area light is an empty node.
#[test]
fn what_blender_leaves_out_is_told() {
    let mut document = triangle();
    document["nodes"] = json!([{"mesh": 0}, {"name": "Area"}]);
    assert!(parse(document.clone()).unwrap().warnings.is_empty());
    document["asset"]["generator"] = json!("Khronos glTF Blender I/O v5.0.21");
    let warnings = parse(document).unwrap().warnings;
    assert_eq!(
        warnings,
        [
            "model.gltf: empty nodes; Blender leaves one of each area light, which glTF does not have, and of each mesh \
             without faces: node 1 (\"Area\")",
            "model.gltf: the file has neither lights nor cameras; Blender exports them with Include > Punctual Lights and \
             Cameras",
        ]
    );
}

/// A lamp that was turned off by a mistake would only be missed in the picture.
#[test]
fn lights_without_strength_are_told() {
    let mut document = triangle();
    let light = |intensity: f32| json!({"type": "point", "intensity": intensity});
    document["extensions"] = json!({"KHR_lights_punctual": {"lights": [light(0.0), light(2.0)]}});
    let node =
        |name: &str, light: usize| json!({"name": name, "extensions": {"KHR_lights_punctual": {"light": light}}});
    document["nodes"] = json!([{"mesh": 0}, node("Off", 0), node("On", 1)]);
    let warnings = parse(document).unwrap().warnings;
    let told: Vec<&String> = warnings.iter().filter(|it| it.contains("strength")).collect();
    assert_eq!(told, ["model.gltf: lights with a strength of 0 emit nothing: node 1 (\"Off\")"]);
}
