//! Skins and morph targets, against vertices computed by hand.

use glam::{Quat, Vec3};
use serde_json::json;

use super::*;

fn assert_near(found: &[Vec3], expected: &[[f32; 3]]) {
    assert_eq!(found.len(), expected.len());
    for (found, &expected) in found.iter().zip(expected) {
        assert!(found.distance(expected.into()) < 1e-6, "{found} {expected:?}");
    }
}

/// An arm of two bones from (0, 0, 0) over (0, 2, 0) upwards, of which the upper one is turned by a quarter about z.
/// The triangle's corners follow the lower one, both and the upper one.
fn arm() -> Model {
    let mut model = Model::triangle();
    let positions = model.floats("VEC3", 3, &[0.5, 0.0, 0.0, 1.0, 2.0, 0.0, 0.0, 3.0, 0.0]);
    let joints = model.add(vec![0, 0, 0, 0, 0, 1, 0, 0, 0, 1, 9, 9], 5121, "VEC4", 3);
    // Their sums are not 1; joint 9 does not exist.
    let weights = [[1.0, 0.0, 0.0, 0.0], [0.25, 0.25, 0.0, 0.0], [0.0, 2.0, 0.0, 0.0]];
    let weights = model.floats("VEC4", 3, weights.as_flattened());
    let mut binds = [[0.0; 16]; 2];
    for (slot, bind) in binds.iter_mut().enumerate() {
        (bind[0], bind[5], bind[10], bind[15], bind[13]) = (1.0, 1.0, 1.0, 1.0, -2.0 * slot as f32);
    }
    let binds = model.floats("MAT4", 2, binds.as_flattened());
    model.document["meshes"][0]["primitives"][0]["attributes"] =
        json!({"POSITION": positions, "NORMAL": 1, "JOINTS_0": joints, "WEIGHTS_0": weights});
    model.document["skins"] = json!([{"joints": [1, 2], "inverseBindMatrices": binds}]);
    let turn = Quat::from_rotation_z(core::f32::consts::FRAC_PI_2).to_array();
    model.document["nodes"] = json!([
        {"mesh": 0, "skin": 0, "translation": [100, 0, 0]},
        {"children": [2]},
        {"translation": [0, 2, 0], "rotation": turn}
    ]);
    model
}

#[test]
fn a_mean_of_joints_takes_vertices_to_the_world() {
    let mut model = arm();
    let scene = model.read().unwrap();
    assert_eq!(scene.warnings, Vec::<String>::new());
    let mesh = one_mesh(scene);
    // The second corner is where (1, 2, 0) and (0, 3, 0) meet. The mesh's own node does not count.
    assert_near(&mesh.positions, &[[0.5, 0.0, 0.0], [0.5, 2.5, 0.0], [-1.0, 2.0, 0.0]]);
    assert_near(&mesh.normals, &[[0.0, 0.0, 1.0], [0.0, 0.0, 1.0], [0.0, 0.6, 0.8]]);
    assert_eq!((mesh.triangles, mesh.origin.unwrap().mirrored), (vec![[0, 1, 2]], false));
    // Without inverse bind matrices they are the identity.
    model.document["skins"][0] = json!({"joints": [1, 2]});
    assert_near(&one_mesh(model.read().unwrap()).positions, &[[0.5, 0.0, 0.0], [-0.5, 2.5, 0.0], [-3.0, 2.0, 0.0]]);
}

#[test]
fn sets_of_joints_add_up() {
    let mut model = arm();
    let attributes = model.document["meshes"][0]["primitives"][0]["attributes"].clone();
    let weights = model.add([[0_u8; 4], [255, 255, 0, 0], [0; 4]].concat(), 5121, "VEC4", 3);
    let all = &mut model.document["meshes"][0]["primitives"][0]["attributes"];
    (all["JOINTS_1"], all["WEIGHTS_1"]) = (attributes["JOINTS_0"].clone(), json!(weights));
    // Weights 0.25 + 1 for both.
    assert_near(&one_mesh(model.read().unwrap()).positions[1..2], &[[0.5, 2.5, 0.0]]);
    let weights = model.add([[0_u8; 4], [0, 255, 0, 0], [0; 4]].concat(), 5121, "VEC4", 3);
    model.document["meshes"][0]["primitives"][0]["attributes"]["WEIGHTS_1"] = json!(weights);
    // 0.25 of (1, 2, 0) and 1.25 of (0, 3, 0).
    assert_near(&one_mesh(model.read().unwrap()).positions[1..2], &[[1.0 / 6.0, 17.0 / 6.0, 0.0]]);
}

#[test]
fn skeletons_that_mirror_flip_the_winding() {
    let mut model = arm();
    model.document["nodes"][1]["scale"] = json!([-1, 1, 1]);
    let mesh = one_mesh(model.read().unwrap());
    assert_near(&mesh.positions[2..], &[[1.0, 2.0, 0.0]]);
    assert_eq!((mesh.triangles, mesh.origin.unwrap().mirrored), (vec![[0, 2, 1]], true));
}

#[test]
fn vertices_and_primitives_without_weights_are_told() {
    let mut model = arm();
    let weights = model.floats("VEC4", 3, &[0.0; 12]);
    model.document["meshes"][0]["primitives"][0]["attributes"]["WEIGHTS_0"] = json!(weights);
    let scene = model.read().unwrap();
    assert_eq!(scene.warnings, ["model.gltf: 3 vertices are bound to the first listed joint: weights are missing"]);
    assert_near(&one_mesh(scene).positions, &[[0.5, 0.0, 0.0], [1.0, 2.0, 0.0], [0.0, 3.0, 0.0]]);
    model.document["meshes"][0]["primitives"][0]["attributes"] = json!({"POSITION": 0});
    let scene = model.read().unwrap();
    assert_eq!(scene.warnings, ["model.gltf: 1 primitive is shown without the skin: JOINTS_0 is missing"]);
    assert_eq!(one_mesh(scene).positions[0], Vec3::new(100.0, 0.0, 0.0));
}

#[test]
fn wrong_skins_are_told() {
    let change = |pointer: &str, value: Value| {
        let model = arm();
        told(parse_with(changed(model.document, pointer, value), &model.bytes))
    };
    assert_eq!(change("/nodes/0/skin", json!(3)), "node 0: it refers to skin 3, which does not exist");
    assert_eq!(change("/skins/0/joints", json!([])), "skin 0: it has no joints");
    assert_eq!(change("/skins/0/joints", json!([1, 7])), "skin 0: it refers to node 7, which does not exist");
    assert_eq!(change("/skins/0/joints", json!([1, 2, 1])), "skin 0: it has 3 joints but 2 inverse bind matrices");
    assert_eq!(
        change("/skins/0/joints", json!([1])),
        "mesh 0, primitive 0: vertex 1 follows joint 1, but its skin has 1 joint"
    );
    let shape = change("/skins/0/inverseBindMatrices", json!(0));
    assert_eq!(shape, "accessor 0: it is VEC3 of float, and serves as inverse bind matrices");
    let no_weights = change("/meshes/0/primitives/0/attributes", json!({"POSITION": 0, "JOINTS_0": 5}));
    assert_eq!(no_weights, "mesh 0, primitive 0: it has JOINTS_0 without WEIGHTS_0");
    let mut outside = arm();
    (outside.document["scenes"], outside.document["scene"]) = (json!([{"nodes": [0]}]), json!(0));
    assert_eq!(told(outside.read()), "skin 0: its joint node 1 is not in the scene");
    let mut nan = arm();
    let weights = nan.floats("VEC4", 3, &[f32::NAN; 12]);
    nan.document["meshes"][0]["primitives"][0]["attributes"]["WEIGHTS_0"] = json!(weights);
    assert_eq!(told(nan.read()), "mesh 0, primitive 0: WEIGHTS_0 of vertex 0 are [NaN, NaN, NaN, NaN]");
    let binds = nan.floats("MAT4", 2, &[0.5; 32]);
    nan.document["skins"][0]["inverseBindMatrices"] = json!(binds);
    assert_eq!(told(nan.read()), "skin 0: its inverse bind matrix 0 is not finite or not affine");
}

/// Two targets: one moves all by x, the other the last vertex by y, in a sparse accessor, and normals by z.
fn morphed() -> Model {
    let mut model = Model::triangle();
    let first = model.floats("VEC3", 3, &[1.0, 0.0, 0.0].repeat(3));
    let index = model.add(vec![2], 5121, "SCALAR", 1);
    let value = model.floats("VEC3", 1, &[0.0, 4.0, 0.0]);
    let view = |model: &Model, accessor: usize| model.document["accessors"][accessor]["bufferView"].clone();
    let sparse = json!({
        "count": 1,
        "indices": {"bufferView": view(&model, index), "componentType": 5121},
        "values": {"bufferView": view(&model, value)}
    });
    let second = json!({"componentType": 5126, "type": "VEC3", "count": 3, "sparse": sparse});
    model.document["accessors"].as_array_mut().unwrap().push(second);
    let normals = model.floats("VEC3", 3, &[0.0, 0.0, -2.0].repeat(3));
    model.document["meshes"][0]["primitives"][0]["targets"] =
        json!([{"POSITION": first}, {"POSITION": value + 1, "NORMAL": normals}]);
    model
}

#[test]
fn weights_of_the_node_or_of_the_mesh_move_vertices_towards_targets() {
    let mut model = morphed();
    assert_near(&one_mesh(model.read().unwrap()).positions, &[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
    model.document["meshes"][0]["weights"] = json!([0.5, 1.0]);
    let mesh = one_mesh(model.read().unwrap());
    assert_near(&mesh.positions, &[[0.5, 0.0, 0.0], [1.5, 0.0, 0.0], [0.5, 5.0, 0.0]]);
    // (0, 0, 1), (0, 0, 2) as it is stored, less 2, and (0.6, 0, 0.8 - 2): where nothing is left, all are flat.
    assert!(mesh.normals.is_empty());
    model.document["nodes"][0]["weights"] = json!([-1, 0.25]);
    let mesh = one_mesh(model.read().unwrap());
    assert_near(&mesh.positions, &[[-1.0, 0.0, 0.0], [0.0, 0.0, 0.0], [-1.0, 2.0, 0.0]]);
    assert_near(&mesh.normals[2..], &[[0.6_f32.hypot(0.3).recip() * 0.6, 0.0, 0.6_f32.hypot(0.3).recip() * 0.3]]);
}

#[test]
fn quantized_targets_and_tangents() {
    let mut model = Model::triangle();
    let deltas = model.add(vec![127, 0, 0, 0, 127, 0, 0, 0, 0x81], 5120, "VEC3", 3);
    model.document["accessors"][deltas]["normalized"] = json!(true);
    let tangents = model.floats("VEC4", 3, &[1.0, 0.0, 0.0, -1.0].repeat(3));
    let turned = model.floats("VEC3", 3, &[-1.0, 0.0, 2.0].repeat(3));
    model.document["extensionsUsed"] = json!(["KHR_mesh_quantization"]);
    let primitive = &mut model.document["meshes"][0]["primitives"][0];
    primitive["attributes"]["TANGENT"] = json!(tangents);
    primitive["targets"] = json!([{"POSITION": deltas, "TANGENT": turned}]);
    model.document["meshes"][0]["weights"] = json!([1]);
    let mesh = one_mesh(model.read().unwrap());
    assert_near(&mesh.positions, &[[1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, -1.0]]);
    assert_eq!(mesh.tangents, [[glam::Vec4::new(0.0, 0.0, 1.0, -1.0); 3]]);
}

#[test]
fn wrong_targets_are_told() {
    let mut model = morphed();
    model.document["meshes"][0]["weights"] = json!([0.5]);
    let scene = model.read().unwrap();
    assert_eq!(scene.warnings, ["model.gltf: 1 primitive has not as many morph targets as weights"]);
    assert_near(&one_mesh(scene).positions[..1], &[[0.5, 0.0, 0.0]]);
    model.document["meshes"][0]["weights"] = json!([0.5, 0.5]);
    let short = model.floats("VEC3", 2, &[0.0; 6]);
    let mut cut = model.document.clone();
    cut["meshes"][0]["primitives"][0]["targets"][0] = json!({"POSITION": short});
    assert_eq!(
        told(parse_with(cut, &model.bytes)),
        "mesh 0, primitive 0: it has 3 positions but 2 deltas of a morph target"
    );
    let infinite = model.floats("VEC3", 3, &[f32::INFINITY; 9]);
    model.document["meshes"][0]["primitives"][0]["targets"][1]["NORMAL"] = json!(infinite);
    assert_eq!(told(model.read()), "mesh 0, primitive 0: target 1, NORMAL: the delta of vertex 0 is not finite");
}
