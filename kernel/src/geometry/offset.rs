//! Origins of rays that leave a surface, so that they do not hit the triangle that they leave.
//!
//! Ize 2013, "Robust BVH Ray Traversal", and Pharr, Jakob and Humphreys, "Physically Based Rendering", 6.8, move the
//! origin along the normal by a bound of its rounding error instead of by a guessed length. Two values are rounded, in
//! units of `u = 2⁻²⁴`:
//!
//! - the point, which `(1 - u - v) a + u b + v c` misses by up to 5 `u` of the greatest coordinate along each axis, and
//!   its sum with the offset by one more;
//! - the test of the next ray, which moves the corners, relative to its origin, by up to 7 `u` of the triangle's extent
//!   across the ray, and finds the depth of the crossing by their weights, with one more (see [`geometry`](super)).
//!
//! The distance to the plane by which both can be wrong is the sum of the errors along the axes, weighted by the
//! normal's components. So a wall in the plane x = 5 needs a few units in the last place of 5 and of its own extent,
//! whatever its position along y and z. In an experiment a third of the first with an eighth of the second was enough
//! for six million rays, and a sixth with an eighth too little for 20 of them.

use glam::{DVec3, Vec3};

use super::Triangle;

/// A bound of the point's error, in units of the greatest coordinate along each axis.
const POINT_ERROR: f32 = 6.0 / (1u32 << 24) as f32;
/// A bound of the test's error along each axis, in units of the triangle's greatest extent.
const TEST_ERROR: f32 = 8.0 / (1u32 << 24) as f32;

/// The unit normal of the side from which the corners of `triangle` run counter-clockwise; zero if it has no area. In
/// `f64`, as the edges of a needle cancel.
pub fn triangle_normal(triangle: &Triangle) -> Vec3 {
    let [a, b, c]: [DVec3; 3] = triangle.map(|p| p.as_dvec3());
    (b - a).cross(c - a).normalize_or_zero().as_vec3()
}

/// The point of `triangle` with the barycentric weights `u` and `v` of a hit, moved along its unit `normal`, to the
/// side to which `direction` points: a ray from there into that direction does not hit the triangle. If the normal is
/// zero, as that of a triangle without area, the point stays.
///
/// The distance is a few units in the last place of the triangle's coordinates and of its extent; it scales with the
/// scene, and there is no length to tune. For many rays from one triangle keep its [`offset_distance`] and call
/// [`offset_point`]; this function does just that.
#[inline]
pub fn offset_origin(triangle: &Triangle, normal: Vec3, u: f32, v: f32, direction: Vec3) -> Vec3 {
    let [a, b, c] = *triangle;
    let point = (1.0 - u - v) * a + u * b + v * c;
    offset_point(point, normal, offset_distance(triangle, normal), direction)
}

/// The distance from the plane of `triangle`, whose unit normal is `normal`, at which a ray that leaves it has to
/// start.
#[inline]
pub fn offset_distance(triangle: &Triangle, normal: Vec3) -> f32 {
    let [a, b, c] = *triangle;
    let coordinates = a.abs().max(b.abs()).max(c.abs());
    let extent = (a.max(b).max(c) - a.min(b).min(c)).max_element();
    normal.abs().dot(coordinates * POINT_ERROR + Vec3::splat(extent * TEST_ERROR))
}

/// `point` moved by `distance` along `normal`, to the side to which `direction` points.
#[inline(always)]
pub fn offset_point(point: Vec3, normal: Vec3, distance: f32, direction: Vec3) -> Vec3 {
    point + normal * distance.copysign(normal.dot(direction))
}

// Miri would take hours.
#[cfg(all(test, not(miri)))]
mod tests {
    use alloc::vec::Vec;

    use glam::vec3;

    use super::*;
    use crate::geometry::intersect_triangle;
    use crate::traverse::tests::{Random, fewer, sphere};
    use crate::{Bvh, Hit, Quality, Ray};

    /// Weights of a point of a triangle; of some on an edge.
    fn weights(random: &mut Random, i: usize) -> (f32, f32) {
        let (u, v) = (random.unit(), random.unit());
        let (u, v) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
        match i % 12 {
            0 => (u, 0.0),
            1 => (0.0, v),
            _ => (u, v),
        }
    }

    /// Triangles of any shape, near and far; needles, upright and flat ones among them.
    fn triangle(random: &mut Random, i: usize) -> Triangle {
        let place =
            random.vector() * [Vec3::ONE, Vec3::X, vec3(1.0, 1e-3, 0.0)][i / 4 % 3] * [0.0, 1.0, 1e3, 1e6][i % 4];
        let size = [1.0, 1e-3, 1e4, 1e-2, 7.0][i % 5];
        let mut triangle = [(); 3].map(|()| random.vector() * size + place);
        let [a, b, c] = &mut triangle;
        match i % 7 {
            0 => *c = a.lerp(*b, random.unit()) + random.vector() * (size * 1e-5),
            1 => (b.y, c.y) = (a.y, a.y),
            2 => [a, b, c].into_iter().for_each(|p| p.y = (p.x - place.x) * 0.5 + place.y),
            _ => {}
        }
        triangle
    }

    #[test]
    fn a_ray_that_leaves_a_triangle_does_not_hit_it() {
        let mut random = Random(7);
        for i in 0..fewer(2_000_000) {
            let triangle = triangle(&mut random, i);
            let normal = triangle_normal(&triangle);
            if normal == Vec3::ZERO {
                continue;
            }
            let (u, v) = weights(&mut random, i);
            // To both sides, steep and grazing, across and along an edge.
            let slope = random.unit() * [1.0, 1e-2, 1e-4, 1e-6][i % 4] * [1.0, -1.0][i / 4 % 2];
            let along = if i % 17 == 0 { triangle[1] - triangle[0] } else { random.vector().reject_from(normal) };
            let direction = along.normalize() + normal * slope;
            let ray = Ray::new(offset_origin(&triangle, normal, u, v, direction), direction);
            assert_eq!(intersect_triangle(&ray, &triangle), None, "{i}: {triangle:?} {ray:?}");
        }
    }

    #[test]
    fn a_ray_that_leaves_a_needle_does_not_hit_it_far_along() {
        // A weight is below zero by 3e-5. If it were clamped before `t` is found, the crossing behind the origin would
        // become one at t = 2.3e-4.
        let needle = [
            vec3(2.8903623, 1.5628053, 6.914675),
            vec3(2.5008483, 1.0290431, -5.1798735),
            vec3(2.6286528, 1.2042518, -1.2111766),
        ];
        let ray = Ray::new(vec3(2.8315444, 1.4822171, 5.088298), vec3(0.58316815, 0.061265934, -1.0229764));
        assert_eq!(intersect_triangle(&ray, &needle), None);
        let behind = intersect_triangle(&Ray { t_min: -1.0, ..ray }, &needle).unwrap();
        assert!((-1e-4..0.0).contains(&behind.t), "{behind:?}");
    }

    #[test]
    fn without_the_offset_it_would() {
        let mut random = Random(8);
        let mut hits = 0;
        for i in 0..1000 {
            let triangle = triangle(&mut random, i);
            let normal = triangle_normal(&triangle);
            let origin = offset_origin(&triangle, Vec3::ZERO, 0.3, 0.3, normal);
            hits += usize::from(intersect_triangle(&Ray::new(origin, normal), &triangle).is_some());
        }
        assert!(hits > 100, "{hits}");
    }

    #[test]
    fn the_offset_is_a_few_units_in_the_last_place() {
        let mut random = Random(9);
        for i in 0..300_000 {
            let triangle = triangle(&mut random, i);
            let (normal, (u, v)) = (triangle_normal(&triangle).as_dvec3(), weights(&mut random, i));
            let origin = offset_origin(&triangle, normal.as_vec3(), u, v, random.vector());
            let distance = (origin.as_dvec3() - triangle[0].as_dvec3()).dot(normal).abs();
            let largest = |x: f32, p: Vec3| x.max(p.abs().max_element());
            // An upper bound of the unit in the last place of all coordinates, and of the extent.
            let unit = f64::from(triangle.iter().fold(0.0, |x, &p| largest(x, p))) * f64::from(f32::EPSILON);
            let extent =
                f64::from(triangle.iter().fold(0.0, |x, &p| largest(x, p - triangle[0]))) * f64::from(f32::EPSILON);
            assert!(distance <= 12.0 * unit + 8.0 * extent, "{i}: {distance} {unit} {extent}");
        }
        // A small tile of a wall, far along y, where coordinates are coarse: at x = 5 they are fine.
        let tile = [vec3(5.0, 1e6, 0.0), vec3(5.0, 1e6, 0.5), vec3(5.0, 1e6 + 0.5, 0.0)];
        let origin = offset_origin(&tile, Vec3::X, 0.25, 0.25, Vec3::X);
        assert_eq!((origin.y, origin.z), (1e6 + 0.125, 0.125));
        assert!(origin.x > 5.0 && origin.x <= 5.0 + 8.0 * 5.0 * f32::EPSILON, "{}", origin.x);
    }

    #[test]
    fn in_a_furnace_no_reflection_escapes_and_none_outside_comes_back() {
        let mut random = Random(10);
        for center in [Vec3::ZERO, Vec3::splat(1e3), vec3(148_376.0, 1234.0, -223_423.0)] {
            let triangles = sphere(3, |p| p * 3.0 + center);
            let normals: Vec<Vec3> = triangles.iter().map(triangle_normal).collect();
            let (bvh, _) = Bvh::build(&triangles, &Quality::Fast.into()).unwrap();
            let leave = |hit: &Hit, random: &mut Random, outwards: bool| {
                let normal = normals[hit.prim_id as usize];
                let side = if outwards { normal } else { -normal };
                let direction = side + random.vector().normalize() * 0.9999;
                Ray::new(offset_origin(&triangles[hit.prim_id as usize], normal, hit.u, hit.v, direction), direction)
            };
            let mut inside = Ray::new(center, Vec3::X);
            for bounce in 0..fewer(30_000) {
                let hit = bvh.view().intersect(&inside).unwrap_or_else(|| panic!("{bounce}: {inside:?} escapes"));
                // Far away the vertices are rounded so much that the sphere has dents.
                if center == Vec3::ZERO {
                    let outside = leave(&hit, &mut random, true);
                    assert_eq!(bvh.view().intersect(&outside), None, "{bounce}: {outside:?}");
                }
                inside = leave(&hit, &mut random, false);
            }
        }
    }
}
