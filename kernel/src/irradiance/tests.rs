//! The sums in lanes against the reference, on every instruction set.

use glam::Vec3;

use super::*;
use crate::Level;
use crate::sampling::{Strata, Stream};
use crate::simd::Isa;

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
    let scalars = |g: &Gather| [g.harmonic_mean_distance, g.minimum_distance];
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
    for isa in Level::ALL.into_iter().filter_map(Isa::new) {
        assert_eq!(layout(isa), expected, "{}", isa.level());
    }
    expected
}

#[test]
fn stratified_is_the_reference() {
    for (rings, sectors) in [(1, 1), (1, 3), (10, 31), (3, 8), (16, 50), (36, 114), (2, 2)] {
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
