//! Items with distorting transforms: all their hits are found, and other items are entered by no more rays.

use alloc::sync::Arc;
use core::sync::atomic::{AtomicUsize, Ordering};

use glam::EulerRot;

use super::*;
use crate::bvh::{BoxTree, Serial};
use crate::geometry::Aabb;

/// A sphere that counts the rays which meet it, and has no hits.
struct Counted(AtomicUsize);

impl Shape for Counted {
    fn count(&self) -> u32 {
        1
    }

    fn bounds(&self, _prim_id: u32) -> Aabb {
        Aabb { min: Vec3::NEG_ONE, max: Vec3::ONE }
    }

    fn intersect(&self, _prim_id: u32, _ray: &Ray, _time: f32) -> Option<Hit> {
        self.0.fetch_add(1, Ordering::Relaxed);
        None
    }
}

/// Stretches that distort more and more; the second is that of a floor made from a cube.
const STRETCHES: [Vec3; 5] = [
    vec3(1.0, 1e-3, 1.0),
    vec3(200.0, 0.02, 200.0),
    vec3(1.0, 1e-4, 1.0),
    vec3(30.0, 3e-3, 30.0),
    vec3(1.0, 1.0, 1e-4),
];

/// The places of items in a square of 200 by 200.
fn square(random: &mut Random, count: usize) -> Vec<Affine3A> {
    let place = |_| {
        let turn = Quat::from_rotation_y(random.unit() * 6.0);
        Affine3A::from_rotation_translation(turn, random.vector() * vec3(100.0, 1.0, 100.0))
    };
    (0..count).map(place).collect()
}

#[test]
fn a_distorted_item_is_not_met_by_the_rays_of_others() {
    let mut random = Random(71);
    let places = square(&mut random, 300);
    let mesh = bvh(&soup(&mut random, 20, 0.5));
    let met = |extra: Option<Item>, rays: &[SceneRay]| {
        let counted = Counted(AtomicUsize::new(0));
        let crowd = places.iter().map(|place| Item::new(&counted).placed(place).unwrap());
        let scene = scene(crowd.chain(extra).collect());
        // Of all hits, so that no hit hides others.
        rays.iter()
            .for_each(|ray| assert!(scene.view().for_each_hit(ray, |_| ControlFlow::Continue(())).is_continue()));
        (counted.0.load(Ordering::Relaxed), scene.view().bounds())
    };
    // From among them, and from as far out as the square is large.
    let rays: Vec<_> = (0..fewer(1000))
        .map(|i| {
            let target = random.vector() * vec3(90.0, 1.0, 90.0);
            let far = target + random.vector().normalize() * 150.0;
            SceneRay::new(if i % 2 == 0 { Ray::new(target, random.vector()) } else { Ray::new(far, target - far) })
        })
        .collect();
    let (expected, _) = met(Some(Item::new(mesh.view())), &rays);
    assert!(expected >= fewer(100), "{expected}");
    for stretch in STRETCHES {
        let item = Item::new(mesh.view()).placed(&Affine3A::from_scale(stretch)).unwrap();
        let bounds = item.aabb(0, 0, 1);
        let (found, around) = met(Some(item), &rays);
        // The floor lies beyond the square, so that rays have a greater reach.
        assert!(found.abs_diff(expected) <= 1, "{stretch}: {found} instead of {expected}");
        // What is around the scene is not widened.
        let size = bounds.max.abs().max(bounds.min.abs()).max(vec3(102.0, 2.0, 102.0));
        assert!(around.max.cmple(size).all() && around.min.cmpge(-size).all(), "{stretch}: {around:?}");
    }
}

/// Rays from all distances to points on the rim of what is in an item, which rounding takes off its box.
fn rays_at_rims(random: &mut Random, triangles: &[Triangle], places: &[Affine3A], count: usize) -> Vec<SceneRay> {
    let corners: Vec<Vec3> = triangles.iter().flatten().copied().collect();
    let ray = |i: usize| {
        let axis = random.bits() as usize % 3;
        let outermost = corners.iter().copied().reduce(|a, b| if a[axis] > b[axis] { a } else { b }).unwrap();
        let rim = places[random.bits() as usize % places.len()].transform_point3(outermost);
        let target = rim + random.vector() * [0.0, 1e-3, 3e-2, 0.3][i / 6 % 4];
        let origin = target + random.vector().normalize() * [3.0, 100.0, 350.0, 2e3, 3e4, 1e5][i % 6];
        SceneRay::new(Ray { t_max: 3.0, ..Ray::between(origin, target) }).at_time(random.unit())
    };
    (0..count).map(ray).collect()
}

#[test]
fn distorted_items_in_a_crowd_lose_no_hits() {
    let mut random = Random(72);
    let triangles = soup(&mut random, 12, 0.5);
    let mesh = bvh(&triangles);
    let crowd = square(&mut random, 40);
    // Few of them are distorted, or more than a few, or all.
    for (count, others) in [(1, 40), (9, 20), (60, 40), (40, 0)] {
        for stretch in STRETCHES {
            // Turned before, so that rounding along the longest axis of its own space is felt along all of the scene.
            let shape =
                Affine3A::from_scale(stretch) * Affine3A::from_quat(Quat::from_euler(EulerRot::XYZ, 0.6, 0.4, 0.5));
            let places: Vec<_> = square(&mut random, count).iter().map(|place| *place * shape).collect();
            let keys: Vec<_> = places.iter().map(|&a| [a, Affine3A::from_translation(Vec3::ONE) * a]).collect();
            let crowd = crowd[..others].iter().map(|place| Item::new(mesh.view()).placed(place).unwrap());
            let still = places.iter().map(|place| Item::new(mesh.view()).placed(place).unwrap());
            let scene = scene(still.chain(crowd.clone()).collect());
            let rays = rays_at_rims(&mut random, &triangles, &places, fewer(600));
            let hits = check(&scene.view(), &rays);
            // Most rays from far away miss what they are aimed at.
            assert!(hits > fewer(5), "{stretch}, {count} distorted: {hits}");
            let moving = keys.iter().map(|keys| Item::new(mesh.view()).moving(keys).unwrap());
            let moving = self::scene(moving.chain(crowd).collect());
            check(&moving.view(), &rays);
            // In another scene, turned.
            let (view, turn) = (scene.view(), Affine3A::from_rotation_y(0.5));
            let outer = self::scene(vec![Item::new(&view).placed(&turn).unwrap(), Item::new(mesh.view())]);
            let turned: Vec<_> = places.iter().map(|place| turn * *place).collect();
            check(&outer.view(), &rays_at_rims(&mut random, &triangles, &turned, fewer(120)));
        }
    }
}

#[test]
fn distorted_items_follow_what_the_scene_reaches() {
    let mut random = Random(73);
    let triangles = soup(&mut random, 12, 0.5);
    let mesh = Arc::new(bvh(&triangles));
    let place = Affine3A::from_scale(vec3(1.0, 1e-4, 1.0)) * Affine3A::from_rotation_z(0.5);
    let mut scene: Scene<'static> = Scene::default();
    scene.insert(Item::new(mesh.clone()).placed(&place).unwrap()).unwrap();
    let other = scene.insert(Item::new(mesh.clone())).unwrap();
    scene.commit().unwrap();
    let rays = rays_at_rims(&mut random, &triangles, &[place], fewer(600));
    let small = scene.view().tree().bounds();
    for distance in [1e3, 10.0, 1e5, 1e12, 1.0, 1e13, 1.0] {
        scene.set_transform(other, &Affine3A::from_translation(Vec3::X * distance)).unwrap();
        scene.commit().unwrap();
        assert!(check(&scene.view(), &rays) > fewer(60), "{distance}");
        let fresh = Scene::build(scene.view().items().to_vec(), &BuildOptions::default()).unwrap().0;
        let (view, fresh) = (scene.view(), fresh.view());
        assert_eq!((view.bounds(), view.tree().bounds()), (fresh.bounds(), fresh.tree().bounds()), "{distance}");
        // The distorted one's box is wider the farther the scene reaches, but where there is no room for that.
        let is_wider = view.tree().bounds().min.x < small.min.x - 1.0;
        assert_eq!(is_wider, [1e3, 1e5].contains(&distance), "{distance}: {:?}", view.tree().bounds());
    }
}

#[test]
fn trees_around_boxes_as_they_are_are_still_traced() {
    let mut random = Random(74);
    let triangles = soup(&mut random, 12, 0.5);
    let mesh = bvh(&triangles);
    let mut places = square(&mut random, 20);
    places.push(Affine3A::from_scale(vec3(1.0, 1e-4, 1.0)));
    let items: Vec<_> = places.iter().map(|place| Item::new(mesh.view()).placed(place).unwrap()).collect();
    let scene = scene(items.clone());
    let rays = rays_at_rims(&mut random, &triangles, &places[20..], fewer(600));
    let hits = check(&scene.view(), &rays);
    assert!(hits > fewer(60), "{hits}");
    // As in blobs that were written before boxes were widened.
    let boxes: Vec<_> = items.iter().map(|item| item.aabb(0, 0, 1)).collect();
    let (plain, _) = BoxTree::build_on(&Serial, &boxes, 1, &Quality::High.into()).unwrap();
    let tree = plain.view();
    let mut others = items.clone();
    let view = SceneView::new(&mut others, scene.view().parts(), tree.nodes(0), tree.items()).unwrap();
    assert!(view.tree().bounds().max != scene.view().tree().bounds().max || view.widening().is_by_rays());
    assert_eq!((check(&view, &rays), view.bounds()), (hits, scene.view().bounds()));
    // As in blobs of today, which are the same again.
    let bytes = scene.to_bytes().unwrap();
    let loaded = Scene::from_bytes(&bytes).unwrap();
    assert_eq!((check(&loaded.view(), &rays), loaded.view().bounds()), (hits, scene.view().bounds()));
    assert!(loaded.to_bytes().unwrap()[..] == bytes[..]);
    let mut memory = vec![Item::nothing(); items.len()];
    let in_place = SceneView::from_bytes(&bytes, &mut memory).unwrap();
    assert_eq!((check(&in_place, &rays), in_place.bounds()), (hits, scene.view().bounds()));
    assert!(!in_place.widening().is_by_rays());
}
