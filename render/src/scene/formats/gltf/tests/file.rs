//! The file as a whole: versions, extensions, buffers, containers.

use serde_json::{Value, json};

use super::*;

#[test]
fn required_extensions() {
    let required = |names: Value| with("/extensionsRequired", names);
    assert_eq!(
        problem(required(json!(["EXT_mesh_features", "KHR_lights_punctual", "MSFT_lod"]))),
        "extensionsRequired: the file requires EXT_mesh_features, MSFT_lod, which cannot be read"
    );
    assert_eq!(
        parse(required(json!(["KHR_materials_unlit", "KHR_materials_subsurface"]))).unwrap().warnings,
        ["model.gltf: KHR_materials_subsurface is not read"]
    );
    let mut used = with("/extensionsUsed", json!(["EXT_mesh_features", "KHR_materials_ior", "ACME_shine"]));
    used["materials"] = json!([{"name": "wax", "extensions": {"ACME_shine": {}}}]);
    assert_eq!(
        parse(used).unwrap().warnings,
        ["model.gltf: ACME_shine is not read: material 0 (\"wax\")", "model.gltf: EXT_mesh_features is not read"]
    );
}

#[test]
fn wrong_json_and_versions() {
    let wrong = |text: &str| told(read_json(&Disk, Path::new("model.gltf"), text.as_bytes(), &LoadOptions::default()));
    assert_eq!(wrong("{\n\"asset\": {\"version\": 2}}"), {
        "line 2: this is not valid glTF: invalid type: integer `2`, expected a string"
    });
    assert_eq!(wrong("{\n\n]"), "line 3: this is not valid glTF: key must be a string");
    assert_eq!(
        wrong("{\"asset\": {\"version\": \"1.0\"}, \"nodes\": {}}"),
        "asset: its version is \"1.0\", which is not 2"
    );
    assert_eq!(wrong("{}"), "asset: it has no glTF version");
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
        read_json(&Disk, &folder.path().join("model.gltf"), document.to_string().as_bytes(), &LoadOptions::default())
    };
    assert_eq!(external("my%20data.bin").unwrap().triangle_count(), 1);
    assert_eq!(external("./my data.bin").unwrap().triangle_count(), 1);
    let error = external("lost.bin").unwrap_err();
    assert_eq!((error.file, error.problem.as_str()), (folder.path().join("lost.bin"), "no such file"));
}

#[test]
fn containers() {
    let file = |bytes: &[u8]| told(read_binary(&Disk, Path::new("model.glb"), bytes, &LoadOptions::default()));
    let whole = small_glb();
    assert!(read_binary(&Disk, Path::new("model.glb"), &whole, &LoadOptions::default()).is_ok());
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
    assert_eq!(damaged(20, b"}"), "JSON chunk, line 1, column 1: this is not valid glTF: expected value");
    let (mut document, binary) = (triangle(), triangle_bytes());
    document["buffers"] = json!([{"byteLength": 104}, {"byteLength": 104}]);
    assert_eq!(file(&glb(&document, &binary)), "buffer 1: it has no data");
    document["buffers"] = json!([{"byteLength": 105}]);
    assert_eq!(file(&glb(&document, &binary)), "buffer 0: it has 104 bytes, and should have 105");
}
