//! The oracle: the distance of a point from the surface, found by a search along the axis, and where a ray crosses the
//! surface, found by steps along the ray.

use super::*;

/// A sphere swept along a Bézier curve of any degree, as the ideal has it.
struct Swept<'a>(&'a [Sphere]);

impl Swept<'_> {
    /// The centre and the radius at a parameter, by de Casteljau's algorithm.
    fn at(&self, u: f64) -> DVec4 {
        let mut points = [DVec4::ZERO; 4];
        for (point, sphere) in points.iter_mut().zip(self.0) {
            *point = sphere.center.as_dvec3().extend(sphere.radius.into());
        }
        for last in (1..self.0.len()).rev() {
            for i in 0..last {
                points[i] = points[i] * (1.0 - u) + points[i + 1] * u;
            }
        }
        points[0]
    }

    /// How far a point is from the surface; less than zero inside.
    fn distance(&self, x: DVec3) -> f64 {
        let from = |u: f64| {
            let sphere = self.at(u);
            (x - sphere.truncate()).length() - sphere.w
        };
        let steps = if self.0.len() > 2 { 48 } else { 1 };
        let at = |i: usize| from(i as f64 / steps as f64);
        let nearest = (0..=steps).min_by(|&a, &b| at(a).total_cmp(&at(b))).unwrap();
        let (mut low, mut high) = (nearest.saturating_sub(1) as f64, (nearest + 1).min(steps) as f64);
        for _ in 0..60 {
            let (a, b) = (low + (high - low) * 0.4, low + (high - low) * 0.6);
            if from(a / steps as f64) < from(b / steps as f64) {
                high = b;
            } else {
                low = a;
            }
        }
        at(nearest).min(from((low + high) * 0.5 / steps as f64))
    }
}

/// Rays at a point from near and far, with ends and without.
fn ray_at(random: &mut Random, target: Vec3, i: usize) -> Ray {
    let origin = target + random.direction() * [0.3, 1.0, 4.0, 1e3][i % 4];
    let length = [1.0, 1e-4, 3e5][i % 3];
    let distance = (target - origin).length();
    let (t_min, t_max) = match i % 5 {
        0 => (distance * random.unit(), f32::INFINITY),
        1 => (0.0, distance * 2.0 * random.unit()),
        2 => (f32::NEG_INFINITY, f32::INFINITY),
        _ => (0.0, f32::INFINITY),
    };
    Ray { origin, t_min: t_min / length, direction: (target - origin) / distance * length, t_max: t_max / length }
}

/// Checks rays at a primitive, which deviates so much from the oracle's. Gives how many hit it from outside, from
/// inside, and not at all.
fn check<P: RoundPrimitive>(
    primitive: &P,
    swept: &Swept,
    deviation: f64,
    random: &mut Random,
    rays: usize,
) -> [usize; 3] {
    let mut counts = [0; 3];
    for i in 0..rays {
        let axis = swept.at(random.unit().into());
        let target = axis.truncate().as_vec3() + random.vector() * axis.w as f32 * 1.2;
        let ray = ray_at(random, target, i);
        let (origin, direction) = (ray.origin.as_dvec3(), ray.direction.as_dvec3());
        let bounds = primitive.bounds();
        let reach = (bounds.min - ray.origin).abs().max((bounds.max - ray.origin).abs()).length();
        let bound = f64::from(reach) * 2f64.powi(-40) + deviation;
        let distance = |t: f64| swept.distance(origin + direction * t);
        // Where the ray is near the primitive.
        let middle = (bounds.center().as_dvec3() - origin).dot(direction) / direction.length_squared();
        let half = f64::from((bounds.max - bounds.min).length()) / direction.length();
        let least = f64::from(ray.t_min).max(middle - half);
        let hit = intersect_round(&ray, primitive);
        let most = hit.map_or(f64::from(ray.t_max).min(middle + half), |hit| hit.t.into());
        let half_unit = most.abs() * f64::from(f32::EPSILON) * 0.5 * direction.length();
        // Before the crossing, all is on one side.
        let steps = (0..=120).map(|step| distance(least + (most - least) * f64::from(step) / 120.0));
        let steps: Vec<f64> = if least <= most { steps.collect() } else { vec![] };
        let is_outside = steps.iter().all(|&distance| distance >= -bound - half_unit);
        let is_inside = steps.iter().all(|&distance| distance <= bound + half_unit);
        assert!(is_outside || is_inside, "{i}: {ray:?} {hit:?} {steps:?}");
        let Some(hit) = hit else {
            counts[2] += 1;
            continue;
        };
        let off = distance(hit.t.into());
        assert!(off.abs() <= bound + half_unit, "{i}: {ray:?} {hit:?} is {off} off, not {}", bound + half_unit);
        assert!((0.0..=1.0).contains(&hit.u) && hit.v == 0.0);
        let surface = RoundSurface::of(&ray, primitive).unwrap();
        counts[usize::from(!surface.is_front)] += 1;
        // The point is nearer than the rounded `t` says, and the normal is the gradient of the distance.
        let point = surface.point.as_dvec3();
        let unit = point.abs().max_element() * f64::from(f32::EPSILON);
        assert!(swept.distance(point).abs() <= bound + unit, "{ray:?} {surface:?}");
        assert!(surface.normal.dot(ray.direction) <= 1e-6 * ray.direction.length(), "{ray:?} {surface:?}");
        // The sphere at `u` touches the point.
        let sphere = swept.at(hit.u.into());
        let off = (point - sphere.truncate()).length() - sphere.w;
        let speed = (swept.at(1.0) - swept.at(0.0)).length().max(half * direction.length());
        assert!(off.abs() <= bound + unit + 4.0 * deviation + 1e-6 * speed, "{off} {ray:?} {hit:?}");
        if sphere.w > 100.0 * (unit + deviation) {
            let outward = (point - sphere.truncate()).normalize() * if surface.is_front { 1.0 } else { -1.0 };
            for (normal, least) in [(surface.normal, 0.995), (surface.shading_normal, 0.999)] {
                let cosine = outward.dot(normal.as_dvec3());
                assert!(cosine > least && normal.is_normalized(), "{cosine} {ray:?} {surface:?}");
            }
        }
    }
    counts
}

#[test]
fn spheres() {
    let mut random = Random::new(91);
    let mut sum = [0; 3];
    for i in 0..60 {
        let sphere = Sphere::new(random.vector() * [1.0, 100.0][i % 2], random.unit() + 1e-3);
        let counts = check(&sphere, &Swept(&[sphere]), 0.0, &mut random, 60);
        (0..3).for_each(|kind| sum[kind] += counts[kind]);
    }
    assert!(sum[0] > 1000 && sum[1] > 150 && sum[2] > 500, "{sum:?}");
}

#[test]
fn linear_curves() {
    let mut random = Random::new(92);
    let mut sum = [0; 3];
    for i in 0..120 {
        let a = random.vector();
        let b = a + random.vector() * [1.0, 0.05, 0.0, 30.0][i % 4];
        let scale = [0.5, 1e-2, 1e-4][i % 3];
        let radius = |random: &mut Random, zero: bool| if zero { 0.0 } else { random.unit() * scale + 1e-6 };
        let ends = [Sphere::new(a, radius(&mut random, i % 5 == 0)), Sphere::new(b, radius(&mut random, i % 7 == 1))];
        if ends[0].radius == 0.0 && ends[1].radius == 0.0 {
            continue;
        }
        let counts = check(&LinearCurve { ends }, &Swept(&ends), 0.0, &mut random, 60);
        (0..3).for_each(|kind| sum[kind] += counts[kind]);
    }
    assert!(sum[0] > 2000 && sum[1] > 150 && sum[2] > 800, "{sum:?}");
}

#[test]
fn cubic_curves() {
    let mut random = Random::new(93);
    let mut sum = [0; 3];
    for i in 0..60 {
        let mut controls = [Sphere::default(); 4];
        let start = random.vector();
        for (k, control) in controls.iter_mut().enumerate() {
            let bend = random.vector() * [1.0, 0.1, 0.0][i % 3];
            let along = [vec3(1.0, 0.3, 0.2), Vec3::ZERO][usize::from(i % 9 == 0)] * k as f32;
            *control = Sphere::new(start + along + bend, random.unit() * [0.3, 0.05, 1e-3][i / 3 % 3]);
        }
        if i % 4 == 0 {
            controls[3].radius = 0.0;
        }
        let largest = controls.iter().fold(0.0f32, |largest, control| largest.max(control.radius));
        let curve = CubicCurve { controls };
        let counts = check(&curve, &Swept(&controls), f64::from(largest) * CUBIC_TOLERANCE, &mut random, 40);
        (0..3).for_each(|kind| sum[kind] += counts[kind]);
    }
    assert!(sum[0] > 500 && sum[1] > 30 && sum[2] > 300, "{sum:?}");
}

#[test]
fn discs() {
    let mut random = Random::new(94);
    let mut counts = [0; 2];
    for i in 0..4000 {
        let normal = [random.direction() * 3.0, Vec3::X, Vec3::NEG_Z][i % 3];
        let disc = Disc { center: random.vector(), radius: [1.0, 1e-4][i % 2] * (random.unit() + 0.01), normal };
        let n = normal.as_dvec3().normalize();
        let target = disc.center + random.vector() * disc.radius;
        let ray = ray_at(&mut random, target, i);
        let (origin, d) = (ray.origin.as_dvec3(), ray.direction.as_dvec3());
        let t = (disc.center.as_dvec3() - origin).dot(n) / d.dot(n);
        let from_center = (origin + d * t - disc.center.as_dvec3()).length();
        let inside = (f64::from(disc.radius) - from_center) / f64::from(disc.radius);
        // Seen edge-on, nothing is certain.
        let doubt = 1e-9 / (d.normalize().dot(n).abs() * f64::from(disc.radius));
        let is_within = f64::from(ray.t_min) <= t && t <= f64::from(ray.t_max);
        let hit = intersect_round(&ray, &disc);
        if inside.abs() > doubt {
            assert_eq!(hit.is_some(), inside > 0.0 && is_within, "{ray:?} {disc:?}");
        }
        let Some(hit) = hit else {
            counts[1] += 1;
            continue;
        };
        counts[0] += 1;
        let error = t.abs() * f64::from(f32::EPSILON) + doubt;
        assert!((f64::from(hit.t) - t).abs() <= error.max(2e-7 * t.abs()), "{hit:?} {t}");
        assert!((f64::from(hit.u) - (1.0 - inside)).abs() < 1e-6 + doubt, "{hit:?} {inside}");
        let surface = RoundSurface::of(&ray, &disc).unwrap();
        assert_eq!(surface.is_front, d.dot(n) < 0.0);
        assert!((surface.normal.as_dvec3() - if surface.is_front { n } else { -n }).length() < 1e-6);
    }
    assert!(counts[0] > 500 && counts[1] > 500, "{counts:?}");
}

#[test]
fn straight_cubic_curves_are_linear_ones() {
    let mut random = Random::new(95);
    let mut hits = 0;
    for i in 0..300 {
        let [a, b] = [(); 2].map(|()| Sphere::new(random.vector() * 4.0, 0.25 + random.unit()));
        // Exact thirds.
        let grid = |s: Sphere| Sphere::new((s.center * 8.0).round() * 3.0, (s.radius * 8.0).round() * 3.0);
        let (a, b) = (grid(a), grid(b));
        let third = |k: f32| {
            Sphere::new(a.center + (b.center - a.center) / 3.0 * k, a.radius + (b.radius - a.radius) / 3.0 * k)
        };
        let (linear, cubic) = (LinearCurve { ends: [a, b] }, CubicCurve { controls: [a, third(1.0), third(2.0), b] });
        for _ in 0..20 {
            let target = a.center.lerp(b.center, random.unit());
            let ray = ray_at(&mut random, target, i);
            let (found, expected) = (intersect_round(&ray, &cubic), intersect_round(&ray, &linear));
            assert_eq!(found.is_some(), expected.is_some());
            if let (Some(found), Some(expected)) = (found, expected) {
                hits += 1;
                assert!((found.t - expected.t).abs() <= 1e-6 * expected.t.abs() && (found.u - expected.u).abs() < 1e-6);
            }
        }
    }
    assert!(hits > 2000, "{hits}");
}

#[test]
fn splines_go_through_the_points_that_they_should() {
    let point = |i: i32| Sphere::new(vec3(i as f32, (i * i) as f32, 1.0), 0.5 + 0.25 * i as f32);
    let points = [point(0), point(1), point(2), point(3)];
    let close = |a: Sphere, b: DVec4| (a.center.as_dvec3().extend(a.radius.into()) - b).length() < 1e-6;
    let curve = CubicCurve::from_catmull_rom(&points);
    assert!(curve.controls[0] == points[1] && curve.controls[3] == points[2]);
    // A quadratic is its own spline.
    assert!(close(Sphere::new(vec3(1.5, 2.25, 1.0), 0.875), Swept(&curve.controls).at(0.5)));
    let curve = CubicCurve::from_b_spline(&points);
    let sphere = |i: usize| points[i].center.as_dvec3().extend(points[i].radius.into());
    let knot = |i: usize| (sphere(i - 1) + 4.0 * sphere(i) + sphere(i + 1)) / 6.0;
    assert!(close(curve.controls[0], knot(1)) && close(curve.controls[3], knot(2)));
    let middle = (sphere(0) + 23.0 * (sphere(1) + sphere(2)) + sphere(3)) / 48.0;
    assert!((Swept(&curve.controls).at(0.5) - middle).length() < 1e-6);
    let strand: Vec<CubicCurve> = CubicCurve::strand(&points).collect();
    assert_eq!((strand.len(), CubicCurve::strand(&points[..1]).count()), (3, 0));
    for (i, curve) in strand.iter().enumerate() {
        assert!(curve.controls[0] == points[i] && curve.controls[3] == points[i + 1]);
    }
    // A radius never falls below zero.
    let thin = [0.6, 0.1, 0.0, 0.0].map(|radius| Sphere::new(Vec3::ZERO, radius));
    assert_eq!(CubicCurve::from_catmull_rom(&thin).controls[1].radius, 0.0);
}
