//! The Hessian against exact polygon lights: of the very triangles it is made of, and of rooms.

use std::f64::consts::PI;

use glam::{DVec3, Vec3, dvec3};
use halfdome_kernel::irradiance::Hessian;
use halfdome_kernel::sampling::Stream;
use halfdome_tests::polygon_light::{Derivatives, polygon};

use super::scene::{directions, gather_hessian, hemicube, hit_quad, room, stratified};

/// A vertex of the mesh: place and luminance.
type Vertex = (DVec3, f64);

/// The sum of the lights of a mesh, each with the radiance of its farthest vertex.
fn sum_of_lights(triangles: impl Iterator<Item = [Vertex; 3]>) -> Derivatives {
    let mut sum = Derivatives::ZERO;
    for vertices in triangles {
        let farthest = vertices.iter().max_by(|a, b| a.0.length().total_cmp(&b.0.length())).unwrap();
        let light = polygon(&vertices.map(|vertex| vertex.0), DVec3::ZERO, DVec3::Z);
        sum.irradiance += farthest.1 * light.irradiance;
        sum.hessian += farthest.1 * light.hessian;
    }
    sum
}

#[test]
fn it_is_that_of_the_triangles_between_hit_points() {
    // The quadrature's error falls with the fourth power of the angles between neighbours.
    is_that_of_the_triangles(10, 31, 3e-3);
    is_that_of_the_triangles(40, 126, 1e-4);
}

fn is_that_of_the_triangles(rings: usize, sectors: usize, tolerance: f64) {
    let layout = stratified(rings as u32, sectors as u32);
    let directions = directions(&*layout, Some(9));
    let random = |cell: usize| Stream::new(1, cell as u32, 0).uniform2(0);
    let radiance: Vec<Vec3> = (0..layout.cells()).map(|cell| Vec3::splat(random(cell).x)).collect();
    let distance: Vec<f32> = (0..layout.cells()).map(|cell| 1.0 + 2.0 * random(cell).y).collect();
    let found = layout.hessian(&directions, &radiance, &distance).unwrap();

    let vertex = |cell: usize| (directions[cell].as_dvec3() * f64::from(distance[cell]), f64::from(radiance[cell].x));
    let first_ring = || (0..sectors).map(&vertex);
    let count = sectors as f64;
    let inverse = first_ring().map(|(place, _)| 1.0 / place.length()).sum::<f64>() / count;
    let zenith = (DVec3::Z / inverse, first_ring().map(|(_, luminance)| luminance).sum::<f64>() / count);
    // Row 0 is the zenith, row M + 1 the points dropped onto the tangent plane.
    let at = |row: usize, column: usize| match row {
        0 => zenith,
        row if row <= rings => vertex((row - 1) * sectors + column % sectors),
        _ => {
            let (place, luminance) = vertex((rings - 1) * sectors + column % sectors);
            (place.with_z(0.0), luminance)
        }
    };
    let quads = (0..=rings).flat_map(|row| (0..sectors).map(move |column| (row, column)));
    let triangles = quads.flat_map(|(row, column)| {
        let [a, b] = [at(row, column), at(row, column + 1)];
        let [d, c] = [at(row + 1, column), at(row + 1, column + 1)];
        let lower = (d.0 != c.0).then_some([a, d, c]);
        lower.into_iter().chain((a.0 != b.0).then_some([a, c, b]))
    });
    let lights = sum_of_lights(triangles);
    let last_ring: Vec<DVec3> = (0..sectors).map(|column| at(rings, column).0).collect();
    let base = 0.01 * lights.irradiance / PI * polygon(&last_ring, DVec3::ZERO, DVec3::Z).hessian;
    let expected = lights.hessian + base;
    let size = expected.x_axis.x.abs() + expected.y_axis.y.abs() + expected.x_axis.y.abs();
    for (found, expected) in
        [(found.xx, expected.x_axis.x), (found.xy, expected.x_axis.y), (found.yy, expected.y_axis.y)]
    {
        assert!((f64::from(found) - expected).abs() < tolerance * size, "{found} {expected}");
    }
    assert!((f64::from(found.irradiance) / lights.irradiance - 1.0).abs() < tolerance);
}

/// How a room shines: a radiance for each of its walls and the ceiling.
fn shine(_: DVec3, axis: usize, upper: bool) -> Vec3 {
    Vec3::splat([[0.2, 1.5], [0.8, 0.4], [0.0, 1.0]][axis][usize::from(upper)])
}

const LOWER: DVec3 = dvec3(-1.0, -1.2, -1e-9);
const UPPER: DVec3 = dvec3(1.5, 2.0, 1.3);

#[test]
fn a_room_has_the_hessian_of_its_walls() {
    let mut exact = Derivatives::ZERO;
    for (axis, upper) in [(0, false), (0, true), (1, false), (1, true), (2, true)] {
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        let corner = |high_u: bool, high_v: bool| {
            let mut corner = DVec3::ZERO;
            corner[axis] = if upper { UPPER[axis] } else { LOWER[axis] };
            corner[u] = if high_u { UPPER[u] } else { LOWER[u] };
            corner[v] = if high_v { UPPER[v] } else { LOWER[v] };
            corner
        };
        let corners = [corner(false, false), corner(true, false), corner(true, true), corner(false, true)];
        let wall = polygon(&corners, DVec3::ZERO, DVec3::Z);
        let radiance = f64::from(shine(DVec3::ZERO, axis, upper).x) * wall.irradiance.signum();
        exact.irradiance += radiance * wall.irradiance;
        exact.hessian += radiance * wall.hessian;
    }
    let exact = exact.hessian;
    let error = |found: Hessian| {
        let error = [(found.xx, exact.x_axis.x), (found.xy, exact.x_axis.y), (found.yy, exact.y_axis.y)]
            .map(|(found, exact)| (f64::from(found) - exact).abs());
        error.into_iter().fold(0.0, f64::max) / exact.x_axis.x.abs()
    };
    let layouts = [stratified(10, 31), stratified(36, 114), stratified(128, 402), hemicube(16), hemicube(64)];
    for (layout, bound) in layouts.into_iter().zip([0.35, 0.12, 0.04, 0.1, 0.06]) {
        let error = error(gather_hessian(&*layout, Some(2), |d| room(d, LOWER, UPPER, shine)));
        println!("{} cells: {error:.3}", layout.cells());
        assert!(error < bound, "{} cells: {error}", layout.cells());
    }
}

#[test]
fn uniform_light_has_next_to_none() {
    for layout in [stratified(36, 114), hemicube(32)] {
        let all = |h: Hessian| [h.xx, h.xy, h.yy];
        let room_of = |radiance| gather_hessian(&*layout, Some(2), |d| room(d, LOWER, UPPER, |_, _, _| radiance));
        let (white, black) = (room_of(Vec3::ONE), room_of(Vec3::ZERO));
        // In black all light is 1 and ends at the last ring; in white only its hundredth does.
        assert!((black.irradiance - PI as f32).abs() < 1e-6 && black.xx != 0.0);
        let scale = black.xx.abs() + black.yy.abs();
        for (white, black) in all(white).into_iter().zip(all(black)) {
            assert!((white - 0.01 * black).abs() < 1e-3 * scale, "{white} {black}");
        }
        // What is infinitely far does not change with the place.
        assert_eq!(all(gather_hessian(&*layout, Some(2), |_| (Vec3::ONE, f64::INFINITY))), [0.0; 3]);
    }
}

#[test]
fn misses_are_very_distant_hits() {
    let light = |far: f64| {
        move |d: DVec3| {
            let hit = hit_quad(d, dvec3(0.5, 0.3, 1.0), DVec3::X, DVec3::Y);
            hit.map_or((Vec3::new(0.2, 0.3, 0.4), far), |distance| (Vec3::ONE, distance))
        }
    };
    for layout in [stratified(16, 50), hemicube(16)] {
        let [miss, distant] = [f64::INFINITY, 1e6].map(|far| gather_hessian(&*layout, Some(2), light(far)));
        for (miss, distant) in [(miss.xx, distant.xx), (miss.xy, distant.xy), (miss.yy, distant.yy)] {
            assert!(miss != 0.0 && (miss - distant).abs() < 1e-4 * miss.abs().max(0.01), "{miss} {distant}");
        }
    }
}
