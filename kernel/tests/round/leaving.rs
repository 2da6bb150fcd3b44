//! Rays that leave a surface on its outside do not hit it again: thin curves far away, and others.

use super::*;

/// The radius and the distance of what is hit.
const RADIUS: f32 = 1e-4;
const DISTANCE: f32 = 1e3;

/// A direction at least so steep (the sine) over a surface.
fn away(random: &mut Random, normal: Vec3, least: f32) -> Vec3 {
    let (a, b) = normal.any_orthonormal_pair();
    let (sin, cos) = (random.unit() * std::f32::consts::TAU).sin_cos();
    let side = a * cos + b * sin;
    let sine = least + (1.0 - least) * random.unit() * [1.0, 1e-2, 1e-5][random.bits() as usize % 3];
    // Less is lost in the rounding of the direction.
    let sine = sine.max(1e-6);
    (side * (1.0 - sine * sine).max(0.0).sqrt() + normal * sine) * [1.0, 1e-3, 1e4][random.bits() as usize % 3]
}

/// Shoots rays at primitives from the distance, each at a place on its axis, until so many have hit; from there rays
/// leave, at least so steep, and do not hit the same primitive again.
fn leave<P: RoundPrimitive>(
    primitives: &[P],
    tree: RoundBvhView,
    target: impl Fn(&P, f32) -> Sphere,
    least: f32,
    leaving_rays: usize,
) {
    let mut random = Random::new(101);
    let (mut rays, mut hits) = (0, 0);
    while hits < leaving_rays {
        rays += 1;
        assert!(rays < 20 * leaving_rays, "{hits} of {rays} rays hit");
        let primitive = &primitives[random.bits() as usize % primitives.len()];
        let Sphere { center, radius } = target(primitive, random.unit());
        let far = random.direction() * DISTANCE;
        let aim = center + random.vector() * radius;
        // From around the origin, and from around the primitive.
        let eye = if rays % 2 == 0 { far } else { center + far };
        let ray = Ray::new(eye, aim - eye);
        let Some(hit) = tree.intersect(&ray) else { continue };
        hits += 1;
        let surface = RoundSurface::of(&ray, &primitives[hit.prim_id as usize]).unwrap();
        assert!(surface.is_front, "{ray:?} {surface:?}");
        let direction = away(&mut random, surface.normal, least);
        let leaving = Ray::new(surface.origin(direction), direction);
        let again = intersect_round(&leaving, &primitives[hit.prim_id as usize]);
        assert_eq!(again, None, "{rays}: {hit:?} {surface:?} {ray:?} {leaving:?}");
        if hits % 16 == 0 {
            // Any other that is hit is a neighbour in the way.
            let again = tree.intersect(&leaving);
            assert!(again.is_none_or(|again| again.prim_id != hit.prim_id), "{rays}: {ray:?} {leaving:?}");
        }
    }
}

fn build<P: halfdome_kernel::bvh::RoundBuild>(primitives: &[P]) -> RoundBvh {
    let (tree, report) = RoundBvh::build(primitives, &BuildOptions::default()).unwrap();
    assert_eq!(report.kept, primitives.len());
    tree
}

/// Places around the origin, and at the distance from it.
fn places(random: &mut Random, count: usize) -> Vec<Vec3> {
    (0..count).map(|i| random.direction() * [1.0, DISTANCE, DISTANCE][i % 3]).collect()
}

/// So many rays leave linear curves and as many cubic ones; fewer leave spheres and discs.
fn leave_all(rays: usize) {
    let mut random = Random::new(102);
    let places = places(&mut random, 64);
    let curve = |random: &mut Random, place: Vec3| {
        let end = place + random.vector() * [1e-3, 0.1, 5.0][random.bits() as usize % 3];
        let thinner = RADIUS * [1.0, 0.5, 0.0][random.bits() as usize % 3];
        LinearCurve { ends: [Sphere::new(place, RADIUS), Sphere::new(end, thinner)] }
    };
    let curves: Vec<_> = places.iter().map(|&place| curve(&mut random, place)).collect();
    let on_axis = |curve: &LinearCurve, u: f32| {
        let [a, b] = curve.ends;
        Sphere::new(a.center.lerp(b.center, u), a.radius + (b.radius - a.radius) * u)
    };
    leave(&curves, build(&curves).view(), on_axis, 0.0, rays);

    // What turns by less than twice the steepness is not in the way of what leaves it.
    let bent = |random: &mut Random, place: Vec3| {
        let (along, bend) = (random.direction(), random.direction());
        let length = [0.02, 0.5][random.bits() as usize % 2];
        let control = |k: f32| place + (along * k + bend * (0.02 * k * k)) * length;
        CubicCurve { controls: [0.0, 1.0, 2.0, 3.0].map(|k| Sphere::new(control(k), RADIUS)) }
    };
    let curves: Vec<_> = places.iter().map(|&place| bent(&mut random, place)).collect();
    let on_curve = |curve: &CubicCurve, u: f32| {
        let [a, b, c, d] = curve.controls.map(|control| control.center);
        let (v, w) = (1.0 - u, u);
        Sphere::new(a * v * v * v + (b * v + c * w) * 3.0 * v * w + d * w * w * w, RADIUS)
    };
    leave(&curves, build(&curves).view(), on_curve, 0.2, rays);

    let spheres: Vec<_> = places.iter().map(|&place| Sphere::new(place, RADIUS)).collect();
    leave(&spheres, build(&spheres).view(), |&sphere, _| sphere, 0.0, rays / 4);

    let mut disc = |&center: &Vec3| Disc { center, radius: RADIUS, normal: random.direction() };
    let discs: Vec<_> = places.iter().map(&mut disc).collect();
    let mut hits = 0;
    for (i, disc) in discs.iter().cycle().take(rays / 4).enumerate() {
        let ray = Ray::new(Vec3::ZERO, disc.center + random.vector() * RADIUS * 0.5);
        let Some(surface) = RoundSurface::of(&ray, disc) else { continue };
        hits += 1;
        let direction = away(&mut random, surface.normal, 0.0) * if i % 2 == 0 { 1.0 } else { -1.0 };
        let leaving = Ray::new(surface.origin(direction), direction);
        assert_eq!(intersect_round(&leaving, disc), None, "{i}: {ray:?} {leaving:?}");
    }
    assert!(hits > rays / 100, "{hits}");
}

#[test]
fn thin_curves_far_away_are_left_behind() {
    leave_all(100_000);
}

/// Some minutes.
#[test]
#[ignore = "ten million rays: cargo test --release -p halfdome-kernel --test round -- --ignored"]
fn ten_million_rays_leave_thin_curves_far_away() {
    leave_all(10_000_000);
}

#[test]
fn without_the_offset_they_would_be_hit_again() {
    let mut random = Random::new(103);
    let mut hits = 0;
    for _ in 0..1000 {
        let center = random.direction() * DISTANCE;
        let sphere = Sphere::new(center, RADIUS * 100.0);
        let surface = RoundSurface::of(&Ray::new(Vec3::ZERO, center), &sphere).unwrap();
        hits += usize::from(intersect_round(&Ray::new(surface.point, surface.normal), &sphere).is_some());
    }
    assert!(hits > 100, "{hits}");
}
