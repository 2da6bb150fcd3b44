//! Warnings about models and light.

use super::*;

#[test]
fn bodies_that_are_inside_out_are_told_and_rooms_are_not() {
    let told = |meshes: Vec<Mesh>, materials: Vec<Material>| {
        let scene = scene(meshes, materials);
        model_warnings(&scene, &World::for_light_query(scene.clone(), LightQuery::Surfaces).unwrap())
    };
    let matte = || vec![glowing(0.0, 0.5), glowing(1.0, 0.5)];
    let at = |name: &str, from: f32, to: f32, inwards| hollow(name, Vec3::splat(from), Vec3::splat(to), inwards);
    let lamp = || Mesh { material: 1, ..at("lamp", 4.0, 4.2, false) };
    let flipped =
        told(vec![at("crate", 0.0, 1.0, true), at("chest", 2.0, 3.0, true), at("box", 5.0, 6.0, false)], matte());
    let [warning] = &flipped[..] else { panic!("{flipped:?}") };
    assert!(warning.starts_with("2 meshes are closed and inside out"), "{warning}");
    assert!(warning.contains("mesh 0 (\"crate\") and mesh 1 (\"chest\")") && warning.contains("Shift+N"), "{warning}");
    // One of two pieces of a mesh, among what is wound outwards.
    let mut two = at("two", 0.0, 1.0, false);
    let other = at("", 2.0, 3.0, true);
    two.triangles.extend(other.triangles.iter().map(|triangle| triangle.map(|corner| corner + 24)));
    two.positions.extend(other.positions);
    assert!(told(vec![two], matte())[0].contains("1 mesh is closed and inside out"));
    let open = |mut mesh: Mesh| {
        mesh.triangles.pop();
        mesh
    };
    for fine in [
        vec![at("room", 0.0, 9.0, true), lamp()],
        vec![at("house", -1.0, 10.0, false), at("room", 0.0, 9.0, true), at("table", 1.0, 2.0, false)],
        vec![at("hollow ball", -1.0, 10.0, false), at("its inner wall", 0.0, 9.0, true)],
        vec![Mesh { material: 1, ..at("furnace", 0.0, 1.0, true) }],
        vec![open(at("shell", 0.0, 1.0, true))],
        vec![at("crate", 0.0, 1.0, false)],
    ] {
        let name = fine[0].name.clone();
        assert_eq!(told(fine, matte()), Vec::<String>::new(), "{name}");
    }
}

#[test]
fn warnings_name_meshes() {
    let mut thin = hollow("thin", Vec3::ZERO, Vec3::ONE, false);
    thin.triangles.push([0, 0, 1]);
    let scene = Scene { files: vec!["a.glb".into()], ..scene(vec![thin], vec![glowing(1.0, 0.5)]) };
    let world = World::new(scene.clone()).unwrap();
    let expected = "a.glb: 1 triangle with two equal corners is dropped: mesh 0 (\"thin\")";
    assert_eq!(model_warnings(&scene, &world), [expected]);
    let mixed = Statistics { texels: 9, mixed: 1, ..Statistics::default() };
    let told = crate::bake::warnings(&world, &BakeOptions::default(), &[], &mixed, &[0]);
    let expected =
        "seams may show at 1 point: charts of the model's own coordinates are too close in mesh 0 (\"thin\")";
    assert!(told.iter().any(|warning| warning == expected), "{told:?}");
}
