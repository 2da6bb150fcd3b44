//! The queries other than the nearest hit, each against a loop over all triangles that shares nothing with the tree, on
//! every instruction set.

use alloc::vec;
use alloc::vec::Vec;
use core::ops::ControlFlow;

use glam::{DVec3, Vec3, vec3};

use super::Facing;
use crate::geometry::{intersect_triangle, overlaps};
use crate::traverse::tests::{Random, isas, rays_at, soup, sphere};
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
                seen.push(hit);
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

/// Ericson 2005, 5.1.5, in `f64`.
fn ericson(p: Vec3, triangle: &Triangle) -> DVec3 {
    let (p, [a, b, c]) = (p.as_dvec3(), triangle.map(|p| p.as_dvec3()));
    let (ab, ac, ap, bp, cp) = (b - a, c - a, p - a, p - b, p - c);
    let (d1, d2, d3, d4, d5, d6) = (ab.dot(ap), ac.dot(ap), ab.dot(bp), ac.dot(bp), ab.dot(cp), ac.dot(cp));
    let (va, vb, vc) = (d3 * d6 - d5 * d4, d5 * d2 - d1 * d6, d1 * d4 - d3 * d2);
    if d1 <= 0.0 && d2 <= 0.0 {
        a
    } else if d3 >= 0.0 && d4 <= d3 {
        b
    } else if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        a + ab * (d1 / (d1 - d3))
    } else if d6 >= 0.0 && d5 <= d6 {
        c
    } else if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        a + ac * (d2 / (d2 - d6))
    } else if va <= 0.0 && d4 >= d3 && d5 >= d6 {
        b + (c - b) * ((d4 - d3) / ((d4 - d3) + (d5 - d6)))
    } else {
        a + ab * (vb / (va + vb + vc)) + ac * (vc / (va + vb + vc))
    }
}

/// The closest point of a triangle. Its edges besides, as signs are noise in `f64` too if the corners are on a line.
fn exact(p: Vec3, triangle: &Triangle) -> f64 {
    let [a, b, c] = *triangle;
    let edges = [[a, b, b], [b, c, c], [c, a, a]].map(|edge| ericson(p, &edge).distance(p.as_dvec3()));
    edges.into_iter().filter(|d| !d.is_nan()).fold(ericson(p, triangle).distance(p.as_dvec3()), f64::min)
}

/// Points near and far, on corners and on edges.
fn points_at(triangles: &[Triangle], random: &mut Random, count: usize) -> Vec<Vec3> {
    (0..count)
        .map(|i| {
            let [a, b, c] = triangles[random.bits() as usize % triangles.len()];
            match i % 6 {
                0 => a,
                1 => b.lerp(c, random.unit()),
                2 => (a + b + c) / 3.0 + random.vector() * 1e-3 * (b - a).length(),
                3 => a + random.vector() * 100.0 * (b - a).length(),
                _ => a + random.vector() * 2.0 * (b - a).length(),
            }
        })
        .collect()
}

/// Checks the closest points of `triangles` on every instruction set against each other, a loop and `f64`; how many there
/// were.
fn check_closest(triangles: &[Triangle], points: &[Vec3], radius: f32) -> usize {
    let mut found = 0;
    let trees = Quality::ALL.map(|quality| build(triangles, quality));
    for &point in points {
        let exact = triangles.iter().map(|triangle| exact(point, triangle)).fold(f64::INFINITY, f64::min);
        let reach = triangles.iter().flatten().fold(point.abs(), |reach, p| reach.max(p.abs())).max_element();
        let tolerance = f64::from(reach) * 1e-6 + 1e-19;
        let expected = trees[0].view().with_isa(crate::Isa::SCALAR).closest_point(point, radius);
        match expected {
            None => assert!(exact > f64::from(radius) - tolerance, "{point}: {exact} is within {radius}"),
            Some(SurfacePoint { point: closest, distance, u, v, prim_id }) => {
                found += 1;
                assert!((f64::from(distance) - exact).abs() < tolerance, "{point}: {distance} is not {exact}");
                assert!(distance <= radius);
                let [a, b, c] = triangles[prim_id as usize].map(|p| p.as_dvec3());
                let (u, v) = (f64::from(u), f64::from(v));
                assert!(u >= 0.0 && v >= 0.0 && u + v <= 1.0 + 1e-6);
                assert!(((1.0 - u - v) * a + u * b + v * c).distance(closest.as_dvec3()) < tolerance);
            }
        }
        for (tree, isa) in trees.iter().flat_map(|tree| isas().map(move |isa| (tree, isa))) {
            let is = tree.view().with_isa(isa).closest_point(point, radius);
            let bits = |p: Option<SurfacePoint>| p.map(bytemuck::cast::<_, [u32; 7]>);
            assert_eq!(bits(is), bits(expected), "{isa:?} {point} {is:?} {expected:?}");
        }
    }
    found
}

#[test]
fn closest_points_are_those_of_a_loop() {
    let mut random = Random(35);
    for (count, size) in [(1, 1.0), (2, 1.0), (9, 0.5), (300, 0.1)] {
        for (scale, shift) in [(1.0, 0.0), (1e-3, 1.0), (1e6, -3e5)] {
            let place = |p: Vec3| p * scale + shift;
            let mut triangles: Vec<_> = soup(&mut random, count, size).iter().map(|t| t.map(place)).collect();
            let needle = random.vector();
            triangles.push([needle, needle + Vec3::X, needle + Vec3::X * 0.3 + Vec3::Y * 1e-6].map(place));
            triangles.push([needle, needle + Vec3::ONE, needle + Vec3::ONE * 0.5].map(place));
            let points = points_at(&triangles, &mut random, 120);
            assert_eq!(check_closest(&triangles, &points, f32::INFINITY), points.len());
            let within = check_closest(&triangles, &points, 0.2 * scale);
            assert!(within > 30 && within < points.len());
        }
    }
}

/// Slivers, whose interior is as close as their edges are but for their width.
#[test]
fn closest_points_of_slivers_are_exact() {
    let mut random = Random(36);
    for width in [1e-5, 1e-4, 1e-3, 3e-3, 1e-2, 0.1] {
        for _ in 0..100 {
            let (along, across) = (random.vector().normalize(), random.vector());
            let across = (across - across.dot(along) * along).normalize();
            let (start, tip) = (5.0 * random.vector(), 4.0 * random.vector().x);
            let sliver = [start - 5.0 * along, start + 5.0 * along, start + tip * along + width * across];
            let points: Vec<Vec3> = (0..20)
                .map(|i| {
                    let (s, t) = (i as f32 / 20.0, 0.5 * random.vector().x.abs());
                    let foot = sliver[0].lerp(sliver[1], s).lerp(sliver[2], t);
                    foot + along.cross(across) * (0.5 * width * random.vector().x)
                })
                .collect();
            assert_eq!(check_closest(&[sliver], &points, f32::INFINITY), points.len());
        }
    }
}

#[test]
fn of_equally_close_triangles_the_first_counts() {
    let fan: Vec<Triangle> =
        (0..40).map(|i| [Vec3::ZERO, vec3(1.0, i as f32, 1.0), vec3(1.0, i as f32 + 1.0, 1.0)]).rev().collect();
    let bvh = build(&fan, Quality::High);
    for isa in isas() {
        let closest = bvh.view().with_isa(isa).closest_point(vec3(-3.0, 0.0, -4.0), 5.0).unwrap();
        assert_eq!(closest, SurfacePoint { point: Vec3::ZERO, distance: 5.0, u: 0.0, v: 0.0, prim_id: 0 });
        assert_eq!(bvh.view().with_isa(isa).closest_point(vec3(-3.0, 0.0, -4.0), 5.0f32.next_down()), None);
    }
}

#[test]
fn boxes_as_close_as_their_triangles_are_not_left_out() {
    // Walls that are their own boxes, of numbers that are rounded, and points straight above corners, edges and insides:
    // there is no room for error between a box's distance and a triangle's, and several triangles are equally close.
    let mut triangles = Vec::new();
    for i in 0..12 {
        for j in 0..12 {
            let p = |x: i32, y: i32| vec3(x as f32 * 0.1, y as f32 * 0.7, 0.3);
            triangles.push([p(i + 1, j + 1), p(i, j), p(i + 1, j)]);
            triangles.push([p(i, j + 1), p(i, j), p(i + 1, j + 1)]);
        }
    }
    triangles.extend_from_within(..100);
    let above = |i: usize| vec3((i % 25) as f32 * 0.05, (i / 25) as f32 * 0.35, [0.3, 1.7, -8.9, 1e4][i % 4]);
    let points: Vec<_> = (0..625).map(above).collect();
    assert_eq!(check_closest(&triangles, &points, f32::INFINITY), points.len());
}

#[test]
fn closest_points_of_what_is_huge_tiny_or_no_number() {
    let mut random = Random(36);
    for scale in [4e12, 1e10, 1e-12, 1e-17] {
        let triangles: Vec<_> = soup(&mut random, 30, 0.4).iter().map(|t| t.map(|p| p * (0.6 * scale))).collect();
        let points = points_at(&triangles, &mut random, 60);
        let points: Vec<_> = points.into_iter().map(|p| p.clamp(Vec3::splat(-4e12), Vec3::splat(4e12))).collect();
        assert_eq!(check_closest(&triangles, &points, f32::INFINITY), points.len());
    }
    let bvh = build(&soup(&mut random, 30, 0.4), Quality::Fast);
    for isa in isas() {
        let tree = bvh.view().with_isa(isa);
        for bad in [f32::NAN, f32::INFINITY, -f32::INFINITY, 5e12] {
            assert_eq!(tree.closest_point(vec3(0.0, bad, 0.0), f32::INFINITY), None);
        }
        for radius in [f32::NAN, -1.0, f32::NEG_INFINITY, 1e-30] {
            assert_eq!(tree.closest_point(Vec3::splat(9.0), radius), None);
        }
        assert!(tree.closest_point(Vec3::splat(9.0), 1e30).is_some());
        assert_eq!(build(&[], Quality::Fast).view().with_isa(isa).closest_point(Vec3::ZERO, f32::INFINITY), None);
    }
}

/// Whether a triangle and a box have a point in common: the triangle clipped by the box's six planes (Sutherland and
/// Hodgman 1974), in `f64`.
fn clipped(triangle: &Triangle, aabb: &Aabb) -> bool {
    let mut corners: Vec<DVec3> = triangle.iter().map(|p| p.as_dvec3()).collect();
    for axis in 0..3 {
        for (sign, bound) in [(1.0, f64::from(aabb.max[axis])), (-1.0, -f64::from(aabb.min[axis]))] {
            let beyond = |p: &DVec3| sign * p[axis] - bound;
            let mut kept = Vec::new();
            for (i, p) in corners.iter().enumerate() {
                let q = corners[(i + 1) % corners.len()];
                let (at_p, at_q) = (beyond(p), beyond(&q));
                if at_p <= 0.0 {
                    kept.push(*p);
                }
                if (at_p < 0.0 && at_q > 0.0) || (at_p > 0.0 && at_q < 0.0) {
                    kept.push(*p + (q - *p) * (at_p / (at_p - at_q)));
                }
            }
            corners = kept;
        }
    }
    !corners.is_empty()
}

#[test]
fn overlaps_are_what_is_left_after_clipping() {
    let mut random = Random(37);
    let mut counts = [0, 0];
    for i in 0..200_000 {
        let size = [0.05, 0.5, 2.0][i % 3];
        let center = random.vector();
        let triangle = [(); 3].map(|()| center + random.vector() * [0.3, 3.0][i % 2]);
        let aabb = Aabb::around(&[random.vector() * size, random.vector() * size]);
        let is = overlaps(&triangle, &aabb);
        assert_eq!(is, clipped(&triangle, &aabb), "{triangle:?} {aabb:?}");
        counts[usize::from(is)] += 1;
    }
    assert!(counts.into_iter().all(|count| count > 10_000), "{counts:?}");
}

#[test]
fn touching_is_overlapping_and_a_rounding_away_is_not() {
    let unit = Aabb { min: Vec3::ZERO, max: Vec3::ONE };
    let away = |x: f32| [vec3(x, 0.5, 0.5), vec3(2.0, 0.0, 0.0), vec3(2.0, 1.0, 1.0)];
    assert!(overlaps(&away(1.0), &unit) && !overlaps(&away(1.0f32.next_up()), &unit));
    // The plane x + y + z = 3 touches a corner, and no axis but its normal tells that from x + y + z = 3.0000002.
    let plane = |sum: f32| [vec3(sum, 0.0, 0.0), vec3(0.0, sum, 0.0), vec3(0.0, 0.0, sum)];
    assert!(overlaps(&plane(3.0), &unit) && !overlaps(&plane(3.0f32.next_up()), &unit));
    // The edge x + y = 2 touches one of the box, and only their product tells.
    let edge = |sum: f32| [vec3(sum, 0.0, 0.25), vec3(0.0, sum, 0.75), vec3(sum, sum, 0.5)];
    assert!(overlaps(&edge(2.0), &unit) && !overlaps(&edge(2.0f32.next_up()), &unit));
    // Around, inside, points, and boxes without an end or without anything.
    let (all, none) = (Aabb { min: Vec3::NEG_INFINITY, max: Vec3::INFINITY }, Aabb::EMPTY);
    let point = |p: Vec3| Aabb { min: p, max: p };
    assert!(overlaps(&plane(1.5), &unit) && overlaps(&plane(3.0), &point(Vec3::ONE)) && overlaps(&plane(3.0), &all));
    assert!(overlaps(&plane(100.0), &Aabb { min: Vec3::ZERO, ..all }));
    assert!(!overlaps(&plane(3.0), &none) && !overlaps(&plane(3.0), &Aabb { min: Vec3::NAN, ..unit }));
    assert!(!overlaps(&plane(3.0), &point(vec3(1.0, 1.0, 1.0f32.next_down()))));
}

#[test]
fn the_tree_leaves_no_overlap_out() {
    let mut random = Random(38);
    let mut triangles = soup(&mut random, 300, 0.3);
    triangles.push([Vec3::splat(4e12), Vec3::splat(-4e12), vec3(4e12, -4e12, 0.0)]);
    let everything = Aabb { min: Vec3::NEG_INFINITY, max: Vec3::INFINITY };
    let mut boxes =
        vec![everything, Aabb::EMPTY, Aabb { min: Vec3::NAN, max: Vec3::NAN }, Aabb { min: Vec3::X, ..everything }];
    for i in 0..200 {
        let corner = triangles[random.bits() as usize % 300][i % 3];
        let size = [0.0, 1e-3, 0.1, 0.7][i % 4];
        boxes.push(Aabb::around(&[corner, corner + random.vector() * size]));
    }
    for quality in Quality::ALL {
        let bvh = build(&triangles, quality);
        for aabb in &boxes {
            let expected: Vec<u32> =
                (0..).zip(&triangles).filter(|(_, t)| overlaps(t, aabb)).map(|(id, _)| id).collect();
            let seen = |isa, most: usize| {
                let mut seen = Vec::new();
                let flow = bvh.view().with_isa(isa).for_each_overlap(aabb, |prim_id| {
                    seen.push(prim_id);
                    if seen.len() == most { ControlFlow::Break(()) } else { GO_ON }
                });
                assert_eq!(flow.is_break(), seen.len() == most);
                seen
            };
            let all = seen(crate::Isa::SCALAR, usize::MAX);
            let mut sorted = all.clone();
            sorted.sort_unstable();
            assert_eq!(sorted, expected);
            for isa in isas() {
                assert_eq!(seen(isa, usize::MAX), all, "{isa:?} {aabb:?}");
                assert_eq!(seen(isa, 2), all[..all.len().min(2)]);
            }
        }
    }
}
