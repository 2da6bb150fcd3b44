//! Points and curves of all sizes, on grids and of any bits, by all ways to trace against the loop.

use glam::Vec3;
use halfdome_kernel::{CubicCurve, Disc, LinearCurve, Ray, Sphere};
use halfdome_tests::check::check_round;
use halfdome_tests::random::Pcg;

fn vector(random: &mut Pcg, i: usize) -> Vec3 {
    let v = random.in_cube();
    match i % 4 {
        0 => (v * 4.0).round().as_vec3(),
        1 if random.below(8) == 0 => Vec3::from([0; 3].map(|_| f32::from_bits(random.bits()))),
        2 => (v * 1e3).as_vec3(),
        _ => v.as_vec3(),
    }
}

fn sphere(random: &mut Pcg, near: Vec3, i: usize) -> Sphere {
    let radius = [0.5, 0.1, 1e-4, 0.0][random.below(4)] * random.unit() as f32;
    Sphere::new(near + vector(random, i + 3) * [1.0, 0.1, 0.0][random.below(3)], radius)
}

#[test]
fn all_ways_agree() {
    let mut random = Pcg::new(51);
    let mut hits = 0;
    for i in 0..24 {
        let count = [1, 7, 9, 60][i / 4 % 4];
        let near: Vec<Vec3> = (0..count).map(|_| vector(&mut random, i)).collect();
        let aimed = |random: &mut Pcg, k: usize| {
            let (target, origin) = (near[random.below(count)], vector(random, i + k) * [1.0, 3.0, 1e3][k % 3]);
            let (t_min, t_max) = if k.is_multiple_of(4) { (random.unit() as f32, 1.0) } else { (0.0, f32::INFINITY) };
            let direction = target + vector(random, 3) * 0.1 - origin;
            Ray { origin, t_min, direction, t_max }
        };
        let rays: Vec<Ray> = (0..60).map(|k| aimed(&mut random, k)).collect();
        let spheres: Vec<Sphere> = near.iter().map(|&near| sphere(&mut random, near, i)).collect();
        let disc = |sphere: &Sphere, normal| Disc { center: sphere.center, radius: sphere.radius, normal };
        let discs: Vec<Disc> = spheres.iter().map(|sphere| disc(sphere, vector(&mut random, 3))).collect();
        let linear = |&near: &Vec3, random: &mut Pcg| LinearCurve { ends: [0; 2].map(|_| sphere(random, near, i)) };
        let linear: Vec<_> = near.iter().map(|near| linear(near, &mut random)).collect();
        let cubic = |&near: &Vec3, random: &mut Pcg| CubicCurve { controls: [0; 4].map(|_| sphere(random, near, i)) };
        let cubic: Vec<_> = near.iter().map(|near| cubic(near, &mut random)).collect();
        let found = [
            check_round(&spheres, &rays),
            check_round(&discs, &rays),
            check_round(&linear, &rays),
            check_round(&cubic, &rays),
        ];
        hits += found.iter().flatten().flatten().count();
    }
    assert!(hits > 300, "{hits}");
}
