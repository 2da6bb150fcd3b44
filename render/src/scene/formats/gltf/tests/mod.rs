//! Documents that the tests of this folder change and read.

mod animations;
mod deformation;
mod extensions;
mod file;
mod geometry;
mod nodes;
mod sharing;
mod surfaces;
mod textures;

use serde_json::{Value, json};

use super::*;
use crate::scene::{Disk, Mesh};

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
fn parse_with(document: Value, bytes: &[u8]) -> Result<Scene, SceneError> {
    parse_as(document, bytes, &LoadOptions::default())
}

/// The same by another method.
fn parse_as(mut document: Value, bytes: &[u8], options: &LoadOptions) -> Result<Scene, SceneError> {
    use base64::Engine;
    if document["buffers"].is_null() {
        let data = base64::engine::general_purpose::STANDARD_NO_PAD.encode(bytes);
        let uri = format!("data:application/octet-stream;base64,{data}");
        document["buffers"] = json!([{"byteLength": bytes.len(), "uri": uri}]);
    }
    read_json(&Disk, Path::new("model.gltf"), document.to_string().as_bytes(), options)
}

/// The triangle, to which accessors can be added.
struct Model {
    document: Value,
    bytes: Vec<u8>,
}

impl Model {
    fn triangle() -> Self {
        Self { document: triangle(), bytes: triangle_bytes() }
    }

    /// Adds an accessor of `count` elements; gives its index.
    fn add(&mut self, bytes: Vec<u8>, component: u32, shape: &str, count: usize) -> usize {
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        let view = json!({"buffer": 0, "byteOffset": self.bytes.len(), "byteLength": bytes.len()});
        self.bytes.extend(bytes);
        let views = self.document["bufferViews"].as_array_mut().unwrap();
        views.push(view);
        let number = views.len() - 1;
        let accessor = json!({"bufferView": number, "componentType": component, "type": shape, "count": count});
        let accessors = self.document["accessors"].as_array_mut().unwrap();
        accessors.push(accessor);
        accessors.len() - 1
    }

    fn floats(&mut self, shape: &str, count: usize, numbers: &[f32]) -> usize {
        self.add(numbers.iter().flat_map(|number| number.to_le_bytes()).collect(), 5126, shape, count)
    }

    fn read(&self) -> Result<Scene, SceneError> {
        parse_with(self.document.clone(), &self.bytes)
    }

    fn read_at(&self, time: f64, names: &[&str]) -> Result<Scene, SceneError> {
        let animations = names.iter().map(|&name| name.to_owned()).collect();
        let options = LoadOptions { moment: Some(Moment { time, animations }), ..LoadOptions::default() };
        parse_as(self.document.clone(), &self.bytes, &options)
    }
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
