//! Files with unusual formatting that are patched, and read back by the scene's loader and by the crate `gltf`.

use glam::Vec3;
use serde_json::Value;

use super::assembly::container;
use super::*;
use crate::scene::formats::gltf::{read_binary, read_json};
use crate::scene::{Disk, LoadOptions, Scene};

/// Four positions at byte 0, colours of three bytes at a stride of four from 48 on, and a strip of 16-bit indices
/// 0 1 2 3 at 64.
fn quad_bytes() -> Vec<u8> {
    let positions = [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.0, 1.0, 0.0], [2.0, 1.0, 0.5]];
    let mut bytes: Vec<u8> = positions.as_flattened().iter().flat_map(|number: &f32| number.to_le_bytes()).collect();
    bytes.extend((0..4).flat_map(|vertex| [10 + vertex, 20 + vertex, 30 + vertex, 99]));
    bytes.extend([0, 0, 1, 0, 2, 0, 3, 0]);
    bytes
}

/// Two nodes show a mesh of two quads, one of them mirrored; spelled as no program would.
const NODES: &str = r#"[ {"mesh":0 ,"name":"w\u00e4nde","extras":{"x":1.50e0}}, {"mesh":0,"scale":[-1,1.0,1]} ]"#;
const MATERIALS: &str = r#"[{"name":"a\/b","extensions":{"EXT_unknown":[1e2,{"x":null}]} , "extras":"kept"} ]"#;

fn json(nodes: &str, buffer: &str) -> String {
    format!(
        r#" {{ "asset" : {{"version":"2.0", "generator":"caf\u00e9"}},"extensionsUsed":["EXT_unknown"],
    "extras":{{"z":[ 1,2 ]}}, "buffers":[{{"byteLength":72{buffer}}}], "materials":{MATERIALS},
    "bufferViews":[{{"buffer":0,"byteLength":48}},{{"buffer":0,"byteOffset":48,"byteStride":4,"byteLength":16}},
      {{"buffer":0,"byteOffset":64,"byteLength":8}}],
    "accessors":[{{"bufferView":0,"componentType":5126,"count":4,"type":"VEC3","min":[0,0,0],"max":[2,1,0.5]}},
      {{"bufferView":1,"componentType":5121,"normalized":true,"count":4,"type":"VEC3"}},
      {{"bufferView":2,"componentType":5123,"count":4,"type":"SCALAR"}}],
    "meshes":[{{"name":"quads","primitives":[
      {{"attributes":{{"POSITION":0,"COLOR_0":1}},"indices":2,"mode":5,"material":0,"targets":[{{"POSITION":0}}]}},
      {{"attributes":{{"POSITION":0}},"indices":2,"mode":5,"extras":[7]}}]}}],
    "scenes":[{{"nodes":[0,1]}}], "scene":0,
    "nodes":{nodes} }} "#
    )
}

/// The file as a container with a chunk of unknown kind.
fn quads(nodes: &str) -> Vec<u8> {
    container(json(nodes, ""), Some(quad_bytes()), &[b"\x04\0\0\0WHATabcd"]).unwrap()
}

fn scene(file: &[u8]) -> Scene {
    let path = Path::new("a.glb");
    if file.starts_with(b"glTF") {
        read_binary(&Disk, path, file, &LoadOptions::default())
    } else {
        read_json(&Disk, path, file, &LoadOptions::default())
    }
    .unwrap()
}

fn text(file: &[u8]) -> &str {
    let (_, chunks) = open(Path::new("a.glb"), file).unwrap();
    str::from_utf8(chunks.json).unwrap()
}

fn root(file: &[u8]) -> Value {
    serde_json::from_str(text(file)).unwrap()
}

/// What a baker would say of a mesh.
struct Owned {
    mesh: Mesh,
    page: usize,
    sources: Vec<u32>,
    uvs: Vec<Vec2>,
    triangles: Vec<[u32; 3]>,
}

impl Owned {
    /// Every vertex where it was, on one chart.
    fn whole(mesh: &Mesh, page: usize) -> Self {
        let uvs = mesh.positions.iter().map(|p| Vec2::new(0.25 * p.x.abs(), 0.5 * p.y)).collect();
        let (sources, triangles) = ((0..mesh.positions.len() as u32).collect(), mesh.triangles.clone());
        Self { mesh: mesh.clone(), page, sources, uvs, triangles }
    }

    /// Every triangle from `first` to `last` a chart of its own, the last triangle first.
    fn split(mesh: &Mesh, page: usize, faces: std::ops::Range<usize>) -> Self {
        let sources: Vec<u32> = mesh.triangles[faces].iter().rev().flatten().copied().collect();
        let uvs = (0..sources.len()).map(|corner| Vec2::new(0.125 * corner as f32, 0.5)).collect();
        let triangles = (0..sources.len() as u32 / 3).map(|face| [3 * face, 3 * face + 1, 3 * face + 2]).collect();
        Self { mesh: mesh.clone(), page, sources, uvs, triangles }
    }

    fn part(&self) -> Part<'_> {
        let Self { mesh, page, sources, uvs, triangles } = self;
        Part { mesh, page: *page, sources, uvs, triangles }
    }
}

fn patched(file: &[u8], parts: &[Owned], target: Target) -> Patched {
    let parts: Vec<Part> = parts.iter().map(Owned::part).collect();
    let pages = [Page { file: "light 0.hdr", embedded: None }, Page { file: "light1.exr", embedded: Some(b"EXR") }];
    let patched = patch(Path::new("a.glb"), file, &parts, &pages, (target, &[])).unwrap();
    if file.starts_with(b"glTF") {
        // Another reader, with a validator of its own.
        ::gltf::Gltf::from_slice(&patched.bytes).unwrap();
    }
    patched
}

/// Corners of all triangles with their lightmap coordinates, in an order of their own.
fn corners(triangles: impl Iterator<Item = [(Vec3, Vec2); 3]>) -> Vec<Vec<f32>> {
    let flat = |corners: [(Vec3, Vec2); 3]| corners.iter().flat_map(|(p, uv)| [p.x, p.y, p.z, uv.x, uv.y]).collect();
    let mut all: Vec<Vec<f32>> = triangles.map(flat).collect();
    all.sort_by(|a, b| a.partial_cmp(b).unwrap());
    all
}

fn corners_of_parts(parts: &[Owned]) -> Vec<Vec<f32>> {
    let corner = |part: &Owned, vertex: u32| {
        let vertex = vertex as usize;
        (part.mesh.positions[part.sources[vertex] as usize], part.uvs[vertex])
    };
    corners(parts.iter().flat_map(|part| part.triangles.iter().map(|t| t.map(|vertex| corner(part, vertex)))))
}

fn corners_of_scene(scene: &Scene) -> Vec<Vec<f32>> {
    let corner = |mesh: &Mesh, vertex: u32| {
        (mesh.positions[vertex as usize], mesh.lightmap_texcoords.get(vertex as usize).copied().unwrap_or_default())
    };
    corners(scene.meshes.iter().flat_map(|mesh| mesh.triangles.iter().map(|t| t.map(|vertex| corner(mesh, vertex)))))
}

#[test]
fn all_that_is_not_touched_survives_byte_for_byte() {
    let file = quads(NODES);
    let parts: Vec<Owned> = scene(&file).meshes.iter().map(|mesh| Owned::split(mesh, 0, 0..2)).collect();
    let new = patched(&file, &parts, Target::Bevy);
    assert!(new.warnings.is_empty());
    let (old_text, new_text) = (text(&file), text(&new.bytes));
    for (name, old) in text::members(old_text) {
        let new = text::member(new_text, &name).unwrap();
        match name.as_str() {
            "nodes" | "meshes" | "buffers" => {}
            "accessors" | "bufferViews" => {
                let (old, new) = (text::elements(old), text::elements(new));
                assert!(new.len() > old.len() && new[..old.len()] == old, "{name} only grow");
            }
            _ => assert_eq!(new, old, "{name}"),
        }
    }
    assert_eq!(text::members(new_text).len(), text::members(old_text).len());
    let nodes = text::elements(text::member(new_text, "nodes").unwrap());
    let extras = r#""extras":{"x":1.50e0,"halfdome_lightmaps":["light 0.hdr","light 0.hdr"]}"#;
    assert_eq!(nodes[0], format!(r#"{{"mesh":0 ,"name":"w\u00e4nde",{extras}}}"#));
    let (old_chunks, new_chunks) =
        (open(Path::new("a.glb"), &file).unwrap().1, open(Path::new("a.glb"), &new.bytes).unwrap().1);
    assert!(new_chunks.binary.unwrap().starts_with(old_chunks.binary.unwrap()), "binary data only grow");
    assert_eq!(new_chunks.others, old_chunks.others);
}

#[test]
fn whole_charts_share_the_geometry() {
    let file = quads(NODES);
    let parts: Vec<Owned> = scene(&file).meshes[..2].iter().map(|mesh| Owned::whole(mesh, 0)).collect();
    let new = patched(&file, &parts, Target::Bevy);
    let root = root(&new.bytes);
    assert_eq!(root["accessors"].as_array().unwrap().len(), 3 + 2, "two sets of coordinates");
    // The other node, which has no lightmap, keeps the old mesh.
    assert_eq!((&root["nodes"][0]["mesh"], &root["nodes"][1]["mesh"]), (&1.into(), &0.into()));
    assert_eq!(root["meshes"][0], self::root(&file)["meshes"][0]);
    let primitive = &root["meshes"][1]["primitives"][0];
    let attributes = serde_json::json!({"POSITION": 0, "COLOR_0": 1, "TEXCOORD_0": 3, "TEXCOORD_1": 3});
    assert_eq!(
        (&primitive["attributes"], &primitive["indices"], &primitive["mode"]),
        (&attributes, &2.into(), &5.into())
    );
    let again = scene(&new.bytes);
    assert_eq!(again.meshes[0].lightmap_texcoords, parts[0].uvs);
    assert!(again.meshes[2].lightmap_texcoords.is_empty());

    // A lightmap with the same coordinates changes nothing of the mesh.
    let same: Vec<Owned> = again.meshes[..2]
        .iter()
        .map(|mesh| Owned { uvs: mesh.lightmap_texcoords.clone(), ..Owned::whole(mesh, 0) })
        .collect();
    let twice = patched(&new.bytes, &same, Target::Bevy);
    assert_eq!(twice.bytes, new.bytes);
}

#[test]
fn cut_vertices_keep_all_attributes_and_every_node_its_own_coordinates() {
    let file = quads(NODES);
    let meshes = scene(&file).meshes;
    // One primitive lies on two pages.
    let mut parts = vec![Owned::split(&meshes[0], 0, 0..1), Owned::split(&meshes[0], 1, 1..2)];
    parts.extend(meshes[1..].iter().map(|mesh| Owned::split(mesh, 1, 0..2)));
    for (number, part) in parts.iter_mut().enumerate() {
        part.uvs.iter_mut().for_each(|uv| uv.y += 0.0625 * number as f32);
    }
    for target in [Target::Bevy, Target::Three] {
        let new = patched(&file, &parts, target);
        let again = scene(&new.bytes);
        assert_eq!(corners_of_scene(&again), corners_of_parts(&parts), "also winding, where a node mirrors");
        assert_eq!(again.meshes.len(), 5);
        let root = root(&new.bytes);
        let primitive = &root["meshes"][0]["primitives"][1];
        let accessor = |index: &Value| root["accessors"][index.as_u64().unwrap() as usize].clone();
        let positions = accessor(&primitive["attributes"]["POSITION"]);
        assert_eq!(positions["count"], 3);
        assert_eq!(positions["min"], serde_json::json!([0.0, 0.0, 0.0]));
        assert_eq!(positions["max"], serde_json::json!([2.0, 1.0, 0.5]));
        assert_eq!((&primitive["mode"], &primitive["targets"].as_array().unwrap().len()), (&4.into(), &1));
        let colors = accessor(&primitive["attributes"]["COLOR_0"]);
        assert_eq!((&colors["componentType"], &colors["normalized"]), (&5121.into(), &true.into()));
        let view = &root["bufferViews"][colors["bufferView"].as_u64().unwrap() as usize];
        let start = view["byteOffset"].as_u64().unwrap() as usize;
        let binary = open(Path::new("a.glb"), &new.bytes).unwrap().1.binary.unwrap().to_vec();
        // The second triangle of a strip is 1 3 2 (or 2 1 3).
        let expected: Vec<u8> = meshes[0].triangles[1]
            .iter()
            .flat_map(|&v| [10, 20, 30, 0].map(|c| if c > 0 { c + v as u8 } else { 0 }))
            .collect();
        assert_eq!(binary[start..start + 12], expected);
    }
}

#[test]
fn materials_are_copied_where_pages_or_surfaces_differ() {
    let file = quads(NODES);
    let meshes = scene(&file).meshes;
    let material = |root: &Value, mesh: usize, primitive: usize| {
        let number = root["meshes"][mesh]["primitives"][primitive]["material"].as_u64().unwrap() as usize;
        (number, root["materials"][number]["extensions"]["MOZ_lightmap"]["index"].as_u64())
    };
    // All on one page: the material changes where it is, and the one that there was not is made.
    let all: Vec<Owned> = meshes.iter().map(|mesh| Owned::whole(mesh, 1)).collect();
    let new = patched(&file, &all, Target::Three);
    let root = root(&new.bytes);
    assert_eq!(
        [material(&root, 0, 0), material(&root, 1, 0), material(&root, 0, 1)],
        [(0, Some(1)), (0, Some(1)), (1, Some(1))]
    );
    let lightmap = r#""MOZ_lightmap":{"index":1,"intensity":1.0,"texCoord":1}"#;
    let expected = MATERIALS.replace(r#"{"x":null}]"#, &format!(r#"{{"x":null}}],{lightmap}"#));
    let materials = text::member(text(&new.bytes), "materials").unwrap();
    assert_eq!(materials, expected.replace("} ]", &format!(r#"}},{{"extensions":{{{lightmap}}}}} ]"#)));

    // On two pages, and one node without any.
    let some = [Owned::whole(&meshes[0], 0)];
    let root = self::root(&patched(&file, &some, Target::Three).bytes);
    assert_eq!((material(&root, 1, 0), material(&root, 0, 0)), ((1, Some(0)), (0, None)));
    assert_eq!(root["materials"][1]["extras"], "kept");
    let two = [Owned::whole(&meshes[0], 0), Owned::whole(&meshes[2], 1)];
    let root = self::root(&patched(&file, &two, Target::Three).bytes);
    assert_eq!((material(&root, 0, 0), material(&root, 1, 0)), ((1, Some(0)), (2, Some(1))));
}

#[test]
fn pages_are_textures_for_three() {
    let file = quads(NODES);
    let parts: Vec<Owned> = scene(&file).meshes.iter().map(|mesh| Owned::whole(mesh, 0)).collect();
    let new = patched(&file, &parts, Target::Three);
    let root = root(&new.bytes);
    assert_eq!(root["images"][0]["uri"], "light%200.hdr");
    assert_eq!(root["images"][0]["mimeType"], "image/vnd.radiance");
    assert_eq!(root["textures"][0]["extensions"]["MOZ_texture_rgbe"]["source"], 0);
    assert_eq!(root["textures"][1]["source"], 1);
    assert_eq!(root["samplers"][0]["wrapS"], 33071);
    let view = &root["bufferViews"][root["images"][1]["bufferView"].as_u64().unwrap() as usize];
    let start = view["byteOffset"].as_u64().unwrap() as usize;
    let binary = open(Path::new("a.glb"), &new.bytes).unwrap().1.binary.unwrap().to_vec();
    assert_eq!(&binary[start..start + view["byteLength"].as_u64().unwrap() as usize], b"EXR");
    assert_eq!(external_files(Path::new("a.glb"), &new.bytes), Ok(vec!["light%200.hdr".to_owned()]));
    assert_eq!(external_files(Path::new("a.glb"), &file), Ok(vec![]));
    let profiles =
        r#"{"asset":{"version":"2.0"},"extensions":{"EXT_lights_ies":{"lights":[{"uri":"a.ies"},{"uri":"data:,"}]}}}"#;
    assert_eq!(external_files(Path::new("a.gltf"), profiles.as_bytes()), Ok(vec!["a.ies".to_owned()]));
    let used = serde_json::json!(["EXT_unknown", "MOZ_lightmap", "MOZ_texture_rgbe"]);
    assert_eq!(root["extensionsUsed"], used);
    assert!(root["extensionsRequired"].is_null() && root["nodes"][0]["extras"]["halfdome_lightmaps"].is_null());
}

#[test]
fn json_files_stay_json() {
    use base64::Engine as _;
    let uri = base64::engine::general_purpose::STANDARD.encode(quad_bytes());
    let file = json(NODES, &format!(",\"uri\":\"data:;base64,{uri}\""));
    let meshes = scene(file.as_bytes()).meshes;
    let parts: Vec<Owned> = meshes.iter().map(|mesh| Owned::split(mesh, 0, 0..2)).collect();
    let new = patched(file.as_bytes(), &parts, Target::Bevy);
    assert_eq!(corners_of_scene(&scene(&new.bytes)), corners_of_parts(&parts));
    let buffers = text::elements(text::member(text(&new.bytes), "buffers").unwrap()).len();
    assert_eq!(buffers, 2);
    // A container whose data are not in it gets its new data in a buffer, too.
    let file = container(file, None, &[]).unwrap();
    let new = patched(&file, &parts, Target::Bevy);
    assert_eq!(corners_of_scene(&scene(&new.bytes)), corners_of_parts(&parts));
}

#[test]
fn what_cannot_be_patched_is_told() {
    let file = quads(NODES);
    let meshes = scene(&file).meshes;
    let page = [Page { file: "a.ktx2", embedded: None }];
    let problem = |file: &[u8], part: Owned| {
        let error = patch(Path::new("a.glb"), file, &[part.part()], &page, (Target::Bevy, &[])).unwrap_err();
        error.problem
    };
    let whole = || Owned::whole(&meshes[0], 0);
    assert_eq!(problem(b"glTF", whole()), "the file is cut short: it ends after 4 bytes");
    assert_eq!(problem(&file, Owned { page: 1, ..whole() }), "its page or a coordinate of a vertex is missing");
    assert_eq!(problem(&file, Owned { sources: vec![0, 1, 2, 4], ..whole() }), "it names a vertex that is not there");
    assert_eq!(problem(&file, Owned { triangles: vec![[0, 1, 4]], ..whole() }), "it names a vertex that is not there");
    let mut other = whole();
    other.mesh.origin = None;
    assert_eq!(problem(&file, other), "it is not of a glTF file");
    let swapped = quads(r#"[{},{"mesh":0}]"#);
    assert_eq!(problem(&swapped, whole()), "the file has no mesh 0 at node 0");

    // A texture needs the coordinates that would be replaced.
    let baked =
        patched(&file, &meshes.iter().map(|mesh| Owned::whole(mesh, 0)).collect::<Vec<_>>(), Target::Bevy).bytes;
    let json = text(&baked).replace(r#""extras":"kept""#, r#""occlusionTexture":{"index":0,"texCoord":1}"#);
    let json = json.replace(r#""scene":0"#, r#""scene":0,"images":[{"uri":"a.png"}],"textures":[{"source":0}]"#);
    let binary = open(Path::new("a.glb"), &baked).unwrap().1.binary.map(<[u8]>::to_vec);
    let textured = container(json, binary, &[]).unwrap();
    let part = Owned::split(&scene(&textured).meshes[0], 0, 0..2);
    assert_eq!(problem(&textured, part), "it has a texture that uses TEXCOORD_1, which the lightmap needs");

    let odd = quads(r#"[{"mesh":0,"extras":[1]},{"mesh":0}]"#);
    let new = patched(&odd, &[whole()], Target::Bevy);
    assert_eq!(new.warnings, ["node 0: its extras are no object, so the manifest alone names its lightmap"]);
    assert_eq!(root(&new.bytes)["nodes"][0]["extras"], serde_json::json!([1]));
}
