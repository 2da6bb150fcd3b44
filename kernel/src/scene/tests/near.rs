//! Closest points and overlaps in scenes, against the loops, and the loops against trees and known answers.

use super::*;
use crate::geometry::overlaps;
use crate::{Aabb, SurfacePoint};

/// Asks a scene everything about a point and a box on all instruction sets, and compares with the loops. Gives how many
/// answers there were.
fn check(scene: &SceneView, random: &mut Random) -> [usize; 2] {
    let bounds = scene.bounds();
    let (center, size) = (bounds.center(), (bounds.max - bounds.min).max_element());
    let point = center + random.vector() * size * 0.7;
    let half = random.vector().abs() * size * 0.1;
    let aabb = Aabb { min: point - half, max: point + half };
    let time = random.unit() * 1.2 - 0.1;
    let mask = [u32::MAX, 1, 2, 5][random.bits() as usize % 4];
    let radius = [f32::INFINITY, size * 0.1 * random.unit()][random.bits() as usize % 2];
    let ask = |scene: &SceneView| {
        let mut all = Vec::new();
        let flow = scene.for_each_overlap(&aabb, time, mask, |hit| {
            all.push(bytemuck::cast::<SceneHit, [u32; 8]>(*hit));
            ControlFlow::Continue(())
        });
        assert!(flow.is_continue());
        all.sort_unstable();
        let closest = scene.closest_point(point, radius, time, mask);
        (closest.map(|found| (found.point.point.to_array().map(f32::to_bits), bits(Some(found.to_hit())))), all)
    };
    let expected = ask(&scene.with_isa(crate::Isa::SCALAR));
    for isa in isas() {
        assert_eq!(ask(&scene.with_isa(isa)), expected, "{}", isa.level());
    }
    let mut left = 2_usize;
    let flow = scene.for_each_overlap(&aabb, time, mask, |_| {
        left -= 1;
        if left == 0 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    });
    assert_eq!(flow.is_break(), expected.1.len() >= 2);
    [usize::from(expected.0.is_some()), expected.1.len()]
}

#[test]
fn walks_lose_nothing_that_loops_find() {
    let mut random = Random(411);
    let mut found = [0; 2];
    for round in (0..60).step_by(60 / fewer(60)) {
        let stock = Stock::new(&mut random);
        let shapes = (&Spheres(&stock.spheres), &Quads(&stock.quads));
        let inner = scene(stock.items(&mut random, 7, shapes, &[]));
        let inner = inner.view();
        let middle = scene(stock.items(&mut random, 5, shapes, &[&inner]));
        let middle = middle.view();
        let outer = scene(stock.items(&mut random, 3 + round, shapes, &[&inner, &middle]));
        for _ in 0..30 {
            let [points, overlaps] = check(&outer.view(), &mut random);
            (found[0], found[1]) = (found[0] + points, found[1] + overlaps);
        }
    }
    assert!(found[0] > fewer(500) && found[1] > fewer(400), "{found:?}");
}

#[test]
fn what_is_not_moved_is_what_its_tree_says() {
    let mut random = Random(412);
    let triangles = soup(&mut random, 300, 0.3);
    let tree = bvh(&triangles);
    let scene = scene(vec![Item::new(tree.view())]);
    let scene = scene.view();
    for _ in 0..500 {
        let (point, half) = (random.vector() * 1.5, random.vector().abs() * 0.1);
        let of_tree = tree.view().closest_point(point, 0.5);
        let of_scene = scene.closest_point(point, 0.5, 0.3, 1).map(|found| found.point);
        assert_eq!(of_scene.map(bytemuck::cast::<_, [u32; 7]>), of_tree.map(bytemuck::cast));
        let aabb = Aabb { min: point - half, max: point + half };
        let mut all = Vec::new();
        let _ = scene.for_each_overlap(&aabb, 0.3, 1, |hit| {
            all.push(hit.hit.prim_id);
            ControlFlow::Continue(())
        });
        all.sort_unstable();
        let expected: Vec<u32> = (0..).zip(&triangles).filter(|(_, it)| overlaps(it, &aabb)).map(|it| it.0).collect();
        assert_eq!(all, expected);
    }
}

#[test]
fn instances_are_where_their_transforms_take_them() {
    let square = [[Vec3::ZERO, Vec3::X, vec3(1.0, 1.0, 0.0)], [Vec3::ZERO, vec3(1.0, 1.0, 0.0), Vec3::Y]];
    let mesh = bvh(&square);
    let keys = [0.0, 8.0].map(|z| Affine3A::from_translation(vec3(0.0, 0.0, z)));
    let inner = scene(vec![Item::new(mesh.view()).placed(&Affine3A::from_scale(vec3(2.0, 2.0, 1.0))).unwrap()]);
    let inner = inner.view();
    let scene = scene(vec![
        Item::new(&inner).placed(&Affine3A::from_translation(vec3(10.0, 0.0, 0.0))).unwrap(),
        Item::new(mesh.view()).moving(&keys).unwrap().with_mask(2),
        // Flattened: nowhere to be found.
        Item::new(mesh.view()).placed(&Affine3A::from_scale(vec3(1.0, 0.0, 1.0))).unwrap(),
    ]);
    let view = scene.view();
    // 10 + 2 * 0.75 along x, one above.
    let found = view.closest_point(vec3(11.5, 0.5, 1.0), f32::INFINITY, 0.0, u32::MAX).unwrap();
    let SurfacePoint { point, distance, prim_id, .. } = found.point;
    assert_eq!((point, distance, prim_id), (vec3(11.5, 0.5, 0.0), 1.0, 0));
    assert_eq!((found.item, found.depth, instances(&view, &found.to_hit())), (0, 1, vec![0]));
    let height = |time: f32| view.closest_point(vec3(0.25, 0.5, 20.0), 100.0, time, 2).map(|found| found.point.point.z);
    assert_eq!([0.0, 0.25, 1.0, 7.0].map(height), [0.0, 2.0, 8.0, 8.0].map(Some));
    assert_eq!(height(f32::NAN), None);
    for radius in [-1.0, f32::NAN, 0.5] {
        assert_eq!(view.closest_point(vec3(0.25, 0.5, 20.0), radius, 0.0, u32::MAX), None);
    }
    assert_eq!(view.closest_point(vec3(f32::NAN, 0.0, 0.0), 1.0, 0.0, u32::MAX), None);
    let count = |z: f32, time: f32, mask: u32| {
        let mut count = 0;
        let aabb = Aabb { min: vec3(0.0, 0.0, z), max: vec3(1.0, 1.0, z) };
        let _ = view.for_each_overlap(&aabb, time, mask, |_| {
            count += 1;
            ControlFlow::Continue(())
        });
        count
    };
    assert_eq!([count(2.0, 0.25, 3), count(2.0, 0.25, 1), count(2.0, 0.5, 3)], [2, 0, 0]);
    assert!(view.for_each_overlap(&Aabb::EMPTY, 0.0, 1, |_| panic!()).is_continue());
}
