//! Shared meshes.

use glam::Vec3;

use super::*;
use crate::scene::Sharing;

/// Three nodes with the triangle, one of them mirrored, and one with another mesh of the same triangle.
fn forest() -> Value {
    let mut document = triangle();
    let mesh = document["meshes"][0].clone();
    document["meshes"] = json!([mesh, mesh]);
    document["nodes"] = json!([
        {"mesh": 0, "name": "a", "translation": [5, 0, 0]},
        {"mesh": 1, "name": "b"},
        {"mesh": 0, "children": [3]},
        {"mesh": 0, "scale": [-2, 1, 1]}
    ]);
    document
}

fn read(document: &Value, sharing: Sharing) -> Result<Scene, SceneError> {
    parse_as(document.clone(), &triangle_bytes(), &LoadOptions { sharing, ..LoadOptions::default() })
}

/// Where the second corner of each triangle is shown.
fn shown(scene: &Scene) -> Vec<Vec3> {
    let in_world = scene.meshes.iter().filter(|mesh| mesh.object.is_none()).map(|mesh| mesh.positions[1]);
    let instances = scene.instances.iter().map(|it| {
        let mesh = scene.meshes.iter().find(|mesh| mesh.object == Some(it.object)).unwrap();
        it.to_world.transform_point3(mesh.positions[1])
    });
    in_world.chain(instances).collect()
}

#[test]
fn shared_meshes_are_kept_once_and_shown_where_their_nodes_are() {
    let shared = read(&forest(), Sharing::Always).unwrap();
    assert_eq!((shared.meshes.len(), shared.objects.len(), shared.instances.len()), (2, 1, 3));
    assert_eq!(shown(&shared), [Vec3::X, Vec3::new(6.0, 0.0, 0.0), Vec3::X, Vec3::new(-2.0, 0.0, 0.0)]);
    let copied = read(&forest(), Sharing::Never).unwrap();
    assert_eq!((copied.meshes.len(), copied.instances.len()), (4, 0));
    assert_eq!((shared.triangle_count(), shared.bounds()), (copied.triangle_count(), copied.bounds()));
    // A few triangles are not worth it.
    assert_eq!(read(&forest(), Sharing::Auto).unwrap(), copied);
}

#[test]
fn nodes_with_many_places() {
    let extension = |attributes: Value| {
        let mut document = triangle();
        document["nodes"][0] = json!({"mesh": 0, "scale": [2, 2, 2], "extensions": {"EXT_mesh_gpu_instancing": {"attributes": attributes}}});
        document["extensionsUsed"] = json!(["EXT_mesh_gpu_instancing"]);
        document["extensionsRequired"] = json!(["EXT_mesh_gpu_instancing"]);
        document
    };
    // The triangle's corners as translations.
    let document = extension(json!({"TRANSLATION": 0, "_ID": 7}));
    for sharing in [Sharing::Always, Sharing::Never] {
        let scene = read(&document, sharing).unwrap();
        assert_eq!(scene.instances.len(), if sharing == Sharing::Always { 3 } else { 0 });
        assert_eq!(shown(&scene), [Vec3::X * 2.0, Vec3::X * 4.0, Vec3::new(2.0, 2.0, 0.0)]);
        assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
    }
    let told = |attributes: Value| told(read(&extension(attributes), Sharing::Always));
    assert_eq!(told(json!({})), "node 0: its EXT_mesh_gpu_instancing has no attributes");
    assert_eq!(told(json!({"TRANSLATION": 9})), "node 0: it refers to accessor 9, which does not exist");
    let mut uneven = extension(json!({"TRANSLATION": 0, "SCALE": 4}));
    uneven["accessors"]
        .as_array_mut()
        .unwrap()
        .push(json!({"bufferView": 0, "componentType": 5126, "count": 2, "type": "VEC3"}));
    let problem = super::told(read(&uneven, Sharing::Never));
    assert_eq!(problem, "node 0: its EXT_mesh_gpu_instancing has 3 values of one attribute and 2 of another");
    uneven["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"] = json!({"ROTATION": 2});
    assert!(super::told(read(&uneven, Sharing::Never)).contains("ROTATION"));
}

#[test]
fn animations_move_instances() {
    let mut model = Model { document: forest(), bytes: triangle_bytes() };
    let (input, output) =
        (model.floats("SCALAR", 2, &[0.0, 1.0]), model.floats("VEC3", 2, &[0.0, 0.0, 0.0, 0.0, 8.0, 0.0]));
    model.document["animations"] = json!([{
        "channels": [{"sampler": 0, "target": {"node": 0, "path": "translation"}}],
        "samplers": [{"input": input, "output": output}]
    }]);
    let places = |sharing| {
        let moment = Some(Moment { time: 0.5, animations: Vec::new() });
        let options = LoadOptions { sharing, moment, ..LoadOptions::default() };
        let mut scene = parse_as(model.document.clone(), &model.bytes, &options).unwrap();
        assert_eq!(scene.instances.is_empty(), sharing == Sharing::Never);
        scene.place_instances();
        scene.bounds().unwrap()
    };
    assert_eq!(places(Sharing::Always), places(Sharing::Never));
    assert_eq!(places(Sharing::Always).1.y, 5.0);
}
