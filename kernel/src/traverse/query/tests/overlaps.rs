//! Triangles that overlap boxes, against clipping.

use super::*;

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
