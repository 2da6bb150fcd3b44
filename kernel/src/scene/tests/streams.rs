//! Batches at the corner cases of streams.

use super::*;
use crate::Aabb;
use crate::bvh::{BoxTree, Child, Serial};

/// Rays of all kinds about a scene of these items, which are many in one place.
fn check_heap(items: Vec<Item>, seed: u32) {
    let mut random = Random(seed.into());
    let scene = scene(items);
    let rays = rays(&mut random, &scene.view(), fewer(100));
    assert!(check(&scene.view(), &rays) > fewer(10));
}

#[test]
fn rays_with_full_stacks_are_finished_alone() {
    let mut random = Random(5);
    let mesh = bvh(&soup(&mut random, 90, 0.8));
    let key = shaken(&mut random, &Affine3A::IDENTITY, 0.2);
    let keys = [key, shaken(&mut random, &key, 0.3), key];
    // All boxes overlap, so that each ray keeps nearly all items on its stack.
    let place = |random: &mut Random| shaken(random, &Affine3A::IDENTITY, 0.1);
    let still: Vec<_> = (0..200).map(|_| Item::new(mesh.view()).placed(&place(&mut random)).unwrap()).collect();
    check_heap(still.clone(), 1);
    let moving = still.into_iter().enumerate();
    check_heap(moving.map(|(i, item)| if i % 3 == 0 { item.moving(&keys).unwrap() } else { item }).collect(), 2);
}

#[test]
fn the_same_mesh_in_the_same_place_is_a_tie() {
    let mut random = Random(6);
    let mesh = bvh(&soup(&mut random, 40, 0.8));
    let inner = scene(vec![Item::new(mesh.view()), Item::new(mesh.view())]);
    let inner = inner.view();
    check_heap((0..40).map(|i| if i % 2 == 0 { Item::new(&inner) } else { Item::new(mesh.view()) }).collect(), 3);
}

#[test]
fn leaves_of_several_items_are_met_one_after_the_other() {
    let mut random = Random(7);
    let mesh = bvh(&soup(&mut random, 12, 0.5));
    let count = 30;
    let mut items: Vec<_> = (0..count)
        .map(|i| Item::new(mesh.view()).placed(&transform(&mut random)).unwrap().with_mask([1, 3, 2][i % 3]))
        .collect();
    let parts: Vec<_> = (0..count as u32).map(|item| Part { item, prim_id: 0 }).collect();
    let boxes: Vec<_> = items.iter().map(|item| item.aabb(0, 0, 1)).collect();
    // One node with leaves of one to five items.
    let mut node = Node::EMPTY;
    let mut first = 0;
    for slot in 0..8 {
        let end = if slot == 7 { count } else { first + 1 + slot % 5 };
        let around = boxes[first..end].iter().fold(Aabb::EMPTY, |sum, aabb| sum.union(aabb));
        node.set(slot, &around, Child::Leaf { first: first as u32, count: (end - first) as u32 });
        first = end;
    }
    node.sort();
    let (nodes, numbers): (_, Vec<_>) = ([node], (0..count as u32).collect());
    let view = SceneView::new(&mut items, &parts, &nodes, &numbers).unwrap();
    let rays = rays(&mut random, &view, 400);
    assert!(check(&view, &rays) > 40);
    // As a tree that was built for them.
    let (built, _) = BoxTree::build_on(&Serial, &boxes, 1, &Quality::High.into()).unwrap();
    assert_eq!(built.view().bounds(), view.bounds());
}

#[test]
fn rays_at_no_time_hit_nothing_and_short_slices_end_early() {
    let mesh = bvh(&[[Vec3::NEG_ONE, vec3(1.0, -1.0, -1.0), vec3(0.0, 1.0, -1.0)]]);
    let scene = scene(vec![Item::new(mesh.view())]);
    let ray = SceneRay::new(Ray::new(vec3(0.0, 0.0, 1.0), Vec3::NEG_Z));
    let rays: Vec<_> = (0..50).map(|i| if i % 3 == 0 { ray.at_time(f32::NAN) } else { ray }).collect();
    for isa in isas() {
        let view = scene.view().with_isa(isa);
        let (mut hits, mut occluded) = (vec![SceneHit::MISS; 90], vec![true; 90]);
        hits[50].item = 77;
        view.intersect_many(&rays, &mut hits);
        view.occluded_many(&rays, &mut occluded);
        for i in 0..50 {
            assert_eq!((hits[i].is_hit(), occluded[i]), (i % 3 != 0, i % 3 != 0), "{}, {i}", isa.level());
        }
        assert_eq!((hits[50].item, &occluded[50..]), (77, &[true; 40][..]));
        let mut few = [SceneHit::MISS; 30];
        view.intersect_many(&rays, &mut few);
        assert_eq!(few[..], hits[..30]);
    }
}
