//! Models for tests, intact or damaged.

use serde_json::{Value, json};

pub(crate) const TRIANGLE: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";

/// A glTF document of one triangle: positions at byte 0, three 16-bit indices at byte 36.
pub(crate) fn document() -> Value {
    json!({
        "asset": {"version": "2.0"},
        "buffers": [{"byteLength": 44}],
        "bufferViews": [
            {"buffer": 0, "byteLength": 36},
            {"buffer": 0, "byteOffset": 36, "byteLength": 6}
        ],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"},
            {"bufferView": 1, "componentType": 5123, "count": 3, "type": "SCALAR"}
        ],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "nodes": [{"mesh": 0}],
        "scenes": [{"nodes": [0]}],
        "scene": 0
    })
}

/// The binary chunk of [`document`].
pub(crate) fn binary(positions: [[f32; 3]; 3], indices: [u16; 3]) -> Vec<u8> {
    let positions = positions.into_iter().flatten().flat_map(f32::to_le_bytes);
    positions.chain(indices.into_iter().flat_map(u16::to_le_bytes)).chain([0, 0]).collect()
}

pub(crate) const POSITIONS: [[f32; 3]; 3] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];

/// A GLB container.
pub(crate) fn glb(document: &Value, binary: &[u8]) -> Vec<u8> {
    let mut text = document.to_string().into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    let length = |bytes: usize| (bytes as u32).to_le_bytes();
    let mut glb = b"glTF\x02\0\0\0".to_vec();
    glb.extend(length(12 + 8 + text.len() + 8 + binary.len()));
    for (kind, chunk) in [(b"JSON", text.as_slice()), (b"BIN\0", binary)] {
        glb.extend(length(chunk.len()));
        glb.extend(kind);
        glb.extend(chunk);
    }
    glb
}

/// The document with `value` at a JSON pointer.
pub(crate) fn with(pointer: &str, value: Value) -> Value {
    let mut document = document();
    let (parent, key) = pointer.rsplit_once('/').unwrap();
    let parent = document.pointer_mut(parent).unwrap();
    match key.parse::<usize>() {
        Ok(index) if parent.is_array() => parent[index] = value,
        _ => parent[key] = value,
    }
    document
}
