//! Points and curves in scenes: as objects among others, shared, and by themselves.

use alloc::sync::Arc;

use super::*;
use crate::geometry::{CubicCurve, Disc, LinearCurve};

/// Trees of each kind over so many primitives.
pub(super) fn trees(random: &mut Random, counts: [usize; 4]) -> Vec<RoundBvh> {
    let sphere = |random: &mut Random| Sphere::new(random.vector(), 0.3 * random.unit());
    let spheres: Vec<_> = (0..counts[0]).map(|_| sphere(random)).collect();
    let disc = |random: &mut Random| {
        let Sphere { center, radius } = sphere(random);
        Disc { center, radius, normal: random.vector() }
    };
    let discs: Vec<_> = (0..counts[1]).map(|_| disc(random)).collect();
    let near = |center: Vec3, random: &mut Random| Sphere::new(center + random.vector() * 0.4, 0.1 * random.unit());
    let linear = |random: &mut Random| {
        let center = random.vector();
        LinearCurve { ends: [(); 2].map(|()| near(center, random)) }
    };
    let linears: Vec<_> = (0..counts[2]).map(|_| linear(random)).collect();
    let cubic = |random: &mut Random| {
        let center = random.vector();
        CubicCurve { controls: [(); 4].map(|()| near(center, random)) }
    };
    let cubics: Vec<_> = (0..counts[3]).map(|_| cubic(random)).collect();
    let options = BuildOptions::default();
    vec![
        RoundBvh::build(&spheres, &options).unwrap().0,
        RoundBvh::build(&discs, &options).unwrap().0,
        RoundBvh::build(&linears, &options).unwrap().0,
        RoundBvh::build(&cubics, &options).unwrap().0,
    ]
}

#[test]
fn each_kind_alone() {
    let mut random = Random(81);
    for tree in trees(&mut random, [300, 300, 200, 60]) {
        let moving = [Affine3A::IDENTITY, Affine3A::from_translation(Vec3::X)];
        let items = vec![Item::new(tree.view()), Item::new(tree.view()).moving(&moving).unwrap().with_mask(1)];
        let scene = scene(items);
        let rays = rays(&mut random, &scene.view(), fewer(600));
        let hits = check(&scene.view(), &rays);
        assert!(hits > fewer(40), "{hits}");
    }
}

#[test]
fn a_tree_by_itself_gives_the_hits_of_a_scene() {
    let mut random = Random(82);
    for tree in trees(&mut random, [300, 300, 200, 60]) {
        let tree = Arc::new(tree);
        let scene: Scene<'static> = scene(vec![Item::new(tree.clone())]);
        let rays = rays(&mut random, &scene.view(), 400);
        let expected: Vec<_> = rays.iter().map(|ray| reference::intersect(&scene.view(), &ray.with_mask(1))).collect();
        for isa in isas() {
            let view = tree.view().with_isa(isa);
            for (ray, expected) in rays.iter().zip(&expected) {
                let found = view.intersect(&ray.ray).map(|hit| SceneHit { hit, ..expected.unwrap_or(SceneHit::MISS) });
                assert_eq!(bits(found), bits(*expected), "{isa:?} {ray:?}");
                assert_eq!(view.occluded(&ray.ray), expected.is_some());
            }
            let plain: Vec<Ray> = rays.iter().map(|ray| ray.ray).collect();
            let (mut hits, mut occluded) = (vec![Hit::MISS; plain.len()], vec![false; plain.len()]);
            view.intersect_many(&plain, &mut hits);
            view.occluded_many(&plain, &mut occluded);
            for ((hit, occluded), expected) in hits.iter().zip(occluded).zip(&expected) {
                let expected = expected.map_or(Hit::MISS, |expected| expected.hit);
                assert_eq!(
                    (bytemuck::cast::<_, [u32; 4]>(*hit), occluded),
                    (bytemuck::cast(expected), expected.is_hit())
                );
            }
        }
    }
}

#[test]
fn boxes_of_primitives_overlap_and_their_points_are_not_looked_at() {
    let mut random = Random(83);
    for tree in trees(&mut random, [90, 90, 90, 90]) {
        let scene =
            scene(vec![Item::new(tree.view()), Item::new(tree.view()).placed(&transform(&mut random)).unwrap()]);
        let scene = scene.view();
        assert_eq!(scene.closest_point(Vec3::ZERO, f32::INFINITY, 0.0, u32::MAX), None);
        for _ in 0..40 {
            let center = random.vector() * 2.0;
            let aabb = crate::Aabb { min: center - 0.2, max: center + 0.2 };
            let found = |isa| {
                let mut found = Vec::new();
                let flow = scene.with_isa(isa).for_each_overlap(&aabb, 0.0, u32::MAX, |hit| {
                    found.push((hit.item, hit.hit.prim_id));
                    ControlFlow::Continue(())
                });
                assert!(flow.is_continue());
                found.sort_unstable();
                found
            };
            let expected = found(crate::Isa::SCALAR);
            isas().for_each(|isa| assert_eq!(found(isa), expected));
        }
    }
}
