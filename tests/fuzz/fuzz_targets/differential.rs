//! Rays of any bits through trees that are fixed and scenes of their instances, by all ways to trace and on all
//! instruction sets, against the scalar loop over all triangles.
#![no_main]

use std::sync::LazyLock;

use glam::{Vec3, vec3};
use halfdome_fuzz::Bytes;
use halfdome_fuzz::check::{check_scenes, check_tree};
use halfdome_kernel::traverse::reference;
use halfdome_kernel::{Bvh, Quality, Triangle};
use libfuzzer_sys::fuzz_target;

struct Scene {
    triangles: Vec<Triangle>,
    bvh: Bvh,
}

impl Scene {
    fn new(triangles: Vec<Triangle>) -> Self {
        let (bvh, report) = Bvh::build(&triangles, &Quality::Medium.into()).expect("there are few");
        // The loop has no others.
        assert_eq!(report.dropped(), 0);
        Self { triangles, bvh }
    }
}

/// Quads of a stepped grid, a fan of needles far away, and shells around each other of all sizes.
static SCENES: LazyLock<[Scene; 3]> = LazyLock::new(|| {
    let at = |x: u32, y: u32| vec3(x as f32, y as f32, ((x * 7 + y * 3) % 4) as f32) - 4.0;
    let quads = (0..5).flat_map(|x| (0..5).map(move |y| (x, y)));
    let grid = quads
        .flat_map(|(x, y)| [[at(x, y), at(x + 1, y), at(x + 1, y + 1)], [at(x, y), at(x + 1, y + 1), at(x, y + 1)]]);
    let needle = |i: u32| {
        let (sin, cos) = (i as f32).sin_cos();
        let place = vec3(148_376.0, 1234.0, -223_423.0);
        [place, place + vec3(sin, cos, 0.5) * 100.0, place + vec3(sin, cos, 0.501) * 100.0]
    };
    let shell = |i: i32| [Vec3::NEG_ONE, vec3(2.0, -1.0, 1.0), vec3(-1.0, 2.0, 0.5)].map(|p| p * 2f32.powi(i));
    [grid.collect(), (0..24).map(needle).collect(), (-50..40).step_by(3).map(shell).collect()].map(Scene::new)
});

fuzz_target!(|data: &[u8]| {
    let mut bytes = Bytes(data);
    let Scene { triangles, bvh } = &SCENES[bytes.below(3)];
    let rays = bytes.rays(triangles, 12);
    let expected: Vec<_> = rays.iter().map(|ray| reference::intersect_all(triangles, ray)).collect();
    check_tree(&bvh.view(), &rays, &expected);
    check_scenes(&bvh.view(), data.len(), &rays);
});
