//! Meshes that deform while a scene uses them: two trees in turn, of which one is in the scene and the other is
//! refitted.

use alloc::sync::Arc;

use super::*;
use crate::RefitError;
use crate::mesh::{IndexedMesh, Indices};

/// Vertices of a strip of `count` squares that waves.
fn wave(count: usize, phase: f32) -> Vec<Vec3> {
    (0..2 * count + 2)
        .map(|i| vec3((i / 2) as f32, (i % 2) as f32, libm::sinf(phase + (i / 2) as f32)) / count as f32)
        .collect()
}

fn indices(count: u16) -> Vec<u16> {
    (0..count).map(|i| 2 * i).flat_map(|a| [a, a + 1, a + 2, a + 1, a + 3, a + 2]).collect()
}

fn rays_onto(count: usize, random: &mut Random) -> Vec<SceneRay> {
    (0..200)
        .map(|_| {
            let target = vec3(random.unit(), random.unit() / count as f32, 0.0);
            SceneRay::new(Ray::new(target + vec3(0.1, -0.2, 4.0), vec3(-0.1, 0.2, -4.0)))
        })
        .collect()
}

fn mesh_of<'a>(vertices: &'a [Vec3], indices: &'a [u16]) -> IndexedMesh<'a> {
    IndexedMesh::new(vertices, Indices::U16(indices)).unwrap()
}

#[test]
fn two_trees_in_turn_follow_a_mesh_that_deforms() {
    let (count, options) = (24, BuildOptions::default());
    let (indices, mut random) = (indices(24), Random(91));
    let tree = Arc::new(Bvh::build_mesh(&mesh_of(&wave(count, 0.0), &indices), &options).unwrap().0);
    let mut trees = [tree.clone(), Arc::new((*tree).clone())];
    drop(tree);
    let mut scene: Scene<'static> = Scene::default();
    let handle = scene.insert(Item::new(trees[0].clone())).unwrap();
    scene.commit().unwrap();
    let rays = rays_onto(count, &mut random);
    for frame in 1..12 {
        let vertices = wave(count, frame as f32);
        let mesh = mesh_of(&vertices, &indices);
        let tree = Arc::get_mut(&mut trees[frame % 2]).expect("after the commit nobody else shares it");
        tree.refit_mesh(&mesh).unwrap();
        scene.set_object(handle, trees[frame % 2].clone()).unwrap();
        assert!(!scene.commit().unwrap().is_rebuilt);
        let fresh = Bvh::build_mesh(&mesh, &options).unwrap().0;
        let fresh = self::scene(vec![Item::new(fresh.view())]);
        let expected: Vec<_> = rays.iter().map(|ray| bits(reference::intersect(&fresh.view(), ray))).collect();
        assert!(expected.iter().flatten().count() > 100);
        for isa in isas() {
            let view = scene.view().with_isa(isa);
            assert!(rays.iter().zip(&expected).all(|(ray, &hit)| bits(view.intersect(ray)) == hit), "{}", isa.level());
        }
        // What is in the scene cannot be changed.
        assert!(Arc::get_mut(&mut trees[frame % 2]).is_none());
    }
}

#[test]
fn an_update_that_is_refused_leaves_the_scene_as_it_was() {
    let (count, options) = (24, BuildOptions::default());
    let (indices, mut random) = (indices(24), Random(92));
    let vertices = wave(count, 0.0);
    let mut tree = Bvh::build_mesh(&mesh_of(&vertices, &indices), &options).unwrap().0;
    let mut scene: Scene<'static> = Scene::default();
    let handle = scene.insert(Item::new(Arc::new(tree.clone()))).unwrap();
    scene.commit().unwrap();
    let rays = rays_onto(count, &mut random);
    let hits = |scene: &Scene| rays.iter().map(|ray| bits(scene.view().intersect(ray))).collect::<Vec<_>>();
    let before = hits(&scene);
    let mut broken = vertices.clone();
    broken[5].y = f32::NAN;
    let error = tree.refit_mesh(&mesh_of(&broken, &indices)).unwrap_err();
    assert!(matches!(error, Error::Refit(RefitError::Vanished { .. })));
    // Fewer triangles than the tree has.
    let error = tree.refit_mesh(&mesh_of(&vertices, &indices[..6])).unwrap_err();
    assert!(matches!(error, Error::Refit(RefitError::Missing { count: 2, .. })));
    // Fewer vertices than the indices name.
    assert!(IndexedMesh::new(&vertices[..9], Indices::U16(&indices)).is_err());
    // The tree that was not refitted is as good as it was.
    scene.set_object(handle, Arc::new(tree)).unwrap();
    scene.commit().unwrap();
    assert!(hits(&scene) == before);

    // A mesh that shrinks is another tree; hits name its triangles, and at last there are none.
    for left in [5, 1, 0] {
        let part = Bvh::build_mesh(&mesh_of(&vertices, &indices[..6 * left]), &options).unwrap().0;
        scene.set_object(handle, Arc::new(part)).unwrap();
        assert!(hits(&scene).iter().flatten().count() > 0, "not before the commit");
        assert_eq!(scene.commit().unwrap().seen, usize::from(left > 0));
        let found = check(&scene.view(), &rays);
        assert_eq!(found > 0, left > 0);
        for hit in rays.iter().filter_map(|ray| scene.view().intersect(ray)) {
            assert!((hit.hit.prim_id as usize) < 2 * left && scene.handle(hit.item) == Some(handle));
        }
    }
}
