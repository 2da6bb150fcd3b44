//! The queries other than the nearest hit, each against a loop over all triangles that shares nothing with the tree, on
//! every instruction set.

mod closest;
mod overlaps;

use alloc::vec;
use alloc::vec::Vec;
use core::ops::ControlFlow;

use glam::{DVec3, Vec3, vec3};

use super::Facing;
use crate::geometry::{intersect_triangle, overlaps};
use crate::simd::isas;
use crate::traverse::tests::{Random, rays_at, soup, sphere};
use crate::{Aabb, Bvh, Hit, Quality, Ray, SurfacePoint, Triangle};

const GO_ON: ControlFlow<()> = ControlFlow::Continue(());

/// All hits, nearest first.
fn sorted_hits(triangles: &[Triangle], ray: &Ray) -> Vec<Hit> {
    let hit = |(prim_id, triangle)| intersect_triangle(ray, triangle).map(|hit| Hit { prim_id, ..hit });
    let mut hits: Vec<Hit> = (0..).zip(triangles).filter_map(hit).collect();
    hits.sort_by(|a, b| a.t.total_cmp(&b.t).then(a.prim_id.cmp(&b.prim_id)));
    hits
}

fn build(triangles: &[Triangle], quality: Quality) -> Bvh {
    Bvh::build(triangles, &quality.into()).unwrap().0
}

#[test]
fn all_hits_are_those_of_a_loop() {
    let mut random = Random(31);
    let mut longest = 0;
    for (count, size) in [(1, 1.0), (9, 0.7), (100, 1.0), (400, 1.5)] {
        let mut triangles = soup(&mut random, count, size);
        // Copies, which differ only in their indices.
        triangles.extend_from_within(..count.min(20));
        let rays = rays_at(&triangles, &mut random, 20);
        for quality in Quality::ALL {
            let bvh = build(&triangles, quality);
            for ray in &rays {
                let expected = sorted_hits(&triangles, ray);
                longest = longest.max(expected.len());
                for isa in isas() {
                    let tree = bvh.view().with_isa(isa);
                    assert_eq!(tree.count_hits(ray), expected.len());
                    assert_eq!(tree.hits(ray).collect::<Vec<_>>(), expected, "{isa:?} {ray:?}");
                    for room in [0, 1, 2, 7, expected.len(), expected.len() + 3] {
                        let mut hits = vec![Hit::MISS; room];
                        let found = tree.nearest_hits(ray, &mut hits);
                        assert_eq!(hits[..found], expected[..room.min(expected.len())], "{isa:?} {ray:?}");
                    }
                    for n in [0, 1, 15, 16, 17, 40, usize::MAX] {
                        assert_eq!(tree.nth_hit(ray, n), expected.get(n).copied());
                    }
                }
            }
        }
    }
    assert!(longest > 48, "only {longest} hits");
}

#[test]
fn hits_in_no_order_are_the_same_everywhere_and_can_be_broken_off() {
    let mut random = Random(32);
    let triangles = soup(&mut random, 300, 0.9);
    let bvh = build(&triangles, Quality::High);
    for ray in rays_at(&triangles, &mut random, 20) {
        let seen = |isa, most: usize| {
            let mut seen = Vec::new();
            let flow = bvh.view().with_isa(isa).for_each_hit(&ray, |hit| {
                seen.push(*hit);
                if seen.len() == most { ControlFlow::Break(()) } else { GO_ON }
            });
            assert_eq!(flow.is_break(), seen.len() == most);
            seen
        };
        let all = seen(crate::Isa::SCALAR, usize::MAX);
        let mut sorted = all.clone();
        sorted.sort_by(|a, b| a.t.total_cmp(&b.t).then(a.prim_id.cmp(&b.prim_id)));
        assert_eq!(sorted, sorted_hits(&triangles, &ray));
        for isa in isas() {
            assert_eq!(seen(isa, usize::MAX), all);
            assert_eq!(seen(isa, 3), all[..all.len().min(3)]);
        }
    }
}

#[test]
fn a_side_is_front_or_back_and_turns_with_the_triangle_and_with_the_ray() {
    let mut random = Random(33);
    let mut needles = soup(&mut random, 40, 0.6);
    // Rays within a triangle's plane, or almost: in which its side is noise, but the same noise everywhere.
    for triangle in &mut needles[..20] {
        triangle[2] = triangle[0].lerp(triangle[1], 0.3) + random.vector() * 1e-6;
    }
    let mut sides = [0, 0];
    for triangle in needles {
        let trees = [triangle, [triangle[0], triangle[2], triangle[1]]].map(|t| build(&[t], Quality::Fast));
        for ray in rays_at(&[triangle], &mut random, 60) {
            let ray = Ray { t_min: f32::NEG_INFINITY, ..ray };
            let hit = intersect_triangle(&ray, &triangle);
            let front = trees[0].view().intersect_facing(&ray, Facing::Front);
            let back = trees[0].view().intersect_facing(&ray, Facing::Back);
            assert_eq!(front.or(back), hit);
            assert!(front.is_none() || back.is_none());
            sides[0] += usize::from(front.is_some());
            sides[1] += usize::from(back.is_some());
            let reversed = Ray { direction: -ray.direction, t_max: f32::INFINITY, ..ray };
            for isa in isas() {
                let [tree, turned] = [&trees[0], &trees[1]].map(|bvh| bvh.view().with_isa(isa));
                for (facing, expected) in [(Facing::Front, front), (Facing::Back, back), (Facing::Both, hit)] {
                    assert_eq!(tree.intersect_facing(&ray, facing), expected, "{isa:?} {ray:?}");
                    assert_eq!(tree.occluded_facing(&ray, facing), expected.is_some());
                }
                let endless = Ray { t_max: f32::INFINITY, ..ray };
                let (front, back) =
                    (tree.occluded_facing(&endless, Facing::Front), tree.occluded_facing(&endless, Facing::Back));
                assert_eq!(turned.occluded_facing(&endless, Facing::Back), front);
                assert_eq!(turned.occluded_facing(&endless, Facing::Front), back);
                assert_eq!(tree.occluded_facing(&reversed, Facing::Back), front);
                assert_eq!(tree.occluded_facing(&reversed, Facing::Front), back);
            }
        }
    }
    assert!(sides.into_iter().all(|side| side > 1000), "{sides:?}");
}

#[test]
fn a_closed_surface_shows_its_front_outside_and_its_back_inside() {
    let mut random = Random(34);
    let triangles = sphere(3, |p| p * 2.0);
    let bvh = build(&triangles, Quality::High);
    for isa in isas() {
        let tree = bvh.view().with_isa(isa);
        for _ in 0..500 {
            let (inside, outside) = (random.vector(), random.vector().normalize() * 5.0);
            let out = Ray::new(inside, random.vector());
            assert_eq!(tree.intersect_facing(&out, Facing::Back), tree.intersect(&out));
            assert!(!tree.occluded_facing(&out, Facing::Front));
            let through = Ray::between(outside, inside);
            assert_eq!(tree.intersect_facing(&through, Facing::Front), tree.intersect(&through));
            let beyond = Ray { t_max: 10.0, ..through };
            let (near, far) =
                (tree.intersect_facing(&beyond, Facing::Front), tree.intersect_facing(&beyond, Facing::Back));
            assert!(near.unwrap().t < 1.0 && far.unwrap().t > 1.0);
        }
    }
}
