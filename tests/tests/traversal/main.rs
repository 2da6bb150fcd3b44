//! Every way to trace, against a loop over all triangles and against independent answers.

mod axes;
mod closed;
mod known_failures;
mod limits;
mod malformed;
mod oracle;
mod round;
mod stack;
mod strategies;

use glam::Vec3;
use halfdome_kernel::geometry::intersect_triangle;
use halfdome_kernel::{Hit, Ray, Triangle};
use halfdome_tests::check::check;
use halfdome_tests::random::Pcg;
use proptest::prelude::*;
use proptest::test_runner::RngSeed;
use strategies::{coordinate, grid, raw, scene};

/// The same cases in every run.
fn config(cases: u32) -> ProptestConfig {
    ProptestConfig { cases, rng_seed: RngSeed::Fixed(0x9a1f_d03e), failure_persistence: None, ..Default::default() }
}

proptest! {
    #![proptest_config(config(1500))]

    #[test]
    fn raw_bits_trace_alike((triangles, rays) in scene(raw(), 40)) {
        check(&triangles, &rays);
    }

    #[test]
    fn mixed_scales_trace_alike((triangles, rays) in scene(coordinate(), 60)) {
        check(&triangles, &rays);
    }

    #[test]
    fn grids_trace_alike((triangles, rays) in scene(grid(), 120)) {
        check(&triangles, &rays);
    }

    #[test]
    fn the_order_of_triangles_does_not_matter((triangles, rays) in scene(coordinate(), 60), seed in any::<u64>()) {
        let before = check(&triangles, &rays);
        // Entry `i` of the shuffled list was at `origin[i]`.
        let mut origin: Vec<usize> = (0..triangles.len()).collect();
        let mut random = Pcg::new(seed);
        for i in (1..origin.len()).rev() {
            origin.swap(i, random.below(i + 1));
        }
        let shuffled: Vec<Triangle> = origin.iter().map(|&i| triangles[i]).collect();
        let after = check(&shuffled, &rays);
        for ((before, after), ray) in before.into_iter().zip(after).zip(&rays) {
            let distance = |hit: Option<Hit>| hit.map(|hit| hit.t);
            assert_eq!(distance(before), distance(after));
            let (Some(before), Some(after)) = (before, after) else { continue };
            let is_tied =
                |triangle: &Triangle| intersect_triangle(ray, triangle).is_some_and(|hit| hit.t == before.t);
            let tied: Vec<usize> = (0..triangles.len()).filter(|&i| is_tied(&triangles[i])).collect();
            let was = origin[after.prim_id as usize];
            if tied.len() == 1 {
                assert_eq!((was, after.u, after.v), (before.prim_id as usize, before.u, before.v));
            } else {
                assert!(tied.contains(&was) && tied.contains(&(before.prim_id as usize)), "{tied:?} {before:?} {was}");
            }
        }
    }
}

#[test]
fn of_equal_hits_the_lowest_index_wins() {
    let triangle = [Vec3::ZERO, Vec3::X, Vec3::Y];
    for count in 1..40 {
        // Copies with all starting corners, and a farther triangle before them.
        let mut triangles = vec![triangle.map(|p| p - Vec3::Z)];
        triangles.extend((0..count).map(|i| [0, 1, 2].map(|corner| triangle[(corner + i) % 3])));
        let ray = Ray::new(Vec3::new(0.25, 0.25, 1.0), Vec3::NEG_Z);
        let [hit] = check(&triangles, &[ray])[..] else { panic!("one ray") };
        assert_eq!(hit.map(|hit| (hit.t, hit.prim_id)), Some((1.0, 1)), "{count} copies");
    }
}

#[test]
fn trees_of_up_to_nine_triangles_hit_each_of_them() {
    for count in 0..=9 {
        let at = |i: usize| Vec3::new(3.0 * i as f32, 0.0, i as f32);
        let triangles: Vec<Triangle> = (0..count).map(|i| [at(i), at(i) + Vec3::X, at(i) + Vec3::Y]).collect();
        let rays: Vec<Ray> = (0..10).map(|i| Ray::new(at(i) + Vec3::new(0.25, 0.25, 2.0), 2.0 * Vec3::NEG_Z)).collect();
        for (i, hit) in check(&triangles, &rays).into_iter().enumerate() {
            let expected = (i < count).then_some((1.0, 0.25, 0.25, i as u32));
            assert_eq!(hit.map(|hit| (hit.t, hit.u, hit.v, hit.prim_id)), expected, "{i} of {count}");
        }
    }
}
