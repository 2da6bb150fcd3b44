//! The Cornell box as model files gives the same bytes as the built-in one.
//!
//! All numbers survive the files: decimals have as many digits as tell a float from its neighbours, and the emission in
//! glTF is split at a power of two.

use std::fmt::Write as _;
use std::fs;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use glam::Vec3;
use halfdome::film::Picture;
use halfdome::output::read_exr;
use halfdome::scene::{Scene, cornell_box};
use halfdome_tests::program::Program;
use serde_json::{Value, json};
use tempfile::TempDir;

/// A folder with models, and the program in it.
struct Desk {
    folder: TempDir,
}

impl Desk {
    fn new() -> Self {
        Self { folder: tempfile::tempdir().unwrap() }
    }

    fn program(&self) -> Program<'_> {
        Program { executable: env!("CARGO_BIN_EXE_halfdome-under-test"), folder: self.folder.path() }
    }

    /// Renders without a warning; gives the files written, EXR and PNG.
    fn render(&self, scene: &str, options: &str) -> [Vec<u8>; 2] {
        let line = format!("render {scene} -o a.exr -o a.png --progress bar {options}");
        let outcome = self.program().run_reproducibly(&line);
        assert_eq!(outcome.code, Some(0), "{scene}: {}", outcome.stderr);
        assert!(!outcome.stderr.contains("warning"), "{scene}: {}", outcome.stderr);
        ["a.exr", "a.png"].map(|name| fs::read(self.folder.path().join(name)).unwrap())
    }

    fn picture(&self, scene: &str, options: &str) -> Picture {
        self.render(scene, options);
        read_exr(&self.folder.path().join("a.exr")).unwrap()
    }

    /// Asserts that the scene gives the files that the built-in one gives, by all that is in them: colours and first
    /// surfaces, camera and scene hash.
    fn gives_the_built_in_files(&self, scene: &str) {
        for options in [
            "--size 40x32 --spp 8 --seed 5 --aov",
            "--size 40x32 --spp 3 --integrator normals --filter mitchell",
            "--size 40x32 --spp 3 --integrator albedo",
        ] {
            let [exr, png] = self.render(scene, options);
            let [built_in_exr, built_in_png] = self.render("cornell", options);
            assert!(exr == built_in_exr, "{scene} {options}: the EXR differs");
            assert!(png == built_in_png, "{scene} {options}: the PNG differs");
        }
    }
}

/// Three numbers with spaces between them.
fn words(v: Vec3) -> String {
    v.to_array().map(|x| x.to_string()).join(" ")
}

/// A scene file with the camera, which neither OBJ nor PLY has.
fn toml(scene: &Scene, model: &str) -> String {
    let camera = scene.camera.unwrap();
    let [eye, target, up] = [camera.eye, camera.target, camera.up].map(|v| v.as_dvec3().to_array());
    let vfov = f64::from(camera.vfov);
    format!("[scene]\nfile = \"{model}\"\n[camera]\neye = {eye:?}\ntarget = {target:?}\nup = {up:?}\nvfov = {vfov:?}\n")
}

fn obj(scene: &Scene) -> String {
    let mut text = String::from("mtllib box.mtl\n");
    let mut first = 1;
    for mesh in &scene.meshes {
        writeln!(text, "o {}", mesh.name).unwrap();
        for &position in &mesh.positions {
            writeln!(text, "v {}", words(position)).unwrap();
        }
        writeln!(text, "usemtl {}", scene.materials[mesh.material].name).unwrap();
        for [a, b, c] in &mesh.triangles {
            writeln!(text, "f {} {} {}", first + a, first + b, first + c).unwrap();
        }
        first += mesh.positions.len() as u32;
    }
    text
}

fn mtl(scene: &Scene) -> String {
    let materials = scene.materials.iter();
    let text =
        materials.map(|m| format!("newmtl {}\nKd {}\nKe {}\n", m.name, words(m.inputs.base_color), words(m.emission)));
    text.collect()
}

/// Little-endian, as one mesh without materials, which is all that the format has.
fn ply(scene: &Scene) -> Vec<u8> {
    let vertices: usize = scene.meshes.iter().map(|mesh| mesh.positions.len()).sum();
    let header = format!(
        "ply\nformat binary_little_endian 1.0\n\
         element vertex {vertices}\nproperty float x\nproperty float y\nproperty float z\n\
         element face {}\nproperty list uchar int vertex_indices\nend_header\n",
        scene.triangle_count()
    );
    let mut bytes = header.into_bytes();
    bytes.extend(scene.meshes.iter().flat_map(|mesh| position_bytes(&mesh.positions)));
    let mut first = 0;
    for mesh in &scene.meshes {
        for corners in &mesh.triangles {
            bytes.push(3);
            bytes.extend(corners.iter().flat_map(|corner| (first + corner).to_le_bytes()));
        }
        first += mesh.positions.len() as u32;
    }
    bytes
}

fn position_bytes(positions: &[Vec3]) -> Vec<u8> {
    positions.iter().flat_map(Vec3::to_array).flat_map(f32::to_le_bytes).collect()
}

/// Buffer, views and accessors of glTF, as they grow.
#[derive(Default)]
struct Data {
    bytes: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
}

impl Data {
    /// Appends `bytes` with an accessor, which lacks its view; gives the accessor's index.
    fn add(&mut self, bytes: &[u8], mut accessor: Value) -> usize {
        accessor["bufferView"] = self.views.len().into();
        self.views.push(json!({"buffer": 0, "byteOffset": self.bytes.len(), "byteLength": bytes.len()}));
        self.bytes.extend(bytes);
        self.accessors.push(accessor);
        self.accessors.len() - 1
    }
}

/// One node, mesh and primitive for every mesh, in a single base64 buffer, with 16-bit indices.
fn gltf(scene: &Scene) -> String {
    /// More than any emission, whose factors glTF wants up to 1, and a power of two, so that the division is exact.
    const STRENGTH: f32 = 32.0;
    let mut data = Data::default();
    let mut meshes = Vec::new();
    for mesh in &scene.meshes {
        let (lower, upper) = mesh
            .positions
            .iter()
            .fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(lower, upper), &p| (p.min(lower), p.max(upper)));
        let positions = data.add(
            &position_bytes(&mesh.positions),
            json!({
                "componentType": 5126, "type": "VEC3", "count": mesh.positions.len(),
                "min": lower.to_array(), "max": upper.to_array()
            }),
        );
        let corners = mesh.triangles.as_flattened();
        let bytes: Vec<u8> = corners.iter().flat_map(|&corner| (corner as u16).to_le_bytes()).collect();
        let indices = data.add(&bytes, json!({"componentType": 5123, "type": "SCALAR", "count": corners.len()}));
        let primitive = json!({"attributes": {"POSITION": positions}, "indices": indices, "material": mesh.material});
        meshes.push(json!({"name": mesh.name, "primitives": [primitive]}));
    }
    let materials = scene.materials.iter().map(|material| {
        json!({
            "name": material.name,
            "pbrMetallicRoughness": {"baseColorFactor": material.inputs.base_color.extend(1.0).to_array(), "metallicFactor": 0},
            "emissiveFactor": (material.emission / STRENGTH).to_array(),
            "extensions": {
                "KHR_materials_emissive_strength": {"emissiveStrength": STRENGTH},
                "KHR_materials_specular": {"specularFactor": 0}
            }
        })
    });
    let uri = format!("data:application/octet-stream;base64,{}", STANDARD.encode(&data.bytes));
    let document = json!({
        "asset": {"version": "2.0"},
        "extensionsUsed": ["KHR_materials_emissive_strength", "KHR_materials_specular"],
        "buffers": [{"byteLength": data.bytes.len(), "uri": uri}],
        "bufferViews": data.views,
        "accessors": data.accessors,
        "materials": materials.collect::<Vec<_>>(),
        "nodes": (0..meshes.len()).map(|mesh| json!({"mesh": mesh})).collect::<Vec<_>>(),
        "scenes": [{"nodes": (0..meshes.len()).collect::<Vec<_>>()}],
        "scene": 0,
        "meshes": meshes,
    });
    document.to_string()
}

#[test]
fn obj_with_mtl_gives_the_built_in_picture() {
    let (scene, desk) = (cornell_box(), Desk::new());
    desk.program().put("box.obj", obj(&scene));
    desk.program().put("box.mtl", mtl(&scene));
    desk.program().put("box.toml", toml(&scene, "box.obj"));
    desk.gives_the_built_in_files("box.toml");
}

#[test]
fn gltf_gives_the_built_in_picture() {
    let (scene, desk) = (cornell_box(), Desk::new());
    desk.program().put("box.gltf", gltf(&scene));
    desk.program().put("box.toml", toml(&scene, "box.gltf"));
    // The scene hash differs, by what glTF says of highlights that are not there.
    let options = "--size 40x32 --spp 8 --seed 5 --aov";
    let [picture, built_in] = ["box.toml", "cornell"].map(|scene| desk.picture(scene, options));
    assert_eq!(picture.metadata.world_to_camera, built_in.metadata.world_to_camera);
    assert_eq!(picture.channels, built_in.channels);
}

/// PLY has no materials: all is equal but the reflectance, which is the default grey.
#[test]
fn ply_gives_the_built_in_geometry() {
    let (scene, desk) = (cornell_box(), Desk::new());
    desk.program().put("box.ply", ply(&scene));
    desk.program().put("box.toml", toml(&scene, "box.ply"));
    let options = "--size 40x32 --spp 8 --seed 5 --aov --integrator normals";
    let (picture, built_in) = (desk.picture("box.toml", options), desk.picture("cornell", options));
    assert_eq!((picture.channels.len(), picture.metadata.world_to_camera), (36, built_in.metadata.world_to_camera));
    for (channel, expected) in picture.channels.iter().zip(&built_in.channels) {
        assert_eq!(channel.name, expected.name);
        // A PLY file is one object of one material.
        if !["Albedo", "Id."].iter().any(|other| channel.name.starts_with(other)) {
            let bits = |values: &[f32]| values.iter().map(|value| value.to_bits()).collect::<Vec<_>>();
            assert!(bits(&channel.values) == bits(&expected.values), "{} differs", channel.name);
        } else {
            let covered = |values: &[f32]| values.iter().map(|value| *value > 0.0).collect::<Vec<_>>();
            assert!(covered(&channel.values) == covered(&expected.values), "{} covers other pixels", channel.name);
            let most = channel.values.iter().copied().fold(0.0, f32::max);
            let expected = match channel.name.as_str() {
                "Id.Object" | "Id.Material" => 1.0,
                "Id.Triangle" => most.min(32.0),
                "Id.Instance" => 0.0,
                _ => 0.5,
            };
            assert_eq!(most, expected, "{}", channel.name);
        }
    }
}
