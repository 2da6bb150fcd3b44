//! Closest points, against exact ones and a loop over all triangles.

use super::*;

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

/// Checks the closest points of `triangles` on every instruction set against each other, a loop and `f64`; how many
/// there were.
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
    // Walls that are their own boxes, of numbers that are rounded, and points straight above corners, edges and
    // insides: there is no room for error between a box's distance and a triangle's, and several triangles are equally
    // close.
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
