//! Motion vectors and numbers of instances, against known positions.

use std::collections::BTreeMap;

use glam::{Affine3A, Vec3};
use halfdome::scene::{CameraPose, Instance, Material, Mesh, Motion, Object, Scene, Sky};
use halfdome::settings::Settings;
use halfdome_tests::render::render;

use crate::values;

/// A square of side 2 at height `z`, seen by [`camera_above`].
fn square(z: f32) -> Mesh {
    let corner = |x: f32, y: f32| Vec3::new(x, y, z);
    Mesh {
        positions: vec![corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        ..Mesh::default()
    }
}

/// Looks down along -z from the height 4, with 45° up and down: at the height 0 a pixel of 40 is 0.2 wide.
fn camera_above() -> CameraPose {
    CameraPose { eye: Vec3::Z * 4.0, target: Vec3::ZERO, up: Vec3::Y, vfov: 90.0 }
}

/// The vectors of pixels that show an object, or of those that show none.
fn vectors(scene: &Scene, shows: impl Fn(f32) -> bool) -> Vec<[f32; 2]> {
    let settings = Settings { width: 40, height: 40, aov: true, spp: 4, ..Settings::default() };
    let picture = render(scene, &settings);
    let objects = values(&picture, "Id.Object").iter();
    let vectors = values(&picture, "forward.u").iter().zip(values(&picture, "forward.v")).map(|(u, v)| [*u, *v]);
    objects.zip(vectors).filter(|(object, _)| shows(**object)).map(|(_, vector)| vector).collect()
}

fn assert_all(vectors: &[[f32; 2]], expected: [f32; 2]) {
    assert!(vectors.len() > 50);
    for [u, v] in vectors {
        assert!((u - expected[0]).abs() < 1e-3 && (v - expected[1]).abs() < 1e-3, "{u} {v}, not {expected:?}");
    }
}

#[test]
fn motion_vectors_are_the_way_on_the_film_from_the_opening_of_the_shutter_to_its_closing() {
    let way = Vec3::new(0.6, 0.4, 0.0);
    let by = |key: usize| way * (0.5 * key as f32 - 0.5);
    let moved = |mesh: &Mesh| -> Vec<Vec<Vec3>> {
        (0..3).map(|key| mesh.positions.iter().map(|&position| position + by(key)).collect()).collect()
    };
    let still = Scene {
        meshes: vec![square(0.0)],
        materials: vec![Material::default()],
        sky: Sky { radiance: Vec3::ONE, picture: None },
        camera: Some(camera_above()),
        ..Scene::default()
    };
    let keys = Motion { keys: 3, ..Motion::default() };
    // Vertices that move: 0.2 is a pixel, y points up in both.
    let meshes = BTreeMap::from([(0, moved(&still.meshes[0]))]);
    let deformed = Scene { motion: Some(Motion { meshes, ..keys.clone() }), ..still.clone() };
    assert_all(&vectors(&deformed, |object| object == 1.0), [3.0, 2.0]);
    assert!(
        vectors(&deformed, |object| object == 0.0).iter().all(|vector| *vector == [0.0; 2]),
        "the sky stands still"
    );
    // An instance that moves, towards a camera that stands still: what is off the axis goes outwards.
    let mut shared = still.clone();
    shared.objects = vec![Object::default()];
    shared.meshes[0].object = Some(0);
    shared.instances = vec![Instance { object: 0, to_world: Affine3A::IDENTITY }];
    let at_keys = |way: Vec3| (0..3).map(|key| Affine3A::from_translation(way * (0.5 * key as f32 - 0.5))).collect();
    let instances = BTreeMap::from([(0, at_keys(way))]);
    let instanced = Scene { motion: Some(Motion { instances, ..keys.clone() }), ..shared.clone() };
    assert_all(&vectors(&instanced, |object| object == 1.0), [3.0, 2.0]);
    // A camera that moves: surfaces go the other way, what is infinitely far away stays.
    let pose = |key: usize| CameraPose { eye: Vec3::Z * 4.0 + by(key), target: by(key), ..camera_above() };
    let moving =
        Scene { motion: Some(Motion { cameras: (0..3).map(pose).collect(), ..keys.clone() }), ..still.clone() };
    assert_all(&vectors(&moving, |object| object == 1.0), [-3.0, -2.0]);
    assert_all(&vectors(&moving, |object| object == 0.0), [0.0, 0.0]);
    // With as much of both nothing moves on the film.
    let instances = BTreeMap::from([(0, at_keys(way))]);
    let both = Motion { instances, cameras: (0..3).map(pose).collect(), ..keys };
    assert_all(&vectors(&Scene { motion: Some(both), ..shared }, |object| object == 1.0), [0.0, 0.0]);
    assert!(vectors(&still, |_| true).iter().all(|vector| *vector == [0.0; 2]));
}

#[test]
fn instances_have_numbers() {
    let scene = Scene {
        meshes: vec![Mesh { object: Some(0), ..square(0.0) }, square(-1.0)],
        materials: vec![Material::default()],
        objects: vec![Object::default()],
        instances: [-3.0, 3.0]
            .map(|x| Instance { object: 0, to_world: Affine3A::from_translation(Vec3::X * x) })
            .into(),
        camera: Some(camera_above()),
        ..Scene::default()
    };
    let picture = render(&scene, &Settings { width: 40, height: 40, aov: true, spp: 1, ..Settings::default() });
    let at = |name: &str, x: usize| values(&picture, name)[20 * 40 + x];
    // The left one, the one between that is in no instance, and the right one.
    assert_eq!([5, 20, 35].map(|x| at("Id.Instance", x)), [1.0, 0.0, 2.0]);
    assert_eq!([5, 20, 35].map(|x| at("Id.Object", x)), [1.0, 2.0, 1.0]);
    // Where nothing is.
    assert_eq!((at("Id.Instance", 12), at("Id.Object", 12)), (0.0, 0.0));
}
