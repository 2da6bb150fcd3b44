//! Animations of nodes, cameras, lights, skins and morph targets, and their errors.

use glam::Vec3;
use serde_json::json;

use super::*;

/// A triangle that goes from x = 0 to 4 within two seconds, and a camera that turns by a quarter about y in one.
fn moving() -> Model {
    let mut model = Model::triangle();
    let times = model.floats("SCALAR", 2, &[0.0, 2.0]);
    let places = model.floats("VEC3", 2, &[0.0, 0.0, 0.0, 4.0, 0.0, 0.0]);
    let second = model.floats("SCALAR", 2, &[0.0, 1.0]);
    // Rotations about y by 0 and a quarter, as normalised integers: 23170 / 32767 is sqrt(1/2).
    let turns: [[i16; 4]; 2] = [[0, 0, 0, 32767], [0, 23170, 0, 23170]];
    let turns = turns.as_flattened().iter().flat_map(|number| number.to_le_bytes()).collect();
    let turns = model.add(turns, 5122, "VEC4", 2);
    model.document["accessors"][turns]["normalized"] = json!(true);
    model.document["cameras"] = json!([{"type": "perspective", "perspective": {"yfov": 1, "znear": 1}}]);
    model.document["nodes"] = json!([{"mesh": 0, "scale": [2, 2, 2]}, {"camera": 0, "translation": [0, 0, 9]}]);
    model.document["animations"] = json!([
        {
            "name": "Walk",
            "channels": [{"sampler": 0, "target": {"node": 0, "path": "translation"}}],
            "samplers": [{"input": times, "output": places}]
        },
        {
            "channels": [{"sampler": 0, "target": {"node": 1, "path": "rotation"}}],
            "samplers": [{"input": second, "output": turns, "interpolation": "LINEAR"}]
        }
    ]);
    model
}

#[test]
fn nodes_are_where_animations_say() {
    let model = moving();
    let still = model.read().unwrap();
    assert_eq!((still.warnings.len(), still.meshes[0].positions[0]), (0, Vec3::ZERO));
    let animations = ["Walk", "1"].iter().zip([2.0, 1.0]);
    let animations = animations.map(|(&name, end)| Animation { name: name.to_owned(), begin: 0.0, end });
    assert_eq!(still.animations, animations.collect::<Vec<_>>());
    for (time, x, angle) in
        [(-1.0, 0.0, 0.0), (0.5, 1.0, 45.0_f32), (1.0, 2.0, 90.0), (1.5, 3.0, 90.0), (9.0, 4.0, 90.0)]
    {
        let scene = model.read_at(time, &[]).unwrap();
        assert_eq!(scene.warnings, Vec::<String>::new());
        // The scale is the node's own.
        assert_eq!(scene.meshes[0].positions[1], Vec3::new(x + 2.0, 0.0, 0.0), "{time}");
        let camera = scene.camera.unwrap();
        let forward = Vec3::new(-angle.to_radians().sin(), 0.0, -angle.to_radians().cos());
        assert!((camera.target - camera.eye).distance(forward) < 2e-4, "{time}: {camera:?}");
        assert_eq!(scene.hash() == still.hash(), time < 0.0, "{time}");
    }
    let one = model.read_at(1.0, &["Walk"]).unwrap();
    assert_eq!((one.meshes[0].positions[0].x, one.camera), (2.0, still.camera));
    let error = model.read_at(1.0, &["Wolk"]).unwrap_err().to_string();
    assert_eq!(error, "model.gltf: the model has no animation \"Wolk\"\n  help: did you mean `Walk`?");
}

#[test]
fn a_matrix_gives_way_to_what_is_animated() {
    let mut model = moving();
    model.document["nodes"][0] = json!({"mesh": 0, "matrix": [3, 0, 0, 0, 0, 3, 0, 0, 0, 0, 3, 0, 7, 8, 9, 1]});
    assert_eq!(model.read_at(1.0, &[]).unwrap().meshes[0].positions[1], Vec3::new(5.0, 0.0, 0.0));
}

#[test]
fn of_animations_that_move_the_same_the_first_plays() {
    let mut model = moving();
    let mut run = model.document["animations"][0].clone();
    run["name"] = json!("Run");
    run["samplers"][0]["interpolation"] = json!("STEP");
    model.document["animations"].as_array_mut().unwrap().push(run);
    let both = model.read_at(1.0, &[]).unwrap();
    assert_eq!(both.meshes[0].positions[0].x, 2.0);
    assert_eq!(
        both.warnings,
        ["model.gltf: animations that move what \"Walk\" moves are not played (--animation chooses): \"Run\""]
    );
    let run = model.read_at(1.0, &["Run"]).unwrap();
    assert_eq!((run.meshes[0].positions[0].x, run.warnings.len()), (0.0, 0));
}

#[test]
fn morph_targets_are_animated_whatever_the_node_says() {
    let mut model = moving();
    let delta = model.floats("VEC3", 3, &[0.0, 0.0, 1.0].repeat(3));
    model.document["meshes"][0]["primitives"][0]["targets"] = json!([{"POSITION": delta}, {"POSITION": delta}]);
    model.document["nodes"][0]["weights"] = json!([9, 9]);
    let weights = model.add(vec![0, 0, 255, 51], 5121, "SCALAR", 4);
    let animation = &mut model.document["animations"][0];
    let input = animation["samplers"][0]["input"].clone();
    animation["samplers"] = json!([{"input": input, "output": weights}]);
    animation["channels"][0]["target"]["path"] = json!("weights");
    // Half of (1 + 0.2), at twice the size.
    let position = model.read_at(1.0, &[]).unwrap().meshes[0].positions[0];
    assert!(position.distance(Vec3::new(0.0, 0.0, 1.2)) < 1e-6, "{position}");
    model.document["animations"][0]["channels"][0]["target"]["node"] = json!(1);
    assert_eq!(
        model.read_at(1.0, &[]).unwrap().warnings,
        ["model.gltf: weights of a node without morph targets are animated, which changes nothing: animation 0 \
          (\"Walk\"), channel 0"]
    );
}

#[test]
fn pointers_are_told_and_channels_without_a_node_ignored() {
    let mut model = moving();
    model.document["extensionsRequired"] = json!(["KHR_animation_pointer"]);
    model.document["animations"][0]["channels"] = json!([
        {"sampler": 0, "target": {"path": "pointer", "extensions": {"KHR_animation_pointer": {"pointer": "/x"}}}},
        {"sampler": 0, "target": {"path": "scale"}}
    ]);
    let scene = model.read_at(1.0, &[]).unwrap();
    let warning = "model.gltf: KHR_animation_pointer is not read: animation 0 (\"Walk\"), channel 0";
    assert_eq!((scene.warnings, scene.meshes[0].positions[0]), (vec![warning.to_owned()], Vec3::ZERO));
}

#[test]
fn wrong_animations_are_told() {
    let change = |pointer: &str, value: Value| {
        let mut model = moving();
        model.document = changed(model.document, pointer, value);
        told(model.read_at(0.0, &[]))
    };
    let place = "animation 0 (\"Walk\"), channel 0";
    let channel = "/animations/0/channels/0";
    assert_eq!(
        change(&format!("{channel}/sampler"), json!(1)),
        format!("{place}: it refers to sampler 1, which does not exist")
    );
    assert_eq!(
        change(&format!("{channel}/target/node"), json!(5)),
        format!("{place}: it refers to node 5, which does not exist")
    );
    assert_eq!(
        change(&format!("{channel}/target/path"), json!("spin")),
        format!("{place}: its path \"spin\" is unknown")
    );
    let sampler = "/animations/0/samplers/0";
    assert_eq!(
        change(&format!("{sampler}/interpolation"), json!("CUBIC")),
        format!("{place}: its interpolation \"CUBIC\" is unknown")
    );
    assert_eq!(
        change(&format!("{sampler}/interpolation"), json!("CUBICSPLINE")),
        format!("{place}: its 2 keys need 18 numbers, and accessor 5 has 6")
    );
    assert_eq!(
        change(&format!("{sampler}/output"), json!(4)),
        "accessor 4: it is SCALAR of float, and serves as translations"
    );
    assert_eq!(
        change("/animations", json!([{"channels": 3}])),
        "animations: this is not valid glTF: invalid type: integer `3`, expected a sequence"
    );
    for (times, problem) in [
        ([1.0, 0.5], "its keys are out of order: 1 s comes before 0.5 s"),
        ([0.0, f32::NAN], "the time of key 1 is not finite"),
    ] {
        let mut model = moving();
        let input = model.floats("SCALAR", 2, &times);
        model.document["animations"][0]["samplers"][0]["input"] = json!(input);
        assert_eq!(told(model.read_at(0.0, &[])), format!("{place}: {problem}"));
        // Who does not play it can use the file.
        let warning = format!("model.gltf: animations that are not played are wrong: {place}: {problem}");
        assert_eq!(model.read().unwrap().warnings, [warning]);
    }
    let mut model = moving();
    let zero = model.floats("VEC4", 2, &[0.0; 8]);
    model.document["animations"][1]["samplers"][0]["output"] = json!(zero);
    assert_eq!(told(model.read_at(0.0, &[])), "animation 1, channel 0: its rotation at key 0 is zero");
}

#[test]
fn lines_count_through_animations() {
    let text = "{\n\"asset\": {\"version\": \"2.0\"},\n\"animations\": [\n\n],\n\"nodes\": {}}";
    assert_eq!(
        told(read_json(&Disk, Path::new("model.gltf"), text.as_bytes(), &LoadOptions::default())),
        "line 6: this is not valid glTF: invalid type: map, expected a sequence"
    );
}
