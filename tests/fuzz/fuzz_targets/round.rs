//! Points and curves of any bits, and rays at them, by all ways to trace and on all instruction sets, against the loop.
#![no_main]

use glam::Vec3;
use halfdome_fuzz::Bytes;
use halfdome_fuzz::check::check_round;
use halfdome_kernel::{CubicCurve, Disc, LinearCurve, Sphere, Triangle};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|data: &[u8]| {
    let mut bytes = Bytes(data);
    let (kind, count) = (bytes.byte() % 4, bytes.below(20));
    let places: Vec<Triangle> = (0..count).map(|_| [bytes.vector(), bytes.vector(), bytes.vector()]).collect();
    let controls = |bytes: &mut Bytes, &[a, b, c]: &Triangle| [a, b, c, a].map(|near: Vec3| bytes.sphere(near));
    let controls: Vec<_> = places.iter().map(|place| controls(&mut bytes, place)).collect();
    let rays = bytes.rays(&places, 12);
    match kind {
        0 => check_round(&controls.iter().map(|&[a, ..]| a).collect::<Vec<_>>(), &rays),
        1 => {
            let disc = |&[a, b, ..]: &[Sphere; 4]| Disc { center: a.center, radius: a.radius, normal: b.center };
            check_round(&controls.iter().map(disc).collect::<Vec<_>>(), &rays)
        }
        2 => check_round(&controls.iter().map(|&[a, b, ..]| LinearCurve { ends: [a, b] }).collect::<Vec<_>>(), &rays),
        _ => check_round(&controls.iter().map(|&controls| CubicCurve { controls }).collect::<Vec<_>>(), &rays),
    };
});
