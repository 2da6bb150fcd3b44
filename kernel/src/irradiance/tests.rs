//! The sums in lanes against the reference, on every instruction set.

use glam::{Vec2, Vec3};

use super::*;
use crate::sampling::{Strata, Stream};
use crate::simd::{Isa, isas};
use crate::traverse::tests::fewer;

/// Noise of radiance, and distances with misses among them.
fn noise(cells: usize, misses: bool) -> (Vec<Vec3>, Vec<f32>) {
    let sample = |cell: usize| {
        let [a, b] = Stream::new(7, cell as u32, 0).uniform2(0).to_array();
        let [c, d] = Stream::new(7, cell as u32, 1).uniform2(0).to_array();
        let distance = if misses && d > 0.8 { f32::INFINITY } else { 0.1 + 3.0 * d };
        (Vec3::new(a, b, 10.0 * c), distance)
    };
    (0..cells).map(sample).unzip()
}

fn close(a: &Gather, b: &Gather, tolerance: f32) {
    let scalars = |g: &Gather| [g.harmonic_mean_distance, g.minimum_distance, g.standard_error];
    for (a, b) in scalars(a).into_iter().zip(scalars(b)) {
        assert!(a == b || (a - b).abs() <= tolerance * b, "{a} {b}");
    }
    let vectors = |g: &Gather| [&[g.irradiance], &g.rotational[..], &g.translational[..]].concat();
    let inverse = 1.0 / b.minimum_distance;
    for (i, (a, b)) in vectors(a).into_iter().zip(vectors(b)).enumerate() {
        // Gradients are sums of both signs: what rounds is as large as the irradiance, times 1/r if it is one of walls.
        let size = 10.0 * if i >= 4 { inverse.max(1.0) } else { 1.0 };
        assert!((a - b).abs().max_element() <= tolerance * size, "{i}: {a} {b}");
    }
}

fn with_all_isas(layout: impl Fn(Isa) -> Gather) -> Gather {
    let expected = layout(Isa::PORTABLE);
    for isa in isas() {
        assert_eq!(layout(isa), expected, "{}", isa.level());
    }
    expected
}

#[test]
fn stratified_is_the_reference() {
    for (rings, sectors) in [(1, 1), (1, 3), (10, 31), (3, 8), (16, 50), (36, 114), (2, 2), (5, 16), (4, 17), (9, 48)] {
        for misses in [false, true] {
            let strata = Strata::new(rings, sectors).unwrap();
            let (radiance, distance) = noise(strata.cells(), misses);
            let gather = with_all_isas(|isa| {
                let layout = Stratified::new(strata, vec![0.0; Stratified::table_len(&strata)]).unwrap();
                layout.with_isa(isa).accumulate(&radiance, &distance).unwrap()
            });
            close(&gather, &reference::stratified(&strata, &radiance, &distance), 2e-6);
        }
    }
}

/// Noise of a known variance in equal cells, 1/12 for each of two channels and 100/12 for the third.
#[test]
fn deviation_is_that_of_independent_cells() {
    let strata = Strata::new(36, 114).unwrap();
    let layout = Stratified::new(strata, vec![0.0; Stratified::table_len(&strata)]).unwrap();
    let (radiance, distance) = noise(strata.cells(), false);
    let found = layout.accumulate(&radiance, &distance).unwrap().standard_error;
    let expected = core::f32::consts::PI * (100.0 / 12.0 / strata.cells() as f32).sqrt();
    assert!((found / expected - 1.0).abs() < 0.03, "{found} {expected}");
    let even = layout.accumulate(&vec![Vec3::new(3.0, 2.0, 1.0); strata.cells()], &distance).unwrap();
    assert_eq!(even.standard_error, 0.0);
}

#[test]
fn hemicube_is_the_reference() {
    for size in [2, 4, 6, 16, 32] {
        for misses in [false, true] {
            let (radiance, distance) = noise(3 * (size * size) as usize, misses);
            let gather = with_all_isas(|isa| {
                let layout = Hemicube::new(size, vec![0.0; Hemicube::table_len(size)]).unwrap();
                layout.with_isa(isa).accumulate(&radiance, &distance).unwrap()
            });
            close(&gather, &reference::hemicube(size, &radiance, &distance), 2e-6);
        }
    }
}

#[test]
fn hessians_are_equal_on_all_instruction_sets() {
    let found = |layout: &dyn Layout| {
        let (radiance, distance) = noise(layout.cells(), true);
        layout.hessian(&middles(layout), &radiance, &distance).unwrap()
    };
    for (rings, sectors, size) in [(10, 31, 6), (1, 3, 2), (8, 12, 4), (9, 48, 16)] {
        let strata = Strata::new(rings, sectors).unwrap();
        let stratified = Stratified::new(strata, vec![0.0; Stratified::table_len(&strata)]).unwrap();
        let hemicube = Hemicube::new(size, vec![0.0; Hemicube::table_len(size)]).unwrap();
        let expected = [&stratified as &dyn Layout, &hemicube].map(found);
        assert!(expected.iter().all(|hessian| hessian.xx.is_finite() && hessian.irradiance > 0.0), "{expected:?}");
        for isa in isas() {
            let (stratified, hemicube) = (stratified.clone().with_isa(isa), hemicube.clone().with_isa(isa));
            assert_eq!([found(&stratified), found(&hemicube)], expected, "{}", isa.level());
        }
    }
}

fn middles(layout: &dyn Layout) -> Vec<Vec3> {
    let mut directions = vec![Vec3::ZERO; layout.cells()];
    layout.directions(&mut |_| Vec2::splat(0.5), &mut directions).unwrap();
    directions
}

#[test]
fn texels_have_the_solid_angles_of_the_corner_formula() {
    // The antiderivative of (x² + y² + 1)^(-3/2) on a face at distance 1.
    let corner = |x: f64, y: f64| (x * y).atan2((x * x + y * y + 1.0).sqrt());
    // A cosine at the middle is off by a part that falls with the square of the size.
    for (n, tolerance) in [(16, 1e-2), (64, 1e-2 / 16.0)] {
        let hemicube = Hemicube::new(n, vec![0.0; Hemicube::table_len(n)]).unwrap();
        let directions = middles(&hemicube);
        let cells = hemicube.cells();
        // Each cell is lit alone: its E is its ∫ cos θ dω, and about the cosine of its middle times its solid angle.
        for cell in (0..cells).step_by(cells / fewer(cells / 7)) {
            let mut radiance = vec![Vec3::ZERO; cells];
            radiance[cell] = Vec3::ONE;
            let found = hemicube.accumulate(&radiance, &vec![1.0; cells]).unwrap();
            let d = directions[cell].as_dvec3();
            let largest = d.abs().max_element();
            let mut across = [d.x, d.y, d.z].map(|part| part / largest).to_vec();
            across.remove([d.x, d.y, d.z].iter().position(|part| part.abs() == largest).unwrap());
            let (half, [x, y]) = (1.0 / f64::from(n), [across[0], across[1]]);
            let solid_angle = corner(x + half, y + half) - corner(x - half, y + half) - corner(x + half, y - half)
                + corner(x - half, y - half);
            let exact = f64::from(found.irradiance.x);
            assert!(
                (exact / (solid_angle * d.z) - 1.0).abs() < tolerance,
                "{n}: {cell}: {exact} {}",
                solid_angle * d.z
            );
        }
        let all = hemicube.accumulate(&vec![Vec3::ONE; cells], &vec![2.0; cells]).unwrap();
        assert!((all.irradiance - core::f32::consts::PI).abs().max_element() < 3e-6);
        assert!((all.harmonic_mean_distance - 2.0).abs() < 3e-6 && all.minimum_distance == 2.0);
    }
}

#[test]
fn hemicube_directions_lie_in_order() {
    let hemicube = Hemicube::new(2, vec![0.0; Hemicube::table_len(2)]).unwrap();
    let on_faces: Vec<Vec3> = middles(&hemicube).iter().map(|d| (d / d.abs().max_element() * 2.0).round()).collect();
    let expected = [
        [-1, -1, 2],
        [1, -1, 2],
        [-1, 1, 2],
        [1, 1, 2],
        [2, -1, 1],
        [2, 1, 1],
        [1, 2, 1],
        [-1, 2, 1],
        [-2, 1, 1],
        [-2, -1, 1],
        [-1, -2, 1],
        [1, -2, 1],
    ];
    assert_eq!(on_faces, expected.map(|d| Vec3::from(d.map(|part| part as f32))));
}

#[test]
fn strata_have_their_own_directions() {
    let strata = Strata::new(3, 8).unwrap();
    let layout = Stratified::new(strata, vec![0.0; Stratified::table_len(&strata)]).unwrap();
    let mut directions = [Vec3::ZERO; 24];
    layout.directions(&mut |cell| Stream::new(3, cell as u32, 0).uniform2(0), &mut directions).unwrap();
    for (cell, direction) in (0..).zip(directions) {
        assert_eq!(direction, strata.direction(cell / 8, cell % 8, Stream::new(3, cell, 0).uniform2(0)));
    }
}

#[test]
fn distances_without_a_reciprocal_are_bounded() {
    let strata = Strata::new(4, 12).unwrap();
    let layout = Stratified::new(strata, vec![0.0; Stratified::table_len(&strata)]).unwrap();
    let (radiance, distance) = noise(48, true);
    let with = |value: f32| {
        let mut distance = distance.clone();
        distance[17] = value;
        let hessian = layout.hessian(&middles(&layout), &radiance, &distance).unwrap();
        (layout.accumulate(&radiance, &distance).unwrap(), hessian)
    };
    let expected = with(MIN_DISTANCE);
    assert_eq!(expected.0.minimum_distance, MIN_DISTANCE);
    assert!(expected.0.translational.iter().all(|gradient| gradient.is_finite()) && expected.1.xx.is_finite());
    for value in [0.0, -0.0, -3.0, 1e-30, f32::NAN] {
        assert_eq!(with(value), expected, "{value}");
    }
    let nowhere = layout.accumulate(&radiance, &[f32::INFINITY; 48]).unwrap();
    assert_eq!(nowhere.translational, [Vec3::ZERO; 3]);
    assert_eq!((nowhere.harmonic_mean_distance, nowhere.minimum_distance), (f32::INFINITY, f32::INFINITY));
}

#[test]
fn bad_sizes_and_slices_are_refused() {
    let strata = Strata::new(2, 5).unwrap();
    let needed = Stratified::table_len(&strata);
    let mut memory = vec![f32::NAN; needed + 1];
    assert_eq!(
        Stratified::new(strata, &mut memory[..needed - 1]).unwrap_err(),
        LayoutError::Table { needed, given: needed - 1 }
    );
    let layout = Stratified::new(strata, &mut memory[..]).unwrap();
    let length = |slice| LayoutError::Length { cells: 10, slice };
    assert_eq!(layout.accumulate(&[Vec3::ZERO; 9], &[1.0; 10]), Err(length(9)));
    assert_eq!(layout.accumulate(&[Vec3::ZERO; 10], &[1.0; 11]), Err(length(11)));
    assert_eq!(layout.directions(&mut |_| Vec2::ZERO, &mut [Vec3::ZERO; 3]), Err(length(3)));
    assert_eq!(layout.hessian(&[Vec3::Z; 1], &[Vec3::ZERO; 10], &[1.0; 10]), Err(length(1)));
    for size in [0, 1, 3, Hemicube::MAX_SIZE + 2, u32::MAX] {
        assert_eq!(Hemicube::new(size, [0.0; 0]).unwrap_err(), LayoutError::Size { size });
    }
    let error = Hemicube::new(2, [0.0; 8]).unwrap_err();
    assert_eq!(error.to_string(), "the layout's table needs memory for 336 floats, there is some for 8");
    let error = LayoutError::Size { size: 3 };
    assert_eq!(error.to_string(), "hemicube of 3 texels a side: must be even, from 2 to 4096");
    let error = LayoutError::Length { cells: 10, slice: 3 };
    assert_eq!(error.to_string(), "10 cells need as many elements, the slice has 3");
}
