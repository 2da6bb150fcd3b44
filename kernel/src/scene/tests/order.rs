//! Masks of rays, and the order of equal hits.

use super::*;

#[test]
fn masks_hide_at_every_level() {
    let triangle = bvh(&[[vec3(-1.0, -1.0, 0.0), vec3(1.0, -1.0, 0.0), vec3(0.0, 1.0, 0.0)]]);
    let at = |z: f32| Affine3A::from_translation(vec3(0.0, 0.0, z));
    let inner =
        scene((0..4).map(|i| Item::new(triangle.view()).placed(&at(-(i as f32))).unwrap().with_mask(1 << i)).collect());
    let inner = inner.view();
    let outer = scene(vec![
        Item::new(&inner).with_mask(0b0110),
        Item::new(&inner).placed(&at(-10.0)).unwrap().with_mask(0b1001),
        Item::new(triangle.view()).placed(&at(-20.0)).unwrap().with_mask(0),
        Item::new(triangle.view()).placed(&at(-30.0)).unwrap(),
    ]);
    for mask in 0..16u32 {
        let ray = SceneRay::new(Ray::new(vec3(0.0, 0.0, 1.0), Vec3::NEG_Z)).with_mask(mask);
        // The first item of the first scene, if the ray sees that scene at all; then of the second.
        let first = (mask & 0b0110 != 0).then(|| mask.trailing_zeros() as f32 + 1.0);
        let second = (mask & 0b1001 != 0).then(|| mask.trailing_zeros() as f32 + 11.0);
        let last = (mask != 0).then_some(31.0);
        let found = outer.view().intersect(&ray);
        assert_eq!(found.map(|found| found.hit.t), first.or(second).or(last), "{mask:04b}");
        check(&outer.view(), &[ray]);
        if first.is_some() {
            let found = found.unwrap();
            assert_eq!((found.item, found.depth), (mask.trailing_zeros(), 1));
            assert_eq!(instances(&outer.view(), &found), [0]);
        }
    }
}

/// A shape of planes `z = 0`, of which all say the same.
struct Planes(u32);

impl Shape for Planes {
    fn count(&self) -> u32 {
        self.0
    }
    fn bounds(&self, _: u32) -> crate::Aabb {
        crate::Aabb { min: vec3(-1.0, -1.0, 0.0), max: vec3(1.0, 1.0, 0.0) }
    }
    fn intersect(&self, prim_id: u32, ray: &Ray, time: f32) -> Option<Hit> {
        Some(Hit { t: -ray.origin.z / ray.direction.z, u: prim_id as f32, v: time, prim_id: 77 })
    }
}

#[test]
fn of_equally_near_hits_the_lowest_ids_count() {
    let corners = [vec3(-1.0, -1.0, 0.0), vec3(1.0, -1.0, 0.0), vec3(1.0, 1.0, 0.0), vec3(-1.0, 1.0, 0.0)];
    let triangle = [corners[0], corners[1], corners[2]];
    let (mesh, quad_list) = (bvh(&[triangle; 9]), [corners; 3]);
    let (quads, planes) = (Quads(&quad_list), Planes(5));
    let inner = scene(vec![Item::new(&planes), Item::new(mesh.view())]);
    let inner = inner.view();
    let ray = SceneRay::new(Ray::new(vec3(0.25, -0.25, 2.0), Vec3::NEG_Z)).at_time(0.75);
    let objects = [Item::new(mesh.view()), Item::new(&quads), Item::new(&planes), Item::new(&inner)];
    for order in 0..24 {
        // All permutations.
        let mut left: Vec<_> = (0..4).collect();
        let order: Vec<usize> = [6, 2, 1, 1]
            .iter()
            .scan(order, |rest, &n| {
                let i = *rest / n;
                *rest %= n;
                Some(left.remove(i))
            })
            .collect();
        let scene = scene(order.iter().map(|&i| objects[i].clone()).collect());
        let found = scene.view().intersect(&ray).unwrap();
        // All have a part 0 and t = 2. In the inner scene geometry 0 is the planes.
        assert_eq!((found.hit.t, found.hit.prim_id, found.item), (2.0, 0, 0), "{order:?}");
        let place_of_scene = order.iter().position(|&i| i == 3).unwrap() as u32;
        // The scene's own path is the last.
        assert_eq!(instances(&scene.view(), &found), [place_of_scene], "{order:?}");
        assert_eq!((found.hit.u, found.hit.v), (0.0, 0.75));
        check(&scene.view(), &[ray]);
        // Rejecting them one after the other gives all in order, each once.
        let mut seen: Vec<SceneHit> = Vec::new();
        while let Some(next) = scene
            .view()
            .intersect_filtered(&ray, |hit| if seen.contains(hit) { Verdict::Reject } else { Verdict::Accept })
        {
            seen.push(next);
        }
        assert_eq!(seen.len(), 9 + 3 + 5 + 5 + 9, "{order:?}");
        assert!(seen.windows(2).all(|pair| pair[0].precedes(&pair[1])));
    }
}

#[test]
fn filters_see_each_hit_once_and_in_one_order() {
    let mut random = Random(40);
    let stock = Stock::new(&mut random);
    let (spheres, quads) = (Spheres(&stock.spheres), Quads(&stock.quads));
    let inner = scene(stock.items(&mut random, 6, (&spheres, &quads), &[]));
    let inner = inner.view();
    let scene = scene(stock.items(&mut random, 20, (&spheres, &quads), &[&inner]));
    let mut total = 0;
    for ray in rays(&mut random, &scene.view(), 500).iter().map(|ray| ray.with_mask(u32::MAX)) {
        let mut first: Option<Vec<SceneHit>> = None;
        for isa in isas() {
            let scene = scene.view().with_isa(isa);
            let mut seen = Vec::new();
            assert!(!scene.occluded_filtered(&ray, |hit| {
                seen.push(*hit);
                Verdict::Reject
            }));
            // The third one ends the search, if there are three.
            let mut count = 0;
            let stopped = scene.intersect_filtered(&ray, |_| {
                count += 1;
                if count == 3 { Verdict::Stop } else { Verdict::Reject }
            });
            assert_eq!(stopped.as_ref(), seen.get(2));
            if isa == crate::Isa::SCALAR {
                // Its order is that of the list.
                continue;
            }
            total += seen.len();
            assert_eq!(*first.get_or_insert_with(|| seen.clone()), seen);
            seen.sort_unstable_by_key(|hit| (hit.item, hit.hit.prim_id, hit.path));
            assert!(seen.windows(2).all(|pair| bits(Some(pair[0])) != bits(Some(pair[1]))));
        }
    }
    // Where there is one instruction set besides, each hit is seen once.
    assert!(total > 80, "{total}");
}
