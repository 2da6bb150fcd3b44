//! Triangles and rays at and beyond the limits of numbers.

use super::*;

#[test]
fn scenes_far_from_the_origin_and_of_extreme_size() {
    let mut random = Random(2);
    for (scale, shift) in [(1.0, 1e5), (1e-6, 1.0), (1e11, 0.0), (1e-20, 0.0), (3.0, 148_376.0)] {
        let triangles: Vec<_> =
            soup(&mut random, 50, 0.4).iter().map(|triangle| triangle.map(|p| p * scale + shift)).collect();
        let rays = rays_at(&triangles, &mut random, 40);
        check(&triangles, &rays);
    }
}

#[test]
fn odd_triangles() {
    let mut random = Random(5);
    let mut triangles = soup(&mut random, 30, 0.5);
    let p = random.vector();
    triangles.push([p; 3]);
    triangles.push([p, p + Vec3::X, p + Vec3::X * 2.0]);
    triangles.push([p, p + Vec3::X, p + Vec3::X * 0.5 + Vec3::Y * 1e-8]);
    triangles.push([p, p + Vec3::X * 1e-20, p + Vec3::Y * 1e-20]);
    triangles.push([Vec3::ZERO, Vec3::X * 1e-20, Vec3::Y * 1e-20]);
    triangles.push([p, Vec3::NAN, Vec3::X]);
    triangles.push([Vec3::INFINITY, p, Vec3::X]);
    triangles.push([Vec3::splat(5.9e11), p, Vec3::X]);
    triangles.push([Vec3::splat(5e12), p, Vec3::X]);
    let (_, report) = Bvh::build(&triangles, &BuildOptions::default()).unwrap();
    assert_eq!((report.out_of_range, report.not_finite, report.degenerate, report.kept), (1, 2, 2, 34));
    let rays = rays_at(&triangles[..31], &mut random, 100);
    check(&triangles, &rays);
}

#[test]
fn corners_on_a_line_can_be_hit_once_they_are_rounded() {
    let triangle = [Vec3::ZERO, vec3(1.0, 3.0, 0.0), vec3(2.0, 6.0, 0.0)];
    let unit = 1.0 / (1u32 << 25) as f32;
    let ray = Ray::new(vec3(3_355_443.0 * unit, 10_066_329.0 * unit, -1.0), Vec3::Z);
    assert_eq!(check(&[triangle], &[ray]), Quality::ALL.len());
}

#[test]
fn rays_out_of_limits_hit_nothing() {
    let triangles = sphere(2, |p| p);
    let (bvh, _) = Bvh::build(&triangles, &BuildOptions::default()).unwrap();
    let good = Ray::new(Vec3::ZERO, Vec3::X);
    assert!(bvh.view().intersect(&good).is_some());
    let (nan, inf) = (f32::NAN, f32::INFINITY);
    let bad = [
        Ray { direction: Vec3::ZERO, ..good },
        Ray { direction: Vec3::splat(1e-40), ..good },
        Ray { direction: Vec3::X * 1e30, ..good },
        Ray { direction: Vec3::X * 1e-30, ..good },
        Ray { direction: vec3(1.0, nan, 0.0), ..good },
        Ray { direction: vec3(1.0, inf, 0.0), ..good },
        Ray { origin: vec3(nan, 0.0, 0.0), ..good },
        Ray { origin: vec3(0.0, -inf, 0.0), ..good },
        Ray { t_min: 2.0, t_max: 1.0, ..good },
        Ray { t_min: nan, ..good },
        Ray { t_max: nan, ..good },
        Ray { t_min: inf, ..good },
        Ray { t_max: 0.0, ..good },
        Ray { t_max: -inf, ..good },
    ];
    for ray in bad {
        assert_eq!(bvh.view().intersect(&ray), None, "{ray:?}");
    }
    check(&triangles, &bad);
    // Negative t counts if it is asked for.
    let behind = bvh.view().intersect(&Ray { t_min: -inf, ..good }).unwrap();
    assert!((behind.t + 1.0).abs() < 1e-6);
}

#[test]
fn rays_of_raw_bits() {
    let mut random = Random(6);
    let triangles = soup(&mut random, 40, 1.0);
    let raw = |random: &mut Random| vec3(random.raw(), random.raw(), random.raw());
    let mut rays = Vec::new();
    for _ in 0..fewer(4000) {
        let ray =
            Ray { origin: raw(&mut random), t_min: random.raw(), direction: raw(&mut random), t_max: random.raw() };
        rays.push(ray);
        rays.push(Ray { origin: random.vector(), t_min: -1e30, t_max: 1e30, ..ray });
        rays.push(Ray { direction: random.vector(), t_min: f32::NEG_INFINITY, t_max: f32::INFINITY, ..ray });
    }
    assert!(check(&triangles, &rays) > fewer(100));
    // Triangles too.
    for _ in 0..fewer(200) {
        let triangles: Vec<_> = (0..12).map(|_| [(); 3].map(|()| raw(&mut random))).collect();
        let rays: Vec<_> = (0..20)
            .map(|i| {
                let target = triangles[i % 12][i % 3];
                Ray { t_min: f32::NEG_INFINITY, ..Ray::between(raw(&mut random), target) }
            })
            .collect();
        check(&triangles, &rays);
    }
}

/// Rays of all kinds, tiny triangles among them, with subnormal numbers flushed to zero: all ways agree with the loop
/// that runs likewise. Where nothing is tiny, hits are those of other processes to the bit.
#[test]
#[cfg(all(target_arch = "x86_64", not(miri)))]
fn flushed_subnormals_change_nothing_that_matters() {
    use crate::simd::tests::flushing_subnormals;
    let mut random = Random(8);
    for scale in [1.0, 1e-12, 1e-19, 1e-30, 1e-38] {
        let mut triangles = soup(&mut random, 60, 0.5);
        triangles.extend((0..20).map(|i| {
            let p = |x: i32, y: i32| vec3(x as f32, y as f32, (i % 3) as f32) * 0.2;
            [p(i, 0), p(i + 1, 0), p(i, 1)]
        }));
        let triangles: Vec<_> = triangles.iter().map(|triangle| triangle.map(|p| p * scale)).collect();
        let rays = rays_at(&triangles, &mut random, fewer(60));
        let tiny =
            rays.iter().flat_map(|ray| [Ray { t_min: 1e-41, ..*ray }, Ray { origin: ray.direction * 1e-40, ..*ray }]);
        check(&triangles, &tiny.clone().collect::<Vec<_>>());
        flushing_subnormals(|| check(&triangles, &tiny.collect::<Vec<_>>()));
        let usual = check(&triangles, &rays);
        let flushed = flushing_subnormals(|| check(&triangles, &rays));
        if scale > 1e-15 {
            assert!(usual > fewer(200) && usual == flushed, "{usual} {flushed}");
            let hits =
                || -> Vec<_> { rays.iter().map(|ray| bits(reference::intersect_all(&triangles, ray))).collect() };
            assert!(hits() == flushing_subnormals(hits));
        }
    }
}
