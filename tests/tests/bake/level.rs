//! A small level as glTF: a room, a lamp, and two crates that share a mesh.

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use serde_json::{Value, json};

/// The corners and triangles of a unit cube at the origin, each side with corners of its own; fronts look outwards.
fn cube() -> (Vec<[f32; 3]>, Vec<u16>) {
    let (mut positions, mut indices) = (Vec::new(), Vec::new());
    for axis in 0..3 {
        for side in [0.0, 1.0] {
            let first = positions.len() as u16;
            for (u, v) in [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)] {
                let mut corner = [0.0; 3];
                (corner[axis], corner[(axis + 1) % 3], corner[(axis + 2) % 3]) = (side, u, v);
                positions.push(corner);
            }
            let order = if side == 1.0 { [0, 1, 2, 0, 2, 3] } else { [0, 2, 1, 0, 3, 2] };
            indices.extend(order.map(|i| first + i));
        }
    }
    (positions, indices)
}

/// The level.
pub(crate) fn level() -> Value {
    inwards(outwards())
}

/// The level with a room whose fronts look outwards.
pub(crate) fn outwards() -> Value {
    let (positions, indices) = cube();
    let mut bytes: Vec<u8> = positions.iter().flatten().flat_map(|value| value.to_le_bytes()).collect();
    let split = bytes.len();
    bytes.extend(indices.iter().flat_map(|index| index.to_le_bytes()));
    let uri = format!("data:application/octet-stream;base64,{}", STANDARD.encode(&bytes));
    let mesh =
        |material: usize| json!({"primitives": [{"attributes": {"POSITION": 0}, "indices": 1, "material": material}]});
    json!({
        "asset": {"version": "2.0", "generator": "by hand"},
        "extensionsUsed": ["EXT_unknown"],
        "buffers": [{"byteLength": bytes.len(), "uri": uri}],
        "bufferViews": [{"buffer": 0, "byteLength": split}, {"buffer": 0, "byteOffset": split, "byteLength": bytes.len() - split}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": positions.len(), "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 1]},
            {"bufferView": 1, "componentType": 5123, "count": indices.len(), "type": "SCALAR"}
        ],
        "materials": [
            {"name": "walls", "pbrMetallicRoughness": {"baseColorFactor": [0.8, 0.7, 0.6, 1]}, "extras": {"keep": 1.50}},
            {"name": "lamp", "pbrMetallicRoughness": {"baseColorFactor": [0, 0, 0, 1]}, "emissiveFactor": [1, 1, 1]}
        ],
        "meshes": [mesh(0), mesh(0), mesh(1)],
        "nodes": [
            {"name": "room", "mesh": 0, "scale": [-4, 3, 4], "translation": [4, 0, 0], "extensions": {"EXT_unknown": {"a": [1, 2]}}},
            {"name": "crate one", "mesh": 1, "translation": [0.5, 0, 0.5]},
            {"name": "crate two", "mesh": 1, "translation": [2.5, 0, 2], "scale": [0.8, 0.5, 0.8]},
            {"name": "lamp", "mesh": 2, "translation": [1.5, 2.8, 1.5], "scale": [1, 0.1, 1]}
        ]
    })
}

/// Turns the room inside out. Its node mirrors it, which does not: glTF turns the winding with it.
fn inwards(mut level: Value) -> Value {
    let (_, mut indices) = cube();
    indices.chunks_exact_mut(3).for_each(|triangle| triangle.swap(1, 2));
    let bytes: Vec<u8> = indices.iter().flat_map(|index| index.to_le_bytes()).collect();
    let uri = format!("data:application/octet-stream;base64,{}", STANDARD.encode(&bytes));
    let mut push = |list: &str, value: Value| level[list].as_array_mut().expect("a list").push(value);
    push("buffers", json!({"byteLength": bytes.len(), "uri": uri}));
    push("bufferViews", json!({"buffer": 1, "byteLength": bytes.len()}));
    push("accessors", json!({"bufferView": 2, "componentType": 5123, "count": indices.len(), "type": "SCALAR"}));
    level["meshes"][0]["primitives"][0]["indices"] = json!(2);
    level
}

/// The level with all materials seen from both sides, as exporters call most of them.
pub(crate) fn double_sided(mut level: Value) -> Value {
    for material in level["materials"].as_array_mut().expect("a list") {
        material["doubleSided"] = json!(true);
    }
    level
}

/// The level with crates that lack their last triangle.
pub(crate) fn open_crates(mut level: Value) -> Value {
    let count = level["accessors"][1]["count"].as_u64().expect("a number") - 3;
    level["accessors"]
        .as_array_mut()
        .expect("a list")
        .push(json!({"bufferView": 1, "componentType": 5123, "count": count, "type": "SCALAR"}));
    level["meshes"][1]["primitives"][0]["indices"] = json!(3);
    level
}
